// solve.DIMS3.SPIN0.FRICTION0.WG64.PER_ITEM1
#define DIMS 3
#define SPIN 0
#define FRICTION 0
#define RESPONSE 1
#define WG 64
#define PER_ITEM 1
#line 1 "kernels/common.clh"
#line 1 "kernels/contact.clh"
#line 1 "kernels/box_contact.clh"
#line 1 "kernels/solve.cl.in"
// SPDX-License-Identifier: MIT
// Contacts pushed apart, one colour at a time: no two of a colour share an
// object that moves, so the order within one does not matter and the result is
// the same on every device.
//
// Each point is a stiff, damped spring where it is pressed in, a stop where a
// gap could close within the substep, and, without `soft`, only a stop: that
// takes back what the spring added to the velocities.
//
//   list    contacts of the colour, [first, first + count)
//   spring  rate of push-out, part of the mass, part of the push that decays,
//           greatest speed of push-out; hard_spring: against what never moves
//   slop    what closes faster than that in a substep is an impact; its push is
//           not expected again
typedef struct {
    float4 velocity; // w: inverse mass
    float4 moved;
#line 23 "kernels/solve.cl.in"
} body;

static inline body body_at(__global const float4 *bodies, uint id)
{
    __global const float4 *from = bodies + (size_t)id * BODY;
    body b;
    b.velocity = from[BODY_VELOCITY];
    b.moved = from[BODY_MOVED];
#line 36 "kernels/solve.cl.in"
    return b;
}

static inline void keep_velocity(__global float4 *bodies, uint id, const body *b)
{
    if (!(b->velocity.w > 0.0f))
        return;
    __global float4 *to = bodies + (size_t)id * BODY;
    to[BODY_VELOCITY] = b->velocity;
#line 48 "kernels/solve.cl.in"
}

// sign -1 for the owner, 1 for the other
static inline void push_body(body *b, float sign, float4 arm, float4 impulse)
{
    b->velocity.xyz = add_float(b->velocity, sign * b->velocity.w, impulse).xyz;
#line 61 "kernels/solve.cl.in"
}

static inline float4 velocity_at(const body *b, float4 arm)
{
    float4 v = (float4)(b->velocity.xyz, 0.0f);
#line 69 "kernels/solve.cl.in"
    return v;
}

// How far a point of the body has come since the step began.
static inline float4 way_of(const body *b, float4 arm)
{
    float4 way = (float4)(b->moved.xyz, 0.0f);
#line 80 "kernels/solve.cl.in"
    return way;
}

static inline float4 owner_arm(__global const float *part)
{
    return float4_at(part + OF_ARM);
}

static inline float4 other_arm(__global const float *part)
{
#line 93 "kernels/solve.cl.in"
    return (float4)(0.0f);
#line 95 "kernels/solve.cl.in"
}

static inline void push_both(body *a, body *b, __global const float *part, float4 impulse)
{
    push_body(a, -1.0f, owner_arm(part), impulse);
    push_body(b, 1.0f, other_arm(part), impulse);
}

static inline float4 velocity_between(const body *a, const body *b, __global const float *part)
{
    return velocity_at(b, other_arm(part)) - velocity_at(a, owner_arm(part));
}

// What a point asks for in this pass.
typedef struct {
    float speed;  // along the normal, at least
    float weight; // part of the mass that answers
    float decay;  // part of the push that is let go
    bool impact;  // closes faster than a slop in a substep
} demand;

static inline demand demand_of(__global const float *part, const body *a, const body *b, float4 normal, uint soft,
                               float per_h, float4 spring, float slop)
{
    float gap = part[OF_GAP] + dot_float(way_of(b, other_arm(part)) - way_of(a, owner_arm(part)), normal);
    float speed = dot_float(velocity_between(a, b, part), normal);
    demand d = {gap > 0.0f ? gap * per_h : 0.0f, 1.0f, 0.0f, speed < -slop * per_h};
    if (gap <= 0.0f && soft) {
        d.speed = fmax(gap * spring.x, -spring.w);
        d.weight = spring.y;
        d.decay = spring.z;
    }
    return d;
}

static inline void add_push(__global float *part, body *a, body *b, float4 normal, float push)
{
    float old = part[OF_PUSH];
    push = fmax(push, 0.0f);
    part[OF_PUSH] = push;
    part[OF_MOST] = fmax(part[OF_MOST], push);
    push_both(a, b, part, normal * (push - old));
}

static inline void press(__global float *part, body *a, body *b, float4 normal, demand d)
{
    float old = part[OF_PUSH];
    float speed = dot_float(velocity_between(a, b, part), normal);
    add_push(part, a, b, normal, fma(-part[OF_MASS] * d.weight, speed + d.speed, fma(-d.decay, old, old)));
}
#line 209 "kernels/solve.cl.in"

static inline void solve_contact(uint i, __global const uint2 *links, __global float *contacts, __global float4 *bodies,
                                 __global float4 *shoves, uint soft, float per_h, float4 spring, float4 hard_spring,
                                 float slop)
{
    uint2 link = links[i];
    __global float *record = contacts + (size_t)i * RECORD;
    body a = body_at(bodies, link.x);
    body b = body_at(bodies, link.y);
    float4 normal = float4_at(record + AT_NORMAL);
    int n = (int)as_uint(record[AT_COUNT]);
    bool hard = !(b.velocity.w > 0.0f) || !(a.velocity.w > 0.0f);
#line 233 "kernels/solve.cl.in"
    demand demands[POINTS];
    bool stiff = true;
    for (int k = 0; k < n; ++k) {
        demands[k] = demand_of(record + HEAD + k * PART, &a, &b, normal, soft, per_h, hard ? hard_spring : spring,
                               slop);
        stiff = stiff && demands[k].decay == 0.0f;
    }
#line 244 "kernels/solve.cl.in"
    for (int turn = 0; turn < n; ++turn) { // to and fro, so that no side is favoured
        int k = soft ? turn : n - 1 - turn;
        press(record + HEAD + k * PART, &a, &b, normal, demands[k]);
    }
    for (int k = 0; k < n; ++k) {
        __global float *part = record + HEAD + k * PART;
        bool stopped = demands[k].impact && part[OF_PUSH] > 0.0f;
        part[OF_IMPACT] = stopped || (!soft && part[OF_IMPACT] != 0.0f) ? 1.0f : 0.0f;
    }
    keep_velocity(bodies, link.x, &a);
    keep_velocity(bodies, link.y, &b);
    if (soft)
        return;
    // What the next substep begins with.
    float4 push = (float4)(0.0f);
#line 262 "kernels/solve.cl.in"
    for (int k = 0; k < n; ++k) {
        __global float *part = record + HEAD + k * PART;
        if (part[OF_IMPACT] != 0.0f) { // once is enough
            part[OF_PUSH] = 0.0f;
#line 272 "kernels/solve.cl.in"
        }
        float4 impulse = normal * part[OF_PUSH];
#line 280 "kernels/solve.cl.in"
        push += impulse;
#line 285 "kernels/solve.cl.in"
    }
    __global float4 *shove = shoves + (size_t)i * SHOVE;
    shove[0] = push;
#line 292 "kernels/solve.cl.in"
}

__kernel void solve(__global const uint2 *restrict links, __global const uint *restrict list, uint first, uint count,
                    __global float *restrict contacts, __global float4 *restrict bodies,
                    __global float4 *restrict shoves, uint soft, float per_h, float4 spring, float4 hard_spring,
                                 float slop)
{
    uint from = get_global_id(0) * PER_ITEM;
    uint to = min(from + PER_ITEM, count);
    for (uint k = from; k < to; ++k)
        solve_contact(list[first + k], links, contacts, bodies, shoves, soft, per_h, spring, hard_spring, slop);
}

// Contacts that found no colour share objects: one work-item, in order.
__kernel void solve_in_order(__global const uint2 *restrict links, __global const uint *restrict list, uint first,
                             uint count, __global float *restrict contacts, __global float4 *restrict bodies,
                             __global float4 *restrict shoves, uint soft, float per_h, float4 spring,
                             float4 hard_spring, float slop)
{
    for (uint k = 0; k < count && get_global_id(0) == 0; ++k)
        solve_contact(list[first + k], links, contacts, bodies, shoves, soft, per_h, spring, hard_spring, slop);
}

// Gives back, once a step, what the impact had of speed along the normal.
static inline void bounce_contact(uint i, __global const uint2 *links, __global const float *contacts,
                                  __global float4 *bodies, float least_speed)
{
    uint2 link = links[i];
    __global const float *record = contacts + (size_t)i * RECORD;
    float restitution = record[AT_BOUNCE];
    if (!(restitution > 0.0f))
        return;
    body a = body_at(bodies, link.x);
    body b = body_at(bodies, link.y);
    float4 normal = float4_at(record + AT_NORMAL);
    int n = (int)as_uint(record[AT_COUNT]);
    for (int k = 0; k < n; ++k) {
        __global const float *part = record + HEAD + k * PART;
        if (part[OF_SPEED] > -least_speed || !(part[OF_MOST] > 0.0f))
            continue;
        float speed = dot_float(velocity_between(&a, &b, part), normal);
        float push = -part[OF_MASS] * fma(restitution, part[OF_SPEED], speed);
        push_both(&a, &b, part, normal * fmax(push, 0.0f));
    }
    keep_velocity(bodies, link.x, &a);
    keep_velocity(bodies, link.y, &b);
}

__kernel void bounce(__global const uint2 *restrict links, __global const uint *restrict list, uint first, uint count,
                     __global const float *restrict contacts, __global float4 *restrict bodies, float least_speed)
{
    uint from = get_global_id(0) * PER_ITEM;
    uint to = min(from + PER_ITEM, count);
    for (uint k = from; k < to; ++k)
        bounce_contact(list[first + k], links, contacts, bodies, least_speed);
}

__kernel void bounce_in_order(__global const uint2 *restrict links, __global const uint *restrict list, uint first,
                              uint count, __global const float *restrict contacts, __global float4 *restrict bodies,
                              float least_speed)
{
    for (uint k = 0; k < count && get_global_id(0) == 0; ++k)
        bounce_contact(list[first + k], links, contacts, bodies, least_speed);
}
