// solve_contacts.DIMS2.ANGULAR_VELOCITY0.FRICTION0.LANES8.BLOCK8.WG1.PER_ITEM256
#define DIMS 2
#define ANGULAR_VELOCITY 0
#define FRICTION 0
#define CONTACT_RESPONSE 1
#define LANES 8
#define BLOCK 8
#define WG 1
#define PER_ITEM 256
#define APPLY_RESTITUTION_ARGS \
    __global const uint4 *restrict spans, \
    int4 span, \
    uint from_colour, \
    uint to_colour, \
    uint each, \
    __global float *restrict blocks, \
    __global float4 *restrict bodies, \
    float4 fall, \
    float least_speed
#define SOLVE_CONTACTS_ARGS \
    __global const uint4 *restrict spans, \
    int4 span, \
    uint from_colour, \
    uint to_colour, \
    uint each, \
    __global float *restrict blocks, \
    __global float4 *restrict bodies, \
    uint soft, \
    float per_h, \
    float4 spring, \
    float4 hard_spring, \
    float load_speed
#line 1 "kernels/common.clh"
#line 1 "kernels/lanes.clh"
#line 1 "kernels/dynamics/vector.clh"
#line 1 "kernels/dynamics/records.h"
#line 1 "kernels/dynamics/contact.clh"
#line 1 "kernels/dynamics/constraint.clh"
#line 1 "kernels/dynamics/solve_contacts.cl.in"
// SPDX-License-Identifier: MIT
#line 8 "kernels/dynamics/solve_contacts.cl.in"
// Solves the contacts of one colour. No two of them share a body that moves, so
// their order does not matter and the result is the same on every device.
//
// With `soft` a point that overlaps is a stiff, damped spring, and a point whose
// separation could close within the substep is a stop. Without `soft` (the relaxing
// pass) every point is only a stop, which takes back the velocity that springs added.
//
//   spans   of each colour: first in the list, count, first slot
//   blocks  constraints (constraint.clh)
//   each    contacts of a colour that a work-item takes
//   spring  bias rate, mass scale, impulse scale, greatest speed of push-out;
//           hard_spring: against bodies that never move
//   load_speed  the speed that a load can add to a point in a substep: what asks for more
//           than that, and twice the last impulse, is an impact

// ------------------------------------------------------------ solving

// What a point asks for in this pass.
typedef struct {
    real speed;  // along the normal, at least
    real weight; // part of the mass that answers
    real decay;  // part of the impulse that is let go
    real load;   // the most that the next substep may begin with
    mask impact;  // asks for more
    mask release; // takes back more than half of its push
} demand;

#line 96 "kernels/dynamics/solve_contacts.cl.in"
// The separation after positions were integrated; the next substep begins with it.
static inline real find_separation(const pair *p, point one, vec anchor)
{
    vec way = vec_less(way_of(&p->b, vec_less(anchor, p->apart)), way_of(&p->a, anchor));
    real separation = get_of(one, BY_SEPARATION) + vec_dot(way, p->normal);
    put_of(one, BY_CURRENT, separation);
    return separation;
}

static inline demand demand_of(const pair *p, point one, uint soft, float per_h, float4 spring,
                               float4 hard_spring, float load_speed)
{
    vec anchor = get_vec_of(one, BY_ANCHOR);
    real mass = get_of(one, BY_NORMAL_MASS), impulse = get_of(one, BY_NORMAL_IMPULSE);
    demand d;
    d.load = soft ? fma(mass, (real)(load_speed), impulse + impulse) : get_of(one, BY_LOAD);
    real asked = fma(-mass, vec_dot(velocity_between(p, anchor), p->normal), impulse);
    d.impact = asked > d.load;
    d.release = asked < 0.5f * impulse;
    real separation = soft ? get_of(one, BY_CURRENT) : find_separation(p, one, anchor);
    d.speed = select((real)(0.0f), separation * per_h, separation > 0.0f);
    d.weight = 1.0f;
    d.decay = 0.0f;
    if (soft) {
        put_of(one, BY_LOAD, d.load);
        mask pressed = separation <= 0.0f;
        mask hard = !(p->b.inverse_mass > 0.0f) | !(p->a.inverse_mass > 0.0f);
        real rate = select((real)(spring.x), (real)(hard_spring.x), hard);
        d.speed = select(d.speed, fmax(separation * rate, -spring.w), pressed);
        d.weight = select(d.weight, select((real)(spring.y), (real)(hard_spring.y), hard), pressed);
        d.decay = select(d.decay, select((real)(spring.z), (real)(hard_spring.z), hard), pressed);
    }
    return d;
}

static inline void add_impulse(pair *p, point one, vec anchor, real impulse, mask where)
{
    real old = get_of(one, BY_NORMAL_IMPULSE);
    impulse = select(old, fmax(impulse, 0.0f), where);
    put_of(one, BY_NORMAL_IMPULSE, impulse);
    put_of(one, BY_MAX_IMPULSE, fmax(get_of(one, BY_MAX_IMPULSE), impulse));
    apply_impulse(p, anchor, vec_times(impulse - old, p->normal));
}

static inline void press(pair *p, point one, demand d, mask where)
{
    vec anchor = get_vec_of(one, BY_ANCHOR);
    real old = get_of(one, BY_NORMAL_IMPULSE);
    real speed = vec_dot(velocity_between(p, anchor), p->normal);
    add_impulse(p, one, anchor, fma(-get_of(one, BY_NORMAL_MASS) * d.weight, speed + d.speed, fma(-d.decay, old, old)), where);
}
#line 207 "kernels/dynamics/solve_contacts.cl.in"

// An impact is stopped once: the next substep begins with a load's part of the impulse.
static inline void forget_impact(point one, real load)
{
    real impulse = get_of(one, BY_NORMAL_IMPULSE);
    mask over = impulse > load;
    if (!any_lane(over))
        return;
    put_of(one, BY_NORMAL_IMPULSE, select(impulse, load, over));
#line 223 "kernels/dynamics/solve_contacts.cl.in"
}

static inline void solve_slots(__global float *constraint, __global float4 *bodies, uint soft, float per_h,
                               float4 spring, float4 hard_spring, float load_speed)
{
    pair p;
    load_pair(&p, constraint, bodies);
    points all = take_points(constraint, p.n);
    if (!soft)
        load_warm_impulses(&p, bodies);
#line 241 "kernels/dynamics/solve_contacts.cl.in"
    if (!soft) {
        load_turn(&p.a, bodies, p.owner);
        load_turn(&p.b, bodies, p.other);
    }
#line 252 "kernels/dynamics/solve_contacts.cl.in"
    demand demands[POINTS];
    mask stiff = p.n > 1u, struck = 0, released = p.n > 1u;
    EACH_POINT(k, p.most) {
        demands[k] = demand_of(&p, point_of(&all, k), soft, per_h, spring, hard_spring, load_speed);
        stiff &= (demands[k].decay == 0.0f) | !has_point(&p, k);
        struck |= demands[k].impact & has_point(&p, k);
        released &= demands[k].release | !has_point(&p, k);
    }
#line 265 "kernels/dynamics/solve_contacts.cl.in"
    EACH_IN_TURN(k, !soft, p.most)
        press(&p, point_of(&all, k), demands[k], has_point(&p, k));
#line 273 "kernels/dynamics/solve_contacts.cl.in"
    if (!soft)
        EACH_POINT(k, p.most)
            forget_impact(point_of(&all, k), demands[k].load);
#line 279 "kernels/dynamics/solve_contacts.cl.in"
    keep_fields(&all, constraint, p.most, BY_CURRENT, FRICTION ? BY_TANGENT_MASS : BY_FIELDS);
#line 281 "kernels/dynamics/solve_contacts.cl.in"
    keep_velocity(bodies, p.owner, &p.a);
    keep_velocity(bodies, p.other, &p.b);
    if (!soft)
        store_warm_impulses(&p, &all, bodies);
}

#if LANES > 1
#define BLOCKS_AHEAD 4

// Blocks come from memory once a pass and are asked for in time, as many points
// of one as this one has, for neighbours have as many.
static inline void ask_for_block(__global const float *constraint, int points)
{
    int words = (FIELDS + points * BY_FIELDS) * BLOCK;
    for (int k = 0; k < words; k += 16)
        ask_for(constraint + k);
}

// Bodies are read at random: those of the next block are asked for in time.
static inline void ask_for_bodies(__global const float *constraint, __global const float4 *bodies, uint soft)
{
    for (int side = IN_OWNER; side <= IN_OTHER; ++side) {
        uint ids[LANES];
        spread(as_word(get(constraint, side)), ids);
#pragma unroll
        for (int k = 0; k < LANES; ++k) {
            ask_for(bodies + (size_t)ids[k] * BODY);
            if (!soft)
                ask_for(bodies + (size_t)ids[k] * BODY + BODY - 1);
        }
    }
}
#endif

__kernel void solve_contacts(SOLVE_CONTACTS_ARGS)
{
    for (uint colour = from_colour; colour < to_colour; ++colour) {
        uint4 where = SPAN_OF(colour);
        uint apart = APART(colour), first_slot = where.z;
        uint from = get_global_id(0) * each;
        uint to = min(from + each, where.y);
        for (uint k = from; k < to; k += STRIDE(apart)) {
#if LANES > 1
            uint next = k + STRIDE(apart), later = k + BLOCKS_AHEAD * STRIDE(apart);
            if (later < to)
                ask_for_block(constraint_at(blocks, first_slot + later * apart),
                              most_points(points_of(constraint_at(blocks, first_slot + k * apart))));
            if (next < to)
                ask_for_bodies(constraint_at(blocks, first_slot + next * apart), bodies, soft);
            solve_slots(constraint_at(blocks, first_slot + k * apart), bodies, soft, per_h, spring, hard_spring, load_speed);
#else
            // A text for each pass, in which the points' order is known and registers hold them.
            __global float *constraint = constraint_at(blocks, first_slot + k * apart);
            if (soft)
                solve_slots(constraint, bodies, 1, per_h, spring, hard_spring, load_speed);
            else
                solve_slots(constraint, bodies, 0, per_h, spring, hard_spring, load_speed);
#endif
        }
        END_COLOUR;
    }
}

// ------------------------------------------------------------ restitution

// An impulse at one point speeds up the others too. With one turn, and impulses that only
// add to what stopped the impact, they would leave faster than they came, and boxes
// that tumble gain energy without end.
#define RESTITUTION_ROUNDS 8

// The speed at which a point leaves that came at `speed` when the step began, `separation`
// apart, and was stopped `current` apart: pulled by `gain` a substep on the way (below 0:
// closer), it met the surface, leaves that with its part of the speed, and is pulled again from
// there to where it is. Velocities are those of the middle of a substep, so half a gain lies
// between them and the place.
//
//   per_h  1 / the substep's time
static inline real speed_after(real speed, real restitution, real gain, real per_h, real separation, real current)
{
    real half_gain = 0.5f * gain, way = -2.0f * per_h * gain;
    real came = -(speed + half_gain);
    real met = fma(way, separation, came * came);
    real left = fma(-way, current, restitution * restitution * met);
    real leaves = fma(left, inverse_root(left), -half_gain);
    return select(-restitution * speed, leaves, (came > 0.0f) & (met > 0.0f) & (left > 0.0f) & (gain != 0.0f));
}

// What a substep pulls the two closer by, along the normal: nothing, where both
// fall alike.
static inline real gain_of(const pair *p, vec fall)
{
    const real zero = 0.0f, one = 1.0f;
    real one_falls = select(zero, one, p->b.inverse_mass > 0.0f) - select(zero, one, p->a.inverse_mass > 0.0f);
    return one_falls * vec_dot(fall, p->normal);
}

// Gives back, once a step, what the impact had of speed along the normal. A point
// that is faster already gives up of what it was stopped with.
//
//   fall  what a substep adds to the velocity of all that falls; w: 1 / its time
static inline void restore_speeds(__global float *constraint, __global float4 *bodies, float4 fall, float least_speed)
{
    word n = points_of(constraint);
    real restitution = get(constraint, IN_RESTITUTION);
    mask wanted[POINTS];
    mask any_wanted = 0;
    for (int k = 0; k < POINTS; ++k) {
        wanted[k] = 0;
        if (!any_lane(n > (word)(uint)k))
            continue;
        wanted[k] = (n > (word)(uint)k) & (restitution > 0.0f) & (get(constraint, IN_SPEEDS + k) <= -least_speed);
        if (any_lane(wanted[k]))
            wanted[k] &= get(point_at(constraint, k), BY_MAX_IMPULSE) > 0.0f;
        any_wanted |= wanted[k];
    }
    if (!any_lane(any_wanted))
        return;
    pair p;
    load_pair(&p, constraint, bodies);
    real gain = gain_of(&p, (vec){(real)(fall.x), (real)(fall.y), (real)(fall.z)});
    real wanted_speed[POINTS];
    for (int k = 0; k < p.most; ++k) {
        __global const float *point = point_at(constraint, k);
        wanted_speed[k] = speed_after(get(constraint, IN_SPEEDS + k), restitution, gain, (real)(fall.w),
                                      get(point, BY_SEPARATION), get(point, BY_CURRENT));
    }
#line 414 "kernels/dynamics/solve_contacts.cl.in"
    real impulses[POINTS] = {0};
    int turns = p.most > 1 ? RESTITUTION_ROUNDS : 1;
    for (int turn = 0; turn < turns; ++turn) {
        for (int k = 0; k < p.most; ++k) {
            __global const float *point = point_at(constraint, k);
            vec anchor = get_vec(point, BY_ANCHOR);
            real speed = vec_dot(velocity_between(&p, anchor), p.normal);
            real more = -get(point, BY_NORMAL_MASS) * (speed - wanted_speed[k]);
            mask asked = wanted[k] & ((p.n > 1u) | (mask)(turn == 0 ? -1 : 0));
            real impulse = select(impulses[k], fmax(impulses[k] + more, -get(point, BY_MAX_IMPULSE)), asked);
#line 427 "kernels/dynamics/solve_contacts.cl.in"
            apply_impulse(&p, anchor, vec_times(impulse - impulses[k], p.normal));
            impulses[k] = impulse;
        }
    }
    keep_velocity(bodies, p.owner, &p.a);
    keep_velocity(bodies, p.other, &p.b);
}

__kernel void apply_restitution(APPLY_RESTITUTION_ARGS)
{
    for (uint colour = from_colour; colour < to_colour; ++colour) {
        uint4 where = SPAN_OF(colour);
        uint apart = APART(colour);
        uint from = get_global_id(0) * each;
        uint to = min(from + each, where.y);
        for (uint k = from; k < to; k += STRIDE(apart))
            restore_speeds(constraint_at(blocks, where.z + k * apart), bodies, fall, least_speed);
        END_COLOUR;
    }
}
