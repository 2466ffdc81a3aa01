// SPDX-License-Identifier: MIT
// Commands as nobody should give them, and what they meet in unusual worlds.
#include "support/commands.h"

#include "base/text_file.h"
#include "runtime/dynamics/motion_commands.h"

static const char path[] = "motion"; // name of the file that a test saves

TEST(numbers_that_overflow_are_refused)
{
    mover *m = make_rows(1, 1);
    uint32_t ram = mover_add_fixed(m, 8, 0, 0.6, 0.5, 0.5, 0.5);
    mover_run(m, 60);
    const uint64_t hash = mover_hash(m);
    duet_motion *motion = m->motion;
    const duet_transform far = {{3e38f, 0, 0}, {0, 0, 0, 1}};
    const duet_force forces[2] = {{.force = {3e38f, 0, 0}}, {.force = {3e38f, 0, 0}}};
    const duet_impulse push = {.impulse = {3e38f, 0, 0}}, spin = {{0, 3e38f, 0}, {3e38f, 0, 0}};
    const uint64_t twice[2] = {1, 1};
    must_fail(duet_motion_set_targets(motion, one(ram), &far, ERR), ANY_FAILURE, "body 0 of 1: ");
    must_fail(duet_motion_apply_forces(motion, by_ids(twice, 2), forces, ERR), ANY_FAILURE,
              "body 0 of 2: ");
    const duet_body light = {.mass = 1e-3f};
    must(duet_motion_set_bodies(motion, one(1), DUET_BODY_MASS, &light, ERR));
    must_fail(duet_motion_apply_impulses(motion, one(1), &push, ERR), ANY_FAILURE, "body 0 of 1: ");
    must_fail(duet_motion_apply_impulses(motion, one(1), &spin, ERR), ANY_FAILURE, "body 0 of 1: ");
    assert_true(mover_hash(m) == hash);
    mover_run(m, 10);
    mover_assert_finite(m);
}

TEST(what_events_are_told_of_cannot_change)
{
    mover *m = make_rows(1, 1);
    m->def.wants |= DUET_EFFECT_EVENTS;
    m->def.hit_speed = 1;
    mover_run(m, 1);
    duet_motion_def def = *duet_motion_get_def(m->motion);
    def.hit_speed = 0;
    must_fail(duet_motion_set_def(m->motion, &def, ERR), ANY_FAILURE, "hit_speed is 0; expected");
    def.hit_speed = 1;
    def.event_mask = 1;
    must_fail(duet_motion_set_def(m->motion, &def, ERR), ANY_FAILURE, "event_mask is 1; expected");
}

// With bodies that come, walls get other numbers; what touched them stays.
TEST(walls_that_get_other_numbers_are_touched_all_the_same)
{
    mover *m = mover_new(3);
    m->def.wants |= DUET_EFFECT_EVENTS;
    mover_wall_in(m, 0, 12);
    m->def.gravity[2] = -9.81;
    mover_add_rough_cube(m, 2, 2, 0.5);
    mover_run(m, 30);
    assert_int_equal(m->last.n_stays, 1);
    const duet_pose high = {{8, 8, 8}, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}};
    must(duet_motion_add_bodies(m->motion, &high, NULL, 1, NULL, ERR));
    mover_run(m, 1);
    assert_int_equal(m->last.n_events, 0);
    assert_int_equal(m->last.n_stays, 1);
    assert_true(m->last.stays[0].a == 0 && m->last.stays[0].b == 2 + 4);
}

// A cube that slides on a ground of either kind after 40 steps; a body comes high above it before
// the last ten.
static duet_state slide_on_ground(const duet_heights *heights, const duet_mesh *mesh, bool comes)
{
    const duet_pose high = {{3, 3, 30}, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}};
    mover *m = mover_new(3);
    m->def.wants |= DUET_EFFECT_EVENTS;
    m->def.gravity[2] = -9.81;
    m->def.heights = heights;
    m->def.mesh = mesh;
    m->bodies[mover_add_rough_cube(m, 0, 0, 0.5)].velocity[0] = 3;
    mover_run(m, 30);
    assert_int_equal(m->last.n_stays, 1);
    if (comes)
        must(duet_motion_add_bodies(m->motion, &high, NULL, 1, NULL, ERR));
    mover_run(m, 1);
    assert_int_equal(m->last.n_events, 0);
    assert_int_equal(m->last.n_stays, 1);
    assert_true(m->last.stays[0].a == 0 && m->last.stays[0].b == m->n + comes + 6);
    mover_run(m, 9);
    return m->states[0];
}

// The ground, too; and a body elsewhere takes no impulse from what touches it.
TEST(a_ground_that_gets_another_number_is_touched_all_the_same)
{
    static const float level[4] = {0, 0, 0, 0};
    static const float corners[] = {-20, -20, 0, 20, -20, 0, 20, 20, 0, -20, 20, 0};
    static const uint32_t faces[] = {0, 1, 2, 0, 2, 3};
    const duet_heights heights = {
        .nx = 2, .ny = 2, .origin = {-20, -20, 0}, .spacing = {40, 40}, .heights = level};
    const duet_mesh mesh = {
        .vertices = corners, .n_vertices = 4, .triangles = faces, .n_triangles = 2};
    for (int i = 0; i < 2; ++i) {
        const duet_heights *h = i == 0 ? &heights : NULL;
        const duet_mesh *t = i == 1 ? &mesh : NULL;
        const duet_state left = slide_on_ground(h, t, false), right = slide_on_ground(h, t, true);
        assert_memory_equal(&left, &right, sizeof left);
    }
}

typedef struct event_sums {
    uint64_t begins, ends, stays;
} event_sums;

// Three cubes lie on a floor: the first changes its group, the second goes.
static event_sums events_of_changed_groups(bool saved)
{
    mover *m = make_rows(3, 1);
    m->def.wants |= DUET_EFFECT_EVENTS | DUET_EFFECT_FILTER;
    m->def.event_mask = 4;
    for (uint32_t i = 0; i < m->n; ++i)
        m->bodies[i].group = 1;
    mover_run(m, 3);
    const duet_body told = {.group = 4, .mask = UINT32_MAX};
    must(duet_motion_set_bodies(m->motion, one(1), DUET_BODY_FILTER, &told, ERR));
    must(duet_motion_remove_bodies(m->motion, one(2), ERR));
    if (saved) {
        must(duet_motion_save(m->motion, path, ERR));
        mover_restart(m);
        mover_run(m, 0);
        must(duet_motion_load(m->motion, path, ERR));
    }
    mover_run(m, 1);
    event_sums sums = {.stays = m->last.n_stays};
    for (uint64_t i = 0; i < m->last.n_events; ++i) {
        sums.begins += m->last.events[i].begins;
        sums.ends += !m->last.events[i].begins;
    }
    return sums;
}

TEST(events_of_changed_groups_do_not_depend_on_a_file)
{
    const event_sums usual = events_of_changed_groups(false),
                     saved = events_of_changed_groups(true);
    assert_true(usual.begins == saved.begins && usual.ends == saved.ends &&
                usual.stays == saved.stays);
    assert_int_equal(usual.begins + usual.stays, 1);
    assert_int_equal(usual.ends, 0); // nobody asked for those of the body that went
}

TEST(a_place_that_had_all_its_bodies_is_used_no_more)
{
    mover *m = make_rows(1, 1);
    mover_run(m, 1);
    const duet_pose pose = {{-5, 0, 5}, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}};
    uint64_t id = 1;
    must(duet_motion_remove_bodies(m->motion, one(1), ERR));
    m->motion->commands->generations[1] = UINT32_MAX;
    mover_run(m, 1);
    must(duet_motion_add_bodies(m->motion, &pose, NULL, 1, &id, ERR));
    assert_true(id == (UINT64_C(0xffffffff) << 32 | 1));
    must(duet_motion_remove_bodies(m->motion, by_ids(&id, 1), ERR));
    mover_run(m, 2);
    assert_false(duet_motion_has_body(m->motion, 1));
    must(duet_motion_add_bodies(m->motion, &pose, NULL, 1, &id, ERR));
    assert_true(id == 2);
}

TEST(a_list_of_none_changes_nothing)
{
    mover *m = make_rows(2, 1);
    m->def.skin = 0.2;
    mover_run(m, 60);
    duet_motion *motion = m->motion;
    const duet_body_list none = {.ids = NULL};
    duet_moved moved;
    must(duet_motion_get_moved(motion, &moved, ERR));
    must(duet_motion_add_bodies(motion, NULL, NULL, 0, NULL, ERR));
    must(duet_motion_remove_bodies(motion, none, ERR));
    must(duet_motion_disable_bodies(motion, none, ERR));
    must(duet_motion_enable_bodies(motion, none, ERR));
    must(duet_motion_set_bodies(motion, none, DUET_BODY_ALL, NULL, ERR));
    must(duet_motion_set_poses(motion, none, NULL, ERR));
    must(duet_motion_set_targets(motion, none, NULL, ERR));
    must(duet_motion_apply_forces(motion, none, NULL, ERR));
    must(duet_motion_apply_impulses(motion, none, NULL, ERR));
    must(duet_motion_wake_bodies(motion, none, ERR));
    mover_run(m, 1);
    assert_false(m->last.rebuilt);
    assert_int_equal(m->last.n_stages, 0); // all sleeps on
    must(duet_motion_get_moved(motion, &moved, ERR));
    assert_int_equal(moved.n, 0);
}

// The data that the step's end sent to the device is waited for once; the group's end counts.
TEST(a_file_can_be_loaded_right_after_a_step_with_forces)
{
    mover *m = make_rows(2, 1);
    mover_run(m, 1);
    const duet_force lift = {.force = {0, 0, 30}};
    must(duet_motion_apply_forces(m->motion, one(1), &lift, ERR));
    must(duet_motion_save(m->motion, path, ERR));
    for (int k = 0; k < 3; ++k) {
        must(duet_motion_advance(m->motion, &m->last, ERR));
        must(duet_motion_load(m->motion, path, ERR));
    }
    mover_run(m, 1);
    assert_true(m->states[1].velocity[2] > 0.1);
}

TEST(a_body_that_came_by_a_file_is_told_as_moved)
{
    mover *m = make_rows(2, 1);
    mover_run(m, 60);
    duet_moved moved;
    must(duet_motion_save(m->motion, path, ERR));
    must(duet_motion_get_moved(m->motion, &moved, ERR));
    must(duet_motion_remove_bodies(m->motion, one(1), ERR));
    mover_run(m, 1);
    must(duet_motion_get_moved(m->motion, &moved, ERR));
    must(duet_motion_load(m->motion, path, ERR));
    must(duet_motion_get_moved(m->motion, &moved, ERR));
    assert_int_equal(moved.n, 3);
}

// A body that went has left no trace in how the others are computed.
TEST(a_body_of_another_kind_that_went_is_forgotten_in_a_file_too)
{
    mover *m = make_rows(3, 2);
    m->bodies[1].angular_velocity[0] = 2;
    m->bodies[1].angular_velocity[2] = 1;
    mover_run(m, 1);
    const duet_pose brick = {{-4, 0, 5}, {0.5f, 0.25f, 0.125f}, {0, 0, 0, 1}};
    duet_body elastic = duet_default_body();
    elastic.restitution = 0.9f;
    uint64_t id;
    must(duet_motion_add_bodies(m->motion, &brick, &elastic, 1, &id, ERR));
    mover_run(m, 1);
    must(duet_motion_remove_bodies(m->motion, by_ids(&id, 1), ERR));
    const duet_pose high = {{0.3f, 0.2f, 6}, {0.5f, 0.5f, 0.5f}, {0.3f, 0.1f, 0, 1}};
    const duet_body turns = {.angular_velocity = {3, 1, 2}};
    must(duet_motion_set_poses(m->motion, one(2), &high, ERR));
    must(duet_motion_set_bodies(m->motion, one(2), DUET_BODY_ANGULAR_VELOCITY, &turns, ERR));
    mover_run(m, 1);
    must(duet_motion_save(m->motion, path, ERR));
    mover *fresh = make_rows(3, 2);
    fresh->bodies[1] = m->bodies[1];
    mover_run(fresh, 0);
    must(duet_motion_load(fresh->motion, path, ERR));
    for (int k = 0; k < 8; ++k) {
        mover_run_alike(m, fresh, 10);
    }
}

TEST(all_bodies_can_go_and_others_come)
{
    for (uint32_t dims = 2; dims <= 3; ++dims)
        for (int mode = 0; mode < 3; ++mode) {
            mover *m = mover_new(dims);
            m->def.gravity[dims - 1] = -9.81;
            m->def.wants = DUET_EFFECT_SLEEP | DUET_EFFECT_EVENTS | DUET_EFFECT_ANGULAR_VELOCITY;
            m->def.plan.mode = (duet_mode)mode;
            m->def.plan.share = DUET_SHARE_ONE / 2;
            m->def.skin = 0.1 * mode;
            for (int i = 0; i < 9; ++i)
                mover_add_cube(m, 0.5 * i, 0, 0, 1);
            mover_run(m, 2);
            assert_true(m->last.contacts > 0);
            const duet_body_list all = {.n = 9};
            must(duet_motion_remove_bodies(m->motion, all, ERR));
            mover_run(m, 1);
            assert_true(m->last.contacts == 0 && m->last.n_stays == 0 && m->last.n_events > 0);
            mover_run(m, 2);
            assert_true(m->last.pairs == 0 && m->last.n_events == 0);
            uint64_t ids[9];
            must(duet_motion_add_bodies(m->motion, m->poses, NULL, 9, ids, ERR));
            assert_true(ids[8] == ((UINT64_C(1) << 32) | 8));
            mover_run(m, 2);
            assert_true(m->last.contacts > 0);
            mover_assert_finite(m);
        }
}

// At once, and one in the place of the other.
TEST(bodies_in_the_same_place_part)
{
    mover *m = make_rows(2, 1);
    mover_run(m, 60);
    duet_pose poses[8];
    for (int i = 0; i < 8; ++i)
        poses[i] = m->poses[1];
    must(duet_motion_add_bodies(m->motion, poses, NULL, 8, NULL, ERR));
    m->n += 8;
    mover_run(m, 240);
    mover_assert_finite(m);
}

TEST(what_moves_without_mass_wakes_in_every_kind_of_world)
{
    for (int kind = 0; kind < 5; ++kind) {
        mover *m = make_rows(2, 1);
        uint32_t ram = mover_add_fixed(m, -4, 0, 0.6, 1, 0.5, 0.5);
        m->def.skin = kind == 1 ? 0.5 : 0;
        m->def.wants |= kind == 2 ? DUET_EFFECT_CONTINUOUS : 0;
        m->def.doubles = kind == 3;
        m->bodies[ram].velocity[0] = kind < 4 ? 1 : 0;
        if (kind == 4) { // its corner comes round
            m->poses[ram].centre[0] = -1.6f;
            m->bodies[ram].angular_velocity[2] = 0.12f;
        }
        mover_run(m, 60);
        assert_true(mover_speed(m, 1) == 0.0);
        mover_run(m, 180);
        assert_true(fabs(m->states[1].centre[0]) > 0.005);
    }
}

// ------------------------------------------------------------ recordings

static mover *make_player(uint32_t share, duet_mode mode)
{
    mover *m = make_rows(3, 2);
    m->def.wants |= DUET_EFFECT_EVENTS | DUET_EFFECT_FILTER | DUET_EFFECT_SENSORS;
    m->def.plan.share = share;
    m->def.plan.mode = mode;
    mover_add_fixed(m, 9, 0, 4, 0.5, 0.5, 0.5);
    mover_run(m, 5);
    return m;
}

// Every command once, with steps between them.
static void command_all(mover *m)
{
    duet_motion *motion = m->motion;
    const duet_pose poses[2] = {{{-4, 0, 5}, {0.5f, 0.25f, 0.5f}, {0, 0, 0.2f, 1}},
                                {{3, 0, 6}, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}}};
    duet_body bodies[2] = {duet_default_body(), duet_default_body()};
    bodies[0].fixed_rotation = true;
    bodies[1].sensor = true;
    const uint64_t data[2] = {7, UINT64_MAX};
    const duet_force force = {.force = {5, 0, 20}};
    const duet_impulse impulse = {.impulse = {0, 1, 0}, .anchor = {0.5f, 0, 0}};
    const duet_transform there = {{9, 0, 4.5f}, {0, 0, 0, 1}};
    uint64_t ids[2];
    must(duet_motion_remove_bodies(motion, one(6), ERR));
    mover_run(m, 1);
    must(duet_motion_add_bodies(motion, poses, bodies, 2, ids, ERR));
    must(duet_motion_set_user_data(motion, by_ids(ids, 2), data, ERR));
    must(duet_motion_apply_forces(motion, one(2), &force, ERR));
    must(duet_motion_apply_impulses(motion, one(4), &impulse, ERR));
    must(duet_motion_set_targets(motion, one(7), &there, ERR));
    mover_run(m, 3);
    must(duet_motion_disable_bodies(motion, one(5), ERR));
    must(duet_motion_sleep_bodies(motion, one(1), ERR));
    must(
        duet_motion_set_bodies(motion, one(3), DUET_BODY_VELOCITY | DUET_BODY_FILTER, bodies, ERR));
    mover_run(m, 2);
    must(duet_motion_enable_bodies(motion, one(5), ERR));
    must(duet_motion_wake_bodies(motion, one(1), ERR));
    must(duet_motion_set_poses(motion, by_ids(ids, 1), poses, ERR));
    duet_motion_def def = *duet_motion_get_def(motion);
    def.gravity[0] = 0.5;
    must(duet_motion_set_def(motion, &def, ERR));
    mover_run(m, 20);
    must(duet_motion_remove_bodies(motion, by_ids(ids, 1), ERR));
}

TEST(recorded_commands_give_the_same_hash_with_any_plan)
{
    mover *m = make_player(0, DUET_MODE_OWN);
    must(duet_motion_record(m->motion, ERR));
    command_all(m);
    must(duet_motion_save_recording(m->motion, path, ERR));
    mover *other = make_player(DUET_SHARE_ONE / 2, DUET_MODE_SLAB);
    duet_replay *replay = kept(duet_replay_create(path, ERR));
    duet_replay_info info = duet_replay_get_info(replay);
    assert_true(info.steps == 26 && info.commands == 14);
    for (uint64_t i = 0; i < info.steps; ++i)
        must(duet_replay_advance(replay, other->motion, &other->last, ERR));
    assert_true(mover_hash(m) == mover_hash(other));
    assert_true(m->last.step == other->last.step);
    uint64_t data = 0;
    must(duet_motion_get_user_data(other->motion, one(8), &data, ERR));
    assert_true(data == UINT64_MAX);
    must_fail(duet_replay_advance(replay, other->motion, &other->last, ERR), ANY_FAILURE,
              "steps are done");
    replay = kept(duet_replay_create(path, ERR));
    must_fail(duet_replay_advance(replay, other->motion, &other->last, ERR), ANY_FAILURE,
              "recorded from step 5, 8 places");
    must(duet_motion_save(m->motion, path, ERR));
    must(duet_motion_load(m->motion, path, ERR));
    must_fail(duet_motion_save_recording(m->motion, path, ERR), ANY_FAILURE, "nothing is recorded");
}

static void sum_file(unsigned char *bytes, size_t n)
{
    uint64_t sum = text_checksum((const char *)bytes, n - 8);
    memcpy(bytes + n - 8, &sum, 8);
}

// Words of a recording that are changed, with a sum that is right: each is refused by one
// line, or is done.
TEST(forged_recordings_are_refused_or_done)
{
    mover *m = make_player(0, DUET_MODE_OWN);
    must(duet_motion_record(m->motion, ERR));
    command_all(m);
    must(duet_motion_save_recording(m->motion, path, ERR));
    text file = {0}, forged = {0};
    must(text_read_file(&file, path, ERR));
    must(text_read_file(&forged, path, ERR));
    rng r = rng_seed(test_seed());
    static const uint32_t words[] = {0, 1, UINT32_MAX, 0x7fc00000, 0x7f800000, 14, 1u << 30};
    uint32_t refused = 0, tries = 60;
    for (uint32_t i = 0; i < tries; ++i) {
        duet_error why = {0};
        size_t at = 40 + 4 * (size_t)rng_below(&r, (uint32_t)(file.length - 56) / 4);
        memcpy(forged.chars, file.chars, file.length);
        memcpy(forged.chars + at, &words[rng_below(&r, 7)], 4);
        size_t length =
            i % 8 == 0 ? file.length - rng_below(&r, (uint32_t)file.length) : file.length;
        if (length > 8)
            sum_file((unsigned char *)forged.chars, length);
        must(text_write_file(path, forged.chars, length, ERR));
        duet_replay *replay = duet_replay_create(path, &why);
        mover *other = replay ? make_player(0, DUET_MODE_OWN) : NULL;
        duet_replay_info info = duet_replay_get_info(replay);
        bool ok = replay;
        for (uint64_t step = 0; ok && step < info.steps && step < 40; ++step)
            ok = duet_replay_advance(replay, other->motion, &other->last, &why);
        refused += !ok;
        if (!ok && (why.text[0] == 0 || strchr(why.text, '\n')))
            fail_msg("word %zu: '%s'", at / 4, why.text);
        duet_replay_destroy(replay);
        if (other)
            mover_free(other);
    }
    assert_true(refused > tries / 4);
    text_free(&file);
    text_free(&forged);
}
