// SPDX-License-Identifier: MIT
// A motion as the profile store knows it, and what it then runs: other kernels, and the same bits.
#include "support/mover.h"
#include "support/store.h"
#include "support/test.h"

#include "runtime/dynamics/motion.h"
#include "runtime/selection/profile_subject.h"

enum { CUBES = 60, STEPS = 12 };

// No device has these by itself, and each device may have them.
#define OWN_SETTINGS                                                       \
    "solve_contacts.LANES=1 solve_contacts.WG=64 build_manifolds.LANES=1 " \
    "build_manifolds.WG=128 build_manifolds.PER_ITEM=1"

static mover *make_pile(uint32_t n)
{
    mover *m = mover_new(3);
    mover_add_pile(m, n);
    m->def.skin = 0.05;
    return m;
}

static void create(mover *m)
{
    mover_restart(m);
    m->motion = must(duet_motion_create(&m->def, m->poses, m->bodies, m->n, ERR));
}

static duet_plan plan_with(const char *settings)
{
    duet_plan plan = duet_default_plan(default_pair());
    snprintf(plan.variant_b, sizeof plan.variant_b, "auto %s", settings);
    plan.share = DUET_SHARE_ONE / 4;
    plan.mode = DUET_MODE_OWN;
    return plan;
}

static void put(const char *path, const profile_subject *p, const char *settings)
{
    duet_plan plan = plan_with(settings);
    profile_plan stored = profile_subject_write_plan(&plan, p->workload.level);
    test_store_plan(path, &p->pair, &p->workload, p->kernels, &stored);
}

static void put_for(const char *path, const mover *m, const char *settings)
{
    profile_subject p;
    must(profile_subject_read_motion(m->motion, &p, ERR));
    put(path, &p, settings);
}

static duet_profile load(const mover *m, const char *path)
{
    duet_profile profile;
    must(duet_motion_load_profile(m->motion, path, &profile, ERR));
    return profile;
}

// ------------------------------------------------------------ plans

static void assert_own_kernels(const mover *m)
{
    const motion_kernels *k = &m->motion->kernels;
    assert_int_equal(kernel_param(k->of[SOLVE_CONTACTS], "WG"), 64);
    assert_int_equal(k->of[SOLVE_CONTACTS]->group, 64);
    assert_int_equal(kernel_param(k->of[APPLY_RESTITUTION], "WG"), 64);
    assert_int_equal(kernel_param(k->of[BUILD_MANIFOLDS], "WG"), 128);
    assert_int_equal(k->of[BUILD_MANIFOLDS]->per_item, 1);
}

TEST(a_plan_changes_kernels_between_steps_and_no_bit)
{
    mover *m = make_pile(CUBES);
    mover_run(m, 2 * STEPS);
    uint64_t hash = mover_hash(m);
    create(m);
    mover_run(m, STEPS);
    duet_plan plan = plan_with(OWN_SETTINGS);
    must(duet_motion_set_plan(m->motion, &plan, ERR));
    assert_own_kernels(m);
    assert_string_equal(duet_motion_get_plan(m->motion)->variant_b, plan.variant_b);
    mover_run(m, STEPS);
    assert_true(mover_hash(m) == hash);
    m->def.plan = plan;
    create(m);
    assert_own_kernels(m);
    mover_run(m, 2 * STEPS);
    assert_true(mover_hash(m) == hash);
}

TEST(a_plan_that_cannot_be_leaves_the_motion_as_it_was)
{
    static const struct {
        const char *settings, *line;
    } wrong[] = {
        {"solve_contacts.WG=3", "WG=3 is not one of"},
        {"solve_contacts.BLOCK=32", "solve_contacts.BLOCK cannot be set; expected WG, PER_ITEM"},
        {"prepare_contacts.LANES=1",
         "prepare_contacts.LANES cannot be set"}, // lanes would lack contacts
        {"motion.skin=1001", "expected motion.skin in percent"},
        {"motion.rest=1", "expected motion.skin in percent"},
        {"motion.colours=32", "or motion.colours between exchanges of ranks, from 0 to 31"},
        {"bodies.DIMS=2", "bodies.DIMS cannot be set"},
        {"update_sleep.WG=64", "no kernel that the motion runs has a parameter 'update_sleep.WG'"},
        {"solve_contacts.PER_ITEM=x", "the value is not a whole number"},
        {"grid=round", "grid=round"},
    };
    mover *m = make_pile(CUBES);
    mover_run(m, 2 * STEPS);
    uint64_t hash = mover_hash(m);
    create(m);
    mover_run(m, STEPS);
    const duet_plan before = *duet_motion_get_plan(m->motion);
    const motion_kernels kernels = m->motion->kernels;
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        duet_plan plan = plan_with(wrong[i].settings);
        must_fail(duet_motion_set_plan(m->motion, &plan, ERR), DUET_STATUS_BAD_ARGUMENT,
                  wrong[i].line);
        assert_memory_equal(duet_motion_get_plan(m->motion), &before, sizeof before);
        assert_memory_equal(&m->motion->kernels, &kernels, sizeof kernels);
    }
    mover_run(m, STEPS);
    assert_true(mover_hash(m) == hash);
}

// Steps that searched pairs.
static uint32_t count_searches(mover *m, uint32_t steps)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < steps; ++i) {
        mover_run(m, 1);
        n += m->last.rebuilt;
    }
    return n;
}

TEST(a_plans_skin_changes_how_often_pairs_are_searched_and_no_bit)
{
    enum { LONG = 3 * STEPS };
    mover *m = make_pile(CUBES);
    duet_plan thin = plan_with("motion.skin=1"), thick = plan_with("motion.skin=80");
    create(m);
    count_searches(m, LONG);
    uint64_t hash = mover_hash(m);
    m->def.plan = thin;
    create(m);
    uint32_t often = count_searches(m, LONG);
    assert_true(mover_hash(m) == hash);
    m->def.plan = thick;
    create(m);
    assert_true(2 * count_searches(m, LONG) < often);
    assert_true(mover_hash(m) == hash);
    create(m);
    mover_run(m, STEPS);
    must(duet_motion_set_plan(m->motion, &thin, ERR));
    mover_run(m, 1);
    assert_true(m->last.rebuilt); // a plan that holds within one skin may not within another
    mover_run(m, LONG - STEPS - 1);
    assert_true(mover_hash(m) == hash);
    assert_true(m->motion->def.skin == 0.05);
    m->def.skin = 0;
    m->def.plan = duet_default_plan(default_pair());
    create(m);
    must_fail(duet_motion_set_plan(m->motion, &thick, ERR), DUET_STATUS_BAD_ARGUMENT,
              "motion.skin=80; expected a motion whose def has a skin");
}

// ------------------------------------------------------------ profiles

TEST(a_motion_takes_its_profile_and_keeps_its_bits)
{
    test_folder folder = test_folder_make();
    mover *m = make_pile(CUBES);
    mover_run(m, STEPS);
    uint64_t hash = mover_hash(m);
    create(m);
    assert_int_equal(load(m, folder.store).grade, DUET_GRADE_DEFAULT);
    put_for(folder.store, m, OWN_SETTINGS);
    duet_profile profile = load(m, folder.store);
    assert_int_equal(profile.grade, DUET_GRADE_EXACT);
    assert_int_equal(profile.plan.share, DUET_SHARE_ONE / 4);
    assert_true(profile.step_ms == 2 && profile.gain == 0.5);
    assert_memory_equal(duet_motion_get_plan(m->motion), &profile.plan, sizeof profile.plan);
    assert_own_kernels(m);
    mover_run(m, STEPS);
    assert_true(mover_hash(m) == hash);

    // A row that somebody wrote is not followed, and the motion goes on.
    test_store_run(folder.store, "UPDATE profile SET variant_b = 'auto solve_contacts.WG=77'");
    create(m);
    must_fail(duet_motion_load_profile(m->motion, folder.store, &profile, ERR),
              DUET_STATUS_BAD_ARGUMENT, "");
    mover_run(m, STEPS);
    assert_true(mover_hash(m) == hash);
}

TEST(a_motion_without_contact_takes_the_kernels_alone)
{
    test_folder folder = test_folder_make();
    mover *m = mover_new(3);
    for (uint32_t i = 0; i < CUBES; ++i)
        m->bodies[mover_add_cube(m, 2.0 * i, 0, 0, 1)].velocity[0] = (float)i;
    mover_run(m, STEPS);
    uint64_t hash = mover_hash(m);
    create(m);
    put_for(folder.store, m, "integrate_free_flight.WG=256 integrate_free_flight.PER_ITEM=1");
    assert_int_equal(load(m, folder.store).grade, DUET_GRADE_EXACT);
    assert_int_equal(m->motion->kernels.of[INTEGRATE_FREE_FLIGHT]->group, 256);
    assert_null(duet_motion_get_plan(m->motion)); // no plan of pairs
    mover_run(m, STEPS);
    assert_true(mover_hash(m) == hash);
}

static duet_world *make_world(const mover *m)
{
    duet_world_def def = duet_default_world_def();
    def.pair = default_pair();
    duet_world *world = kept(duet_world_create(&def, ERR));
    must(duet_world_set_objects(world, DUET_OBJECT_POSES, m->poses, m->n, ERR));
    return world;
}

TEST(a_still_worlds_profile_is_no_motions_nor_the_reverse)
{
    test_folder still = test_folder_make(), moving = test_folder_make();
    mover *m = make_pile(CUBES);
    duet_profile profile;
    profile_subject p;
    create(m);
    duet_world *world = make_world(m);
    must(profile_subject_read(world, &p, ERR));
    put(still.store, &p, "");
    put_for(moving.store, m, OWN_SETTINGS);
    must(duet_world_load_profile(world, still.store, &profile, ERR));
    assert_int_equal(profile.grade, DUET_GRADE_EXACT);
    must(duet_world_load_profile(world, moving.store, &profile, ERR));
    assert_int_equal(profile.grade, DUET_GRADE_DEFAULT);
    assert_int_equal(load(m, still.store).grade, DUET_GRADE_DEFAULT);
    assert_int_equal(load(m, moving.store).grade, DUET_GRADE_EXACT);
}

// A number that makes no motion of another kind.
TEST(another_number_of_bodies_takes_the_plan_and_no_figure)
{
    test_folder folder = test_folder_make();
    mover *m = make_pile(CUBES), *more = make_pile(2 * CUBES), *many = make_pile(10 * CUBES);
    create(m);
    create(more);
    create(many);
    put_for(folder.store, m, OWN_SETTINGS);
    duet_profile profile = load(more, folder.store);
    assert_int_equal(profile.grade, DUET_GRADE_INTERPOLATED);
    assert_int_equal(profile.plan.share, DUET_SHARE_ONE / 4);
    assert_own_kernels(more);
    assert_true(profile.step_ms == 0 && profile.gain == 0 && profile.measured_s == 0);
    assert_string_equal(profile.verdict, "");
    assert_int_equal(load(many, folder.store).grade, DUET_GRADE_DEFAULT);
}

TEST(other_effects_or_substeps_are_another_workload)
{
    test_folder folder = test_folder_make();
    mover *m = make_pile(CUBES);
    create(m);
    put_for(folder.store, m, OWN_SETTINGS);
    assert_int_equal(load(m, folder.store).grade, DUET_GRADE_EXACT);
    m->def.wants = DUET_EFFECT_SLEEP;
    create(m);
    assert_int_equal(load(m, folder.store).grade, DUET_GRADE_DEFAULT);
    m->def.wants = 0;
    m->def.substeps = 9;
    create(m);
    assert_int_equal(load(m, folder.store).grade, DUET_GRADE_DEFAULT);
}

TEST(what_nothing_happens_to_has_no_profile)
{
    mover *m = mover_new(3);
    duet_profile profile;
    for (uint32_t n = 0; n < 2; ++n) {
        create(m);
        must_fail(duet_motion_load_profile(m->motion, "no.db", &profile, ERR),
                  DUET_STATUS_BAD_ARGUMENT, "has no profile; expected bodies that");
        mover_add_cube(m, 0, 0, 0, 1);
    }
}
