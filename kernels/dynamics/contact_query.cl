// SPDX-License-Identifier: MIT
// Where pairs of boxes touch that the caller brings, as the contacts of bodies are found.
//
// Which of a pair's boxes comes first decides between axes that are equally good, so the
// one with the lower id does, and (a, b) and (b, a) have the same points.
//
//   poses    [objects][10]
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

static inline solid solid_of(const object *o)
{
    float axis[3][3];
    set_axes(axis, o->rotation);
    solid s;
    for (int k = 0; k < 3; ++k) {
        s.axis[k] = (float4)(axis[k][0], axis[k][1], axis[k][2], 0.0f);
        s.halves[k] = o->halves[k];
    }
    return s;
}

static inline float slack_of(const object *a, const object *b, float4 d)
{
    float size = fabs(d.x) + fabs(d.y) + fabs(d.z);
    for (int k = 0; k < 3; ++k)
        size += a->halves[k] + b->halves[k];
    return SLACK * size;
}

// The corner of `other` that is deepest behind face k of `own`, brought onto that face.
static inline void touch_corner(const solid *own, const solid *other, float4 d, int k, float separation, manifold *m)
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
static inline void touch_nearest(const solid *a, const solid *b, float4 d, best_axis face, manifold *m)
{
    if (face.b < 0) {
        touch_corner(a, b, d, face.a, face.separation, m);
        return;
    }
    touch_corner(b, a, -d, face.b, face.separation, m);
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

// Points from a's centre, up to the margin. False where there are none: the boxes are
// further apart, or faces are beside each other.
static inline bool touch(const solid *a, const solid *b, float4 d, float margin, float slack, manifold *m)
{
    float lead = lead_of(margin) + slack;
    best_axis face;
    best_axis best = find_axis(a, b, d, lead, margin + slack, &face);
    m->n = 0;
    if (best.separation > margin + slack)
        return false;
    touch_along(a, b, d, best, face, lead, margin + slack, m);
#if DIMS == 3
    bool edges = best.a >= 0 && best.b >= 0;
    if (edges && m->n == 1 && !edges_cross(a, b, d, m, slack)) {
        m->n = 0;
        if (best.separation > slack)
            return false;
        best = face; // a better axis is left out, for its edges are nearly parallel
        touch_faces(a, b, d, best, lead, margin + slack, m);
    }
#endif
    if (m->n == 0 && margin == 0.0f)
        touch_nearest(a, b, d, best, m);
    return m->n > 0;
}

// With a margin some pairs that meet have no points, where they do without.
static inline void find_points(const object *a, const object *b, float4 d, float margin, manifold *m)
{
    solid one = solid_of(a), other = solid_of(b);
    float slack = slack_of(a, b, d);
    if (!touch(&one, &other, d, margin, slack, m) && margin > 0.0f)
        touch(&one, &other, d, 0.0f, slack, m);
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

static inline void look_at(__global const float *poses, uint a, uint b, float margin, __global uint *row)
{
    uint first[1] = {min(a, b)}, second[1] = {max(a, b)};
    object one = object_at(poses, first), other = object_at(poses, second);
    float4 d = (float4)(other.centre[0] - one.centre[0], other.centre[1] - one.centre[1],
                        other.centre[2] - one.centre[2], 0.0f);
    manifold m;
    bool bad = object_is_bad(&one) || object_is_bad(&other);
    m.n = 0;
    if (!bad)
        find_points(&one, &other, d, margin, &m);
    put_contact(&m, d, a > b, row);
    if (bad)
        row[AT_POINTS] = NO_BOX;
}

__kernel void contact_query(CONTACT_QUERY_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint i = first; i < last; ++i) {
        uint a = pairs[2 * (size_t)i], b = pairs[2 * (size_t)i + 1];
        __global uint *row = contacts + (size_t)i * WORDS;
        row[0] = a;
        row[1] = b;
        look_at(poses, a, b, margin, row);
    }
}
