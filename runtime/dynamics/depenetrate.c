// SPDX-License-Identifier: MIT
// Takes bodies that begin deep in each other apart before the first step, by positions alone.
// Springs would do it with a velocity, and a column of bodies adds up those of its contacts.
//
// If some contact is deeper than a slop, each that is deeper than a fifth of it moves its bodies
// along its normal, shared by their masses, one contact after the other and to and fro (Gauss and
// Seidel), with the separations as the moves change them. Contacts are then found again, for others
// may touch.
#include "runtime/dynamics/motion_state.h"

#include "base/error.h"

#include <math.h>
#include <stdlib.h>

enum { SWEEPS = 200 };

typedef struct apart {
    const duet_motion *m;
    duet_contact *contacts;
    uint64_t n;
    double (*moves)[3]; // of each body, so far
    double deep;        // contacts that are deeper are parted, to half of that
} apart;

// Walls, what has no mass and what pushes nothing stay.
static double inverse_mass_of(const duet_motion *m, uint32_t id)
{
    return id < m->n && m->bodies[id].mass > 0.0f ? 1.0 / m->bodies[id].mass : 0.0;
}

static bool is_sensor(const duet_motion *m, uint32_t id)
{
    return id < m->n && m->bodies[id].sensor;
}

static double depth_of(const apart *a, const duet_contact *c)
{
    double least = c->points[0].separation, way = 0.0;
    for (uint32_t k = 1; k < c->n; ++k)
        least = fmin(least, c->points[k].separation);
    for (int k = 0; k < 3; ++k) {
        double of_b = c->b < a->m->n ? a->moves[c->b][k] : 0.0;
        way += c->normal[k] * (of_b - a->moves[c->a][k]);
    }
    return -(least + way);
}

static void move(apart *a, uint32_t id, const duet_contact *c, double way)
{
    for (int k = 0; id < a->m->n && k < 3; ++k)
        a->moves[id][k] += way * c->normal[k];
}

// Returns whether the contact was too deep.
static bool part_contact(apart *a, const duet_contact *c)
{
    double of_a = inverse_mass_of(a->m, c->a), of_b = inverse_mass_of(a->m, c->b);
    double depth = depth_of(a, c), all = of_a + of_b;
    if (depth <= a->deep || all == 0.0 || is_sensor(a->m, c->a) || is_sensor(a->m, c->b))
        return false;
    double way = depth - 0.5 * a->deep;
    move(a, c->a, c, -way * of_a / all);
    move(a, c->b, c, way * of_b / all);
    return true;
}

static bool sweep(apart *a, bool back)
{
    bool any = false;
    for (uint64_t i = 0; i < a->n; ++i)
        any |= part_contact(a, &a->contacts[back ? a->n - 1 - i : i]);
    return any;
}

// Puts the bodies that moved where they are now.
static bool place_moved(duet_motion *m, const apart *a, duet_error *err)
{
    uint32_t n = 0, *places = malloc(m->n * sizeof *places + 1);
    if (!places)
        return no_memory(err, "%u bodies", m->n);
    for (uint32_t id = 0; id < m->n; ++id) {
        const double *way = a->moves[id];
        if (way[0] == 0.0 && way[1] == 0.0 && way[2] == 0.0)
            continue;
        for (uint32_t k = 0; k < m->def.dims; ++k)
            m->poses[id].centre[k] = (float)(m->poses[id].centre[k] + way[k]);
        places[n++] = id;
    }
    motion_alter_all(m);
    products_move_bodies(&m->products);
    bool ok = motion_send_places(m, places, n, PART_POSE, err);
    free(places);
    return ok;
}

bool motion_part_deep(duet_motion *m, bool *parted, duet_error *err)
{
    apart a = {.m = m, .deep = m->margin / MOTION_SLOPS};
    bool ok = motion_read_contacts(m, &a.contacts, &a.n, err);
    a.moves = ok ? calloc((size_t)m->n + 1, sizeof *a.moves) : NULL;
    if (ok && !a.moves)
        ok = no_memory(err, "%u bodies", m->n);
    *parted = ok && sweep(&a, false);
    a.deep *= 0.2;
    for (int i = 1; *parted && i < SWEEPS && sweep(&a, i % 2); ++i)
        ;
    ok = ok && (!*parted || place_moved(m, &a, err));
    free(a.contacts);
    free(a.moves);
    return ok;
}
