#ifndef GPU
// build_manifolds.DIMS2.DOUBLE0.ROTATED0.ANGULAR_VELOCITY0.BOUNDARY0.CONTACT_RESPONSE0.FRICTION0.CONTINUOUS0.SLEEP0.LANES8.WG1.PER_ITEM256
#define DIMS 2
#else /* GPU */
// build_manifolds.DIMS3.DOUBLE0.ROTATED0.ANGULAR_VELOCITY0.BOUNDARY0.CONTACT_RESPONSE0.FRICTION0.CONTINUOUS0.SLEEP0.LANES1.WG64.PER_ITEM4
#define DIMS 3
#endif /* GPU */
#define DOUBLE 0
#define ORIGIN 0
#define ROTATED 0
#define ANGULAR_VELOCITY 0
#define BOUNDARY 0
#define CONTACT_RESPONSE 0
#define FRICTION 0
#define CONTINUOUS 0
#define SLEEP 0
#ifndef GPU
#define LANES 8
#define WG 1
#define PER_ITEM 256
#else /* GPU */
#define LANES 1
#define WG 64
#define PER_ITEM 4
#endif /* GPU */
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
// as in the template: 9
#line 15 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 7
#line 32 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 3
#line 38 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 2
#line 359 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 16
#line 378 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 1
#line 396 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 7
#line 406 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 1
#line 408 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 4
#line 415 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 1
#line 417 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 3
#line 619 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 2
static inline void keep_points(const scene *s, uint i, uint2 link, float4 extents, float4 d, float at, float speed, manifold *m)
// as in the template: 2
#line 637 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 1
#line 642 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 4
#line 649 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 1
#line 661 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 3
#line 728 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 3
static inline void keep(const scene *s, uint i, float4 extents, float4 d, float at, float speed, manifold *m,
// as in the template: 4
        keep_points(s, i, link, extents, d, at, speed, m);
#line 741 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 1
#line 745 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 1
#line 783 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 6
#line 790 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 2
    touch_boxes(&a, &b, d, s->margin, &m, &axis);
// as in the template: 1
#line 813 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 1
#line 870 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 1
#ifdef GPU
#line 872 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 4
#line 886 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 13
#line 903 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 6
#endif /* GPU */
#line 910 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 1
#ifndef GPU
#line 914 "kernels/dynamics/build_manifolds.cl.in"
#else /* GPU */
#line 912 "kernels/dynamics/build_manifolds.cl.in"
#endif /* GPU */
// as in the template: 1
#line 916 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 2
#line 921 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 1
#line 937 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 1
#ifndef GPU
#line 954 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 2
#line 960 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 2
#line 977 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 1
#line 987 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 1
#else /* GPU */
#line 943 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 10
#endif /* GPU */
#line 998 "kernels/dynamics/build_manifolds.cl.in"
// as in the template: 1
