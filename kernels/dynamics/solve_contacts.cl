// SPDX-License-Identifier: MIT
// Solves the contacts of one colour after the other by sequential impulses.
//
// Invariant: contacts of a colour share no body that moves (constraint.clh), so their order does not
// matter and the result is the same on every device.
//
//   a substep:   integrate velocities        (bodies.cl)
//                solve, soft = 1             springs push overlapping points apart
//                integrate positions
//                solve, soft = 0             relaxes: takes back the velocity that springs added
//   a step ends: apply_restitution
//
//   blocks  constraints (constraint.clh)
//   each    contacts of a colour that a work-item takes

__kernel void solve_contacts(SOLVE_CONTACTS_ARGS)
{
    const solver s = {SOLVE_CONTACTS_VALUES};
    colour_parts parts = COLOUR_PARTS;
    colour_part part;
    for (uint colour = from_colour; colour < to_colour; ++colour) {
        BEGIN_COLOUR(parts, colour);
        while (next_part(&parts, &part))
            for (uint k = part.from; k < part.to; k += part.stride)
                solve_part(&s, &part, k);
        END_COLOUR(parts);
    }
}

// ------------------------------------------------------------ restitution

// An impulse at one point speeds up the others too. With one round, and impulses that only
// add to what stopped the impact, they would leave faster than they came, and boxes
// that tumble gain energy without end.
#define RESTITUTION_ROUNDS 8

// Which points bounce: those that came fast enough and pushed. True if any lane has one.
static inline bool find_bouncing(__global const float *constraint, real restitution, float least_speed, mask bounces[POINTS])
{
    word n = points_of(constraint);
    mask any_bounces = 0;
    for (int k = 0; k < POINTS; ++k) {
        bounces[k] = 0;
        if (!any_lane(n > (word)(uint)k))
            continue;
        bounces[k] = (n > (word)(uint)k) & (restitution > 0.0f) & (get(constraint, IN_SPEEDS + k) <= -least_speed);
        if (any_lane(bounces[k]))
            bounces[k] &= get(point_at((__global float *)constraint, k), BY_MAX_IMPULSE) > 0.0f;
        any_bounces |= bounces[k];
    }
    return any_lane(any_bounces);
}

// Gives back, once a step, the impact's part of speed along the normal. A point that is faster
// already gives up some of the impulse that stopped it; a pair that has turned far since gets no more
// than its part of that impulse.
static inline void bounce(pair *p, __global float *constraint, real restitution, const mask bounces[POINTS],
                          const real wanted_speed[POINTS])
{
    real impulses[POINTS] = {0};
    mask turned = FAR ? is_pair_far_turned(p) : (mask)(0);
    int rounds = p->most > 1 ? RESTITUTION_ROUNDS : 1;
    for (int round = 0; round < rounds; ++round) {
        for (int k = 0; k < p->most; ++k) {
            __global const float *point = point_at(constraint, k);
            vec anchor = get_vec(point, BY_ANCHOR);
            real speed = vec_dot(velocity_between(p, anchor), p->normal);
            real more = -get(point, BY_NORMAL_MASS) * (speed - wanted_speed[k]);
            mask asked = bounces[k] & ((p->n > 1u) | (mask)(round == 0 ? -1 : 0));
            real impulse = select(impulses[k], fmax(impulses[k] + more, -get(point, BY_MAX_IMPULSE)), asked);
            if (FAR)
                impulse = select(impulse, fmin(impulse, restitution * get(point, BY_MAX_IMPULSE)), turned);
            apply_impulse(p, anchor, vec_times(impulse - impulses[k], p->normal));
            impulses[k] = impulse;
        }
    }
}

//   fall  what a substep adds to the velocity of all that falls; w: 1 / its time
static inline void restore_speeds(__global float *constraint, __global float4 *bodies, float4 fall, float least_speed)
{
    real restitution = get(constraint, IN_RESTITUTION);
    mask bounces[POINTS];
    if (!find_bouncing(constraint, restitution, least_speed, bounces))
        return;
    pair p;
    load_pair(&p, constraint, bodies);
    if (FAR)
        load_turns(&p, bodies);
    real gain = gain_of(&p, (vec){(real)(fall.x), (real)(fall.y), (real)(fall.z)});
    real wanted_speed[POINTS];
    for (int k = 0; k < p.most; ++k) {
        __global const float *point = point_at(constraint, k);
        wanted_speed[k] = speed_after(get(constraint, IN_SPEEDS + k), restitution, gain, (real)(fall.w),
                                      get(point, BY_SEPARATION), get(point, BY_CURRENT));
    }
    bounce(&p, constraint, restitution, bounces, wanted_speed);
    store_velocity(bodies, p.owner, &p.a);
    store_velocity(bodies, p.other, &p.b);
}

__kernel void apply_restitution(APPLY_RESTITUTION_ARGS)
{
    colour_parts parts = COLOUR_PARTS;
    colour_part part;
    for (uint colour = from_colour; colour < to_colour; ++colour) {
        BEGIN_COLOUR(parts, colour);
        while (next_part(&parts, &part))
            for (uint k = part.from; k < part.to; k += part.stride)
                restore_speeds(constraint_at(blocks, &part, k), bodies, fall, least_speed);
        END_COLOUR(parts);
    }
}
