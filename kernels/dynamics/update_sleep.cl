// SPDX-License-Identifier: MIT
// Sleep.
//
// Invariant: a body sleeps if it has rested for `sleep_after` seconds and touches no body that moves.
//
//   awake --- rested, touches none that moves ---> asleep --- deep in others ---> pressed: pushed out
//     ^                                              |                              |  of them
//     +---- touches a body that moves, or lost a contact, which set its rest to 0 --+
//
//   rests, asleep  as rest.clh has them

static inline bool is_sensor(const scene *s, uint id)
{
    return SENSORS && id < s->n && s->sensors[id] > 0.0f;
}

// Finds what a body touches: whether all of it rests, and whether some of it is deep in the body.
typedef struct {
    bool rests;
    bool deep;
} touch;

static inline void add_touch(const scene *s, uint word, uint other, touch *so_far)
{
    if (!so_far->rests || !(word & TOUCH_POINTS) || is_sensor(s, other))
        return;
    so_far->rests = is_at_rest(s, other);
    so_far->deep = so_far->deep || (word & TOUCH_DEEP);
}

// As far as something that moves is found.
static inline touch touch_of(const scene *s, uint id)
{
    touch found = {true, false};
    if (is_sensor(s, id))
        return found;
    const body_row row = row_of(s->starts, s->return_starts, s->returns, id);
    for (uint k = 0; found.rests && k < row.n; k += ROW_AHEAD) {
        const contacts_ahead next = look_ahead(&row, k, s->links, s->touches);
        EACH_AHEAD(j, next)
            add_touch(s, next.words[j], other_of(next.links[j], id), &found);
    }
    return found;
}

__kernel void update_sleep(UPDATE_SLEEP_ARGS)
{
    const scene s = {UPDATE_SLEEP_VALUES};
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, N_AWAKE);
    bool any_awake = false, any_pressed = false;
    for (uint k = first; k < last; ++k) {
        uint id = AWAKE_AT(k);
        bool slept = asleep[id] & SLEEPS, sleeps = has_rested(&s, id), pressed = false;
        if (sleeps) {
            touch found = touch_of(&s, id);
            sleeps = found.rests;
            pressed = found.rests && found.deep && rests[id] < sleep_after + PRESSED_STEPS * dt;
        }
        if (sleeps != slept)
            atomic_or(flags + FLAG_FELL_ASLEEP, 1u);
        if (slept && !sleeps)
            atomic_or(flags + FLAG_WOKE, 1u);
        asleep[id] = (sleeps ? SLEEPS : 0u) | (pressed ? PRESSED : 0u) | (slept && !sleeps ? WOKE : 0u);
        any_pressed = any_pressed || pressed;
        any_awake = any_awake || pressed || !(sleeps || (!(velocities[id].w > 0) && is_at_rest(&s, id)));
    }
    if (any_awake)
        atomic_or(flags + FLAG_AWAKE, 1u);
    if (any_pressed)
        atomic_or(flags + FLAG_PRESSED, 1u);
}

static inline void wake_across(const scene *s, volatile __global uint *asleep, uint word, uint other)
{
    if (other < s->n && (word & TOUCH_POINTS) && !is_sensor(s, other) && (asleep[other] & SLEEPS))
        atomic_xchg(asleep + other, WOKE);
}

// A sleeper that lost a contact in this step wakes what it touches, which may be in no list yet.
__kernel void wake_touching(WAKE_TOUCHING_ARGS)
{
    const scene s = {WAKE_TOUCHING_VALUES};
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, N_AWAKE);
    for (uint k = first; k < last; ++k) {
        uint id = AWAKE_AT(k);
        if (!(asleep[id] & WOKE) || is_at_rest(&s, id) || is_sensor(&s, id))
            continue;
        const body_row row = row_of(starts, return_starts, returns, id);
        for (uint i = 0; i < row.n; i += ROW_AHEAD) {
            const contacts_ahead next = look_ahead(&row, i, links, touches);
            EACH_AHEAD(j, next)
                wake_across(&s, asleep, next.words[j], other_of(next.links[j], id));
        }
    }
}

// ------------------------------------------------------------ pushing apart

// Bodies that sleep deep in others go out of them in rounds, each from the ways of the round
// before. Only what goes has a way; ways are kept where the solver will have its bodies.
//
//   bodies  [n + FIXED][BODY] ways, of even rounds in the first vector and of odd ones in the next
#define LEFT 0.5f // of the margin, which is not pushed out

static inline bool is_pushed_out(const scene *s, uint id)
{
    return id < s->n && (s->asleep[id] & PRESSED);
}

static inline float4 way_of(const scene *s, uint id)
{
    bool goes = s->round > 0 && is_pushed_out(s, id);
    return goes ? s->bodies[(size_t)id * BODY + (s->round & 1u)] : (float4)(0.0f);
}

// The body's part of a way that both go, where the other goes as well.
static inline float share_of(const scene *s, uint id, uint other)
{
    real mass = s->velocities[id].w;
    return is_pushed_out(s, other) ? (float)(mass * inverse(mass + s->velocities[other].w)) : 1.0f;
}

static inline bool is_pushing(const scene *s, uint word, uint other)
{
    return !is_sensor(s, other) && (word & TOUCH_POINTS);
}

static inline float depth_of(__global const float *record, uint word)
{
    float deepest = 0.0f;
    for (uint k = 0; k < (word & TOUCH_POINTS); ++k)
        deepest = fmax(deepest, -record[HEAD + k * POINT_FLOATS + OF_SEPARATION]);
    return deepest;
}

// The other's way against the body's, along the normal away from the body; side -1: the
// body owns the contact, 1: the other does.
static inline float way_apart(const scene *s, float4 normal, float4 way, uint other, float side)
{
    float4 between = way_of(s, other) - way;
    return -side * fma(between.x, normal.x, fma(between.y, normal.y, between.z * normal.z));
}

static inline float4 push_of(const scene *s, uint contact, uint word, uint2 link, uint id, float4 way)
{
    const uint other = other_of(link, id);
    if (!(word & TOUCH_DEEP) || !is_pushing(s, word, other))
        return (float4)(0.0f);
    __global const float *record = s->contacts + (size_t)contact * RECORD;
    const float side = link.x == id ? -1.0f : 1.0f;
    float4 normal = float4_at(record + AT_NORMAL);
    float excess = depth_of(record, word) - way_apart(s, normal, way, other, side) - LEFT * s->margin;
    return excess > 0.0f ? 0.5f * side * excess * share_of(s, id, other) * normal : (float4)(0.0f);
}

// Lessens a contact's impulses by as much as it is less deep, for when its bodies wake.
static inline void lessen_pushes(const scene *s, __global float *record, uint word, uint other, float4 way)
{
    float depth = depth_of(record, word);
    if (!is_pushing(s, word, other) || !(depth > 0.0f))
        return;
    float apart = way_apart(s, float4_at(record + AT_NORMAL), way, other, -1.0f);
    float part = clamp((depth - apart) * (float)inverse((real)depth), 0.0f, 1.0f);
    for (uint k = 0; k < (word & TOUCH_POINTS); ++k) {
        __global float *point = record + HEAD + k * POINT_FLOATS;
        point[OF_NORMAL_IMPULSE] *= part;
        for (int j = 0; FRICTION && j < DIMS - 1; ++j)
            point[OF_TANGENT_IMPULSE + j] *= part;
    }
}

__kernel void push_sleepers(PUSH_SLEEPERS_ARGS)
{
    const scene s = {PUSH_SLEEPERS_VALUES};
    if (WAITS_FOR_HOST)
        return;
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, N_AWAKE);
    for (uint k = first; k < last; ++k) {
        uint id = AWAKE_AT(k);
        if (!is_pushed_out(&s, id))
            continue;
        float4 way = way_of(&s, id), push = (float4)(0.0f);
        const body_row row = row_of(starts, return_starts, returns, id);
        for (uint i = 0; i < row.n; i += ROW_AHEAD) {
            const contacts_ahead next = look_ahead(&row, i, links, touches);
            EACH_AHEAD(j, next)
                push += push_of(&s, next.contacts[j], next.words[j], next.links[j], id, way);
        }
        bodies[(size_t)id * BODY + (~round & 1u)] = way + push;
    }
}

// Moves sleepers to where the last round has brought them.
__kernel void move_sleepers(MOVE_SLEEPERS_ARGS)
{
    const scene s = {MOVE_SLEEPERS_VALUES};
    if (WAITS_FOR_HOST)
        return;
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, N_AWAKE);
    for (uint k = first; k < last; ++k) {
        uint id = AWAKE_AT(k);
        if (!is_pushed_out(&s, id))
            continue;
        float4 way = way_of(&s, id);
        const body_row own = own_row_of(starts, id);
        for (uint i = 0; i < own.n; i += ROW_AHEAD) {
            const contacts_ahead next = look_ahead(&own, i, links, touches);
            EACH_AHEAD(j, next)
                lessen_pushes(&s, contacts + (size_t)next.contacts[j] * RECORD, next.words[j], next.links[j].y, way);
        }
        real4 centre = centres[id];
        centre.xyz += convert_real4(way).xyz;
        if (ORIGIN)
            normalize_offset(&centre, s.cells + id);
        centres[id] = centre;
        if (rests[id] > 0.0f)
            rests[id] += dt;
    }
}
