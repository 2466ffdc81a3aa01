// build_manifolds.DIMS3.DOUBLE0.ROTATED0.ANGULAR_VELOCITY0.BOUNDARY0.CONTACT_RESPONSE0.FRICTION0.CONTINUOUS0.SLEEP0.LANES1.WG64.PER_ITEM4
#define DIMS 3
#define DOUBLE 0
#define ORIGIN 0
#define ROTATED 0
#define ANGULAR_VELOCITY 0
#define BOUNDARY 0
#define CONTACT_RESPONSE 0
#define FRICTION 0
#define CONTINUOUS 0
#define SLEEP 0
#define LANES 1
#define WG 64
#define PER_ITEM 4
#define BUILD_MANIFOLDS_ARGS \
    __global const uint2 *restrict links, \
    uint n_contacts, \
    uint n, \
    __global const float4 *restrict centres, \
    __global const float4 *restrict halves, \
    float margin, \
    __global uint *restrict touches, \
    __global float *restrict contacts
#line 1 "kernels/common.clh"
#line 1 "kernels/dynamics/motion.clh"
#line 1 "kernels/dynamics/records.h"
#line 1 "kernels/dynamics/contact.clh"
#line 1 "kernels/dynamics/box_contact.clh"
#line 1 "kernels/dynamics/box_lanes.clh"
#line 1 "kernels/dynamics/build_manifolds.cl.in"
// SPDX-License-Identifier: MIT
// The manifold of each pair that may touch: the narrow phase of a moving world.
//
// A new point takes over the impulses of the nearest point of the last step.
//
//   links    [n] owner and other; objects + k: wall k
//   contacts [n] records (contact.clh)
//   touches  [n] words
//   bodies   [objects + 6][BODY]
#line 15 "kernels/dynamics/build_manifolds.cl.in"

static inline solid solid_at(float4 extents)
{
    solid s;
    s.axis[0] = (float4)(1, 0, 0, 0);
    s.axis[1] = (float4)(0, 1, 0, 0);
    s.axis[2] = (float4)(0, 0, 1, 0);
#line 32 "kernels/dynamics/build_manifolds.cl.in"
    s.halves[0] = extents.x;
    s.halves[1] = extents.y;
    s.halves[2] = extents.z;
#line 38 "kernels/dynamics/build_manifolds.cl.in"
    return s;
}
#line 359 "kernels/dynamics/build_manifolds.cl.in"

static inline void keep_deepest(manifold *m)
{
    int deepest = 0;
    for (int i = 1; i < m->n; ++i)
        if (m->point[i].w < m->point[deepest].w)
            deepest = i;
    m->point[0] = m->point[deepest];
    m->n = m->n > 0 ? 1 : 0;
}

// What a work-item reads and writes.
typedef struct {
    __global const uint2 *links;
    uint objects;
    __global const real4 *centres;
#line 378 "kernels/dynamics/build_manifolds.cl.in"
    __global const float4 *halves;
#line 396 "kernels/dynamics/build_manifolds.cl.in"
    float margin;
    __global uint *touches;
    __global float *contacts;
} scene;

static inline solid solid_of(const scene *s, uint id)
{
#line 406 "kernels/dynamics/build_manifolds.cl.in"
    return solid_at(s->halves[id]);
#line 408 "kernels/dynamics/build_manifolds.cl.in"
}

static inline float4 way_of(const scene *s, uint2 link)
{
#line 415 "kernels/dynamics/build_manifolds.cl.in"
    float4 d = convert_float4(s->centres[link.y] - s->centres[link.x]);
#line 417 "kernels/dynamics/build_manifolds.cl.in"
    d.w = 0.0f;
    return d;
}
#line 619 "kernels/dynamics/build_manifolds.cl.in"

// Writes the points into the record; extents: the owner's half extents.
static inline void keep_points(const scene *s, uint i, uint2 link, float4 extents, float4 d, float at, float speed, manifold *m)
{
    __global float *record = s->contacts + (size_t)i * RECORD;
#line 637 "kernels/dynamics/build_manifolds.cl.in"
    put_float4(record + AT_NORMAL, m->normal);
#line 642 "kernels/dynamics/build_manifolds.cl.in"
    for (int k = 0; k < m->n; ++k) {
        __global float *saved = record + HEAD + k * POINT_FLOATS;
        float4 anchor = m->point[k];
        put_float4(saved + OF_ANCHOR, anchor);
#line 649 "kernels/dynamics/build_manifolds.cl.in"
        saved[OF_SEPARATION] = fma(-at, speed, anchor.w);
#line 661 "kernels/dynamics/build_manifolds.cl.in"
    }
}

#line 728 "kernels/dynamics/build_manifolds.cl.in"

// axis: what separates those without points. The manifold is where they are after a time
// `at`, at this speed along its normal.
static inline void keep(const scene *s, uint i, float4 extents, float4 d, float at, float speed, manifold *m,
                        uint axis)
{
    uint2 link = s->links[i];
    if (m->n > 0)
        keep_points(s, i, link, extents, d, at, speed, m);
#line 741 "kernels/dynamics/build_manifolds.cl.in"
    s->touches[i] = (uint)m->n | (m->n > 0 ? m->axis : axis) << TOUCH_AXIS;
#line 745 "kernels/dynamics/build_manifolds.cl.in"
}
#line 783 "kernels/dynamics/build_manifolds.cl.in"

static inline void look_at_pair(const scene *s, uint i, uint2 link)
{
    solid a = solid_of(s, link.x), b = solid_of(s, link.y);
    float4 d = way_of(s, link);
    uint axis = s->touches[i] >> TOUCH_AXIS;
#line 790 "kernels/dynamics/build_manifolds.cl.in"
    float at = 0.0f, speed = 0.0f;
    manifold m;
    touch_boxes(&a, &b, d, s->margin, &m, &axis);
    keep(s, i, s->halves[link.x], d, at, speed, &m, axis);
#line 813 "kernels/dynamics/build_manifolds.cl.in"
}
#line 870 "kernels/dynamics/build_manifolds.cl.in"

#line 872 "kernels/dynamics/build_manifolds.cl.in"

static inline void look_at_one(const scene *s, uint i)
{
    uint2 link = s->links[i];
#line 886 "kernels/dynamics/build_manifolds.cl.in"
    look_at_pair(s, i, link);
}

// Of a group's pairs, by its work-items together: those that had points a step ago lie first in
// `places`, and those that had none, which are soon seen to be apart, last, so that work-items
// side by side have as much to do. The barriers around it are the kernel's: the compiler of
// PoCL 3.1 fails on some where a function has them.
static inline void divide_group(const scene *s, uint n_contacts, __local uint *places,
                                volatile __local uint *n_places)
{
    const uint most = WG * PER_ITEM;
    uint first = get_group_id(0) * most;
    for (uint k = first + get_local_id(0); k < min(first + most, n_contacts); k += WG) {
#line 903 "kernels/dynamics/build_manifolds.cl.in"
        if (s->touches[k] & TOUCH_POINTS)
            places[atomic_inc(n_places)] = k;
        else
            places[most - 1 - atomic_inc(n_places + 1)] = k;
    }
}
#line 910 "kernels/dynamics/build_manifolds.cl.in"

#line 912 "kernels/dynamics/build_manifolds.cl.in"
__kernel __attribute__((reqd_work_group_size(WG, 1, 1))) void build_manifolds(BUILD_MANIFOLDS_ARGS)
#line 916 "kernels/dynamics/build_manifolds.cl.in"
{
    scene s = {links, n, centres,
#line 921 "kernels/dynamics/build_manifolds.cl.in"
               halves,
#line 937 "kernels/dynamics/build_manifolds.cl.in"
               margin, touches, contacts};
#line 943 "kernels/dynamics/build_manifolds.cl.in"
    __local uint places[WG * PER_ITEM];
    __local uint n_places[2];
    if (get_local_id(0) < 2)
        n_places[get_local_id(0)] = 0;
    barrier(CLK_LOCAL_MEM_FENCE);
    divide_group(&s, n_contacts, places, n_places);
    barrier(CLK_LOCAL_MEM_FENCE);
    uint touched = n_places[0], all = touched + n_places[1];
    for (uint k = get_local_id(0); k < all; k += WG)
        look_at_one(&s, places[k < touched ? k : WG * PER_ITEM - 1 - (k - touched)]);
#line 998 "kernels/dynamics/build_manifolds.cl.in"
}
