// SPDX-License-Identifier: MIT
// The manifold of each pair that may touch: the narrow phase of a moving world.
//
// Invariant: a pair's manifold depends on the two bodies and its own record alone, so any work-item
// may make it, and eight pairs side by side get the same bits as one.
//
//   a pair ---- asleep, or not woken ----------------------> stays as it is   (needs_update)
//        \----- a wall ------------------------------------> collide_wall
//         \---- pushed, and hardly moved ------------------> renew_separations
//          \--- else: find_axis, points; fast: at the impact -> smooth_seams -> store_contact
//
//   links    [n_contacts] owner and other; n + k: wall k, from n + AT_GROUND on the ground
//   contacts [n_contacts] records (records.h)
//   touches  [n_contacts] words
//   bodies   [n + FIXED][BODY]

// Eight pairs of a work-item side by side; a wider state or rounded boxes go one by one.
#define SIDE_BY_SIDE (LANES == 8 && DIMS == 3 && ROTATED && !DOUBLE && !CONTINUOUS && !ROUNDED)

// ------------------------------------------------------------ walls

static inline float4 along_axis(int k, float length)
{
    return (float4)(k == 0 ? length : 0.0f, k == 1 ? length : 0.0f, k == 2 ? length : 0.0f, 0.0f);
}

// A wall across axis k, `distance` from the box's centre on its upper or lower
// side: the corners of the face that is turned most to it.
static inline void collide_wall_face(const solid *box, int k, float side, float distance, float margin, manifold *m)
{
    float4 outward = along_axis(k, side), corners[FACE_CORNERS];
    int facing = facing_axis(box, outward);
    float toward = dot_float(box->axis[facing], outward) < 0.0f ? -box->halves[facing] : box->halves[facing];
    set_corners(box, facing, box->axis[facing] * toward, corners);
    m->normal = outward;
    m->axis = 0;
    m->n = 0;
    for (int i = 0; i < FACE_CORNERS; ++i) {
        float separation = distance - dot_float(corners[i], outward) - radius_of(box);
        if (separation > margin)
            continue;
        float4 point = ROUNDED ? add_float(corners[i], box->radius, outward) : corners[i];
        point.w = separation;
        m->point[m->n++] = point;
    }
    if (radius_of(box) > 0.0f)
        merge_points(m, 0.01f * radius_of(box));
}

static inline void collide_wall(const scene *s, uint i, uint2 link)
{
    int k = (int)(link.y - s->n) >> 1;
    bool upper = (link.y - s->n) & 1u;
    real4 wall = upper ? s->upper : s->lower, centre = s->centres[link.x];
    real to = k == 0 ? wall.x : k == 1 ? wall.y : wall.z;
    real at = k == 0 ? centre.x : k == 1 ? centre.y : centre.z;
    float distance = (float)(upper ? to - at : at - to), side = upper ? 1.0f : -1.0f;
    float slack = 0.5f * s->margin * (1.0f - 0x1p-10f); // a little less than the grid's bounds have
    solid box = solid_of(s, link.x);
    manifold m;
    sweep w;
    if (CONTINUOUS)
        w = sweep_of(s, link, &box, &box);
    if (CONTINUOUS && is_fast(&w, s->dt, s->margin)) {
        collide_wall_face(&box, k, side, distance, slack, &m);
        w.target = target_of(&m, s->margin);
        float4 outward = along_axis(k, side);
        float impact = time_of_wall_impact(&box, distance * outward, outward, &w, s->dt);
        if (impact < s->dt) {
            w.met = impact;
            box = box_after(&box, &w, 0, impact);
            distance = fma(impact, dot_float(w.velocity, outward), distance);
            slack = INFINITY;
        }
    }
    collide_wall_face(&box, k, side, distance, slack, &m);
    store_contact(s, i, s->halves[link.x], (float4)(0.0f), &w, &m, 0);
}

// ------------------------------------------------------------ pairs

static inline void collide_pair(const scene *s, uint i, uint2 link)
{
    solid a = solid_of(s, link.x), b = solid_of(s, link.y);
    float4 d = offset_of(s, link);
    uint axis = s->touches[i] >> TOUCH_AXIS;
    manifold m;
    sweep w;
    bool touching = collide_rounded(&a, &b, d, s->margin, &m, &axis);
    if (CONTINUOUS)
        w = sweep_of(s, link, &a, &b);
    if (CONTINUOUS && is_fast(&w, s->dt, s->margin) && !(touching && is_straight(&w))) {
        w.target = target_of(&m, s->margin);
        float impact = time_of_impact(&a, &b, d, &w, s->dt);
        if (impact > 0.0f && impact < s->dt) {
            w.met = impact;
            a = box_after(&a, &w, 0, impact);
            b = box_after(&b, &w, 1, impact);
            d = add_float(d, impact, w.velocity);
            axis = 0;
            collide_at_impact(&a, &b, d, s->margin, &m);
        }
    }
//@ if ROUNDED == 1 and CONTACT_RESPONSE == 1 then
    smooth_seams(s, i, &a, &w, &m);
//@ end
    store_contact(s, i, s->halves[link.x], d, &w, &m, axis);
}

static inline bool had_points(const scene *s, uint i)
{
    return s->touches[i] & TOUCH_POINTS;
}

// Eight pairs, or n of them and seven at most of no interest. Pairs that touch get points one after
// the other.
static inline void collide_eight(const scene *s, const uint places[8], uint n)
{
    float4 rotations[8], extents[8], more_rotations[8], more_extents[8], offsets[8];
#pragma unroll
    for (uint k = 0; k < 8; ++k) {
        uint2 link = s->links[places[k]];
        rotations[k] = convert_float4(s->rotations[link.x]);
        extents[k] = s->halves[link.x];
        more_rotations[k] = convert_float4(s->rotations[link.y]);
        more_extents[k] = s->halves[link.y];
        offsets[k] = offset_of(s, link);
    }
    solid_lanes a = solids_of(rotations, extents), b = solids_of(more_rotations, more_extents);
    vec_lanes d = vectors_of(offsets);
    float lead = lead_of(s->margin);
    best_lanes bests = {INFINITY, -1, -1}, faces = bests;
    int8 near = are_within_reach(&a, &b, d, s->margin);
    if (any(near))
        bests = find_axes(&a, &b, d, lead, s->margin, &faces);
    near &= bests.separation <= s->margin;
    int is_near[8];
    best_axis best[8], face[8];
    vstore8(near, 0, is_near);
    put_lanes_of_best(&bests, best);
    put_lanes_of_best(&faces, face);
    for (uint k = 0; k < n; ++k) {
        manifold m;
        m.n = 0;
        if (is_near[k]) {
            solid one = solid_at(convert_real4(rotations[k]), extents[k]);
            solid other = solid_at(convert_real4(more_rotations[k]), more_extents[k]);
            make_manifold(&one, &other, offsets[k], best[k], face[k], lead, s->margin, &m);
        }
        store_contact(s, places[k], extents[k], offsets[k], 0, &m, 0);
    }
}

// ------------------------------------------------------------ the kernel

// All pairs that may change, or none in a pass for bodies that just woke if none did.
static inline uint contacts_to_update(const scene *s)
{
    return SLEEP && s->woken && !s->flags[FLAG_WOKE] ? 0 : N_AWAKE_CONTACTS_OF(s);
}

// Whether a pair needs no search for an axis: a wall, the ground, or a record that could be renewed.
static inline bool update_directly(const scene *s, uint i, uint2 link)
{
//@ if GROUND > 0 then
    if (link.y >= s->n + AT_GROUND) {
        if (link.y == s->n + AT_GROUND)
            collide_ground(s, i, link);
        return true;
    }
//@ end
    if (BOUNDARY && is_wall(s, link.y)) {
        collide_wall(s, i, link);
        return true;
    }
    return renew_separations(s, i, link);
}

#if WG > 1

// A group's pairs go through lists, each in turn for its work-items together, so that work-items side by side have as
// much to do:
//
//   asked    pairs to be updated: those that had points a step ago from the front on, the others from the back
//   waiting  those of them that need the search for an axis: most others are still apart as they were
//   near     with IN_LISTS, those of them that come within the margin: by a face from the front on, by edges from the
//            back; with the axes that were found
//
// The barriers are the kernel's: the compiler of PoCL 3.1 fails on some if a function has them.
#define MOST_OF_GROUP (WG * PER_ITEM)
#define IN_LISTS (ROTATED && !CONTINUOUS && !ROUNDED)

static inline void ask_for_updates(const scene *s, __local uint *asked, volatile __local uint *n)
{
    uint first = get_group_id(0) * MOST_OF_GROUP;
    for (uint k = first + get_local_id(0); k < min(first + MOST_OF_GROUP, contacts_to_update(s)); k += WG) {
        uint i = AWAKE_CONTACT_OF(s, k);
        if (!needs_update(s, s->links[i]))
            continue;
        if (had_points(s, i))
            asked[atomic_inc(n)] = i;
        else
            asked[MOST_OF_GROUP - 1 - atomic_inc(n + 1)] = i;
    }
}

// Whether the axis that separated a pair without points does so still, and nothing else is to be known.
static inline bool stays_apart(const scene *s, uint i, uint2 link)
{
    if (!IN_LISTS || had_points(s, i))
        return false;
    solid a = solid_of(s, link.x), b = solid_of(s, link.y);
    return is_still_separated(&a, &b, offset_of(s, link), lead_of(s->margin), s->margin, s->touches[i] >> TOUCH_AXIS);
}

static inline void update_asked(const scene *s, __local const uint *asked, uint touched, uint others,
                                __local uint *waiting, volatile __local uint *n_waiting)
{
    for (uint k = get_local_id(0); k < touched + others; k += WG) {
        uint i = asked[k < touched ? k : MOST_OF_GROUP - 1 - (k - touched)];
        uint2 link = s->links[i];
        if (!update_directly(s, i, link) && !stays_apart(s, i, link))
            waiting[atomic_inc(n_waiting)] = i;
    }
}

typedef struct {
    uint contact;
    uint axes; // numbers: of the axis, and from bit 4 on of the best face
    float separation;
} near_pair;

static inline void find_near(const scene *s, uint i, __local near_pair *near, volatile __local uint *n)
{
    uint2 link = s->links[i];
    solid a = solid_of(s, link.x), b = solid_of(s, link.y);
    float4 d = offset_of(s, link);
    uint axis = s->touches[i] >> TOUCH_AXIS;
    best_axis best, face;
    if (find_near_axes(&a, &b, d, lead_of(s->margin), s->margin, &best, &face, &axis)) {
        bool edges = best.a >= 0 && best.b >= 0;
        uint at = edges ? MOST_OF_GROUP - 1 - atomic_inc(n + 1) : atomic_inc(n);
        near[at] = (near_pair){i, axis_number(best) | axis_number(face) << 4, best.separation};
        return;
    }
    manifold none;
    none.n = 0;
    store_contact(s, i, s->halves[link.x], d, 0, &none, axis);
}

static inline void collide_near(const scene *s, near_pair near)
{
    uint2 link = s->links[near.contact];
    solid a = solid_of(s, link.x), b = solid_of(s, link.y);
    float4 d = offset_of(s, link);
    manifold m;
    make_manifold(&a, &b, d, numbered_axis(near.axes & 15u, near.separation), numbered_axis(near.axes >> 4, 0.0f),
                  lead_of(s->margin), s->margin, &m);
    store_contact(s, near.contact, s->halves[link.x], d, 0, &m, 0);
}

__kernel __attribute__((reqd_work_group_size(WG, 1, 1))) void build_manifolds(BUILD_MANIFOLDS_ARGS)
{
    const scene s = {BUILD_MANIFOLDS_VALUES};
    __local uint asked[MOST_OF_GROUP], waiting[MOST_OF_GROUP];
    __local near_pair near[IN_LISTS ? MOST_OF_GROUP : 1];
    __local uint counts[5]; // with points, without, that wait, near by a face, and by edges
    const uint item = get_local_id(0);
    if (item < 5)
        counts[item] = 0;
    barrier(CLK_LOCAL_MEM_FENCE);
    ask_for_updates(&s, asked, counts);
    barrier(CLK_LOCAL_MEM_FENCE);
    update_asked(&s, asked, counts[0], counts[1], waiting, counts + 2);
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint k = item; k < counts[2]; k += WG) {
        if (IN_LISTS)
            find_near(&s, waiting[k], near, counts + 3);
        else
            collide_pair(&s, waiting[k], links[waiting[k]]);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    const uint faces = counts[3], all = IN_LISTS ? faces + counts[4] : 0;
    for (uint k = item; k < all; k += WG)
        collide_near(&s, near[k < faces ? k : MOST_OF_GROUP - 1 - (k - faces)]);
}

#else

// Pairs that wait until there are eight: those without points a step ago, and the others.
typedef struct {
    uint places[2][8];
    uint n[2];
} eights;

#define AHEAD 8 // contacts whose records are asked for in time

// Asks for the record of a pair that touched.
static inline void ask_for_record(const scene *s, uint i)
{
    uint words = HEAD + (s->touches[i] & TOUCH_POINTS) * POINT_FLOATS;
    for (uint k = 0; words > HEAD && k < words; k += 16)
        ask_for(s->contacts + (size_t)i * RECORD + k);
}

// Asks for what is read of a pair once eight are there.
static inline void ask_for_pair(const scene *s, uint2 link)
{
    ask_for(s->rotations + link.y);
    ask_for(s->halves + link.y);
    ask_for(s->centres + link.y);
}

static inline void add_to_eights(const scene *s, eights *e, uint i, uint2 link)
{
    uint touched = had_points(s, i) ? 1 : 0;
    e->places[touched][e->n[touched]++] = i;
    ask_for_pair(s, link);
    if (e->n[touched] == 8) {
        collide_eight(s, e->places[touched], 8);
        e->n[touched] = 0;
    }
}

static inline void collide_rest(const scene *s, eights *e)
{
    for (uint touched = 0; touched < 2; ++touched) {
        uint size = e->n[touched];
        for (uint k = size; size > 0 && k < 8; ++k)
            e->places[touched][k] = e->places[touched][0];
        if (size > 0)
            collide_eight(s, e->places[touched], size);
    }
}

__kernel void build_manifolds(BUILD_MANIFOLDS_ARGS)
{
    const scene s = {BUILD_MANIFOLDS_VALUES};
    eights waiting;
    waiting.n[0] = waiting.n[1] = 0;
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, contacts_to_update(&s));
    for (uint k = first; k < last; ++k) {
        uint i = AWAKE_CONTACT_AT(k);
        uint2 link = links[i];
        uint ahead = AWAKE_CONTACT_AT(min(k + AHEAD, last - 1));
        if (needs_update(&s, links[ahead]))
            ask_for_record(&s, ahead);
        if (!needs_update(&s, link) || update_directly(&s, i, link))
            continue;
        if (SIDE_BY_SIDE)
            add_to_eights(&s, &waiting, i, link);
        else
            collide_pair(&s, i, link);
    }
    if (SIDE_BY_SIDE)
        collide_rest(&s, &waiting);
}

#endif
