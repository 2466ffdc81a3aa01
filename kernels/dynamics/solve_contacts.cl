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
// With `soft` a point that overlaps is a stiff, damped spring, and a point whose separation could close
// within the substep is a stop. Without `soft` every point is only a stop.
//
//   blocks  constraints (constraint.clh)
//   each    contacts of a colour that a work-item takes
//   spring  bias rate, mass scale, impulse scale, greatest speed of push-out;
//           hard_spring: against bodies that never move
//   load_speed  the speed that a resting load can add to a point in a substep: a point that needs
//           more than that, and than twice the last impulse, is an impact

typedef struct {
    ARG_FIELDS
} solver;

// ------------------------------------------------------------ turned far

// Bodies that turn far in a step push with the levers of when they meet: points move along their
// tangents there, so that separations change as velocities say.
static inline mask is_far_turned(const body *b)
{
    return vec_dot(b->arc, b->arc) > FAR_TURNED;
}

static inline vec arc_of(const body *b, vec anchor)
{
    vec exact = way_of(b, anchor), along = vec_sum(b->moved, vec_cross(b->arc, anchor));
    mask far = is_far_turned(b);
    return (vec){select(exact.x, along.x, far), select(exact.y, along.y, far), select(exact.z, along.z, far)};
}

static inline void update_mass(const pair *p, point one, uint field, vec anchor, vec direction, mask where)
{
    put_of(one, field, select(get_of(one, field), inverse(inverse_effective_mass(p, anchor, direction)), where));
}

// Effective masses with the inertia that the bodies have now.
static inline void update_masses(const pair *p, points *all, mask far)
{
    EACH_POINT(k, p->most) {
        point one = point_of(all, k);
        vec anchor = get_vec_of(one, BY_ANCHOR);
        mask where = far & has_point(p, k);
        update_mass(p, one, BY_NORMAL_MASS, anchor, p->normal, where);
        if (FRICTION)
            update_mass(p, one, BY_TANGENT_MASS, anchor, p->tangent, where);
        if (FRICTION && DIMS == 3)
            update_mass(p, one, BY_TANGENT_MASS + 1, anchor, p->bitangent, where);
    }
}

// ------------------------------------------------------------ the normal impulse

// A point's constraint in this pass.
typedef struct {
    real bias;          // speed along the normal, at least
    real mass_scale;    // softness: part of the effective mass that acts
    real impulse_scale; // softness: part of the impulse that is let go
    real expected;      // the most impulse that the next substep may begin with
    mask impact;        // needs more than that
    mask release;       // takes back more than half of its impulse
} point_constraint;

// From the anchor to the core's point: a radius along the normal does not turn with the body.
static inline vec core_lever(const body *b, vec lever, vec normal, real side)
{
    return ROUNDED && ANGULAR_VELOCITY ? vec_add(lever, side * b->radius, normal) : lever;
}

static inline vec way_of_core(const body *b, vec lever, vec normal, real side)
{
    vec core = core_lever(b, lever, normal, side);
    return FAR ? arc_of(b, core) : way_of(b, core);
}

// The separation after positions were integrated; the next substep begins with it.
static inline real update_separation(const pair *p, point one, vec anchor)
{
    vec way = vec_less(way_of_core(&p->b, other_anchor(p, anchor), p->normal, 1.0f),
                       way_of_core(&p->a, anchor, p->normal, -1.0f));
    real separation = get_of(one, BY_SEPARATION) + vec_dot(way, p->normal);
    put_of(one, BY_CURRENT, separation);
    return separation;
}

// Softens a point that overlaps.
static inline void soften(point_constraint *c, const solver *s, const pair *p, real separation)
{
    mask pressed = separation <= 0.0f;
    mask hard = !(p->b.inverse_mass > 0.0f) | !(p->a.inverse_mass > 0.0f);
    real rate = select((real)(s->spring.x), (real)(s->hard_spring.x), hard);
    c->bias = select(c->bias, fmax(separation * rate, -s->spring.w), pressed);
    c->mass_scale = select(c->mass_scale, select((real)(s->spring.y), (real)(s->hard_spring.y), hard), pressed);
    c->impulse_scale = select(c->impulse_scale, select((real)(s->spring.z), (real)(s->hard_spring.z), hard), pressed);
}

static inline point_constraint constrain_point(const solver *s, uint soft, const pair *p, point one)
{
    vec anchor = get_vec_of(one, BY_ANCHOR);
    real mass = get_of(one, BY_NORMAL_MASS), impulse = get_of(one, BY_NORMAL_IMPULSE);
    point_constraint c;
    c.expected = soft ? fma(mass, (real)(s->load_speed), impulse + impulse) : get_of(one, BY_EXPECTED_IMPULSE);
    real needed = fma(-mass, vec_dot(velocity_between(p, anchor), p->normal), impulse);
    c.impact = needed > c.expected;
    c.release = needed < 0.5f * impulse;
    real separation = soft ? get_of(one, BY_CURRENT) : update_separation(p, one, anchor);
    c.bias = select((real)(0.0f), separation * s->per_h, separation > 0.0f);
    c.mass_scale = 1.0f;
    c.impulse_scale = 0.0f;
    if (soft) {
        put_of(one, BY_EXPECTED_IMPULSE, c.expected);
        soften(&c, s, p, separation);
    }
    return c;
}

static inline void set_normal_impulse(pair *p, point one, vec anchor, real impulse, mask where)
{
    real old = get_of(one, BY_NORMAL_IMPULSE);
    impulse = select(old, fmax(impulse, 0.0f), where);
    put_of(one, BY_NORMAL_IMPULSE, impulse);
    put_of(one, BY_MAX_IMPULSE, fmax(get_of(one, BY_MAX_IMPULSE), impulse));
    apply_impulse(p, anchor, vec_times(impulse - old, p->normal));
}

static inline void solve_point(pair *p, point one, point_constraint c, mask where)
{
    vec anchor = get_vec_of(one, BY_ANCHOR);
    real old = get_of(one, BY_NORMAL_IMPULSE);
    real speed = vec_dot(velocity_between(p, anchor), p->normal);
    real impulse = fma(-get_of(one, BY_NORMAL_MASS) * c.mass_scale, speed + c.bias, fma(-c.impulse_scale, old, old));
    set_normal_impulse(p, one, anchor, impulse, where);
}

// Stops all points of an impact alike, as one in their middle: one after the other they would set an
// even impact spinning.
static inline void solve_together(pair *p, points *all, const point_constraint *constraints, mask where)
{
    vec anchor = {0.0f, 0.0f, 0.0f}, anchor_b = anchor;
    real bias = 0.0f;
    EACH_POINT(k, p->most) {
        vec own = get_vec_of(point_of(all, k), BY_ANCHOR), other = other_anchor(p, own);
        mask on = has_point(p, k);
        anchor = vec_sum(anchor, own);
        anchor_b = (vec){anchor_b.x + select((real)(0.0f), other.x, on), anchor_b.y + select((real)(0.0f), other.y, on),
                      anchor_b.z + select((real)(0.0f), other.z, on)};
        bias += select((real)(0.0f), constraints[k].bias, on);
    }
    real share = select(select((real)(0.25f), (real)(1.0f / 3.0f), p->n == 3u), (real)(0.5f), p->n == 2u);
    anchor = vec_times(share, anchor);
    anchor_b = vec_times(share, anchor_b);
    real inverse_mass = inverse_mass_along(&p->a, anchor, p->normal) + inverse_mass_along(&p->b, anchor_b, p->normal);
    real speed = vec_dot(vec_less(velocity_at(&p->b, anchor_b), velocity_at(&p->a, anchor)), p->normal);
    real impulse = -share * fma(share, bias, speed) * inverse(inverse_mass);
    EACH_POINT(k, p->most) {
        point one = point_of(all, k);
        set_normal_impulse(p, one, get_vec_of(one, BY_ANCHOR), get_of(one, BY_NORMAL_IMPULSE) + impulse,
                           where & has_point(p, k));
    }
}

// All points of a contact. Several that are hit as stops, or let go, are solved together first.
static inline void solve_points(const solver *s, uint soft, pair *p, points *all, point_constraint constraints[POINTS])
{
    mask stiff = p->n > 1u, impact = 0, release = p->n > 1u;
    EACH_POINT(k, p->most) {
        constraints[k] = constrain_point(s, soft, p, point_of(all, k));
        stiff &= (constraints[k].impulse_scale == 0.0f) | !has_point(p, k);
        impact |= constraints[k].impact & has_point(p, k);
        release &= constraints[k].release | !has_point(p, k);
    }
    mask together = (stiff & impact) | release;
    if (ANGULAR_VELOCITY && any_lane(together))
        solve_together(p, all, constraints, together);
    EACH_IN_TURN(k, !soft, p->most)
        solve_point(p, point_of(all, k), constraints[k], has_point(p, k));
}

// ------------------------------------------------------------ friction

// Keeps the tangent impulse within friction times the normal impulse, in any direction. True in lanes
// that slide: they need more.
static inline mask solve_friction(pair *p, point one, real friction, mask where)
{
    vec anchor = get_vec_of(one, BY_ANCHOR);
    real most = friction * get_of(one, BY_NORMAL_IMPULSE);
    vec velocity = velocity_between(p, anchor);
    if (CONVEYS)
        velocity = vec_sum(velocity, p->belt);
    real old_t = get_of(one, BY_TANGENT_IMPULSE);
    real t = fma(-get_of(one, BY_TANGENT_MASS), vec_dot(velocity, p->tangent), old_t);
    if (DIMS == 2) {
        mask slides = fabs(t) > most;
        t = select(old_t, fmin(fmax(t, -most), most), where);
        put_of(one, BY_TANGENT_IMPULSE, t);
        apply_impulse(p, anchor, vec_times(t - old_t, p->tangent));
        return slides;
    }
    real old_s = get_of(one, BY_TANGENT_IMPULSE + 1);
    real s = fma(-get_of(one, BY_TANGENT_MASS + 1), vec_dot(velocity, p->bitangent), old_s);
    real length2 = fma(t, t, s * s);
    mask slides = length2 > most * most;
    real scale = select((real)(1.0f), most * inverse_root(length2), slides);
    t = select(old_t, t * scale, where);
    s = select(old_s, s * scale, where);
    put_of(one, BY_TANGENT_IMPULSE, t);
    put_of(one, BY_TANGENT_IMPULSE + 1, s);
    apply_impulse(p, anchor, vec_add(vec_times(t - old_t, p->tangent), s - old_s, p->bitangent));
    return slides;
}

// Lets the next substep begin with the expected impulse at most: an impact is stopped once.
static inline void limit_impulse(point one, real expected)
{
    real impulse = get_of(one, BY_NORMAL_IMPULSE);
    mask over = impulse > expected;
    if (!any_lane(over))
        return;
    put_of(one, BY_NORMAL_IMPULSE, select(impulse, expected, over));
    if (!FRICTION)
        return;
    real part = select((real)(1.0f), expected * inverse(impulse), over);
    put_of(one, BY_TANGENT_IMPULSE, part * get_of(one, BY_TANGENT_IMPULSE));
    if (DIMS == 3)
        put_of(one, BY_TANGENT_IMPULSE + 1, part * get_of(one, BY_TANGENT_IMPULSE + 1));
}

// ------------------------------------------------------------ rolling resistance

// Turns both bodies to one angular velocity, by an impulse of a torque whose length is at most
// `lever` times what presses.
static inline void solve_rolling(pair *p, points *all, real lever)
{
    const real zero = 0.0f;
    real pressed = zero;
    EACH_POINT(k, p->most)
        pressed += get_of(point_of(all, k), BY_NORMAL_IMPULSE);
    real most = lever * pressed;
    vec turn = vec_less(p->b.angular, p->a.angular);
    real square = vec_dot(turn, turn);
    real answer = vec_dot(turn, vec_sum(turn_by(&p->a, turn), turn_by(&p->b, turn)));
    real scale = select(zero, square * inverse(answer), answer > 1e-30f); // else it stands
    vec wanted = vec_add(p->rolling, -scale, turn);
    real length2 = vec_dot(wanted, wanted);
    real part = select((real)(1.0f), most * inverse_root(length2), length2 > most * most);
    vec more = vec_less(vec_times(select(zero, part, most > 0.0f), wanted), p->rolling);
    p->rolling = vec_sum(p->rolling, more);
    p->a.angular = vec_less(p->a.angular, turn_by(&p->a, more));
    p->b.angular = vec_sum(p->b.angular, turn_by(&p->b, more));
}

// ------------------------------------------------------------ a contact

static inline void load_turns(pair *p, __global const float4 *bodies)
{
    load_turn(&p->a, bodies, p->owner);
    load_turn(&p->b, bodies, p->other);
}

static inline mask is_pair_far_turned(const pair *p)
{
    return is_far_turned(&p->a) | is_far_turned(&p->b);
}

static inline void solve_constraint(const solver *s, uint soft, __global float *constraint)
{
    pair p;
    load_pair(&p, constraint, s->bodies);
    points all = take_points(constraint, p.n);
    if (!soft && LANES == 1)
        load_warm_impulses(&p, s->bodies);
    if (!soft || FAR)
        load_turns(&p, s->bodies);
    if (FAR && any_lane(is_pair_far_turned(&p)))
        update_masses(&p, &all, is_pair_far_turned(&p));
    real friction = FRICTION ? get(constraint, IN_FRICTION) : (real)(0.0f);
    mask slides = 0;
    if (ROLLING) {
        solve_rolling(&p, &all, get(constraint, IN_ROLLING));
        put_vec(constraint, IN_ROLLING + 1, p.rolling);
    }
    if (FRICTION)
        EACH_IN_TURN(k, !soft, p.most)
            slides |= solve_friction(&p, point_of(&all, k), friction, has_point(&p, k)) & has_point(&p, k);
    point_constraint constraints[POINTS];
    solve_points(s, soft, &p, &all, constraints);
    // Points that slide have the friction of the normal impulse that they end with.
    if (FRICTION && any_lane(slides))
        EACH_IN_TURN(k, !soft, p.most)
            solve_friction(&p, point_of(&all, k), friction, slides);
    if (!soft)
        EACH_POINT(k, p.most)
            limit_impulse(point_of(&all, k), constraints[k].expected);
    if (FAR)
        store_fields(&all, constraint, p.most, BY_NORMAL_MASS, BY_FIELDS);
    else
        store_fields(&all, constraint, p.most, BY_CURRENT, FRICTION ? BY_TANGENT_MASS : BY_FIELDS);
    store_velocity(s->bodies, p.owner, &p.a);
    store_velocity(s->bodies, p.other, &p.b);
    if (!soft)
        store_warm_impulses(&p, &all, s->bodies);
}

#if LANES > 1
#define BLOCKS_AHEAD 4

// Asks for a block as it is stored, as many points as the present one has: neighbours have as many.
static inline void ask_for_block(__global const float *constraint, int points)
{
    int words = (FIELDS + points * BY_FIELDS) * BLOCK;
    for (int k = 0; k < words; k += 16)
        ask_for(constraint + k);
}

// Asks for the bodies of the next block, which are read at random.
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

static inline void solve_part(const solver *s, const colour_part *part, uint k)
{
    __global float *constraint = constraint_at(s->blocks, part, k);
#if LANES > 1
    uint next = k + part->stride, later = k + BLOCKS_AHEAD * part->stride;
    if (later < part->to)
        ask_for_block(constraint_at(s->blocks, part, later), most_points(points_of(constraint)));
    if (next < part->to)
        ask_for_bodies(constraint_at(s->blocks, part, next), s->bodies, s->soft);
    solve_constraint(s, s->soft, constraint);
#else
    // Compiled once for each pass, in which the points' order is known and registers hold them.
    if (s->soft)
        solve_constraint(s, 1, constraint);
    else
        solve_constraint(s, 0, constraint);
#endif
}

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
