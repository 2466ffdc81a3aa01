// SPDX-License-Identifier: MIT
// How a world is stepped while a plan is measured.
#include "support/test.h"

#include "runtime/broadphase/world.h"
#include "support/devices.h"
#include "tuner/subject.h"

enum { BOXES = 300 };

static duet_world *make_world(void)
{
    duet_world_def def = devices_def(3);
    duet_world *world = must(duet_world_create(&def, ERR));
    duet_pose *poses = must(duet_world_map_objects(world, DUET_OBJECT_POSES, BOXES, ERR));
    for (int i = 0; i < BOXES; ++i)
        poses[i] =
            (duet_pose){{0.7f * (float)(i % 17), 0.8f * (float)(i % 5), 0.9f * (float)(i % 13)},
                        {0.5f, 0.5f, 0.5f},
                        {0, 0, 0, 1}};
    return world;
}

// A machine that another one does the work of.
typedef struct watched {
    const measure_machine *machine;
    const duet_world *world;
    uint32_t launches;
    uint32_t timed; // launches timed stage by stage: a bit each, the first lowest
} watched;

static bool launch_watched(void *context, const duet_plan *plan, bool staged,
                           measure_launch *launch, duet_error *err)
{
    watched *w = context;
    bool ok = w->machine->launch(w->machine->context, plan, staged, launch, err);
    w->timed |= (uint32_t)!w->world->parts[1].times.untimed << w->launches++;
    return ok;
}

// Three measurements are more steps than those of which a GPU times one in any world.
TEST(a_gpus_launches_that_count_are_not_timed_by_stages)
{
    static const struct {
        bool staged;
        uint32_t timed;
    } cases[] = {{false, 1}, {false, 1}, {true, 0x1fff}, {false, 1}};
    devices_seem_gpus(true);
    duet_world *world = make_world();
    subject at = {.kind = &subject_still, .state = world};
    measure_machine machine = subject_machine(&at, 0);
    measure_launch first = {0};
    duet_plan plan = {.mode = DUET_MODE_OWN, .variant_a = "simd", .variant_b = "simd"};
    must(machine.launch(machine.context, &plan, false, &first, ERR));
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        watched w = {.machine = &machine, .world = world};
        measure_machine watching = {.context = &w, .launch = launch_watched, .hash = first.hash};
        measurement m =
            measure_plan(&watching, &plan, (measure_way){.repeats = 12, .staged = cases[i].staged});
        assert_string_equal(m.row.outcome, "ok");
        assert_int_equal(w.launches, 13);
        assert_int_equal(w.timed, cases[i].timed);
        assert_true(m.launch.terms.gpu2 > 0); // the launch that warmed up has it
    }
    duet_world_destroy(world);
    devices_seem_gpus(false);
}
