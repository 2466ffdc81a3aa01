// SPDX-License-Identifier: MIT
// A motion builds all that its steps need when it is made: a frame never waits for a compiler.
#include "support/commands.h"
#include "support/devices.h"
#include "support/mover.h"
#include "support/test.h"

enum { SIDE = 6, LAYERS = 14 };

static const double APART = 1.3;

static uint32_t built;

static void count_built(void *context, const duet_device_info *device, const char *kernel,
                        uint32_t k, uint32_t n)
{
    (void)context;
    (void)k;
    (void)n;
    (void)device;
    built += kernel != NULL;
}

// On a pair that has built nothing, and that keeps nothing.
static mover *make(double skin)
{
    duet_device_pair_def def = duet_default_device_pair_def();
    def.cache_dir = "";
    def.on_compile = count_built;
    mover *m = mover_new(3);
    m->def.pair = kept(duet_device_pair_create(&def, ERR));
    m->def.plan = duet_default_plan(m->def.pair);
    m->def.wants |= DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_SLEEP;
    m->def.gravity[2] = -9.81;
    m->def.skin = skin;
    m->def.sleep_speed = 0.15;
    return m;
}

// A column of boxes of about one size, turned anyhow.
static void add_column(mover *m)
{
    rng r = rng_seed(test_seed());
    for (int i = 0; i < SIDE * SIDE * LAYERS; ++i) {
        const double x = i % SIDE + 0.5, y = i / SIDE % SIDE + 0.5, z = i / (SIDE * SIDE) + 1;
        const uint32_t id =
            mover_add(m, APART * x, APART * y, APART * z, rng_between(&r, 0.25, 0.45),
                      rng_between(&r, 0.25, 0.45), rng_between(&r, 0.25, 0.45));
        turn_at_random(&m->poses[id], &r);
        m->bodies[id].friction = 0.5f;
    }
}

static mover *make_pile(double skin)
{
    mover *m = make(skin);
    mover_wall_in(m, 0, APART * SIDE);
    m->def.upper[2] = APART * (LAYERS + 2);
    add_column(m);
    return m;
}

static void assert_builds_none(mover *m, uint32_t steps)
{
    const uint32_t before = built;
    assert_true(before > 0);
    mover_run(m, steps);
    assert_int_equal(built, before);
}

static uint32_t count_moving(const mover *m)
{
    uint32_t moving = 0;
    for (uint32_t i = 0; i < m->n; ++i)
        moving += mover_speed(m, i) > 0;
    return moving;
}

TEST(a_pile_comes_to_rest_by_what_its_first_step_built)
{
    mover *m = make_pile(0.05);
    mover_run(m, 1);
    assert_builds_none(m, 400);
    assert_true(count_moving(m) < m->n / 2);
}

TEST(so_does_a_pile_without_a_skin)
{
    mover *m = make_pile(0);
    mover_run(m, 1);
    assert_builds_none(m, 60);
}

TEST(bodies_that_are_removed_and_added_make_it_build_none)
{
    mover *m = make_pile(0.05);
    uint64_t id;
    mover_run(m, 1);
    for (int i = 0; i < 6; ++i) {
        must(duet_motion_remove_bodies(m->motion, one(40 * i), ERR));
        assert_builds_none(m, 8);
        must(duet_motion_add_bodies(m->motion, m->poses, m->bodies, 1, &id, ERR));
        assert_builds_none(m, 8);
    }
}

TEST(a_game_that_begins_empty_has_built_all_for_the_bodies_that_come)
{
    mover *m = make_pile(0);
    uint64_t *ids = test_alloc(m->n * sizeof *ids);
    const uint32_t n = m->n;
    m->def = duet_game_motion_def(m->def.pair, 3);
    m->n = 0;
    mover_run(m, 1);
    must(duet_motion_add_bodies(m->motion, m->poses, m->bodies, n, ids, ERR));
    m->n = n;
    assert_builds_none(m, 60);
}

// Once so many come that a grid is laid anew, it has a table: dense cells would be too wide.
TEST(a_body_that_leaves_all_others_makes_it_build_none)
{
    mover *m = make(0.05);
    add_column(m);
    uint64_t *ids = test_alloc(2 * m->n * sizeof *ids);
    m->bodies[0].velocity[0] = -1e4f;
    mover_run(m, 1);
    for (int i = 0; i < 2; ++i) {
        for (uint32_t k = 0; k < m->n; ++k)
            m->poses[k].centre[1] += 20;
        must(duet_motion_add_bodies(m->motion, m->poses, m->bodies, m->n, ids, ERR));
        assert_builds_none(m, 10);
    }
}

// A few bodies, whose grid is less than three cells wide; the plan changes after some steps.
static uint64_t hash_by(const char *first, const char *then)
{
    mover *m = make(0.05);
    mover_wall_in(m, 0, 4);
    for (int i = 0; i < 20; ++i)
        mover_add_cube(m, 0.7 + 1.1 * (i % 3), 0.7 + 1.1 * (i / 3 % 3), 0.7 + 1.1 * (i / 9), 1);
    snprintf(m->def.plan.variant_a, sizeof m->def.plan.variant_a, "%s", first);
    snprintf(m->def.plan.variant_b, sizeof m->def.plan.variant_b, "%s", first);
    mover_run(m, 10);
    duet_plan plan = m->def.plan;
    snprintf(plan.variant_a, sizeof plan.variant_a, "%s", then);
    snprintf(plan.variant_b, sizeof plan.variant_b, "%s", then);
    must(duet_motion_set_plan(m->motion, &plan, ERR));
    mover_run(m, 10);
    uint64_t hash = mover_hash(m);
    mover_free(m);
    return hash;
}

TEST(what_is_built_ahead_keeps_to_what_a_plan_has_compiled_in)
{
    static const char *const plans[] = {"auto", "paper", "simd cells=fixed", "gpu cells=fixed"};
    const uint64_t truth = hash_by("auto", "auto");
    for (int i = 0; i < 4; ++i) {
        assert_int_equal(hash_by(plans[i], plans[(i + 1) % 4]), truth);
        assert_int_equal(hash_by(plans[(i + 2) % 4], plans[i]), truth);
    }
}
