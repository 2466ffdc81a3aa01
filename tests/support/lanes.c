// SPDX-License-Identifier: MIT
#include "support/lanes.h"
#include "support/test.h"

mover *lanes_new(uint32_t dims)
{
    mover *m = mover_new(dims);
    m->def.slop = LANES_SLOP;
    m->def.gravity[dims - 1] = -9.81;
    m->def.wants = DUET_EFFECT_CONTACT_RESPONSE;
    return m;
}

uint32_t lanes_add_fixed(mover *m, const double at[3], const double half[3])
{
    uint32_t id = mover_add_fixed(m, at[0], at[1], at[2], half[0], half[1], half[2]);
    m->bodies[id].friction = 1; // only a rolling ball has some, too
    return id;
}

double lanes_place(int lane)
{
    return 4.0 * lane;
}

void lanes_add(mover *m, int lane, const paving *p, rng *r)
{
    uint32_t up = m->def.dims - 1;
    int wide = up == 2 && !p->one_box ? 1 : 0, tiles = p->one_box ? 1 : TILES;
    double half[3] = {0.5, 0.5, 0.5}, x = p->one_box ? 0.5 * (TILES - 1) : 0;
    if (p->one_box)
        half[0] = 0.5 * TILES;
    if (p->one_box && up == 2)
        half[1] = 1.5;
    for (int i = 0; i < tiles; ++i, x += 1 + p->gap * rng_between(r, 0, 1))
        for (int j = -wide; j <= wide; ++j) {
            double at[3] = {x, lanes_place(lane) + j, 0};
            at[up] = (up == 1 ? lanes_place(lane) : 0) - 0.5 - p->uneven * rng_between(r, 0, 1);
            lanes_add_fixed(m, at, half);
        }
}

uint32_t lanes_add_glider(mover *m, int shape, int lane, double speed)
{
    static const double halves[SHAPES][3] = {
        {0, 0, 0}, {0, 0, 0}, {0.3, 0, 0}, {0, 0.3, 0}, {0.2, 0.3, 0.1}};
    uint32_t up = m->def.dims - 1;
    double radius = shape == ROUNDED_BOX ? 0.05 : 0.25;
    double half[3] = {halves[shape][0], halves[shape][up == 1 ? 2 : 1], halves[shape][2]};
    double at[3] = {0, lanes_place(lane) + 0.1, 0};
    at[up] = (up == 1 ? lanes_place(lane) : 0) + radius + half[up];
    uint32_t id = mover_add(m, at[0], at[1], at[2], half[0], half[1], half[2]);
    m->bodies[id].radius = (float)radius;
    m->bodies[id].velocity[0] = (float)speed;
    if (shape == ROLLING) {
        m->bodies[id].friction = 1;
        m->bodies[id].angular_velocity[up == 2 ? 1 : 2] = (float)(up == 2 ? speed : -speed) * 4;
    }
    return id;
}

static void turn_vector(const double k[3], double angle, double v[3])
{
    double along = k[0] * v[0] + k[1] * v[1] + k[2] * v[2], from[3] = {v[0], v[1], v[2]};
    for (int a = 0; a < 3; ++a) {
        int b = (a + 1) % 3, c = (a + 2) % 3;
        v[a] = from[a] * cos(angle) + (k[b] * from[c] - k[c] * from[b]) * sin(angle) +
               k[a] * along * (1 - cos(angle));
    }
}

static void turn_floats(const double k[3], double angle, float v[3])
{
    double turned[3] = {v[0], v[1], v[2]};
    turn_vector(k, angle, turned);
    for (int a = 0; a < 3; ++a)
        v[a] = (float)turned[a];
}

void lanes_turn(mover *m, double x, double y, double z, double angle)
{
    double scale = 1 / sqrt(x * x + y * y + z * z), k[3] = {x * scale, y * scale, z * scale};
    turn_vector(k, angle, m->def.gravity);
    for (uint32_t id = 0; id < m->n; ++id) {
        turn_floats(k, angle, m->poses[id].centre);
        turn_floats(k, angle, m->bodies[id].velocity);
        turn_floats(k, angle, m->bodies[id].angular_velocity);
        mover_turn(m, id, x, y, z, angle);
    }
}
