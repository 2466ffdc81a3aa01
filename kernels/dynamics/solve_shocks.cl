// SPDX-License-Identifier: MIT
// Lets impacts pass through rows of bodies that touch, at the beginning of a substep.
//
// An impact that is stopped by a row is shared by all of it, and what the row gives back afterwards
// knows nothing of who came first. Here every contact that closes fast bounces by itself, colour by
// colour, and again as long as any does: a blow goes from ball to ball as in a cradle.
//
//   blocks   constraints (constraint.clh)
//   fall     what a substep adds to the velocity of all that falls; w: 1 / its time
//   soon     1 / the time that two substeps take: the second pass of a substep stops what would meet in
//            the next one
//   sweep    the number of this sweep, one more than the last one's; first_sweep: that of the substep's
//            first
//   shocked  the last sweep in which something bounced: after one without, nothing will

typedef struct {
    ARG_FIELDS
} shocks;

#define SHOCK_ROUNDS 8

// The points of a contact that bounce in this sweep.
typedef struct {
    mask points[POINTS];
    real wanted[POINTS]; // speeds along the normal to leave with
} impact;

// Finds the points that meet soon, and fast enough. True if any lane has one.
static inline bool find_impact(const shocks *s, const pair *p, __global float *constraint, impact *hit)
{
    real restitution = get(constraint, IN_RESTITUTION);
    real gain = gain_of(p, (vec){(real)(s->fall.x), (real)(s->fall.y), (real)(s->fall.z)});
    mask found = 0;
    for (int k = 0; k < p->most; ++k) {
        __global const float *point = point_at(constraint, k);
        real speed = vec_dot(velocity_between(p, get_vec(point, BY_ANCHOR)), p->normal);
        real separation = get(point, BY_CURRENT);
        mask meets = fma(separation, (real)(s->soon), speed) <= 0.0f;
        hit->points[k] = has_point(p, k) & (restitution > 0.0f) & (speed <= -s->least_speed) & meets;
        // The velocity has the substep's fall already.
        hit->wanted[k] = gain + speed_after(speed - gain, restitution, gain, (real)(s->fall.w), separation, separation);
        found |= hit->points[k];
    }
    return any_lane(found);
}

// Pushes until each point that was hit leaves as fast as it is to.
static inline void push_apart(pair *p, __global float *constraint, const impact *hit, real impulses[POINTS])
{
    int rounds = p->most > 1 ? SHOCK_ROUNDS : 1;
    for (int round = 0; round < rounds; ++round) {
        for (int k = 0; k < p->most; ++k) {
            __global const float *point = point_at(constraint, k);
            vec anchor = get_vec(point, BY_ANCHOR);
            real speed = vec_dot(velocity_between(p, anchor), p->normal);
            real more = -get(point, BY_NORMAL_MASS) * (speed - hit->wanted[k]);
            mask asked = hit->points[k] & ((p->n > 1u) | (mask)(round == 0 ? -1 : 0));
            real impulse = select(impulses[k], fmax(impulses[k] + more, (real)(0.0f)), asked);
            apply_impulse(p, anchor, vec_times(impulse - impulses[k], p->normal));
            impulses[k] = impulse;
        }
    }
}

// Stops sliding, by at most friction times what each point was pushed with.
static inline void rub(pair *p, __global float *constraint, const real impulses[POINTS])
{
    real friction = get(constraint, IN_FRICTION);
    for (int k = 0; k < p->most; ++k) {
        __global const float *point = point_at(constraint, k);
        vec anchor = get_vec(point, BY_ANCHOR), velocity = velocity_between(p, anchor);
        if (CONVEYS)
            velocity = vec_sum(velocity, p->belt);
        real most = friction * impulses[k];
        real t = -get(point, BY_TANGENT_MASS) * vec_dot(velocity, p->tangent);
        real s = DIMS == 3 ? -get(point, BY_TANGENT_MASS + DIMS - 2) * vec_dot(velocity, p->bitangent) : (real)(0.0f);
        real length2 = fma(t, t, s * s);
        real scale = select((real)(1.0f), most * inverse_root(length2), length2 > most * most);
        scale = select((real)(0.0f), scale, most > 0.0f);
        apply_impulse(p, anchor, vec_add(vec_times(t * scale, p->tangent), s * scale, p->bitangent));
    }
}

// Hits are told by the greatest push of a step.
static inline void note_impulses(const pair *p, __global float *constraint, const real impulses[POINTS])
{
    for (int k = 0; k < p->most; ++k) {
        __global float *point = point_at(constraint, k);
        put(point, BY_MAX_IMPULSE, fmax(get(point, BY_MAX_IMPULSE), impulses[k]));
    }
}

static inline void solve_shock(const shocks *s, __global float *constraint)
{
    pair p;
    impact hit;
    real impulses[POINTS] = {0};
    if (!any_lane(get(constraint, IN_RESTITUTION) > 0.0f))
        return;
    load_pair(&p, constraint, s->bodies);
    if (!find_impact(s, &p, constraint, &hit))
        return;
    push_apart(&p, constraint, &hit, impulses);
    if (FRICTION)
        rub(&p, constraint, impulses);
    note_impulses(&p, constraint, impulses);
    store_velocity(s->bodies, p.owner, &p.a);
    store_velocity(s->bodies, p.other, &p.b);
    *s->shocked = s->sweep;
}

__kernel void solve_shocks(SOLVE_SHOCKS_ARGS)
{
    const shocks s = {SOLVE_SHOCKS_VALUES};
    const bool ended = sweep != first_sweep && *shocked + 1 != sweep && *shocked != sweep;
    colour_parts parts = COLOUR_PARTS;
    colour_part part;
    for (uint colour = from_colour; colour < to_colour; ++colour) {
        BEGIN_COLOUR(parts, colour);
        while (next_part(&parts, &part))
            for (uint k = part.from; k < part.to && !ended; k += part.stride)
                solve_shock(&s, constraint_at(blocks, &part, k));
        END_COLOUR(parts);
    }
}
