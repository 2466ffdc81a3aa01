// SPDX-License-Identifier: MIT
// Fat AABBs of moving bodies for the broad phase.
//
// Invariant: bodies that can touch before the next search have fat AABBs that overlap; they are
// rounded outward.
//
//   compute_fat_aabbs   body -> AABB, grown by the margin, by the way of this step (CONTINUOUS) and
//                       by the way of some steps ahead (SKIN)
//   check_fat_aabbs     a body that left its fat AABB sets a flag, and all are computed again; of all
//                       bodies, or of those that a step may have moved
//
//   boxes    [n][6]  lower xyz, upper xyz
//   altered  [n_altered] the bodies whose fat AABBs are computed (ALTERED)
//   aabb_margin, contact_margin  how far apart contacts are kept, and half the skin
#ifndef ALTERED
#define ALTERED 0
#endif

typedef struct {
    ARG_FIELDS
} bodies_at;

typedef struct {
    float4 lower;
    float4 upper;
} aabb;

static inline aabb aabb_around(real4 centre, real4 reach)
{
    float4 lower = convert_float4(centre - reach);
    float4 upper = convert_float4(centre + reach);
    aabb b;
    b.lower = lower - fma(fabs(lower), (float4)(0x1p-22f), (float4)(0x1p-125f));
    b.upper = upper + fma(fabs(upper), (float4)(0x1p-22f), (float4)(0x1p-125f));
    return b;
}

static inline real4 turned_reach(const bodies_at *s, uint id)
{
    real4 half_size = convert_real4(s->halves[id]);
    return ROTATED ? box_reach(s->rotations[id], half_size) : half_size;
}

// How far the box reaches in this step: no corner leaves the ball about the box, nor comes further
// than its arc.
static inline real4 reach_in_step(const bodies_at *s, uint id)
{
    real4 half_size = convert_real4(s->halves[id]), reach = turned_reach(s, id);
    if (CONTINUOUS && ANGULAR_VELOCITY) {
        real4 turn = s->angular_velocities[id];
        real square = dot_product(half_size, half_size), radius = root(square);
        reach = fmin(fmax(reach, (real4)(radius)), reach + s->dt * root(dot_product(turn, turn)) * radius);
    }
    return ROUNDED ? reach + (real)s->halves[id].w : reach;
}

static inline aabb body_aabb(const bodies_at *s, uint id, real margin)
{
    real4 reach = reach_in_step(s, id), centre = s->centres[id];
    if (ORIGIN) { // from a cell that all share: rounded, and grown by as much
        centre = offset_between((real4)(0), s->base, centre, s->cells[id]);
        reach = fma(fabs(centre), (real4)(0x1p-22f), reach);
    }
    aabb b = aabb_around(centre, reach + margin);
    if (CONTINUOUS) {
        aabb ahead = aabb_around(centre + s->velocities[id] * s->dt, reach + margin);
        b.lower = fmin(b.lower, ahead.lower);
        b.upper = fmax(b.upper, ahead.upper);
    }
    return b;
}

// At most `skins` skins, but along the axis of the greatest way further where few bodies are awake: a long and thin
// AABB has few neighbours.
static inline real4 most_ahead(const bodies_at *s, real4 below, real4 above)
{
    real most = s->skins * s->skin;
    if (!(s->skins > LEAST_HORIZON))
        return (real4)(most);
    real4 far = fmax(below, above);
    real longest = fmax(far.x, fmax(far.y, far.z)), times = s->skins / LEAST_HORIZON;
    real along = most * times * fmin(times, (real)4);
    return (real4)(far.x < longest ? most : along, far.y < longest ? most : along, far.z < longest ? most : along, most);
}

// How much further a body that turns reaches in `horizon` steps, at most `most`: no corner leaves the ball about
// the box.
static inline real4 arc_ahead(const bodies_at *s, uint id, real most)
{
    real4 turn = s->angular_velocities[id], half_size = convert_real4(s->halves[id]);
    real square = dot_product(half_size, half_size), way = dot_product(turn, turn) * square;
    if (!(way > 0))
        return (real4)(0);
    real arc = fmin(s->horizon * s->dt * root(way), most);
    return fmin((real4)(arc), fmax(root(square) - turned_reach(s, id), (real4)(0)));
}

// How far gravity takes a body in `time`: what lies awake on others falls for `skins` steps in its bounds, what has
// fallen for longer as long again, and a sleeper not at all.
static inline real4 fall_ahead(const bodies_at *s, uint id, real time)
{
    real4 gravity = s->gravity;
    real fallen = dot_product(s->velocities[id], gravity) * inverse(dot_product(gravity, gravity));
    real falls = fmin(time, fmax(s->skins * s->dt, fallen));
    bool sleeps = SLEEP && (s->asleep[id] & SLEEPS);
    return sleeps ? (real4)(0) : gravity * ((real)0.5 * falls * falls);
}

// How much further AABBs reach than the skin, below and above: as far as the body comes in `horizon`
// steps, if nothing stops it.
static inline void grow_by_skin(const bodies_at *s, uint id, aabb *b)
{
    real time = s->horizon * s->dt;
    real4 velocity = s->velocities[id], way = velocity * time, fallen = way;
    if (GRAVITY == 1 && velocity.w > 0)
        fallen += fall_ahead(s, id, time);
    real4 lower = fmax(-fmin(way, fallen), (real4)(0)), upper = fmax(fmax(way, fallen), (real4)(0));
    real4 ahead = most_ahead(s, lower, upper);
    lower = fmin(lower, ahead);
    upper = fmin(upper, ahead);
    if (ANGULAR_VELOCITY) {
        real4 arc = arc_ahead(s, id, s->skins * s->skin);
        lower += arc;
        upper += arc;
    }
    if (SLEEP && (s->asleep[id] & PRESSED)) { // it goes somewhere, without a velocity
        lower += s->skin;
        upper += s->skin;
    }
    b->lower -= convert_float4(lower);
    b->upper += convert_float4(upper);
}

__kernel void compute_fat_aabbs(COMPUTE_FAT_AABBS_ARGS)
{
    const bodies_at s = {COMPUTE_FAT_AABBS_VALUES};
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, ALTERED ? s.n_altered : s.n);
    for (uint i = first; i < last; ++i) {
        uint id = ALTERED ? s.altered[i] : i;
        aabb b = body_aabb(&s, id, aabb_margin);
        if (SKIN)
            grow_by_skin(&s, id, &b);
        vstore3(b.lower.xyz, 2 * (size_t)id, boxes);
        vstore3(b.upper.xyz, 2 * (size_t)id + 1, boxes);
    }
}

#if SKIN && !ALTERED
__kernel void check_fat_aabbs(CHECK_FAT_AABBS_ARGS)
{
    const bodies_at s = {CHECK_FAT_AABBS_VALUES};
    if (WAITS_FOR_HOST)
        return;
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, SLEEP && !of_all ? N_AWAKE : n);
    bool inside = true;
    for (uint k = first; k < last; ++k) {
        uint id = SLEEP && !of_all ? AWAKE_AT(k) : k;
        aabb b = body_aabb(&s, id, contact_margin);
        float3 lower = vload3(2 * (size_t)id, boxes);
        float3 upper = vload3(2 * (size_t)id + 1, boxes);
        inside = inside && all(b.lower.xy >= lower.xy) && all(b.upper.xy <= upper.xy);
        if (DIMS == 3)
            inside = inside && b.lower.z >= lower.z && b.upper.z <= upper.z;
    }
    if (!inside)
        atomic_or(flags + FLAG_MOVED, 1u);
}
#endif
