// update_sleep.DIMS3.DOUBLE0.ANGULAR_VELOCITY0.FRICTION0.SENSORS0.WG64.PER_ITEM1
#define DIMS 3
#define DOUBLE 0
#define ORIGIN 0
#define ANGULAR_VELOCITY 0
#define FRICTION 0
#define CONTACT_RESPONSE 1
#define SENSORS 0
#define WG 64
#define PER_ITEM 1
#define MOVE_SLEEPERS_ARGS \
    __global const uint *restrict touches, \
    __global const uint *restrict starts, \
    __global const uint2 *restrict links, \
    __global const uint *restrict asleep, \
    __global const float4 *restrict velocities, \
    uint n, \
    float margin, \
    uint round, \
    float dt, \
    __global float *restrict contacts, \
    __global float4 *restrict bodies, \
    __global float4 *restrict centres, \
    __global float *restrict rests
#define PUSH_SLEEPERS_ARGS \
    __global const uint *restrict touches, \
    __global const uint *restrict starts, \
    __global const uint *restrict return_starts, \
    __global const uint *restrict returns, \
    __global const uint2 *restrict links, \
    __global const uint *restrict asleep, \
    __global const float4 *restrict velocities, \
    uint n, \
    float margin, \
    uint round, \
    __global float *restrict contacts, \
    __global float4 *restrict bodies
#define UPDATE_SLEEP_ARGS \
    __global const uint2 *restrict links, \
    __global const uint *restrict touches, \
    __global const uint *restrict starts, \
    __global const uint *restrict return_starts, \
    __global const uint *restrict returns, \
    uint n, \
    __global const float *restrict rests, \
    __global const float4 *restrict velocities, \
    float sleep_after, \
    float dt, \
    __global uint *restrict asleep, \
    volatile __global uint *restrict flags
#line 1 "kernels/common.clh"
#line 1 "kernels/dynamics/motion.clh"
#line 1 "kernels/dynamics/records.h"
#line 1 "kernels/dynamics/contact.clh"
#line 1 "kernels/dynamics/update_sleep.cl.in"
// SPDX-License-Identifier: MIT
// Sleep. A body sleeps when it has rested for `sleep_after` seconds and touches no body
// that moves. A moving body wakes what it touches, and that wakes what it touches. A
// body that lost a contact was woken before, by having its rest time set to 0. What sleeps
// deep in others is pushed out of them (push_sleepers).
//
//   rests   [n] seconds at rest, 0 for what moves; below 0: has no mass, and a command changed it
//   asleep  [n] SLEEPS, then maybe PRESSED; or what it did until now, WOKE
typedef struct {
    __global const uint2 *links;
    __global const uint *touches;
    __global const uint *starts;
    __global const uint *return_starts;
    __global const uint *returns;
    uint n;
    __global const float *rests;
    __global const real4 *velocities;
#line 24 "kernels/dynamics/update_sleep.cl.in"
} touched;

static inline bool is_at_rest(const touched *t, uint id)
{
    if (id >= t->n)
        return true;
    real4 velocity = t->velocities[id];
    if (velocity.w > 0)
        return t->rests[id] > 0.0f;
    if (t->rests[id] < 0.0f)
        return false;
    real fastest = dot_product(velocity, velocity);
#line 39 "kernels/dynamics/update_sleep.cl.in"
    return !(fastest > 0);
}

#line 49 "kernels/dynamics/update_sleep.cl.in"
// What a body touches: whether all of it rests, and whether some of it is deep in the body.
typedef struct {
    bool rests;
    bool deep;
} touch;

static inline void add_touch(const touched *t, uint contact, uint other, touch *so_far)
{
    uint word = t->touches[contact];
    if (!(word & TOUCH_POINTS))
        return;
#line 64 "kernels/dynamics/update_sleep.cl.in"
    so_far->rests = is_at_rest(t, other);
    so_far->deep = so_far->deep || (word & TOUCH_DEEP);
}

// As far as something that moves is found.
static inline touch touch_of(const touched *t, uint id)
{
    touch found = {true, false};
#line 76 "kernels/dynamics/update_sleep.cl.in"
    for (uint i = t->starts[id]; found.rests && i < t->starts[id + 1]; ++i)
        add_touch(t, i, t->links[i].y, &found);
    for (uint k = t->return_starts[id]; found.rests && k < t->return_starts[id + 1]; ++k)
        add_touch(t, t->returns[k], t->links[t->returns[k]].x, &found);
    return found;
}

__kernel void update_sleep(UPDATE_SLEEP_ARGS)
{
    const touched t = {links, touches, starts, return_starts, returns, n, rests, velocities,
#line 94 "kernels/dynamics/update_sleep.cl.in"
    };
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    bool awake = false, any_pressed = false;
    for (uint id = first; id < last; ++id) {
        bool slept = asleep[id] & SLEEPS;
        bool sleeps = rests[id] > 0.0f && rests[id] >= sleep_after, pressed = false;
        if (sleeps) {
            touch found = touch_of(&t, id);
            sleeps = found.rests;
            pressed = found.rests && found.deep && rests[id] < sleep_after + PRESSED_STEPS * dt;
        }
        if (sleeps != slept)
            atomic_or(flags + FLAG_FELL_ASLEEP, 1u);
        asleep[id] = (sleeps ? SLEEPS : 0u) | (pressed ? PRESSED : 0u) | (slept && !sleeps ? WOKE : 0u);
        any_pressed = any_pressed || pressed;
        awake = awake || pressed || !(sleeps || (!(velocities[id].w > 0) && is_at_rest(&t, id)));
    }
    if (awake)
        atomic_or(flags + FLAG_AWAKE, 1u);
    if (any_pressed)
        atomic_or(flags + FLAG_PRESSED, 1u);
}

// ------------------------------------------------------------ pushing apart

// What sleeps deep in others goes out of them in rounds, each from the ways of the round
// before. Only what goes has a way; ways are kept where the solver will have its bodies.
//
//   bodies  [n + 6][BODY] ways, of even rounds in the first vector and of odd ones in the next
#define LEFT 0.5f // of the margin, which is not pushed out

typedef struct {
    __global const uint *asleep;
    __global const real4 *velocities;
#line 132 "kernels/dynamics/update_sleep.cl.in"
    __global const uint *touches;
    __global float *contacts;
    __global float4 *bodies;
    uint round;
    uint n;
    float margin;
} pressure;

static inline bool is_pushed_out(const pressure *p, uint id)
{
    return id < p->n && (p->asleep[id] & PRESSED);
}

static inline float4 way_of(const pressure *p, uint id)
{
    bool goes = p->round > 0 && is_pushed_out(p, id);
    return goes ? p->bodies[(size_t)id * BODY + (p->round & 1u)] : (float4)(0.0f);
}

// The body's part of a way that both go, where the other goes as well.
static inline float share_of(const pressure *p, uint id, uint other)
{
    real mass = p->velocities[id].w;
    return is_pushed_out(p, other) ? (float)(mass * inverse(mass + p->velocities[other].w)) : 1.0f;
}

static inline bool is_pushing(const pressure *p, uint contact, uint other)
{
#line 164 "kernels/dynamics/update_sleep.cl.in"
    return p->touches[contact] & TOUCH_POINTS;
}

static inline float depth_of(const pressure *p, uint contact)
{
    __global const float *points = p->contacts + (size_t)contact * RECORD + HEAD;
    float deepest = 0.0f;
    for (uint k = 0; k < (p->touches[contact] & TOUCH_POINTS); ++k)
        deepest = fmax(deepest, -points[k * POINT_FLOATS + OF_SEPARATION]);
    return deepest;
}

// The other's way against the body's, along the normal away from the body; side -1: the
// body owns the contact, 1: the other does.
static inline float way_apart(const pressure *p, float4 normal, float4 way, uint other, float side)
{
    float4 between = way_of(p, other) - way;
    return -side * fma(between.x, normal.x, fma(between.y, normal.y, between.z * normal.z));
}

static inline float4 push_of(const pressure *p, uint contact, uint id, uint other, float4 way, float side)
{
    if (!(p->touches[contact] & TOUCH_DEEP) || !is_pushing(p, contact, other))
        return (float4)(0.0f);
    float4 normal = float4_at(p->contacts + (size_t)contact * RECORD + AT_NORMAL);
    float excess = depth_of(p, contact) - way_apart(p, normal, way, other, side) - LEFT * p->margin;
    return excess > 0.0f ? 0.5f * side * excess * share_of(p, id, other) * normal : (float4)(0.0f);
}

// What a contact pushed with is less, once its bodies wake, by as much as it is less deep.
static inline void lessen_pushes(const pressure *p, uint contact, uint other, float4 way)
{
    float depth = depth_of(p, contact);
    __global float *record = p->contacts + (size_t)contact * RECORD;
    if (!is_pushing(p, contact, other) || !(depth > 0.0f))
        return;
    float apart = way_apart(p, float4_at(record + AT_NORMAL), way, other, -1.0f);
    float part = clamp((depth - apart) * (float)inverse((real)depth), 0.0f, 1.0f);
    for (uint k = 0; k < (p->touches[contact] & TOUCH_POINTS); ++k) {
        __global float *point = record + HEAD + k * POINT_FLOATS;
        point[OF_NORMAL_IMPULSE] *= part;
#line 209 "kernels/dynamics/update_sleep.cl.in"
    }
}

__kernel void push_sleepers(PUSH_SLEEPERS_ARGS)
{
    const pressure p = {asleep, velocities,
#line 218 "kernels/dynamics/update_sleep.cl.in"
                        touches, contacts, bodies, round, n, margin};
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id) {
        if (!is_pushed_out(&p, id))
            continue;
        float4 way = way_of(&p, id), push = (float4)(0.0f);
        for (uint i = starts[id]; i < starts[id + 1]; ++i)
            push += push_of(&p, i, id, links[i].y, way, -1.0f);
        for (uint k = return_starts[id]; k < return_starts[id + 1]; ++k)
            push += push_of(&p, returns[k], id, links[returns[k]].x, way, 1.0f);
        bodies[(size_t)id * BODY + (~round & 1u)] = way + push;
    }
}

// Where the last round has brought them.
__kernel void move_sleepers(MOVE_SLEEPERS_ARGS)
{
    const pressure p = {asleep, velocities,
#line 240 "kernels/dynamics/update_sleep.cl.in"
                        touches, contacts, bodies, round, n, margin};
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id) {
        if (!is_pushed_out(&p, id))
            continue;
        float4 way = way_of(&p, id);
        for (uint i = starts[id]; i < starts[id + 1]; ++i)
            lessen_pushes(&p, i, links[i].y, way);
        real4 centre = centres[id];
        centre.xyz += convert_real4(way).xyz;
#line 254 "kernels/dynamics/update_sleep.cl.in"
        centres[id] = centre;
        if (rests[id] > 0.0f)
            rests[id] += dt;
    }
}
