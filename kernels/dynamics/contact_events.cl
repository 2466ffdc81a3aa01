// SPDX-License-Identifier: MIT
// Which contacts touch, and which hit hard.
//
// A contact touches if a point overlapped when its manifold was built, or pushed in the step. A
// sleeping contact is as it was when it fell asleep.
//
// Invariant: it runs while centres and velocities are still those that the step began with.
//
//   touching [(n_contacts + 31) / 32] a bit for each contact
//   hits     [n_contacts][HIT_WORDS] in any order (records.h)
#define HIT_WORDS 16
#define HIT_CENTRE 10

typedef struct {
    ARG_FIELDS
} events;

// The velocity of a point that is seen from the object's centre; walls stand still.
static inline float4 velocity_at(const events *e, uint id, float4 point)
{
//@ if HITS * CARRIED == 1 then
    id = MOVER_OF(e, id);
//@ end
    if (id >= e->n)
        return (float4)(0.0f);
    real4 v = e->velocities[id];
    if (ANGULAR_VELOCITY)
        v += cross_product(e->angular_velocities[id], convert_real4(point));
    return convert_float4(v);
}

// The greatest speed at which points that push come together, and the point; 0 and 0.
static inline float approach_speed(const events *e, uint2 link, __global const float *record, uint points, uint *fastest)
{
    float greatest = 0.0f;
    float4 normal = float4_at(record + AT_NORMAL), offset = float4_at(record + AT_OFFSET);
    for (uint k = 0; k < points; ++k) {
        __global const float *point = record + HEAD + k * POINT_FLOATS;
        float4 anchor = float4_at(point + OF_ANCHOR);
        float4 approach = velocity_at(e, link.x, anchor) - velocity_at(e, link.y, anchor - offset);
        float speed = fma(approach.x, normal.x, fma(approach.y, normal.y, approach.z * normal.z));
        if (point[OF_MAX_IMPULSE] > 0.0f && speed > greatest) {
            greatest = speed;
            *fastest = k;
        }
    }
    return greatest;
}

static inline void put_words(float4 v, __global uint *to)
{
    to[0] = as_uint(v.x);
    to[1] = as_uint(v.y);
    to[2] = as_uint(v.z);
}

static inline void put_centre(const events *e, uint id, __global uint *to)
{
    real4 centre = e->centres[id];
#if DOUBLE
    vstore2(as_uint2(centre.x), 0, to);
    vstore2(as_uint2(centre.y), 1, to);
    vstore2(as_uint2(centre.z), 2, to);
#else
    put_words(centre, to);
#endif
    if (ORIGIN)
        vstore3(as_uint3(e->cells[id].xyz), 0, to + 3);
}

static inline void put_hit(uint2 link, __global const float *record, uint points, uint fastest, float speed,
                           __global uint *hit)
{
    float impulse = 0.0f;
    for (uint k = 0; k < points; ++k)
        impulse += record[HEAD + k * POINT_FLOATS + OF_MAX_IMPULSE];
    hit[0] = link.x;
    hit[1] = link.y;
    put_words(float4_at(record + AT_NORMAL), hit + 2);
    put_words(float4_at(record + HEAD + fastest * POINT_FLOATS + OF_ANCHOR), hit + 5);
    hit[8] = as_uint(speed);
    hit[9] = as_uint(impulse);
}

// Adds contact i to the hits, if its bodies came together faster than hit_speed.
static inline void add_hit(const events *e, uint i, __global const float *record, uint points)
{
    uint fastest = 0;
    uint2 link = e->links[i];
    float speed = approach_speed(e, link, record, points, &fastest);
    if (!(speed > e->hit_speed))
        return;
    uint slot = atomic_inc(e->flags + FLAG_EVENTS);
    if (slot >= e->n_contacts)
        return;
    __global uint *hit = e->hits + (size_t)slot * HIT_WORDS;
    put_hit(link, record, points, fastest, speed, hit);
    put_centre(e, link.x, hit + HIT_CENTRE);
}

static inline bool is_touching(__global const float *record, uint points)
{
    bool touches = false;
    for (uint k = 0; k < points; ++k) {
        __global const float *point = record + HEAD + k * POINT_FLOATS;
        touches = touches || point[OF_SEPARATION] <= 0.0f;
        if (CONTACT_RESPONSE)
            touches = touches || point[OF_MAX_IMPULSE] > 0.0f;
    }
    return touches;
}

__kernel void contact_events(CONTACT_EVENTS_ARGS)
{
    const events e = {CONTACT_EVENTS_VALUES};
    if (WAITS_FOR_HOST)
        return;
    uint n_words = (n_contacts + 31) / 32;
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n_words);
    for (uint w = first; w < last; ++w) {
        uint word = 0;
        for (uint i = 32 * w; i < min(32 * w + 32, n_contacts); ++i) {
            uint points = touches[i] & TOUCH_POINTS;
            __global const float *record = contacts + (size_t)i * RECORD;
            if (!is_touching(record, points))
                continue;
            word |= 1u << (i & 31u);
            if (HITS)
                add_hit(&e, i, record, points);
        }
        touching[w] = word;
    }
}
