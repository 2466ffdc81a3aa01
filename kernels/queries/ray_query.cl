// SPDX-License-Identifier: MIT
// Which boxes rays meet, by walking down a box tree (queries/tree.h).
//
//   items    [n][RAY_WORDS] rays: origin xyz, direction xyz, t_max
//   order    [n] of rays, by where they begin; in_order 1: as they come
//   boxes, nodes    of the tree
//   levels   [n_levels] first node of each level, the lowest first
//   hits     [n][HIT_WORDS]; for all hits [hits_capacity][HIT_WORDS], in any order
//   open     [open_capacity][HIT_WORDS] boxes that float leaves to the host, those that a
//            nearer hit makes needless left out
//
// A ray's direction is scaled by a power of two to 1 .. 2, and `t` with it, so that
// nothing is rounded. docs/accuracy.md, "Rays", has the error bounds.
//
// What a ray finds does not depend on the tree. The distance to a box is never below
// that to its bounds, and the distance to bounds never below that to wider ones: each
// operation on the way is monotone. So a node that is passed over for being further away
// than the nearest hit holds nothing nearer.
#define CLOSEST 0
#define ANY 1
#define EVERY 2

#define RAY_WORDS 7
#define HIT_WORDS 3 // the ray, the box's id, how far along the ray

#define SLACK (64.0f * 0x1p-24f) // of a box's size, as seen from the ray's origin
#define LEAST_SIZE 0x1p-70f
#define GREATEST_SIZE 0x1p110f
#define BOUNDS_SLACK 0x1p-18f
#define LEAST_SPEED 0x1p-60f   // along an axis of the world, of a direction of 1 .. 2
#define SLOW 0x1p-40f          // along an edge of a box
#define LEAST_DIRECTION 0x1p-100f

typedef struct {
    float origin[3];
    float direction[3]; // scaled
    float inverse[3];   // of it; 0: no speed along that axis, NaN: too little to tell
    float nearer[3], farther[3]; // the same, less and more by BOUNDS_SLACK
    float t_max;        // scaled
    float scale;        // of what is scaled, to the caller's
} ray;

struct walk {
    ray r;
    __global const float *boxes;
    uint number;
    float best; // CLOSEST: t and id of the nearest hit so far
    uint id;
#if WANTS == EVERY
    __global uint *hits;
    uint hits_capacity;
#endif
    __global uint *open;
    uint open_capacity;
    volatile __global uint *counters;
};

static inline bool is_zero(float x)
{
    return (as_uint(x) & 0x7FFFFFFFu) == 0;
}

static inline bool ray_is_bad(const float r[RAY_WORDS])
{
    float greatest = 0.0f, sum = 0.0f;
    bool zero = true;
    for (int k = 0; k < 3; ++k) {
        bool counts = k < DIMS;
        sum = fma(counts ? r[k] : 0.0f, 0.0f, fma(counts ? r[3 + k] : 0.0f, 0.0f, sum));
        if (counts) {
            sum = fabs(r[k]) > MOST_COORDINATE ? NAN : sum;
            greatest = fmax(greatest, fabs(r[3 + k]));
            zero = zero && is_zero(r[3 + k]);
        }
    }
    bool has_length = greatest >= LEAST_DIRECTION && greatest <= MOST_COORDINATE;
    return sum != 0.0f || !(r[6] >= 0.0f) || !(zero || has_length);
}

static inline float signed_inverse(float component, float scaled)
{
    if (is_zero(component))
        return 0.0f;
    if (fabs(scaled) < LEAST_SPEED)
        return NAN;
    return copysign(inverse_of(fabs(scaled)), scaled);
}

static inline ray ray_of(const float given[RAY_WORDS])
{
    ray r;
    float greatest = 0.0f;
    for (int k = 0; k < DIMS; ++k)
        greatest = fmax(greatest, fabs(given[3 + k]));
    uint exponent = as_uint(greatest) & 0x7F800000u;
    bool still = exponent == 0;
    r.scale = still ? 1.0f : as_float(0x7F000000u - exponent);
    r.t_max = still ? 0.0f : given[6] * as_float(exponent);
    for (int k = 0; k < 3; ++k) {
        r.origin[k] = k < DIMS ? given[k] : 0.0f;
        r.direction[k] = k < DIMS ? given[3 + k] * r.scale : 0.0f;
        r.inverse[k] = k < DIMS ? signed_inverse(given[3 + k], r.direction[k]) : 0.0f;
        r.nearer[k] = r.inverse[k] * (1.0f - BOUNDS_SLACK);
        r.farther[k] = r.inverse[k] * (1.0f + BOUNDS_SLACK);
    }
    return r;
}

// ------------------------------------------------------------ bounds

// Whether the ray meets the bounds of children from `node` on, and from which t. A
// difference has the right sign, so what counts of `near` is above 0, and what is below 0
// of `far` is a miss whatever the slack.
static inline mask meets_bounds(const walk *w, __global const float *node, real *from)
{
    const ray *r = &w->r;
    real near = (real)(0.0f), far = (real)(r->t_max);
    mask beside = (mask)(0);
#pragma unroll
    for (int k = 0; k < DIMS; ++k) {
        real lower = load_lanes(node + k * TREE_WIDTH);
        real upper = load_lanes(node + (3 + k) * TREE_WIDTH);
        float inverse = r->inverse[k];
        if (inverse == 0.0f) {
            beside |= (lower > (real)(r->origin[k])) | (upper < (real)(r->origin[k]));
        } else if (inverse == inverse) {
            near = fmax(near, ((inverse > 0.0f ? lower : upper) - r->origin[k]) * r->nearer[k]);
            far = fmin(far, ((inverse > 0.0f ? upper : lower) - r->origin[k]) * r->farther[k]);
        } else {
            beside |= lower > upper; // no box here
        }
    }
    *from = near;
    return (near <= far) & !beside;
}

// ------------------------------------------------------------ a box

#define MISSED 0
#define MET 1
#define OPEN 2

static inline float along(__global const float *axis, const float v[3])
{
#if DIMS == 3
    return fma(axis[0], v[0], fma(axis[1], v[1], axis[2] * v[2]));
#else
    return fma(axis[0], v[0], axis[1] * v[1]);
#endif
}

#if SHAPE // bounds

// Where denormal numbers may be lost on the way to a difference.
static inline bool is_tiny(float a, float b)
{
    return fabs(a - b) < LEAST_DIRECTION && as_uint(a) != as_uint(b) && !(is_zero(a) && is_zero(b));
}

// A difference has the right sign and is off by a part of itself, as all that follows:
// BOUNDS_SLACK is above them together.
static inline uint meet_box(const ray *r, __global const float *box, float *t)
{
    float enter = *t, surely_enter = 0.0f, maybe_enter = 0.0f;
    float surely_leave = r->t_max, maybe_leave = r->t_max;
    bool open = false;
#pragma unroll
    for (int k = 0; k < DIMS; ++k) {
        float inverse = r->inverse[k];
        if (inverse == 0.0f) {
            if (box[k] > r->origin[k] || box[3 + k] < r->origin[k])
                return MISSED;
            continue;
        }
        if (inverse != inverse) {
            open = true;
            continue;
        }
        if (is_tiny(box[k], r->origin[k]) || is_tiny(box[3 + k], r->origin[k]))
            return OPEN;
        float lower = box[k] - r->origin[k], upper = box[3 + k] - r->origin[k];
        float in = inverse > 0.0f ? lower : upper, out = inverse > 0.0f ? upper : lower;
        enter = fmax(enter, in * inverse);
        surely_enter = fmax(surely_enter, in * r->farther[k]);
        maybe_enter = fmax(maybe_enter, in * r->nearer[k]);
        surely_leave = fmin(surely_leave, out * r->nearer[k]);
        maybe_leave = fmin(maybe_leave, out * r->farther[k]);
    }
    if (maybe_enter > maybe_leave)
        return MISSED;
    *t = fmin(enter, r->t_max);
    return !open && surely_enter <= surely_leave ? MET : OPEN;
}

#else

// Where the ray is between the two faces of each edge, widened and narrowed by what
// float may be wrong by. `t` is at least that of the box's bounds.
static inline uint meet_box(const ray *r, __global const float *box, float *t)
{
    float way[3], size = 0.0f;
#pragma unroll
    for (int k = 0; k < DIMS; ++k) {
        way[k] = r->origin[k] - box[k];
        size += fabs(way[k]) + box[3 + k];
    }
    if (!(size >= LEAST_SIZE && size <= GREATEST_SIZE))
        return OPEN;
    float doubt = SLACK * size;
    float enter = *t, surely_enter = 0.0f, maybe_enter = 0.0f;
    float surely_leave = r->t_max, maybe_leave = r->t_max;
    bool open = false;
#pragma unroll
    for (int k = 0; k < DIMS; ++k) {
        float at = along(box + TREE_BOX_AXES + 3 * k, way), half_extent = box[3 + k];
        float speed = along(box + TREE_BOX_AXES + 3 * k, r->direction);
        if (fabs(speed) < SLOW) {
            if (fabs(at) > half_extent + doubt)
                return MISSED;
            open = open || fabs(at) > half_extent - doubt;
            continue;
        }
        float inverse = inverse_of(fabs(speed));
        at = speed > 0.0f ? at : -at;
        float in = (-half_extent - at) * inverse, out = (half_extent - at) * inverse, error = doubt * inverse;
        enter = fmax(enter, in);
        surely_enter = fmax(surely_enter, in + error);
        maybe_enter = fmax(maybe_enter, in - error);
        surely_leave = fmin(surely_leave, out - error);
        maybe_leave = fmin(maybe_leave, out + error);
    }
    if (maybe_enter > maybe_leave)
        return MISSED;
    *t = fmin(enter, r->t_max);
    return !open && surely_enter <= surely_leave ? MET : OPEN;
}

#endif

// ------------------------------------------------------------ the walk

static inline float farthest(const walk *w)
{
    return w->best;
}

static inline void list_hit(const walk *w, __global uint *row, uint id, float t)
{
    if (!row)
        return;
    row[0] = w->number;
    row[1] = id;
    row[2] = as_uint(t * w->r.scale);
}

static inline bool visit_box(walk *w, uint slot, float from)
{
    __global const float *box = w->boxes + (size_t)slot * TREE_BOX_WORDS;
    float t = from;
    uint id = as_uint(box[TREE_BOX_ID]);
    uint found = meet_box(&w->r, box, &t);
    bool needless = WANTS == CLOSEST && (t > w->best || (t == w->best && id > w->id));
    if (found == MISSED || needless)
        return false;
    if (found == OPEN) {
        list_hit(w, add_row(w->open, w->open_capacity, w->counters + COUNT_OPEN, HIT_WORDS), id, t);
        return false;
    }
#if WANTS == EVERY
    list_hit(w, add_row(w->hits, w->hits_capacity, w->counters + COUNT_HITS, HIT_WORDS), id, t);
#endif
    w->best = WANTS == EVERY ? INFINITY : t;
    w->id = id;
    return WANTS == ANY;
}

__kernel void ray_query(RAY_QUERY_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    for (uint i = first; i < min(first + PER_ITEM, n); ++i) {
        uint at = in_order ? i : order[i];
        float given[RAY_WORDS];
        for (int k = 0; k < RAY_WORDS; ++k)
            given[k] = items[(size_t)at * RAY_WORDS + k];
        walk w;
        w.number = first_item + at;
        w.best = INFINITY;
        w.id = NO_OBJECT;
        w.boxes = boxes;
        w.open = open;
        w.open_capacity = open_capacity;
        w.counters = counters;
#if WANTS == EVERY
        w.hits = hits;
        w.hits_capacity = hits_capacity;
#endif
        if (ray_is_bad(given)) {
            atomic_max(counters + BAD_LATEST, ~at);
            continue;
        }
        w.r = ray_of(given);
        walk_tree(&w, nodes, levels, n_levels);
#if WANTS != EVERY
        hits[(size_t)at * HIT_WORDS] = first_item + at;
        hits[(size_t)at * HIT_WORDS + 1] = WANTS == ANY && w.id != NO_OBJECT ? 0 : w.id;
        hits[(size_t)at * HIT_WORDS + 2] = WANTS == ANY ? 0 : as_uint(w.best * w.r.scale);
#endif
    }
}
