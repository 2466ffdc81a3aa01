// SPDX-License-Identifier: MIT
#include "cli/body_states.h"

#include "base/error.h"
#include "runtime/narrowphase/mesh.h"

#include <stdlib.h>

static bool carry_mesh(body_states *b, duet_error *err)
{
    const duet_mesh *mesh = b->def.mesh;
    if (!mesh || mesh->carrier == 0)
        return true;
    b->def.mesh = &b->carried;
    return mesh_carry(&b->carried, mesh, &b->states[mesh->carrier - 1], err);
}

bool body_states_read(body_states *b, duet_motion *motion, duet_error *err)
{
    uint32_t n = duet_motion_get_count(motion);
    *b = (body_states){.n = n, .def = *duet_motion_get_def(motion)};
    b->states = calloc((size_t)n + 1, sizeof *b->states);
    b->boxes = calloc((size_t)n + 1, sizeof *b->boxes);
    b->ids = calloc((size_t)n + 1, sizeof *b->ids);
    if (!b->states || !b->boxes || !b->ids)
        return no_memory(err, "a picture of %u objects", n);
    return duet_motion_get_states(motion, b->states, err) &&
           duet_motion_get_rounded_boxes(motion, b->boxes, err) &&
           duet_motion_get_ids(motion, 0, n, b->ids, err) && carry_mesh(b, err);
}

bool body_states_read_asleep(body_states *b, duet_motion *motion, duet_error *err)
{
    b->asleep = calloc((size_t)b->n + 1, sizeof *b->asleep);
    if (!b->asleep)
        return no_memory(err, "%u objects that sleep", b->n);
    return duet_motion_get_asleep(motion, b->asleep, err);
}

void body_states_free(body_states *b)
{
    free(b->states);
    free(b->boxes);
    free(b->ids);
    free(b->asleep);
    free((void *)b->carried.vertices);
    *b = (body_states){0};
}

bool body_states_has(const body_states *b, uint32_t place)
{
    return b->ids[place] != DUET_NO_BODY;
}

uint32_t body_states_count(const body_states *b)
{
    uint32_t n = 0;
    for (uint32_t place = 0; place < b->n; ++place)
        n += body_states_has(b, place);
    return n;
}
