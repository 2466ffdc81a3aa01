#ifndef GPU
// prepare_contacts.DIMS2.ANGULAR_VELOCITY0.FRICTION0.LANES8.BLOCK8.WG1.PER_ITEM256
#define DIMS 2
#else /* GPU */
// prepare_contacts.DIMS3.ANGULAR_VELOCITY0.FRICTION0.LANES1.BLOCK32.WG128.PER_ITEM1
#define DIMS 3
#endif /* GPU */
#define ANGULAR_VELOCITY 0
#define FRICTION 0
#define CONTACT_RESPONSE 1
#ifndef GPU
#define LANES 8
#define BLOCK 8
#define WG 1
#define PER_ITEM 256
#else /* GPU */
#define LANES 1
#define BLOCK 32
#define WG 128
#define PER_ITEM 1
#endif /* GPU */
#define PREPARE_CONTACTS_ARGS \
    __global const uint2 *restrict links, \
    __global const uint *restrict touches, \
    __global const float *restrict contacts, \
    __global const float *restrict restitutions, \
    uint n, \
    __global const uint *restrict list, \
    __global const uint4 *restrict spans, \
    int4 span, \
    uint from_colour, \
    uint to_colour, \
    uint each, \
    __global float *restrict blocks, \
    __global float4 *restrict bodies
#define STORE_IMPULSES_ARGS \
    __global const uint *restrict list, \
    __global const uint4 *restrict spans, \
    int4 span, \
    uint from_colour, \
    uint to_colour, \
    uint each, \
    __global float *restrict blocks, \
    __global float *restrict contacts
#line 1 "kernels/common.clh"
#line 1 "kernels/lanes.clh"
#line 1 "kernels/dynamics/vector.clh"
#line 1 "kernels/dynamics/records.h"
#line 1 "kernels/dynamics/contact.clh"
#line 1 "kernels/dynamics/constraint.clh"
#line 1 "kernels/dynamics/prepare_contacts.cl.in"
// as in the template: 16
#line 20 "kernels/dynamics/prepare_contacts.cl.in"
// as in the template: 13
#line 36 "kernels/dynamics/prepare_contacts.cl.in"
// as in the template: 12
#line 52 "kernels/dynamics/prepare_contacts.cl.in"
// as in the template: 19
#line 94 "kernels/dynamics/prepare_contacts.cl.in"
// as in the template: 16
#line 116 "kernels/dynamics/prepare_contacts.cl.in"
// as in the template: 6
#line 125 "kernels/dynamics/prepare_contacts.cl.in"
// as in the template: 35
#line 163 "kernels/dynamics/prepare_contacts.cl.in"
// as in the template: 28
#line 195 "kernels/dynamics/prepare_contacts.cl.in"
// as in the template: 18
