// SPDX-License-Identifier: MIT
// Bodies for the solver.
//
// Invariant: between prepare_bodies and finalize_bodies `bodies` is what moves, and the state stays as
// the step began. A sleeping body has no velocity, no mass and no inertia there, as a wall.
//
//   prepare_bodies        state -> bodies
//   integrate_velocities  each substep: gravity, drag, forces, the impulses to warm start with
//   finalize_bodies       bodies -> state, and rest times
//
//   bodies [n + FIXED][BODY]  the last are the walls and the ground

// ------------------------------------------------------------ prepare

// The inverse inertia of a turned box along the world's axes.
static inline void put_inertia(float4 body[BODY], real4 rotation, float4 inverse)
{
    real4 axis[3];
    box_axes(rotation, axis);
    float4 u = convert_float4(axis[0]), v = convert_float4(axis[1]), w = convert_float4(axis[2]);
    float4 a = u * inverse.x, b = v * inverse.y, c = w * inverse.z;
    body[BODY_DELTA_POSITION].w = fma(a.x, u.x, fma(b.x, v.x, c.x * w.x));
    body[BODY_ANGULAR_VELOCITY].w = fma(a.y, u.y, fma(b.y, v.y, c.y * w.y));
    body[BODY_INERTIA] = (float4)(fma(a.z, u.z, fma(b.z, v.z, c.z * w.z)), fma(a.x, u.y, fma(b.x, v.y, c.x * w.y)),
                                  fma(a.x, u.z, fma(b.x, v.z, c.x * w.z)), fma(a.y, u.z, fma(b.y, v.z, c.y * w.z)));
}

static inline void prepare_turn(const state *s, uint id, float4 body[BODY])
{
    const bool wall = id >= s->n;
    body[BODY_DELTA_ROTATION].w = 1.0f;
    if (ROUNDED && !wall)
        body[BODY_ARC].w = s->halves[id].w;
    if (wall)
        return;
    body[BODY_ANGULAR_VELOCITY].xyz = convert_float4(s->angular_velocities[id]).xyz;
    put_inertia(body, s->rotations[id], s->inertias[id]);
}

static inline void put_to_sleep(float4 body[BODY])
{
    body[BODY_VELOCITY] = (float4)(0.0f);
    if (!ANGULAR_VELOCITY)
        return;
    body[BODY_ANGULAR_VELOCITY] = (float4)(0.0f);
    body[BODY_INERTIA] = (float4)(0.0f);
    body[BODY_DELTA_POSITION].w = 0.0f;
}

// Prepares all rows, so that no part of a body's line is read.
static inline void prepare_body(const state *s, uint id, float4 body[BODY])
{
    const bool wall = id >= s->n;
#pragma unroll
    for (uint row = 0; row < BODY; ++row)
        body[row] = (float4)(0.0f);
    if (!wall)
        body[BODY_VELOCITY] = convert_float4(s->velocities[id]);
    if (ANGULAR_VELOCITY)
        prepare_turn(s, id, body);
    if (SLEEP && !wall && (s->asleep[id] & SLEEPS))
        put_to_sleep(body);
}

// Whether a body woke in this step or fell asleep, since it was prepared.
static inline bool is_turned_over(const state *s, uint id, __global const float4 *body)
{
    return (s->asleep[id] & WOKE) || ((s->asleep[id] & SLEEPS) && body[BODY_VELOCITY].w > 0.0f);
}

// The body that comes k-th: those awake, then all that never move, which a step prepares once.
static inline uint id_to_prepare(const state *s, __global const float4 *bodies, uint k)
{
    const uint n_here = N_AWAKE_OF(s);
    if (k >= n_here)
        return k < n_here + FIXED && !(SLEEP && s->woken) ? s->n + (k - n_here) : NO_BODY;
    const uint id = AWAKE_OF(s, k);
    return SLEEP && s->woken && !is_turned_over(s, id, bodies + (size_t)id * BODY) ? NO_BODY : id;
}

__kernel void prepare_bodies(PREPARE_BODIES_ARGS)
{
    const state s = {PREPARE_BODIES_VALUES};
    BODY_LINES(lines);
    if (SLEEP && s.woken && !s.flags[FLAG_FELL_ASLEEP])
        return;
    for (uint turn = 0; turn < PER_ITEM; ++turn) {
        const uint id = id_to_prepare(&s, bodies, k_of(turn));
        float4 body[BODY];
        if (id != NO_BODY)
            prepare_body(&s, id, body);
        store_body(&lines, bodies, id, ~0u, body);
        END_TURN;
    }
}

// ------------------------------------------------------------ a substep

__kernel void integrate_velocities(INTEGRATE_VELOCITIES_ARGS)
{
    const state s = {INTEGRATE_VELOCITIES_VALUES};
    BODY_LINES(lines);
    const uint n_here = N_AWAKE;
    for (uint turn = 0; turn < PER_ITEM; ++turn) {
        const uint k = k_of(turn), id = k < n_here ? AWAKE_AT(k) : NO_BODY;
        float4 body[BODY];
        load_body(&lines, bodies, id, ~0u, body);
        if (id != NO_BODY)
            accelerate_body(&s, id, body);
        store_body(&lines, bodies, id, ACCELERATED_ROWS, body);
        END_TURN;
    }
}

// ------------------------------------------------------------ finalize

// Seconds of rest. A body that trembles between others goes to sleep as well: a moment above the
// speed takes back twice its time, and only haste takes all.
static inline float rest_after(const state *s, uint id, float fastest, float inverse_mass)
{
    float slow = s->sleep_speed * s->sleep_speed, rest = inverse_mass > 0.0f ? fmax(0.0f, s->rests[id]) : 0.0f;
    float rested = fastest < slow ? rest + s->dt : fastest < HASTE * slow ? rest - 2.0f * s->dt : 0.0f;
    return inverse_mass > 0.0f ? fmax(0.0f, fmin(rested, fmax(s->sleep_after, s->dt))) : 0.0f;
}

// The square of the speed of the centre and, at most, of a corner about it.
static inline float fastest_square(const state *s, uint id, float4 velocity, float4 angular_velocity)
{
    float fastest = dot_float(velocity, velocity);
    if (!ANGULAR_VELOCITY)
        return fastest;
    float4 half_size = s->halves[id];
    float square = dot_float(half_size, half_size);
    if (ROUNDED)
        square = fma(half_size.w, half_size.w, square);
    return fastest + dot_float(angular_velocity, angular_velocity) * square;
}

#define MOVED_ROWS                                           \
    (ROW_BIT(BODY_VELOCITY) | ROW_BIT(BODY_DELTA_POSITION) | \
     (ANGULAR_VELOCITY ? ROW_BIT(BODY_ANGULAR_VELOCITY) | ROW_BIT(BODY_DELTA_ROTATION) : 0u))

__kernel void finalize_bodies(FINALIZE_BODIES_ARGS)
{
    const state s = {FINALIZE_BODIES_VALUES};
    BODY_LINES(lines);
    if (WAITS_FOR_HOST)
        return;
    const uint n_here = N_AWAKE;
    for (uint turn = 0; turn < PER_ITEM; ++turn) {
        const uint k = k_of(turn), id = k < n_here ? AWAKE_AT(k) : NO_BODY;
        const bool sleeps = SLEEP && id != NO_BODY && (s.asleep[id] & SLEEPS);
        float4 body[BODY];
        load_body(&lines, bodies, id, MOVED_ROWS, body);
        if (sleeps) {
            velocities[id].xyz = (real)0;
#if ANGULAR_VELOCITY
            angular_velocities[id] = (real4)(0);
#endif
        }
        if (id != NO_BODY && !sleeps) {
            float4 velocity = body[BODY_VELOCITY], angular_velocity = (float4)(0.0f);
            real4 centre = centres[id];
            centre.xyz += convert_real4(body[BODY_DELTA_POSITION]).xyz;
            if (ORIGIN)
                normalize_offset(&centre, s.cells + id);
            centres[id] = centre;
            velocities[id].xyz = convert_real4(velocity).xyz;
#if ANGULAR_VELOCITY
            angular_velocity = body[BODY_ANGULAR_VELOCITY];
            rotations[id] = turned_by(rotations[id], convert_real4(body[BODY_DELTA_ROTATION]));
            angular_velocities[id].xyz = convert_real4(angular_velocity).xyz;
#endif
            if (SLEEP)
                s.rests[id] = rest_after(&s, id, fastest_square(&s, id, velocity, angular_velocity), velocity.w);
        }
        END_TURN;
    }
}
