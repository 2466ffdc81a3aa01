// SPDX-License-Identifier: MIT
#include "support/ground.h"
#include "support/test.h"

const double ground_slop = 0.005;

mover *ground_mover(const duet_heights *heights, const duet_mesh *mesh)
{
    mover *m = mover_new(3);
    m->def.heights = heights;
    m->def.mesh = mesh;
    m->def.gravity[2] = -9.81;
    m->def.slop = ground_slop;
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_CONTINUOUS;
    return m;
}

double ground_flat(double x, double y)
{
    (void)x;
    (void)y;
    return 0;
}

double ground_bowl(double x, double y)
{
    return 0.05 * (x * x + y * y);
}

rng ground_drawn;

double ground_rough(double x, double y)
{
    (void)x;
    (void)y;
    return rng_between(&ground_drawn, -0.6, 0.6);
}

// ---------------------------------------------------------------- bodies

uint32_t ground_add(mover *m, uint32_t kind, double x, double y)
{
    static const double half[GROUND_KINDS][4] = {
        [BALL] = {0, 0, 0, 0.25},
        [ROLLING_BALL] = {0, 0, 0, 0.25},
        [CAPSULE_ALONG] = {0.3, 0, 0, 0.25},
        [CAPSULE_ACROSS] = {0, 0.3, 0, 0.25},
        [ROUNDED] = {0.2, 0.3, 0.1, 0.05},
        [SHARP] = {0.2, 0.3, 0.15, 0},
    };
    const double *h = half[kind];
    uint32_t id = mover_add(m, x, y, h[2] + h[3], h[0], h[1], h[2]);
    m->bodies[id].radius = (float)h[3];
    return id;
}

void ground_add_thrown(mover *m, rng *r, uint32_t kind)
{
    uint32_t id = ground_add(m, kind, rng_between(r, -6, 6), rng_between(r, -6, 6));
    duet_body *b = &m->bodies[id];
    m->poses[id].centre[2] = (float)rng_between(r, 2, 8);
    mover_turn(m, id, rng_normal(r), rng_normal(r), rng_normal(r), rng_between(r, 0, 3));
    b->friction = (float)rng_between(r, 0, 1);
    b->restitution = (float)rng_between(r, 0, 0.5);
    for (int k = 0; k < 3; ++k) {
        b->velocity[k] = (float)(rng_normal(r) * (k == 2 ? 20 : 2));
        b->angular_velocity[k] = (float)(rng_normal(r) * 5);
    }
}

void ground_add_falling(mover *m)
{
    for (uint32_t i = 0; i < 4 * GROUND_KINDS; ++i) {
        uint32_t id = ground_add(m, i % GROUND_KINDS, -6 + 2.1 * (i % 6), -6 + 3.3 * (i / 6.0));
        m->poses[id].centre[2] += 0.3f;
        mover_turn(m, id, 0, 0, 1, 0.7 * i);
        m->bodies[id].friction = 0.5f;
    }
}

void ground_assert_rest(const mover *m)
{
    for (uint32_t id = 0; id < 4 * GROUND_KINDS; ++id) {
        assert_close(m->states[id].centre[2], (double)m->poses[id].centre[2] - 0.3, ground_slop);
        if (!(mover_speed(m, id) < 0.002))
            fail_msg("kind %u goes at %g m/s", id % GROUND_KINDS, mover_speed(m, id));
    }
}

static void add_gliding(mover *m, uint32_t kind, double speed, double direction)
{
    double c = cos(direction), s = sin(direction), along = -29, across = -5 + 2.0 * kind;
    uint32_t id = ground_add(m, kind, c * along - s * across, s * along + c * across);
    mover_turn(m, id, 0, 0, 1, direction);
    m->bodies[id].velocity[0] = (float)(c * speed);
    m->bodies[id].velocity[1] = (float)(s * speed);
    if (kind == ROLLING_BALL) {
        m->bodies[id].friction = 1;
        m->bodies[id].angular_velocity[0] = (float)(-s * speed / 0.25);
        m->bodies[id].angular_velocity[1] = (float)(c * speed / 0.25);
    }
}

void ground_glide(mover *m, double speed, double direction)
{
    for (uint32_t kind = 0; kind < GROUND_KINDS; ++kind)
        add_gliding(m, kind, speed, direction);
    uint32_t steps = (uint32_t)(58 / speed / m->def.dt);
    for (uint32_t i = 0; i < steps; i += 4) {
        mover_run(m, 4);
        for (uint32_t k = 0; k < GROUND_KINDS; ++k) {
            const duet_state *state = &m->states[k];
            double kept =
                (cos(direction) * state->velocity[0] + sin(direction) * state->velocity[1]) / speed;
            double hop = state->centre[2] - (double)m->poses[k].centre[2];
            if (!(kept >= 0.98 && fabs(hop) <= ground_slop))
                fail_msg("kind %u at %g m/s along %g keeps %g and hops %g after %u steps", k, speed,
                         direction, kept, hop, i);
        }
    }
}

// ---------------------------------------------------------------- what becomes of them

double ground_least_of(const duet_contact *c)
{
    double least = INFINITY;
    for (uint32_t k = 0; k < c->n; ++k)
        least = fmin(least, (double)c->points[k].separation);
    return least;
}

void ground_least_separations(mover *m, double *least)
{
    duet_contact *contacts;
    uint64_t n;
    mover_run(m, 1);
    for (uint32_t id = 0; id < m->n; ++id)
        least[id] = INFINITY;
    must(duet_motion_get_contacts(m->motion, &contacts, &n, ERR));
    for (uint64_t i = 0; i < n; ++i)
        if (contacts[i].b == m->n + 6)
            least[contacts[i].a] = fmin(least[contacts[i].a], ground_least_of(&contacts[i]));
    duet_free(contacts);
}

static void add_many_thrown(mover *m, uint64_t seed, uint32_t n)
{
    rng r = rng_seed(seed);
    for (uint32_t k = 0; k < n; ++k)
        ground_add_thrown(m, &r, k % GROUND_KINDS);
}

// The hash of sixty bodies that were thrown, after 90 steps.
static uint64_t hash_of(mover *m, uint32_t share, double skin, bool sleeps)
{
    m->def.plan.share = share;
    m->def.skin = skin;
    m->def.wants |= sleeps ? DUET_EFFECT_SLEEP : 0;
    add_many_thrown(m, 11, 60);
    mover_run(m, 90);
    return mover_hash(m);
}

void ground_assert_same_bits(const duet_heights *h, const duet_mesh *mesh)
{
    uint64_t expected = hash_of(ground_mover(h, mesh), 0, 0, false);
    assert_int_equal(hash_of(ground_mover(h, mesh), DUET_SHARE_ONE / 2, 0, false), expected);
    assert_int_equal(hash_of(ground_mover(h, mesh), DUET_SHARE_ONE, 0.1, false), expected);
    assert_int_equal(hash_of(ground_mover(h, mesh), 0, 0.3, false), expected);
    assert_int_equal(hash_of(ground_mover(h, mesh), 0, 0.3, true),
                     hash_of(ground_mover(h, mesh), DUET_SHARE_ONE / 3, 0.05, true));
}

void ground_assert_refused(const mover *m, const duet_heights *heights, const duet_mesh *mesh,
                           const char *says)
{
    duet_motion_def def = m->def;
    def.heights = heights;
    def.mesh = mesh;
    must_fail(duet_motion_create(&def, m->poses, m->bodies, m->n, ERR), DUET_STATUS_BAD_ARGUMENT,
              says);
}

mover *ground_throw(mover *m, uint32_t steps)
{
    m->def.wants |= DUET_EFFECT_SLEEP;
    m->def.skin = 0.1;
    add_many_thrown(m, 5, 30);
    if (steps > 0)
        mover_run(m, steps);
    return m;
}

void ground_assert_saved(mover *m, mover *other)
{
    must(duet_motion_save(m->motion, "saved", ERR));
    mover_run(m, 50);
    uint64_t expected = mover_hash(m);
    must(duet_motion_load(m->motion, "saved", ERR));
    mover_run(m, 50);
    assert_int_equal(mover_hash(m), expected);
    must(duet_motion_load(other->motion, "saved", ERR));
    mover_run(other, 50);
    assert_int_equal(mover_hash(other), expected);
}

bool ground_replay(mover *m, duet_error *err)
{
    duet_replay *replay = must(duet_replay_create("recorded", ERR));
    duet_motion_result result;
    bool ok = true;
    for (int i = 0; i < 40 && ok; ++i)
        ok = duet_replay_advance(replay, m->motion, &result, err);
    duet_replay_destroy(replay);
    return ok;
}

void ground_assert_recorded(mover *m)
{
    must(duet_motion_save(m->motion, "begin", ERR));
    must(duet_motion_record(m->motion, ERR));
    mover_run(m, 40);
    must(duet_motion_save_recording(m->motion, "recorded", ERR));
    must(duet_motion_load(m->motion, "begin", ERR));
    must(ground_replay(m, ERR));
}
