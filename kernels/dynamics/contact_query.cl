// SPDX-License-Identifier: MIT
// Where pairs of boxes touch that the caller brings, as the contacts of bodies are found.
//
// Invariant: (a, b) and (b, a) have the same points. Which of a pair's boxes comes first decides
// between axes that are equally good, so the one with the lower id does.
//
//   objects  [objects] poses, rounded boxes or spheres (narrowphase/object.clh)
//   pairs    [n][2] ids
//   contacts [n][WORDS] a, b, normal xyz, points, and four times anchor xyz, separation, 0
#define WORDS 26
#define AT_NORMAL 2
#define AT_POINTS 5
#define AT_POINT 6
#define POINT_WORDS 5
#define NO_BOX 0xffffffffu // points, where one of the two is no box

// Separations along one direction are off by less than this part of the boxes' size and
// distance (docs/notes/accuracy.md, "Contacts").
#define SLACK 0x1p-17f

// LANES pairs, each from its first box's centre.
typedef struct {
    solid a[LANES], b[LANES];
    float4 d[LANES];
    float slack[LANES];
    float most[LANES]; // how far cores may be apart that touch
} pairs_at;

static inline void put_lanes(real numbers, float to[LANES])
{
    uint words[LANES];
    spread(as_word(numbers), words);
    for (int k = 0; k < LANES; ++k)
        to[k] = as_float(words[k]);
}

static inline void set_solids(solid to[LANES], real axis[3][3], const object *o)
{
    float turned[3][3][LANES], halves[3][LANES];
    for (int i = 0; i < 3; ++i) {
        put_lanes(o->halves[i], halves[i]);
        for (int k = 0; k < 3; ++k)
            put_lanes(axis[i][k], turned[i][k]);
    }
#if ROUNDED
    float radii[LANES];
    put_lanes(o->radius, radii);
    for (int lane = 0; lane < LANES; ++lane)
        to[lane].radius = radii[lane];
#endif
    for (int lane = 0; lane < LANES; ++lane)
        for (int i = 0; i < 3; ++i) {
            to[lane].axis[i] = (float4)(turned[i][0][lane], turned[i][1][lane], turned[i][2][lane], 0.0f);
            to[lane].halves[i] = halves[i][lane];
        }
}

static inline real slack_of(const object *a, const object *b, const real d[3])
{
    real size = fabs(d[0]) + fabs(d[1]) + fabs(d[2]);
    for (int k = 0; k < 3; ++k)
        size += a->halves[k] + b->halves[k];
#if ROUNDED
    size += a->radius + b->radius;
#endif
    return SLACK * size;
}

// The corner of `other` that is deepest behind face k of `own`, brought onto that face.
static inline void collide_corner(const solid *own, const solid *other, float4 d, int k, float separation, manifold *m)
{
    float4 normal = dot_float(d, own->axis[k]) < 0.0f ? -own->axis[k] : own->axis[k];
    float4 corner = d;
    for (int j = 0; j < DIMS; ++j) {
        float toward = dot_float(other->axis[j], normal) < 0.0f ? other->halves[j] : -other->halves[j];
        corner = add_float(corner, toward, other->axis[j]);
    }
    float4 at = fma(0.5f, separation, own->halves[k]) * normal;
    for (int j = 0; j < DIMS; ++j)
        if (j != k)
            at = add_float(at, clamp(dot_float(corner, own->axis[j]), -own->halves[j], own->halves[j]), own->axis[j]);
    m->normal = normal;
    m->n = 1;
    m->point[0] = at;
    m->point[0].w = separation;
}

// Where faces pass each other by a hair there is still a point.
static inline void collide_nearest(const solid *a, const solid *b, float4 d, best_axis face, manifold *m)
{
    if (face.b < 0) {
        collide_corner(a, b, d, face.a, face.separation, m);
        return;
    }
    collide_corner(b, a, -d, face.b, face.separation, m);
    m->normal = -m->normal;
    m->point[0].xyz += d.xyz;
}

// Whether a point, seen from the centre, is in the box or nearly.
static inline bool has_point(const solid *box, float4 point, float slack)
{
    bool inside = true;
    for (int k = 0; k < DIMS; ++k)
        inside = inside && fabs(dot_float(point, box->axis[k])) <= box->halves[k] + slack;
    return inside;
}

// Edges that do not cross have their nearest points beyond their ends.
static inline bool edges_cross(const solid *a, const solid *b, float4 d, const manifold *m, float slack)
{
    float4 half_way = 0.5f * m->point[0].w * m->normal;
    float4 at = (float4)(m->point[0].xyz, 0.0f);
    return has_point(a, at - half_way, slack) && has_point(b, at + half_way - d, slack);
}

// Points from a's centre, up to the margin, once the axes are known. False where there are none:
// the boxes are further apart, or faces are beside each other.
static inline bool collide(const solid *a, const solid *b, float4 d, best_axis best, best_axis face, float margin,
                         float slack, manifold *m)
{
    float lead = lead_of(margin) + slack;
    m->n = 0;
    if (best.separation > margin + slack)
        return false;
    make_manifold(a, b, d, best, face, lead, margin + slack, m);
#if DIMS == 3
    bool edges = best.a >= 0 && best.b >= 0;
    if (edges && m->n == 1 && !edges_cross(a, b, d, m, slack)) {
        m->n = 0;
        if (best.separation > slack)
            return false;
        best = face; // a better axis is left out, for its edges are nearly parallel
        collide_faces(a, b, d, best, lead, margin + slack, m);
    }
#endif
    if (m->n == 0 && margin == 0.0f)
        collide_nearest(a, b, d, best, m);
    return m->n > 0;
}

#if DIMS == 3
#define FLAT 0x1p-6f // squared sine

// a b - c d, of which nothing cancels that counts.
static inline float difference(float a, float b, float c, float d)
{
    float less = c * d;
    return fma(a, b, -less) + fma(-c, d, less);
}

static inline float4 cross_exactly(float4 a, float4 b)
{
    return (float4)(difference(a.y, b.z, a.z, b.y), difference(a.z, b.x, a.x, b.z), difference(a.x, b.y, a.y, b.x),
                    0.0f);
}

// Where edges cross that are nearly parallel, which find_nearest leaves out or finds roughly. Without
// these a pair could collide and have no point.
static inline void offer_flat_crossings(nearest_points *best, const solid *a, const solid *b, float4 d)
{
    for (int k = 0; k < 9; ++k) {
        int i = k / 3, j = k % 3;
        float4 across = cross_exactly(a->axis[i], b->axis[j]);
        float length2 = dot_float(across, across);
        if (a->halves[i] == 0.0f || b->halves[j] == 0.0f || length2 > FLAT || length2 < 1e-13f)
            continue;
        float4 outward = dot_float(across, d) < 0.0f ? -across : across;
        float4 of_a[4], of_b[4];
        int n_a = edges_facing(a, i, outward, length2, of_a), n_b = edges_facing(b, j, -outward, length2, of_b);
        across *= inverse_float(length2);
        for (int e = 0; e < n_a * n_b; ++e) {
            float4 on_a = of_a[e % n_a], on_b = d + of_b[e / n_a];
            float at_a = dot_float(cross_exactly(on_b - on_a, b->axis[j]), across);
            float at_b = dot_float(cross_exactly(on_b - on_a, a->axis[i]), across);
            offer_points(best, add_float(on_a, clamp(at_a, -a->halves[i], a->halves[i]), a->axis[i]),
                         add_float(on_b, clamp(at_b, -b->halves[j], b->halves[j]), b->axis[j]));
        }
    }
}
#endif

// As collide, where one of the two has a radius. best, face: of the cores, up to both radii more.
static inline void collide_surfaces(const solid *a, const solid *b, float4 d, best_axis best, best_axis face, float margin,
                                  float slack, manifold *m)
{
    float reach = margin + slack, most = reach + (a->radius + b->radius);
    nearest_points p = {(float4)(0.0f), d, 0.0f};
    m->n = 0;
    if (best.separation > most)
        return;
    if (best.separation > 0.0f) {
        p = find_nearest(a, b, d);
#if DIMS == 3
        offer_flat_crossings(&p, a, b, d);
#endif
    }
    if (p.square <= most * most)
        collide_cores(a, b, d, &p, best, face, lead_of(margin) + slack, reach, m);
}

// ------------------------------------------------------------ pairs

#if LANES == 8

static inline solid_lanes lanes_of(const object *o, real axis[3][3])
{
    solid_lanes s;
    for (int i = 0; i < 3; ++i) {
        s.axis[i] = (vec_lanes){axis[i][0], axis[i][1], axis[i][2]};
        s.halves[i] = o->halves[i];
    }
    return s;
}

#endif

static inline void find_points(const pairs_at *p, int k, best_axis best, best_axis face, float margin, manifold *m)
{
    const solid *a = &p->a[k], *b = &p->b[k];
    float slack = p->slack[k];
    if (are_round(a, b)) {
        collide_surfaces(a, b, p->d[k], best, face, margin, slack, m);
        return;
    }
    if (collide(a, b, p->d[k], best, face, margin, slack, m) || margin == 0.0f)
        return;
    // With a margin some pairs that meet have no points, where they do without.
    best = find_axis(a, b, p->d[k], slack, slack, &face);
    collide(a, b, p->d[k], best, face, 0.0f, slack, m);
}

static inline void put_vector(float4 v, __global uint *to)
{
    to[0] = as_uint(v.x);
    to[1] = as_uint(v.y);
    to[2] = as_uint(v.z);
}

// flipped: anchors are from b's centre, and the normal points to a.
static inline void put_contact(manifold *m, float4 d, bool flipped, __global uint *row)
{
    put_vector(m->n == 0 ? (float4)(0.0f) : flipped ? -m->normal : m->normal, row + AT_NORMAL);
    row[AT_POINTS] = (uint)m->n;
    for (int k = 0; k < 4; ++k) {
        __global uint *point = row + AT_POINT + k * POINT_WORDS;
        float4 at = k < m->n ? m->point[k] : (float4)(0.0f);
        put_vector(k < m->n && flipped ? at - d : at, point);
        point[3] = as_uint(at.w);
        point[4] = 0;
    }
}

// Loads the boxes of LANES pairs, the one of the lower id first; bad: one of the two is no box.
static inline void load_pairs(__global const float *objects, const uint2 ids[LANES], float margin, pairs_at *p,
                              uint bad[LANES], best_axis bests[LANES], best_axis faces[LANES])
{
    uint firsts[LANES], seconds[LANES];
    for (uint k = 0; k < LANES; ++k) {
        firsts[k] = min(ids[k].x, ids[k].y);
        seconds[k] = max(ids[k].x, ids[k].y);
    }
    object one = object_at(objects, firsts), other = object_at(objects, seconds);
    spread(as_word(object_is_bad(&one) | object_is_bad(&other)), bad);
    real axis_a[3][3], axis_b[3][3], d[3];
    float offsets[3][LANES];
    set_axes(axis_a, one.rotation);
    set_axes(axis_b, other.rotation);
    for (int k = 0; k < 3; ++k) {
        d[k] = other.centre[k] - one.centre[k];
        put_lanes(d[k], offsets[k]);
    }
    for (uint k = 0; k < LANES; ++k)
        p->d[k] = (float4)(offsets[0][k], offsets[1][k], offsets[2][k], 0.0f);
    real slack = slack_of(&one, &other, d), most = margin + slack;
#if ROUNDED
    most += one.radius + other.radius;
#endif
    set_solids(p->a, axis_a, &one);
    set_solids(p->b, axis_b, &other);
    put_lanes(slack, p->slack);
    put_lanes(most, p->most);
#if LANES == 8 && DIMS == 3
    solid_lanes a = lanes_of(&one, axis_a), b = lanes_of(&other, axis_b);
    best_lanes face, best = find_axes(&a, &b, (vec_lanes){d[0], d[1], d[2]}, lead_of(margin) + slack, most, &face);
    put_lanes_of_best(&best, bests);
    put_lanes_of_best(&face, faces);
#else
    for (uint k = 0; k < LANES; ++k)
        bests[k] = find_axis(&p->a[k], &p->b[k], p->d[k], lead_of(margin) + p->slack[k], p->most[k], &faces[k]);
#endif
}

// Finds the contacts of pairs from `from` on, LANES of them or as many as there are up to n.
static inline void collide_lanes(__global const float *objects, __global const uint *pairs, uint from, uint n,
                                 float margin, __global uint *contacts)
{
    uint2 ids[LANES];
    uint bad[LANES];
    pairs_at p;
    best_axis bests[LANES], faces[LANES];
    for (uint k = 0; k < LANES; ++k)
        ids[k] = vload2(min(from + k, n - 1), pairs);
    load_pairs(objects, ids, margin, &p, bad, bests, faces);
    for (uint k = 0; k < LANES && from + k < n; ++k) {
        __global uint *row = contacts + (size_t)(from + k) * WORDS;
        manifold m;
        m.n = 0;
        if (!bad[k])
            find_points(&p, k, bests[k], faces[k], margin, &m);
        row[0] = ids[k].x;
        row[1] = ids[k].y;
        put_contact(&m, p.d[k], ids[k].x > ids[k].y, row);
        if (bad[k])
            row[AT_POINTS] = NO_BOX;
    }
}

__kernel void contact_query(CONTACT_QUERY_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint i = first; i < last; i += LANES)
        collide_lanes(objects, pairs, i, last, margin, contacts);
}
