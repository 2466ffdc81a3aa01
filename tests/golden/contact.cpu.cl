// contact.DIMS2.DOUBLE0.ROTATED0.SPIN0.BOUNDS0.RESPONSE0.FRICTION0.FAST0.SLEEP0.EVENTS0.WG1.PER_ITEM256
#define DIMS 2
#define DOUBLE 0
#define ORIGIN 0
#define ROTATED 0
#define SPIN 0
#define BOUNDS 0
#define RESPONSE 0
#define FRICTION 0
#define FAST 0
#define SLEEP 0
#define EVENTS 0
#define WG 1
#define PER_ITEM 256
#line 1 "kernels/common.clh"
#line 1 "kernels/motion.clh"
#line 1 "kernels/flags.clh"
#line 1 "kernels/contact.clh"
#line 1 "kernels/box_contact.clh"
#line 1 "kernels/contact.cl.in"
// SPDX-License-Identifier: MIT
// The manifold of each pair that may touch, ready to be solved.
//
// What the last step pushed with at a point is taken over by the new point
// nearest to it.
//
//   links    [n] owner and other; objects + k: wall k
//   contacts [n] records (contact.clh)
//   touches  [n] words
//   bodies   [objects + 6][BODY]
#line 12 "kernels/contact.cl.in"

static inline solid solid_at(float4 extents)
{
    solid s;
    s.axis[0] = (float4)(1, 0, 0, 0);
    s.axis[1] = (float4)(0, 1, 0, 0);
    s.axis[2] = (float4)(0, 0, 1, 0);
#line 29 "kernels/contact.cl.in"
    s.halves[0] = extents.x;
    s.halves[1] = extents.y;
    s.halves[2] = extents.z;
    return s;
}
#line 189 "kernels/contact.cl.in"

static inline void keep_deepest(manifold *m)
{
    int deepest = 0;
    for (int i = 1; i < m->n; ++i)
        if (m->point[i].w < m->point[deepest].w)
            deepest = i;
    m->point[0] = m->point[deepest];
    m->n = m->n > 0 ? 1 : 0;
}

__kernel void contact(__global const uint2 *restrict links, uint n, uint objects, __global const real4 *restrict centres,
#line 204 "kernels/contact.cl.in"
                      __global const float4 *restrict halves,
#line 223 "kernels/contact.cl.in"
                      float margin, __global uint *restrict touches, __global float *restrict contacts)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint i = first; i < last; ++i) {
        uint a = links[i].x, b = links[i].y;
        __global float *record = contacts + (size_t)i * RECORD;
#line 245 "kernels/contact.cl.in"
        solid solid_a = solid_at(halves[a]);
#line 247 "kernels/contact.cl.in"
        float4 d = (float4)(0.0f);
        manifold m;
        m.n = 0;
        uint axis = touches[i] >> TOUCH_AXIS;
#line 270 "kernels/contact.cl.in"
        {
#line 274 "kernels/contact.cl.in"
            solid solid_b = solid_at(halves[b]);
#line 279 "kernels/contact.cl.in"
            d = convert_float4(centres[b] - centres[a]);
#line 281 "kernels/contact.cl.in"
            d.w = 0.0f;
#line 283 "kernels/contact.cl.in"
            touch_boxes(&solid_a, &solid_b, d, margin, &m, &axis);
#line 298 "kernels/contact.cl.in"
        }
#line 309 "kernels/contact.cl.in"
        bool touching = false; // no gap, or pushed in the last step
#line 324 "kernels/contact.cl.in"
        put_float4(record + AT_NORMAL, m.normal);
        for (int k = 0; k < m.n; ++k) {
            __global float *part = record + HEAD + k * PART;
            float4 arm = m.point[k];
            put_float4(part + OF_ARM, arm);
            part[OF_GAP] = arm.w;
            touching = touching || arm.w <= 0.0f;
#line 342 "kernels/contact.cl.in"
        }
#line 351 "kernels/contact.cl.in"
        touches[i] = (uint)m.n | (touching ? TOUCH_MEETS : 0u) | axis << TOUCH_AXIS;
    }
}
