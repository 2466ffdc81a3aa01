// SPDX-License-Identifier: MIT
// Sums over a motion's state: its hash, and its energy and momentum.
#include "runtime/bodies/vector.h"
#include "runtime/dynamics/motion_commands.h"
#include "runtime/dynamics/motion_state.h"

#include "base/error.h"
#include "base/exact_sum.h"

#include <math.h>
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

static void add_hash(const duet_motion *m, uint32_t place, const duet_state *s, void *sum)
{
    uint64_t *hash = sum;
    (void)m;
    *hash = motion_hash_state(*hash, s, place);
}

bool motion_hash(duet_motion *m, uint64_t *hash, duet_error *err)
{
    *hash = 0;
    return motion_sum_states(m, add_hash, hash, err);
}

bool duet_motion_get_hash(duet_motion *m, uint64_t *hash, duet_error *err)
{
    PUBLIC_CALL(err);
    uint64_t sum;
    if (!motion_is_whole(m, __func__, err) || !error_given(hash, __func__, "hash", err) ||
        !motion_hash(m, &sum, err))
        return false;
    *hash = sum;
    return true;
}

// The axes of a box turned by q, |q| = 1.
static void axes_of(const double q[4], double axes[3][3])
{
    double x = q[0], y = q[1], z = q[2], w = q[3];
    const double columns[3][3] = {
        {1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
        {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
        {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)},
    };
    memcpy(axes, columns, sizeof columns);
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

static bool turns(const duet_state *s)
{
    const double *w = s->angular_velocity;
    return w[0] != 0.0 || w[1] != 0.0 || w[2] != 0.0;
}

// Returns an object's energy of turning, and adds to its angular momentum.
static double turning_of(const duet_motion *m, uint32_t id, const duet_state *s, double angular[3])
{
    double inverse[3], axes[3][3], turning = 0.0;
    motion_inverse_inertia(m, id, inverse);
    axes_of(s->rotation, axes);
    for (int k = 0; k < 3; ++k) {
        double along = vector_dot(axes[k], s->angular_velocity, 3);
        double inertia = inverse[k] > 0.0 ? 1.0 / inverse[k] : 0.0;
        turning += 0.5 * inertia * along * along;
        for (int j = 0; j < 3; ++j)
            angular[j] += inertia * along * axes[k][j];
    }
    return turning;
}

static void add_object(const duet_motion *m, uint32_t id, const duet_state *s, energy_sums *e)
{
    double mass = m->bodies[id].mass, angular[3];
    vector_cross(s->centre, s->velocity, angular);
    for (int k = 0; k < 3; ++k)
        angular[k] *= mass;
    if (turns(s))
        exact_sum_add(&e->turning, turning_of(m, id, s, angular));
    exact_sum_add(&e->kinetic, 0.5 * mass * vector_dot(s->velocity, s->velocity, 3));
    if (m->effects & DUET_EFFECT_GRAVITY)
        exact_sum_add(&e->potential, potential_of(&m->def, s, mass));
    for (int k = 0; k < 3; ++k) {
        exact_sum_add(&e->momentum[k], mass * s->velocity[k]);
        exact_sum_add(&e->angular[k], angular[k]);
    }
}

static void add_energy(const duet_motion *m, uint32_t id, const duet_state *s, void *sum)
{
    if (m->bodies[id].mass > 0.0f && !motion_is_hidden(m, id))
        add_object(m, id, s, sum);
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
    energy_sums sums = {0};
    if (!motion_is_whole(m, __func__, err) || !error_given(energy, __func__, "energy", err) ||
        !motion_sum_states(m, add_energy, &sums, err))
        return false;
    *energy = round_sums(&sums);
    return true;
}
