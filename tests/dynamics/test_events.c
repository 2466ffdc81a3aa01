// SPDX-License-Identifier: MIT
// Events of a motion. The truth is taken from the contacts' records, each step anew, and
// from falls whose end is known.
#include "support/commands.h"

#include "runtime/dynamics/motion.h"

static const char path[] = "motion"; // name of the file that a test saves

// ---------------------------------------------------------------- against the records

enum { PILE = 60, WIDE = PILE + MOTION_WALLS };

typedef struct touching {
    bool pair[PILE][WIDE];
} touching;

static void read(duet_motion *m, motion_buffer which, void *to, size_t bytes)
{
    must(timeline_read(&m->times, "test", &m->buffers[which], to, bytes, ERR));
}

// From all records, whatever order they are in.
static touching *what_touches(duet_motion *m)
{
    touching *t = calloc(1, sizeof *t);
    uint32_t n = m->graph.n_contacts;
    uint32_t(*links)[2] = calloc(n + 1, sizeof *links);
    uint32_t *touches = test_alloc((n + 1) * sizeof *touches);
    float *records = test_alloc(((size_t)n + 1) * m->layout.record * sizeof *records);
    if (n > 0) {
        read(m, LINKS, links, n * sizeof *links);
        read(m, TOUCHES, touches, n * sizeof *touches);
        read(m, CONTACTS, records, (size_t)n * m->layout.record * sizeof *records);
    }
    for (uint32_t i = 0; i < n; ++i)
        for (uint32_t k = 0; k < (touches[i] & TOUCH_POINTS); ++k) {
            const float *point = records + (size_t)i * m->layout.record + m->layout.head +
                                 (size_t)k * m->layout.point;
            bool pushes = (m->effects & DUET_EFFECT_CONTACT_RESPONSE) && point[OF_MAX_IMPULSE] > 0;
            uint32_t a = links[i][0], b = links[i][1];
            if (point[OF_SEPARATION] <= 0 || pushes)
                t->pair[a < b ? a : b][a < b ? b : a] = true;
        }
    free(links);
    return t;
}

typedef struct counts {
    uint64_t begins, ends, stays, hits;
} counts;

// Both arrays are exactly what two steps' records say, in order.
static void assert_events(const mover *m, const touching *before, const touching *now,
                          uint32_t event_mask, counts *c)
{
    uint64_t event = 0, stay = 0;
    for (uint32_t a = 0; a < m->n; ++a)
        for (uint32_t b = a + 1; b < m->n + MOTION_WALLS; ++b) {
            uint32_t groups = m->bodies[a].group | (b < m->n ? m->bodies[b].group : 0);
            bool was = before->pair[a][b], is = now->pair[a][b];
            if (!(groups & event_mask) || (!was && !is))
                continue;
            if (was && is) {
                assert_true(stay < m->last.n_stays);
                assert_true(m->last.stays[stay].a == a && m->last.stays[stay].b == b);
                ++stay;
                continue;
            }
            assert_true(event < m->last.n_events);
            const duet_event *e = &m->last.events[event++];
            assert_true(e->a == a && e->b == b && e->begins == is);
            c->begins += is;
            c->ends += was;
        }
    assert_int_equal(event, m->last.n_events);
    assert_int_equal(stay, m->last.n_stays);
    c->stays += stay;
}

static void assert_hits(const mover *m, counts *c)
{
    for (uint64_t i = 0; i < m->last.n_hits; ++i) {
        const duet_hit_event *h = &m->last.hits[i];
        assert_true(h->a < h->b && h->speed > m->def.hit_speed && h->impulse > 0);
        assert_true(i == 0 || h[-1].a < h->a || (h[-1].a == h->a && h[-1].b < h->b));
        bool told = false;
        for (uint64_t k = 0; k < m->last.n_events; ++k)
            told |= m->last.events[k].a == h->a && m->last.events[k].b == h->b &&
                    m->last.events[k].begins;
        for (uint64_t k = 0; k < m->last.n_stays; ++k)
            told |= m->last.stays[k].a == h->a && m->last.stays[k].b == h->b;
        assert_true(told);
    }
    c->hits += m->last.n_hits;
}

// Boxes without mass among those that fall, and walls.
static mover *new_pile(void)
{
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_EVENTS | DUET_EFFECT_SLEEP;
    m->def.hit_speed = 1.0;
    m->def.sleep_speed = 0.3;
    m->def.sleep_after = 0.2;
    mover_add_pile(m, PILE);
    for (uint32_t id = 20; id < 25; ++id)
        m->bodies[id].mass = 0;
    return m;
}

static counts run_and_compare(mover *m, uint32_t steps)
{
    counts c = {0};
    touching *before = m->motion ? what_touches(m->motion) : calloc(1, sizeof *before);
    for (uint32_t i = 0; i < steps; ++i) {
        mover_run(m, 1);
        touching *now = what_touches(m->motion);
        assert_events(m, before, now, m->def.event_mask, &c);
        assert_hits(m, &c);
        free(before);
        before = now;
    }
    free(before);
    return c;
}

TEST(events_are_those_of_the_records)
{
    for (int way = 0; way < 3; ++way) {
        mover *m = new_pile();
        m->def.skin = way == 1 ? 0.2 : 0;
        m->def.doubles = way == 2;
        counts c = run_and_compare(m, 150);
        assert_true(c.begins > 2 * PILE && c.ends > PILE / 2 && c.stays > 50 * PILE);
        assert_true(c.hits > PILE / 2);
        print_message("%d begin, %d end, %d hit\n", (int)c.begins, (int)c.ends, (int)c.hits);
    }
}

TEST(a_mask_leaves_the_events_of_its_groups)
{
    mover *m = new_pile();
    for (uint32_t id = 0; id < m->n; ++id)
        m->bodies[id].group = id % 6 == 0 ? 2 : 1;
    m->def.event_mask = 2;
    counts c = run_and_compare(m, 100);
    assert_true(c.begins > PILE / 6);
    for (uint64_t i = 0; i < m->last.n_stays; ++i)
        assert_true(m->last.stays[i].a % 6 == 0 || m->last.stays[i].b % 6 == 0);
}

TEST(without_response_events_are_overlaps)
{
    mover *m = mover_new(2);
    m->def.wants = DUET_EFFECT_EVENTS;
    for (uint32_t i = 0; i < PILE; ++i) {
        uint32_t id = mover_add_cube(m, i % 8 * 1.5, i / 8 * 1.5, 0, 1);
        m->bodies[id].velocity[0] = (float)(i % 3) - 1.0f;
        m->bodies[id].velocity[1] = (float)(i % 5) - 2.0f;
    }
    counts c = run_and_compare(m, 120);
    assert_true(c.begins > PILE && c.ends > PILE && c.hits == 0);
}

// ---------------------------------------------------------------- closed forms

static const double fall = 1.0, gravity = 9.81;

// A unit cube whose lower face is `fall` above a floor.
static mover *new_fall(uint32_t dims, float restitution)
{
    mover *m = mover_new(dims);
    uint32_t floor = mover_add_floor(m, 5);
    uint32_t cube = dims == 3 ? mover_add_rough_cube(m, 0, 0, 0.5 + fall)
                              : mover_add_rough_cube(m, 0, 0.5 + fall, 0);
    m->bodies[floor].restitution = m->bodies[cube].restitution = restitution;
    m->def.wants |= DUET_EFFECT_EVENTS;
    m->def.hit_speed = 0.5;
    return m;
}

typedef struct story {
    uint32_t begins, ends, hits;
    uint64_t first_begin, first_hit, first_end;
    duet_hit_event first;
} story;

static story run_story(mover *m, uint32_t steps)
{
    story s = {0};
    for (uint32_t i = 0; i < steps; ++i) {
        mover_run(m, 1);
        for (uint64_t k = 0; k < m->last.n_events; ++k) {
            const duet_event *e = &m->last.events[k];
            assert_true(e->a == 0 && e->b == 1);
            if (e->begins && s.begins++ == 0)
                s.first_begin = m->last.step;
            if (!e->begins && s.ends++ == 0)
                s.first_end = m->last.step;
        }
        assert_true(m->last.n_hits <= 1);
        if (m->last.n_hits == 1 && s.hits++ == 0) {
            s.first_hit = m->last.step;
            s.first = m->last.hits[0];
        }
    }
    return s;
}

TEST(a_cube_that_falls_begins_once_and_hits_once)
{
    for (uint32_t dims = 2; dims <= 3; ++dims) {
        mover *m = new_fall(dims, 0);
        m->def.wants |= DUET_EFFECT_SLEEP;
        story s = run_story(m, 240);
        double speed = sqrt(2 * gravity * fall), time = sqrt(2 * fall / gravity);
        assert_int_equal(s.begins, 1);
        assert_int_equal(s.ends, 0);
        assert_int_equal(s.hits, 1);
        assert_int_equal(s.first_hit, s.first_begin);
        assert_close((double)s.first_hit * m->def.dt, time, 1.5 * m->def.dt);
        assert_close(s.first.speed, speed, 1.5 * gravity * m->def.dt);
        assert_close(s.first.impulse, speed, 0.1 * speed); // its mass is 1
        assert_true(s.first.normal[dims - 1] == 1);        // from the floor to the cube
        assert_close(s.first.point[dims - 1], 0, speed * m->def.dt);
        assert_close(fabs(s.first.point[0]), 0.5, 0.02);
        assert_int_equal(m->last.n_stays, 1); // asleep
        assert_int_equal(m->last.n_stages, 0);
    }
}

TEST(a_cube_that_bounces_ends_when_it_leaves)
{
    mover *m = new_fall(3, 1);
    const uint32_t bounce = (uint32_t)(2 * sqrt(2 * fall / gravity) / m->def.dt);
    story s = run_story(m, 4 * bounce);
    assert_in_range(s.hits, 3, 4);
    assert_int_equal(s.begins, s.hits);
    assert_in_range(s.ends, s.begins - 1, s.begins);
    assert_in_range(s.first_end, s.first_hit + 1, s.first_hit + 3);
}

TEST(a_hit_far_away_is_where_it_is)
{
    for (int way = 0; way < 2; ++way) {
        mover *m = new_fall(3, 0);
        m->def.doubles = way == 0;
        m->def.origin_edge = way == 0 ? 0 : 1;
        m->def.origin[0] = 1e7;
        story s = run_story(m, 60);
        assert_int_equal(s.hits, 1);
        assert_close(fabs(s.first.point[0] - 1e7), 0.5, 0.02);
    }
}

// ---------------------------------------------------------------- the same

static uint64_t hash_events(const mover *m, uint64_t sum)
{
    const duet_motion_result *r = &m->last;
    for (uint64_t i = 0; i < r->n_events; ++i)
        sum = sum * 1000003 + r->events[i].a * 977 + 2 * r->events[i].b + r->events[i].begins;
    for (uint64_t i = 0; i < r->n_stays; ++i)
        sum = sum * 1000003 + r->stays[i].a * 977 + r->stays[i].b;
    for (uint64_t i = 0; i < r->n_hits; ++i) {
        const duet_hit_event *h = &r->hits[i];
        double numbers[8] = {h->point[0],  h->point[1],  h->point[2], h->normal[0],
                             h->normal[1], h->normal[2], h->speed,    h->impulse};
        for (int k = 0; k < 8; ++k) {
            uint64_t bits;
            memcpy(&bits, &numbers[k], sizeof bits);
            sum = sum * 1000003 + bits;
        }
    }
    return sum;
}

TEST(share_and_launch_change_no_event)
{
    uint64_t expected = 0;
    duet_device_info *info = &default_pair()->devices[1].info;
    duet_device_kind kind = info->kind;
    for (int way = 0; way < 4; ++way) {
        mover *m = new_pile();
        m->def.plan.share = way == 1 ? DUET_SHARE_ONE / 2 : 0;
        m->def.plan.mode = way == 2 ? DUET_MODE_SLAB : DUET_MODE_OWN;
        info->kind = way == 3 ? DUET_KIND_GPU : kind;
        uint64_t sum = 0;
        for (int i = 0; i < 100; ++i) {
            mover_run(m, 1);
            info->kind = kind;
            sum = hash_events(m, sum);
        }
        if (way == 0)
            expected = sum;
        assert_true(sum == expected);
    }
}

TEST(a_loaded_motion_tells_what_the_saved_one_does)
{
    mover *m = new_pile(), *other = new_pile();
    m->def.skin = other->def.skin = 0.2;
    mover_run(m, 80);
    must(duet_motion_save(m->motion, "events.motion", ERR));
    mover_run(other, 30);
    must(duet_motion_load(other->motion, "events.motion", ERR));
    for (int i = 0; i < 60; ++i) {
        mover_run(m, 1);
        mover_run(other, 1);
        assert_true(hash_events(m, 0) == hash_events(other, 0));
    }
}

// ---------------------------------------------------------------- sensors

// A floor, and a cube on it that goes to sleep, and one above that falls.
static mover *make_cubes(bool doubles)
{
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_EVENTS | DUET_EFFECT_SLEEP | DUET_EFFECT_SENSORS;
    m->def.sleep_after = 0.1;
    m->def.doubles = doubles;
    mover_add_floor(m, 20);
    mover_add_rough_cube(m, 0, 0, 0.5);
    mover_add_rough_cube(m, 5, 0, 4);
    return m;
}

static uint32_t add_sensor(mover *m, double x, double z, double half)
{
    uint32_t id = mover_add_fixed(m, x, 0, z, half, half, half);
    m->bodies[id].sensor = true;
    return id;
}

static counts events_with(const mover *m, uint32_t id)
{
    counts c = {0};
    for (uint64_t i = 0; i < m->last.n_events; ++i)
        if (m->last.events[i].a == id || m->last.events[i].b == id)
            ++*(m->last.events[i].begins ? &c.begins : &c.ends);
    for (uint64_t i = 0; i < m->last.n_stays; ++i)
        c.stays += m->last.stays[i].a == id || m->last.stays[i].b == id;
    return c;
}

// Runs the mover and adds up a sensor's events.
static counts run_sensor(mover *m, uint32_t id, uint32_t steps)
{
    counts sum = {0};
    for (uint32_t i = 0; i < steps; ++i) {
        mover_run(m, 1);
        counts c = events_with(m, id);
        sum.begins += c.begins;
        sum.ends += c.ends;
        sum.stays += c.stays;
    }
    return sum;
}

TEST(what_falls_through_a_sensor_is_told_and_not_pushed)
{
    for (int doubles = 0; doubles < 2; ++doubles) {
        mover *m = make_cubes(doubles), *without = make_cubes(doubles);
        uint32_t sensor = add_sensor(m, 5, 2, 0.25);
        counts c = run_sensor(m, sensor, 90);
        mover_run(without, 90);
        assert_true(c.begins == 1 && c.ends == 1 && c.stays > 5 && c.stays < 40);
        assert_memory_equal(m->states, without->states, 3 * sizeof *m->states);
        assert_true(mover_speed(m, 2) == 0.0); // asleep
    }
}

TEST(a_sensor_sees_what_sleeps_and_does_not_wake_it)
{
    mover *m = make_cubes(false);
    uint32_t still = add_sensor(m, 0, 1, 0.3), guide = add_sensor(m, -5, 0.5, 0.3);
    mover_run(m, 120);
    assert_int_equal(events_with(m, still).stays, 1); // the cube, not the floor
    assert_int_equal(events_with(m, guide).stays, 0);
    assert_int_equal(m->last.n_stages, 0); // all sleeps
    const duet_body goes = {.velocity = {2, 0, 0}};
    const duet_body_list list = {.first = guide, .n = 1};
    must(duet_motion_set_bodies(m->motion, list, DUET_BODY_VELOCITY, &goes, ERR));
    counts c = run_sensor(m, guide, 360);
    assert_true(c.begins == 2 && c.ends == 2 && c.stays > 60);
    assert_close(mover_speed(m, 1) + mover_speed(m, 2), 0, 0);
    duet_pose away = m->poses[still];
    away.centre[0] = 9;
    const duet_body_list other = {.first = still, .n = 1};
    must(duet_motion_set_poses(m->motion, other, &away, ERR));
    mover_run(m, 1);
    assert_int_equal(events_with(m, still).ends, 1);
    assert_close(mover_speed(m, 1), 0, 0);
}

// A body without mass is seen as well: a lift that passes while all sleeps, and a floor.
TEST(a_sensor_without_mass_sees_what_has_none)
{
    for (int skin = 0; skin < 2; ++skin) {
        mover *m = make_cubes(false), *without = make_cubes(false);
        m->def.skin = without->def.skin = 0.1 * skin;
        for (int k = 0; k < 2; ++k) {
            mover *one = k ? without : m;
            mover_add_fixed(one, -8, 0, 3, 0.4, 0.4, 0.4);
        }
        uint32_t still = add_sensor(m, -5, 3, 0.3), low = add_sensor(m, -9, 0, 0.3);
        uint32_t masked = add_sensor(m, 9, 0, 0.3);
        m->bodies[0].group = 2;
        m->bodies[masked].mask = 1;
        m->def.wants |= DUET_EFFECT_FILTER;
        mover_run(m, 1);
        assert_int_equal(events_with(m, low).begins, 1);
        mover_run(m, 119);
        mover_run(without, 120);
        assert_int_equal(events_with(m, low).stays, 1);
        assert_int_equal(events_with(m, still).stays + events_with(m, masked).stays, 0);
        assert_int_equal(m->last.n_stages, 0); // all sleeps
        const duet_body goes = {.velocity = {2, 0, 0}};
        const duet_body_list lift = {.first = 3, .n = 1};
        must(duet_motion_set_bodies(m->motion, lift, DUET_BODY_VELOCITY, &goes, ERR));
        must(duet_motion_set_bodies(without->motion, lift, DUET_BODY_VELOCITY, &goes, ERR));
        counts c = run_sensor(m, still, 180);
        mover_run(without, 180);
        assert_true(c.begins == 1 && c.ends == 1 && c.stays > 30 && c.stays < 60);
        assert_memory_equal(m->states, without->states, 4 * sizeof *m->states);
    }
}

// Sensors fall through floors, walls and each other, and see what their masks allow.
TEST(sensors_do_not_see_sensors_and_fall_through_all)
{
    mover *m = make_cubes(false);
    mover_wall_in(m, -9, 9);
    uint32_t falls = add_sensor(m, 0, 2, 0.3), other = add_sensor(m, 0, 2.2, 0.3);
    uint32_t blind = add_sensor(m, 0, 0.5, 0.3);
    m->bodies[falls].mass = m->bodies[other].mass = 1;
    m->bodies[blind].mask = 2;
    m->bodies[falls].group = m->bodies[1].group = 1;
    counts c = run_sensor(m, falls, 120);
    assert_true(c.begins == 2 && c.ends == 2); // the cube and the floor
    assert_true(m->states[falls].centre[2] < -10);
    assert_int_equal(events_with(m, blind).stays, 0);
}

TEST(a_sensor_that_came_by_a_command_is_saved)
{
    mover *m = make_cubes(false), *fresh = make_cubes(false);
    mover_run(m, 10);
    mover_run(fresh, 1);
    const duet_pose pose = {{5, 0, 2}, {0.25f, 0.25f, 0.25f}, {0, 0, 0, 1}};
    duet_body sensor = duet_default_body();
    sensor.mass = 0;
    sensor.sensor = true;
    must(duet_motion_add_bodies(m->motion, &pose, &sensor, 1, NULL, ERR));
    must(duet_motion_save(m->motion, path, ERR));
    must(duet_motion_load(fresh->motion, path, ERR));
    m->n = fresh->n = 4;
    counts c = run_sensor(m, 3, 90), d = run_sensor(fresh, 3, 90);
    assert_true(c.begins == 1 && c.ends == 1 && c.stays == d.stays && d.begins == 1);
    assert_true(mover_hash(m) == mover_hash(fresh));
}
