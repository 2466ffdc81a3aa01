// SPDX-License-Identifier: MIT
// Positions and rotations of the bodies after a substep.
//
// Invariant: a body that neither moves nor turns keeps its bits, and lanes do step for step what
// integrate_free_flight.cl does for one body.
//
//   bodies [n + FIXED][BODY]  the last are the walls and the ground
#if DOUBLE
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#endif

typedef struct {
    ARG_FIELDS
} substep;

static inline void keep_row(__global float4 *bodies, const uint ids[LANES], uint row, real from[8], word wanted)
{
    store_eight((__global float *)bodies, ids, 4 * BODY, 4 * row, from, wanted);
}

static inline vec select_vec(vec no, vec yes, mask where)
{
    return (vec){select(no.x, yes.x, where), select(no.y, yes.y, where), select(no.z, yes.z, where)};
}

// ------------------------------------------------------------ tumbling

static inline void load_four(const float4 rows[LANES], real to[4])
{
#if LANES == 1
    vstore4(rows[0], 0, to);
#else
    for (int k = 0; k < 4; ++k)
        for (int lane = 0; lane < LANES; ++lane)
            ((float *)(to + k))[lane] = rows[lane][k];
#endif
}

// Twice the energy of a turn, on the scale of ratios_of.
static inline real energy_of(vec rates, vec inverse_inertia)
{
    vec i = ratios_of(inverse_inertia);
    return vec_dot((vec){rates.x * inverse(i.x), rates.y * inverse(i.y), rates.z * inverse(i.z)}, rates);
}

// How bodies turn in this substep.
typedef struct {
    quaternion turned; // since the step began
    vec angular;
    // With GYRO:
    mask tumbles; // lanes that turn otherwise than steadily
    vec inverse_inertia;
    quaternion pose;
} rotation;

static inline vec load_inertia(const substep *s, const uint ids[LANES])
{
    float4 rows[LANES];
    real i[4];
    for (uint k = 0; k < LANES; ++k)
        rows[k] = s->inertias[ids[k]];
    load_four(rows, i);
    return (vec){i[0], i[1], i[2]};
}

static inline quaternion load_rotation(const substep *s, const uint ids[LANES])
{
    float4 rows[LANES];
    real q[4];
    for (uint k = 0; k < LANES; ++k)
        rows[k] = convert_float4(s->rotations[ids[k]]);
    load_four(rows, q);
    return (quaternion){q[0], q[1], q[2], q[3]};
}

// Turns bodies that tumble, each about its own axes. A body that turns far in a substep gains no
// energy.
static inline void tumble(const substep *s, const uint ids[LANES], mask moves, rotation *r)
{
    r->inverse_inertia = load_inertia(s, ids);
    r->tumbles = moves & turns_freely(r->inverse_inertia);
    if (!any_lane(r->tumbles))
        return;
    quaternion began = load_rotation(s, ids);
    quaternion now = turn_normalised(turn_product(r->turned, began));
    vec rates = turn_vector(turn_back(now), r->angular);
    mask far = vec_dot(r->angular, r->angular) * s->h * s->h > FAR_TURNED / 16.0f;
    real energy = FAR ? energy_of(rates, r->inverse_inertia) : (real)(0.0f);
    free_rotation(&now, &rates, r->inverse_inertia, s->h);
    if (FAR) {
        real later = energy_of(rates, r->inverse_inertia);
        far &= later > energy;
        if (any_lane(far))
            rates = vec_times(select((real)(1.0f), energy * inverse_root(energy * later), far), rates);
    }
    r->pose = now;
    r->turned = turn_select(r->turned, turn_product(now, turn_back(began)), r->tumbles);
    r->angular = select_vec(r->angular, turn_vector(now, rates), r->tumbles);
}

// The inverse inertia along the world's axes, into the rows that have it (bodies.cl has the same).
static inline void turn_inertia(real place[8], real fast[8], vec inverse, quaternion q, mask where)
{
    real xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z, ww = q.w * q.w;
    vec u = {(ww + xx) - (yy + zz), 2.0f * fma(q.x, q.y, q.w * q.z), 2.0f * fma(q.x, q.z, -(q.w * q.y))};
    vec v = {2.0f * fma(q.x, q.y, -(q.w * q.z)), (ww + yy) - (xx + zz), 2.0f * fma(q.y, q.z, q.w * q.x)};
    vec w = {2.0f * fma(q.x, q.z, q.w * q.y), 2.0f * fma(q.y, q.z, -(q.w * q.x)), (ww + zz) - (xx + yy)};
    vec a = vec_times(inverse.x, u), b = vec_times(inverse.y, v), c = vec_times(inverse.z, w);
    place[7] = select(place[7], fma(a.x, u.x, fma(b.x, v.x, c.x * w.x)), where);
    fast[7] = select(fast[7], fma(a.y, u.y, fma(b.y, v.y, c.y * w.y)), where);
    place[0] = select(place[0], fma(a.z, u.z, fma(b.z, v.z, c.z * w.z)), where);
    place[1] = select(place[1], fma(a.x, u.y, fma(b.x, v.y, c.x * w.y)), where);
    place[2] = select(place[2], fma(a.x, u.z, fma(b.x, v.z, c.x * w.z)), where);
    place[3] = select(place[3], fma(a.y, u.z, fma(b.y, v.z, c.y * w.z)), where);
}

// fast: the row of velocities, which is stored again.
static inline void tumble_lanes(const substep *s, const uint ids[LANES], word wanted, mask turns, vec arc, real fast[8],
                                rotation *r)
{
    tumble(s, ids, turns & (fast[3] > 0.0f), r);
    mask far = r->tumbles & (vec_dot(arc, arc) > FAR_TURNED);
    if (FAR && any_lane(far)) {
        real place[8];
        load_row(s->bodies, ids, BODY_INERTIA, place);
        turn_inertia(place, fast, r->inverse_inertia, r->pose, far);
        keep_row(s->bodies, ids, BODY_INERTIA, place, wanted);
    }
    fast[4] = r->angular.x;
    fast[5] = r->angular.y;
    fast[6] = r->angular.z;
    keep_row(s->bodies, ids, BODY_VELOCITY, fast, wanted);
}

// ------------------------------------------------------------ a substep

static inline void rotate_lanes(const substep *s, const uint ids[LANES], word wanted, mask turns, real fast[8])
{
    real row[8];
    load_row(s->bodies, ids, BODY_DELTA_ROTATION, row);
    rotation r;
    r.turned = (quaternion){row[0], row[1], row[2], row[3]};
    r.angular = (vec){fast[4], fast[5], fast[6]};
    vec arc = {row[4], row[5], row[6]};
    if (FAR)
        arc = vec_add(arc, s->h, r.angular);
    mask steady = turns;
    if (GYRO) {
        tumble_lanes(s, ids, wanted, turns, arc, fast, &r);
        steady &= ~r.tumbles;
    }
    if (any_lane(steady)) {
        quaternion on = turn_normalised(turn_product(exponential(vec_times(s->h, r.angular)), r.turned));
        r.turned = turn_select(r.turned, on, steady);
    }
    real turned[8] = {r.turned.x, r.turned.y, r.turned.z, r.turned.w, arc.x, arc.y, arc.z, row[7]};
    keep_row(s->bodies, ids, BODY_DELTA_ROTATION, turned, wanted);
}

static inline void integrate_lanes(const substep *s, const uint ids[LANES], word wanted)
{
    real fast[8];
    load_row(s->bodies, ids, BODY_VELOCITY, fast);
    mask turns = (fast[4] != 0.0f) | (fast[5] != 0.0f) | (fast[6] != 0.0f);
    mask moves = (fast[0] != 0.0f) | (fast[1] != 0.0f) | (fast[2] != 0.0f) | turns;
    if (!any_lane(moves))
        return;
    real place[8];
    load_row(s->bodies, ids, BODY_INERTIA, place);
    for (int k = 0; k < 3; ++k)
        place[4 + k] = fma((real)(s->h), fast[k], place[4 + k]);
    keep_row(s->bodies, ids, BODY_INERTIA, place, wanted);
    if (any_lane(turns))
        rotate_lanes(s, ids, wanted, turns, fast);
}

static inline void move_body(const substep *s, uint id)
{
    __global float4 *body = s->bodies + (size_t)id * BODY;
    body[BODY_DELTA_POSITION].xyz = fma((float4)(s->h), body[BODY_VELOCITY], body[BODY_DELTA_POSITION]).xyz;
}

#if ANGULAR_VELOCITY

// Listed bodies lie apart, so that no stream brings them: they are asked for 16 places ahead.
static inline void ask_ahead(const substep *s, uint k, uint last)
{
#if SLEEP && LANES > 1
    __global const float4 *ahead = s->bodies + (size_t)s->awake[min(k + 16, last - 1)] * BODY;
    ask_for(ahead);
    ask_for(ahead + BODY - 1);
#endif
}

// Lanes past the last body take it once more and keep nothing.
static inline word list_lanes(const substep *s, uint k, uint last, uint ids[LANES])
{
    word wanted = 0;
    for (uint lane = 0; lane < LANES; ++lane) {
        ids[lane] = min(k + lane, last - 1);
        ((uint *)&wanted)[lane] = k + lane < last;
    }
#if SLEEP
    for (uint lane = 0; lane < LANES && !s->all_awake; ++lane) {
        ids[lane] = s->awake[ids[lane]];
        ask_ahead(s, k + lane, last);
    }
#endif
    return wanted;
}
#endif

__kernel void integrate_positions(INTEGRATE_POSITIONS_ARGS)
{
    const substep s = {INTEGRATE_POSITIONS_VALUES};
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, N_AWAKE);
#if ANGULAR_VELOCITY
    for (uint k = first; k < last; k += LANES) {
        uint ids[LANES];
        word wanted = list_lanes(&s, k, last, ids);
        integrate_lanes(&s, ids, wanted);
    }
#else
    for (uint k = first; k < last; ++k)
        move_body(&s, AWAKE_AT(k));
#endif
}
