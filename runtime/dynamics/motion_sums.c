// SPDX-License-Identifier: MIT
// Sums over a motion's state: its hash, and its energy and momentum.
#include "runtime/bodies/vector.h"
#include "runtime/dynamics/motion_commands.h"

#include "base/error.h"
#include "base/exact_sum.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// -0 counts as 0: which of the two a sum of nothing is does not matter.
static uint64_t mix(uint64_t sum, double value, uint64_t place)
{
    double plain = value + 0.0;
    uint64_t k;
    memcpy(&k, &plain, sizeof k);
    k ^= place * UINT64_C(0x9E3779B97F4A7C15);
    k *= UINT64_C(0xBF58476D1CE4E5B9);
    k ^= k >> 29;
    k *= UINT64_C(0x94D049BB133111EB);
    return sum + (k ^ k >> 32);
}

uint64_t motion_hash_state(uint64_t sum, const duet_state *state, uint64_t id)
{
    const size_t numbers = sizeof *state / sizeof(double);
    const double *values = (const double *)state;
    for (size_t k = 0; k < numbers; ++k)
        sum = mix(sum, values[k], id * numbers + k + 1);
    return sum;
}

bool duet_motion_get_hash(duet_motion *m, uint64_t *hash, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!motion_is_whole(m, __func__, err) || !error_given(hash, __func__, "hash", err))
        return false;
    duet_state *states = motion_read_states(m, err);
    if (!states)
        return false;
    *hash = 0;
    for (uint32_t id = 0; id < m->n; ++id)
        *hash = motion_hash_state(*hash, &states[id], id);
    free(states);
    return true;
}

// Axis k of a box turned by q, |q| = 1.
static void axis_of(const double q[4], int k, double axis[3])
{
    double x = q[0], y = q[1], z = q[2], w = q[3];
    const double columns[3][3] = {
        {1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
        {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
        {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)},
    };
    memcpy(axis, columns[k], sizeof columns[k]);
}

static double potential_of(const duet_motion_def *def, const duet_state *s, double mass)
{
    if (def->attraction != 0.0) {
        double to[3] = {def->centre[0] - s->centre[0], def->centre[1] - s->centre[1],
                        def->dims == 3 ? def->centre[2] - s->centre[2] : 0.0};
        return -mass * def->attraction / sqrt(vector_dot(to, to, 3));
    }
    return -mass * vector_dot(def->gravity, s->centre, 3);
}

// Exact sums of what each object has: the same bits in any order of the objects.
typedef struct energy_sums {
    exact_sum kinetic, turning, potential;
    exact_sum momentum[3], angular[3];
} energy_sums;

static void add_turning(const duet_motion *m, uint32_t id, const duet_state *s, energy_sums *e)
{
    double inverse[3];
    motion_inverse_inertia(m, id, inverse);
    for (int k = 0; k < 3; ++k) {
        double axis[3];
        axis_of(s->rotation, k, axis);
        double along = vector_dot(axis, s->angular_velocity, 3);
        double inertia = inverse[k] > 0.0 ? 1.0 / inverse[k] : 0.0;
        exact_sum_add(&e->turning, 0.5 * inertia * along * along);
        for (int j = 0; j < 3; ++j)
            exact_sum_add(&e->angular[j], inertia * along * axis[j]);
    }
}

static void add_object(const duet_motion *m, uint32_t id, const duet_state *s, energy_sums *e)
{
    double mass = m->bodies[id].mass;
    double swing[3];
    vector_cross(s->centre, s->velocity, swing);
    exact_sum_add(&e->kinetic, 0.5 * mass * vector_dot(s->velocity, s->velocity, 3));
    if (m->effects & DUET_EFFECT_GRAVITY)
        exact_sum_add(&e->potential, potential_of(&m->def, s, mass));
    for (int k = 0; k < 3; ++k) {
        exact_sum_add(&e->momentum[k], mass * s->velocity[k]);
        exact_sum_add(&e->angular[k], mass * swing[k]);
    }
    add_turning(m, id, s, e);
}

static duet_energy round_sums(const energy_sums *e)
{
    duet_energy energy = {.kinetic = exact_sum_round(&e->kinetic),
                          .turning = exact_sum_round(&e->turning),
                          .potential = exact_sum_round(&e->potential)};
    for (int k = 0; k < 3; ++k) {
        energy.momentum[k] = exact_sum_round(&e->momentum[k]);
        energy.angular[k] = exact_sum_round(&e->angular[k]);
    }
    return energy;
}

bool duet_motion_get_energy(duet_motion *m, duet_energy *energy, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!motion_is_whole(m, __func__, err) || !error_given(energy, __func__, "energy", err))
        return false;
    duet_state *states = motion_read_states(m, err);
    if (!states)
        return false;
    energy_sums sums = {0};
    for (uint32_t id = 0; id < m->n; ++id)
        if (m->bodies[id].mass > 0.0f && !motion_is_hidden(m, id))
            add_object(m, id, &states[id], &sums);
    free(states);
    *energy = round_sums(&sums);
    return true;
}
