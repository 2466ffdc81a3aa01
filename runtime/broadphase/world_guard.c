// SPDX-License-Identifier: MIT
// A public call asks a world first whether a step is under way.
#include "runtime/broadphase/world.h"

#include "base/error.h"

bool world_is_under_way(const duet_world *world)
{
    return world->background.owner;
}

bool world_is_idle(const duet_world *world, const char *call, duet_error *err)
{
    return error_given(world, call, "world", err) &&
           (!world_is_under_way(world) ||
            bad_argument(err,
                         "%s: a step of the world is under way; expected duet_world_step_end first",
                         call));
}
