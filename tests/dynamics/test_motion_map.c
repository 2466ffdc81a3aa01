// SPDX-License-Identifier: MIT
// Mapped states: what is written is what is sent, as by the commands that set the same.
#include "support/mover.h"
#include "support/test.h"

#include "runtime/dynamics/motion.h"

enum { CUBES = 24 };

// Cubes above a floor, at place 0, that stay apart for a while.
static mover *make_shower(uint32_t dims, bool doubles)
{
    mover *m = mover_new(dims);
    m->def.doubles = doubles;
    m->def.wants = DUET_EFFECT_SLEEP | DUET_EFFECT_ANGULAR_VELOCITY | DUET_EFFECT_MOTION;
    mover_add_floor(m, 20.0);
    for (int i = 0; i < CUBES; ++i)
        mover_add_rough_cube(m, 1.5 * (i % 5), 1.0 + i / 5, dims == 3 ? 0.3 * i : 0.0);
    mover_run(m, 2);
    return m;
}

static void *map(mover *m, duet_state_part part, duet_map_access access, uint32_t first, uint32_t n)
{
    return must(duet_motion_map_states(m->motion, part, access, first, n, ERR));
}

static void unmap(mover *m, duet_state_part part)
{
    must(duet_motion_unmap_states(m->motion, part, ERR));
}

static void set_host_memory(bool host)
{
    for (int side = 0; side < 2; ++side)
        default_pair()->devices[side].info.host_memory = host;
}

// ------------------------------------------------------------ facts

// Places 3 to 7 are put elsewhere and thrown, in one motion by commands.
static void write_some(mover *by_map, mover *by_command, bool doubles)
{
    duet_pose poses[5];
    duet_body bodies[5];
    const duet_body_list list = {.first = 3, .n = 5};
    void *rows[3];
    for (int part = 0; part < 3; ++part)
        rows[part] = map(by_map, (duet_state_part)part, DUET_MAP_WRITE, 3, 5);
    for (int i = 0; i < 5; ++i) {
        bool solid = by_map->def.dims == 3;
        const float numbers[3][4] = {{2.0f * (float)i, 9.5f, solid ? 1.25f : 0.0f, 0},
                                     {solid ? 0.5f : 0.0f, 0, 0.25f * (float)i, 1.5f},
                                     {1.0f, -3.0f, solid ? 0.5f : 0.0f, 77.0f}};
        for (int part = 0; part < 3; ++part)
            for (int k = 0; k < 4; ++k) {
                if (doubles)
                    ((double *)rows[part])[4 * i + k] = (double)numbers[part][k];
                else
                    ((float *)rows[part])[4 * i + k] = numbers[part][k];
            }
        poses[i] = by_map->poses[3 + i];
        memcpy(poses[i].centre, numbers[0], sizeof poses[i].centre);
        memcpy(poses[i].rotation, numbers[1], sizeof poses[i].rotation);
        bodies[i] = by_map->bodies[3 + i];
        memcpy(bodies[i].velocity, numbers[2], sizeof bodies[i].velocity);
    }
    for (int part = 0; part < 3; ++part)
        unmap(by_map, (duet_state_part)part);
    must(duet_motion_set_poses(by_command->motion, list, poses, ERR));
    must(duet_motion_set_bodies(by_command->motion, list, DUET_BODY_VELOCITY, bodies, ERR));
}

static void written_is_as_set_in(uint32_t dims, bool doubles)
{
    mover *by_map = make_shower(dims, doubles), *by_command = make_shower(dims, doubles);
    const uint64_t before = mover_hash(by_map);
    write_some(by_map, by_command, doubles);
    assert_true(mover_hash(by_map) != before);
    for (int i = 0; i < 3; ++i) {
        assert_true(mover_hash(by_map) == mover_hash(by_command));
        mover_run(by_map, 20);
        mover_run(by_command, 20);
    }
}

TEST(what_is_written_is_what_is_set)
{
    bool host = default_pair()->devices[1].info.host_memory;
    written_is_as_set_in(3, false);
    written_is_as_set_in(2, false);
    set_host_memory(false);
    written_is_as_set_in(3, false);
    set_host_memory(host);
    if (default_pair()->devices[1].info.fp64)
        written_is_as_set_in(3, true);
}

TEST(what_is_read_is_the_state_without_a_copy)
{
    static const duet_state_part all[] = {DUET_STATE_CENTRES, DUET_STATE_ROTATIONS,
                                          DUET_STATE_VELOCITIES, DUET_STATE_ANGULAR_VELOCITIES};
    static const motion_buffer buffers[] = {CENTRES, ROTATIONS, VELOCITIES, ANGULAR_VELOCITIES};
    mover *m = make_shower(3, false);
    mover_run(m, 30);
    const uint64_t hash = mover_hash(m);
    for (int p = 0; p < 4; ++p) {
        const float *rows = map(m, all[p], DUET_MAP_READ, 1, CUBES);
        const buffer *b = &m->motion->buffers[buffers[p]];
        if (b->host)
            assert_ptr_equal(rows, (const float *)b->host + 4);
        for (uint32_t i = 0; i < CUBES; ++i) {
            const duet_state *s = &m->states[i + 1];
            const double *parts[] = {s->centre, s->rotation, s->velocity, s->angular_velocity};
            for (int k = 0; k < (p == 1 ? 4 : 3); ++k)
                assert_true((double)rows[4 * i + (uint32_t)k] == parts[p][k]);
        }
        if (p == 2)
            assert_true(rows[3] == 1.0f / m->bodies[1].mass);
    }
    for (int p = 0; p < 4; ++p)
        unmap(m, all[p]);
    assert_true(mover_hash(m) == hash);
}

// But that everything wakes.
TEST(what_is_mapped_and_not_written_stays_bit_for_bit)
{
    mover *m = make_shower(3, false), *same = make_shower(3, false);
    for (int i = 0; i < 3; ++i) {
        for (int part = 0; part < 4; ++part)
            map(m, (duet_state_part)part, DUET_MAP_WRITE, 0, m->n);
        for (int part = 0; part < 4; ++part)
            unmap(m, (duet_state_part)part);
        assert_true(mover_hash(m) == mover_hash(same));
        mover_run(m, 5);
        mover_run(same, 5);
    }
}

TEST(a_row_that_is_no_number_stays_mapped_to_be_mended)
{
    mover *m = make_shower(3, false);
    float *centres = map(m, DUET_STATE_CENTRES, DUET_MAP_WRITE, 2, 4);
    float *rotations = map(m, DUET_STATE_ROTATIONS, DUET_MAP_WRITE, 2, 4);
    const float kept = centres[4 + 1];
    float turned[4];
    memcpy(turned, rotations + 12, sizeof turned);
    centres[4 + 1] = NAN;
    memset(rotations + 12, 0, sizeof turned);
    must_fail(duet_motion_unmap_states(m->motion, DUET_STATE_CENTRES, ERR), DUET_STATUS_BAD_OBJECT,
              "row 1 of 4 of the centres: a number of it is not finite");
    must_fail(duet_motion_unmap_states(m->motion, DUET_STATE_ROTATIONS, ERR),
              DUET_STATUS_BAD_OBJECT, "row 3 of 4 of the rotations: it is no rotation");
    centres[4 + 1] = kept;
    memcpy(rotations + 12, turned, sizeof turned);
    unmap(m, DUET_STATE_CENTRES);
    unmap(m, DUET_STATE_ROTATIONS);
    mover_run(m, 2);
    mover_assert_finite(m);
}

TEST(a_sleeper_that_is_written_wakes_and_a_target_is_forgotten)
{
    mover *m = make_shower(3, false);
    mover_run(m, 240);
    assert_true(product_is_right(&m->motion->products, PRODUCT_BODIES));
    float *velocities = map(m, DUET_STATE_VELOCITIES, DUET_MAP_WRITE, CUBES, 1);
    velocities[1] = 4.0f;
    unmap(m, DUET_STATE_VELOCITIES);
    const double height = m->states[CUBES].centre[1];
    mover_run(m, 3);
    assert_true(m->states[CUBES].centre[1] > height + 0.1);

    const duet_transform target = {.centre = {0, -4.0f, 0}, .rotation = {0, 0, 0, 1}};
    const duet_body_list floor = {.first = 0, .n = 1};
    must(duet_motion_set_targets(m->motion, floor, &target, ERR));
    map(m, DUET_STATE_VELOCITIES, DUET_MAP_WRITE, 0, 1);
    unmap(m, DUET_STATE_VELOCITIES);
    const double before = m->states[0].centre[1];
    mover_run(m, 1);
    assert_true(m->states[0].centre[1] == before);
}

TEST(a_disabled_body_stands_still_whatever_is_written)
{
    mover *m = make_shower(3, false);
    const duet_body_list fifth = {.first = 5, .n = 1};
    must(duet_motion_disable_bodies(m->motion, fifth, ERR));
    float *velocities = map(m, DUET_STATE_VELOCITIES, DUET_MAP_WRITE, 4, 3);
    velocities[4] = 9.0f;
    velocities[7] = 1.0f;
    unmap(m, DUET_STATE_VELOCITIES);
    mover_run(m, 1);
    const double at = m->states[5].centre[0];
    mover_run(m, 2);
    assert_true(m->states[5].centre[0] == at && m->states[5].velocity[0] == 0.0);
}

TEST(while_states_are_mapped_other_calls_are_refused)
{
    duet_motion_result result;
    duet_state states[CUBES + 1];
    uint64_t hash;
    mover *m = make_shower(3, false);
    const duet_body_list list = {.first = 1, .n = 1};
    map(m, DUET_STATE_VELOCITIES, DUET_MAP_READ, 0, 2);
#define REFUSED(call)                         \
    must_fail(call, DUET_STATUS_BAD_ARGUMENT, \
              "velocities are mapped; expected duet_motion_unmap_states first")
    REFUSED(duet_motion_advance(m->motion, &result, ERR));
    REFUSED(duet_motion_get_states(m->motion, states, ERR));
    REFUSED(duet_motion_get_hash(m->motion, &hash, ERR));
    REFUSED(duet_motion_wake_bodies(m->motion, list, ERR));
    REFUSED(duet_motion_set_poses(m->motion, list, m->poses, ERR));
    REFUSED(duet_motion_add_bodies(m->motion, m->poses, NULL, 1, NULL, ERR));
    REFUSED(duet_motion_set_def(m->motion, &m->def, ERR));
    REFUSED(duet_motion_save(m->motion, "mapped.duet", ERR));
    REFUSED(duet_motion_load(m->motion, "mapped.duet", ERR));
    assert_int_equal(duet_motion_get_count(m->motion), m->n);
    must_fail(duet_motion_map_states(m->motion, DUET_STATE_VELOCITIES, DUET_MAP_READ, 0, 1, ERR),
              DUET_STATUS_BAD_ARGUMENT, "velocities are mapped already");
    mover_free(m); // mapped as it is
}

TEST(what_cannot_be_mapped_is_refused_by_name)
{
    mover *plain = mover_new(3);
    mover_add_cube(plain, 0, 0, 0, 1);
    plain->bodies[0].velocity[0] = 1.0f;
    mover_run(plain, 1);
    duet_motion *m = plain->motion;
    const struct {
        int part, access;
        uint32_t first, n;
        const char *says;
    } wrong[] = {
        {9, DUET_MAP_READ, 0, 1, "part is 9; expected a duet_state_part"},
        {DUET_STATE_CENTRES, 5, 0, 1, "access is 5; expected a duet_map_access"},
        {DUET_STATE_CENTRES, DUET_MAP_READ, 1, 1, "places 1 to 2; the motion has 1 places"},
        {DUET_STATE_CENTRES, DUET_MAP_READ, 0, UINT32_MAX, "the motion has 1 places"},
        {DUET_STATE_ANGULAR_VELOCITIES, DUET_MAP_READ, 0, 1, "needs the effect angular_velocity"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i)
        must_fail(duet_motion_map_states(m, (duet_state_part)wrong[i].part,
                                         (duet_map_access)wrong[i].access, wrong[i].first,
                                         wrong[i].n, ERR),
                  DUET_STATUS_BAD_ARGUMENT, wrong[i].says);
    must_fail(duet_motion_unmap_states(m, DUET_STATE_CENTRES, ERR), DUET_STATUS_BAD_ARGUMENT,
              "centres are not mapped; expected duet_motion_map_states first");
    assert_string_equal(duet_state_part_name(DUET_STATE_ROTATIONS), "rotations");
    assert_null(duet_state_part_name((duet_state_part)9));
    map(plain, DUET_STATE_CENTRES, DUET_MAP_WRITE, 1, 0); // a map of no rows
    unmap(plain, DUET_STATE_CENTRES);
    must(duet_motion_record(m, ERR));
    must_fail(duet_motion_map_states(m, DUET_STATE_CENTRES, DUET_MAP_WRITE, 0, 1, ERR),
              DUET_STATUS_BAD_ARGUMENT, "what is written in place is not recorded");
    map(plain, DUET_STATE_CENTRES, DUET_MAP_READ, 0, 1);
}

// ---------------------------------------------------------------- states of some bodies, against
// those of all

enum { SOME = 100 };

static mover *new_pile(int way)
{
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_SLEEP;
    m->def.sleep_speed = 0.3;
    m->def.sleep_after = 0.2;
    m->def.doubles = way == 1;
    mover_add_pile(m, SOME);
    if (way == 2) {
        m->def.boundary = DUET_BOUNDARY_NONE;
        m->def.origin_edge = 1;
        m->def.origin[0] = 1e6;
    }
    for (uint32_t id = 20; id < 25; ++id)
        m->bodies[id].mass = 0;
    return m;
}

TEST(states_of_ids_are_those_of_all)
{
    rng r = rng_seed(test_seed());
    for (int way = 0; way < 3; ++way) {
        mover *m = new_pile(way);
        for (int step = 0; step < 5; ++step) {
            uint32_t ids[SOME / 2];
            duet_state some[SOME / 2];
            mover_run(m, 10);
            for (int i = 0; i < SOME / 2; ++i)
                ids[i] = rng_below(&r, SOME);
            must(duet_motion_get_states_of(m->motion, ids, SOME / 2, some, ERR));
            for (int i = 0; i < SOME / 2; ++i)
                assert_memory_equal(&some[i], &m->states[ids[i]], sizeof some[i]);
        }
    }
}

static bool is_elsewhere(const duet_state *a, const duet_state *b)
{
    return memcmp(a->centre, b->centre, sizeof a->centre) != 0 ||
           memcmp(a->rotation, b->rotation, sizeof a->rotation) != 0;
}

TEST(what_moved_is_what_differs_from_the_last_read)
{
    for (int way = 0; way < 3; ++way) {
        mover *m = new_pile(way);
        static duet_state last[SOME];
        uint32_t still = 0;
        for (int read = 0; read < 60; ++read) {
            duet_moved moved;
            mover_run(m, 1 + read % 4);
            must(duet_motion_get_moved(m->motion, &moved, ERR));
            uint32_t at = 0;
            for (uint32_t id = 0; id < m->n; ++id) {
                if (read > 0 && !is_elsewhere(&last[id], &m->states[id]))
                    continue;
                assert_true(at < moved.n);
                assert_int_equal(moved.places[at], id);
                assert_memory_equal(&moved.states[at], &m->states[id], sizeof last[id]);
                ++at;
            }
            assert_int_equal(at, moved.n);
            still += m->n - at;
            memcpy(last, m->states, sizeof last);
        }
        assert_true(still > 5 * 59);
    }
}

TEST(nothing_moved_where_everything_rests)
{
    duet_moved moved;
    mover *m = mover_new(2);
    mover_add_cube(m, 0, 0, 0, 1);
    mover_run(m, 1);
    must(duet_motion_get_moved(m->motion, &moved, ERR));
    assert_int_equal(moved.n, 1);
    mover_run(m, 3);
    must(duet_motion_get_moved(m->motion, &moved, ERR));
    assert_int_equal(moved.n, 0);
}

// A turn of 90 degrees about z, and half of it.
TEST(half_way_is_half_of_the_turn)
{
    const double half = sqrt(0.5);
    const duet_state from = {.centre = {1, 2, 3}, .rotation = {0, 0, 0, 1}, .velocity = {4, 0, 0}};
    const duet_state to = {.centre = {3, 2, 7},
                           .rotation = {0, 0, -half, -half}}; // the same as half, half
    duet_state middle = duet_state_between(&from, &to, 0.5);
    assert_true(middle.centre[0] == 2 && middle.centre[1] == 2 && middle.centre[2] == 5);
    assert_true(middle.velocity[0] == 2);
    assert_close(middle.rotation[2], sin(acos(-1) / 8), 1e-15);
    assert_close(middle.rotation[3], cos(acos(-1) / 8), 1e-15);
    duet_state begin = duet_state_between(&from, &to, 0), end = duet_state_between(&from, &to, 1);
    assert_memory_equal(&begin, &from, sizeof from);
    assert_true(!memcmp(end.centre, to.centre, sizeof to.centre));
    assert_close(end.rotation[2], half, 1e-15);
    for (int i = 0; i <= 20; ++i) { // within a third of a degree for 45 degrees
        double angle = acos(-1) / 4, t = i / 20.0;
        const duet_state turned = {.rotation = {0, 0, sin(angle / 2), cos(angle / 2)}};
        duet_state at = duet_state_between(&from, &turned, t);
        assert_close(2 * atan2(at.rotation[2], at.rotation[3]), t * angle, 0.0058);
    }
}
