#ifndef GPU
// contact_graph.DIMS2.DOUBLE0.BOUNDARY0.CONTACT_RESPONSE0.FILTER0.SENSORS0.WG1.PER_ITEM1024
#define DIMS 2
#else /* GPU */
// contact_graph.DIMS3.DOUBLE0.BOUNDARY0.CONTACT_RESPONSE0.FILTER0.SENSORS0.WG64.PER_ITEM1
#define DIMS 3
#endif /* GPU */
#define DOUBLE 0
#define BOUNDARY 0
#define CONTACT_RESPONSE 0
#define FILTER 0
#define SENSORS 0
#ifndef GPU
#define WG 1
#define PER_ITEM 1024
#else /* GPU */
#define WG 64
#define PER_ITEM 1
#endif /* GPU */
#define CONTACT_GRAPH_PAIRS_ARGS \
    __global const uint2 *restrict pairs, \
    uint n_pairs, \
    __global const float4 *restrict velocities, \
    uint fill, \
    volatile __global uint *restrict starts, \
    __global uint *restrict others
#define CONTACT_GRAPH_REVERSE_ARGS \
    __global const uint *restrict starts, \
    __global const uint *restrict others, \
    uint n, \
    __global const float4 *restrict velocities, \
    uint fill, \
    __global uint2 *restrict links, \
    __global uint *restrict touches, \
    volatile __global uint *restrict return_starts, \
    __global uint *restrict returns
#define CONTACT_GRAPH_SORT_ARGS \
    __global const uint *restrict row_starts, \
    uint n, \
    __global uint *restrict row_values
#define CONTACT_GRAPH_WALLS_ARGS \
    __global const float *restrict boxes, \
    __global const float4 *restrict velocities, \
    float4 lower, \
    float4 upper, \
    uint n, \
    uint fill, \
    volatile __global uint *restrict starts, \
    __global uint *restrict others
#line 1 "kernels/common.clh"
#line 1 "kernels/dynamics/motion.clh"
#line 1 "kernels/dynamics/records.h"
#line 1 "kernels/dynamics/contact_graph.cl.in"
// as in the template: 27
#line 37 "kernels/dynamics/contact_graph.cl.in"
// as in the template: 5
#line 48 "kernels/dynamics/contact_graph.cl.in"
// as in the template: 2
#line 74 "kernels/dynamics/contact_graph.cl.in"
// as in the template: 61
#line 138 "kernels/dynamics/contact_graph.cl.in"
// as in the template: 6
