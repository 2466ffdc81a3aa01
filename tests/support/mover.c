// SPDX-License-Identifier: MIT
#include "support/mover.h"
#include "support/test.h"

void mover_restart(mover *m)
{
    duet_motion_destroy(m->motion);
    m->motion = NULL;
}

static void give_back(void *m)
{
    mover_restart(m);
    free(m);
}

mover *mover_new(uint32_t dims)
{
    mover *m = calloc(1, sizeof *m);
    assert_non_null(m);
    test_keep(m, give_back);
    m->def = duet_default_motion_def();
    m->def.pair = default_pair();
    m->def.plan = duet_default_plan(m->def.pair);
    m->def.dims = dims;
    return m;
}

void mover_free(mover *m)
{
    test_give_back(m);
}

uint32_t mover_add(mover *m, double x, double y, double z, double hx, double hy, double hz)
{
    assert_true(m->n < MOVER_MOST);
    m->poses[m->n] = (duet_pose){.centre = {(float)x, (float)y, (float)z},
                                 .half_extents = {(float)hx, (float)hy, (float)hz},
                                 .rotation = {0, 0, 0, 1}};
    m->bodies[m->n] = duet_default_body();
    return m->n++;
}

uint32_t mover_add_fixed(mover *m, double x, double y, double z, double hx, double hy, double hz)
{
    uint32_t id = mover_add(m, x, y, z, hx, hy, hz);
    m->bodies[id].mass = 0;
    return id;
}

uint32_t mover_add_cube(mover *m, double x, double y, double z, double edge)
{
    return mover_add(m, x, y, z, edge / 2, edge / 2, edge / 2);
}

void mover_wall_in(mover *m, double from, double to)
{
    m->def.boundary = DUET_BOUNDARY_WALLS;
    for (int k = 0; k < 3; ++k) {
        m->def.lower[k] = from;
        m->def.upper[k] = to;
    }
}

void mover_turn(mover *m, uint32_t id, double x, double y, double z, double angle)
{
    double scale = sin(angle / 2) / sqrt(x * x + y * y + z * z);
    float *q = m->poses[id].rotation;
    q[0] = (float)(x * scale);
    q[1] = (float)(y * scale);
    q[2] = (float)(z * scale);
    q[3] = (float)cos(angle / 2);
}

static void make(mover *m)
{
    if (m->motion)
        return;
    m->motion = must(duet_motion_create(&m->def, m->poses, m->bodies, m->n, ERR));
}

void mover_run(mover *m, uint32_t steps)
{
    make(m);
    for (uint32_t i = 0; i < steps; ++i)
        must(duet_motion_advance(m->motion, &m->last, ERR));
    must(duet_motion_get_states(m->motion, m->states, ERR));
}

duet_energy mover_energy(mover *m)
{
    duet_energy energy;
    make(m);
    must(duet_motion_get_energy(m->motion, &energy, ERR));
    return energy;
}

bool mover_has_stage(const mover *m, const char *name)
{
    for (uint32_t i = 0; i < m->last.n_stages; ++i)
        if (strcmp(m->last.stages[i].name, name) == 0)
            return true;
    return false;
}

double mover_speed(const mover *m, uint32_t id)
{
    const double *v = m->states[id].velocity;
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

double mover_greatest_speed(const mover *m)
{
    double greatest = 0.0;
    for (uint32_t id = 0; id < m->n; ++id)
        greatest = fmax(greatest, mover_speed(m, id));
    return greatest;
}

void mover_assert_finite(const mover *m)
{
    const double *numbers = (const double *)m->states;
    for (size_t i = 0; i < m->n * sizeof m->states[0] / sizeof(double); ++i)
        if (!isfinite(numbers[i]))
            fail_msg("number %zu of object %zu is not finite", i % 13, i / 13);
}

uint32_t mover_add_floor(mover *m, double half)
{
    uint32_t k = m->def.dims - 1;
    m->def.gravity[k] = -9.81;
    m->def.wants |= DUET_EFFECT_CONTACT_RESPONSE;
    uint32_t id = mover_add(m, 0, 0, 0, half, half, half);
    m->poses[id].half_extents[k] = 0.5f;
    m->poses[id].centre[k] = -0.5f;
    m->bodies[id].mass = 0.0f;
    m->bodies[id].friction = 0.6f;
    return id;
}

uint32_t mover_add_rough_cube(mover *m, double x, double y, double z)
{
    uint32_t id = mover_add_cube(m, x, y, z, 1);
    m->bodies[id].friction = 0.6f;
    return id;
}

void mover_add_pile(mover *m, uint32_t n)
{
    m->def.gravity[2] = -9.81;
    m->def.boundary = DUET_BOUNDARY_WALLS;
    m->def.upper[0] = m->def.upper[1] = 6.0;
    m->def.upper[2] = 40.0;
    for (uint32_t i = 0; i < n; ++i) {
        uint32_t id = mover_add(m, 0.7 + 1.1 * (i % 5), 0.7 + 1.1 * (i / 5 % 5), 1 + 1.2 * (i / 25),
                                0.4, 0.3 + 0.02 * (i % 7), 0.5);
        mover_turn(m, id, 1, i % 3, i % 5, 0.1 * (i % 60));
        m->bodies[id].friction = 0.5f;
        m->bodies[id].restitution = 0.2f;
    }
}

void mover_add_pyramid(mover *m, uint32_t rows)
{
    mover_add_floor(m, rows);
    for (uint32_t row = 0; row < rows; ++row)
        for (uint32_t i = 0; i < rows - row; ++i)
            mover_add_rough_cube(m, i - 0.5 * (rows - row - 1), 0, row + 0.5);
}

static void add_card(mover *m, double x, double z, double lean)
{
    uint32_t id = mover_add(m, x, 0, z, 0.01, 0.2, 0.2);
    mover_turn(m, id, 0, 1, 0, lean);
    m->bodies[id].friction = 0.7f;
}

void mover_add_card_house(mover *m, uint32_t levels)
{
    const double lean = 25 * 3.14159265358979323846 / 180, half = 0.2, thin = 0.01;
    double apart = half * sin(lean) + thin * cos(lean); // the middles of a pair from its edge
    double tall = 2 * (half * cos(lean) + thin * sin(lean)), pitch = 2 * half + 0.002, z = 0;
    uint32_t floor = mover_add_floor(m, 5);
    m->bodies[floor].friction = 0.7f;
    for (uint32_t pairs = levels; pairs > 0; --pairs) {
        double first = -0.5 * (pairs - 1) * pitch;
        for (uint32_t i = 0; i < pairs; ++i) {
            add_card(m, first + i * pitch - apart, z + tall / 2, lean);
            add_card(m, first + i * pitch + apart, z + tall / 2, -lean);
        }
        z += tall;
        for (uint32_t i = 0; i + 1 < pairs; ++i)
            add_card(m, first + (i + 0.5) * pitch, z + thin, 3.14159265358979323846 / 2);
        z += 2 * thin;
    }
}

duet_tree *mover_tree(const mover *m)
{
    duet_tree_def def = duet_motion_tree_def(m->motion);
    duet_tree *tree = kept(duet_tree_create(&def, ERR));
    must(duet_tree_set_motion(tree, m->motion, ERR));
    return tree;
}

duet_contact *mover_contacts(mover *m, uint64_t *n)
{
    duet_contact *contacts = NULL;
    must(duet_motion_get_contacts(m->motion, &contacts, n, ERR));
    return test_keep(contacts, duet_free);
}

void mover_run_alike(mover *m, mover *other, uint32_t steps)
{
    mover_run(m, steps);
    mover_run(other, steps);
    assert_true(mover_hash(m) == mover_hash(other));
}

double mover_total(mover *m)
{
    duet_energy e = mover_energy(m);
    return e.kinetic + e.turning + e.potential;
}

duet_pose mover_pose(const mover *m, uint32_t id)
{
    duet_pose pose = m->poses[id];
    for (int k = 0; k < 4; ++k)
        pose.rotation[k] = (float)m->states[id].rotation[k];
    for (int k = 0; k < 3; ++k)
        pose.centre[k] = (float)m->states[id].centre[k];
    return pose;
}

uint64_t mover_hash(mover *m)
{
    uint64_t hash = 0;
    make(m);
    must(duet_motion_get_hash(m->motion, &hash, ERR));
    return hash;
}
