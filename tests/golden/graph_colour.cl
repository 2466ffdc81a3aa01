#ifndef GPU
// graph_colour.DIMS2.DOUBLE0.ANGULAR_VELOCITY0.FRICTION0.SENSORS0.WG1.PER_ITEM1024
#define DIMS 2
#else /* GPU */
// graph_colour.DIMS3.DOUBLE0.ANGULAR_VELOCITY0.FRICTION0.SENSORS0.WG64.PER_ITEM1
#define DIMS 3
#endif /* GPU */
#define DOUBLE 0
#define ANGULAR_VELOCITY 0
#define FRICTION 0
#define CONTACT_RESPONSE 1
#define SENSORS 0
#ifndef GPU
#define WG 1
#define PER_ITEM 1024
#else /* GPU */
#define WG 64
#define PER_ITEM 1
#endif /* GPU */
#define GRAPH_COLOUR_CHOOSE_ARGS \
    __global const uint2 *restrict links, \
    __global const uint *restrict colours, \
    __global const uint *restrict starts, \
    __global const uint *restrict return_starts, \
    __global const uint *restrict returns, \
    uint n, \
    __global uint *restrict used, \
    __global uint *restrict choices
#define GRAPH_COLOUR_KEY_ARGS \
    __global const uint *restrict colours, \
    __global const uint *restrict touches, \
    uint n_contacts, \
    __global uint *restrict keys
#define GRAPH_COLOUR_MARK_ARGS \
    __global const uint2 *restrict links, \
    __global const uint *restrict touches, \
    uint n_contacts, \
    uint n, \
    __global const float4 *restrict bodies, \
    __global uint *restrict colours, \
    volatile __global uint *restrict choices, \
    volatile __global uint *restrict flags
#define GRAPH_COLOUR_TAKE_ARGS \
    __global const uint2 *restrict links, \
    uint n, \
    __global const float4 *restrict velocities, \
    __global const uint *restrict used, \
    __global const uint *restrict choices, \
    uint round, \
    __global uint *restrict colours, \
    volatile __global uint *restrict flags
#line 1 "kernels/common.clh"
#line 1 "kernels/dynamics/motion.clh"
#line 1 "kernels/dynamics/records.h"
#line 1 "kernels/dynamics/contact.clh"
#line 1 "kernels/dynamics/graph_colour.cl.in"
// as in the template: 32
#line 36 "kernels/dynamics/graph_colour.cl.in"
// as in the template: 88
