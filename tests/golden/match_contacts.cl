#ifndef GPU
// match_contacts.DIMS2.ANGULAR_VELOCITY0.CONTACT_RESPONSE0.FRICTION0.SLEEP0.WG1.PER_ITEM1024
#define DIMS 2
#else /* GPU */
// match_contacts.DIMS3.ANGULAR_VELOCITY0.CONTACT_RESPONSE0.FRICTION0.SLEEP0.WG64.PER_ITEM1
#define DIMS 3
#endif /* GPU */
#define ANGULAR_VELOCITY 0
#define CONTACT_RESPONSE 0
#define FRICTION 0
#define SLEEP 0
#ifndef GPU
#define WG 1
#define PER_ITEM 1024
#else /* GPU */
#define WG 64
#define PER_ITEM 1
#endif /* GPU */
#define MATCH_CONTACTS_ARGS \
    __global const uint2 *restrict old_links, \
    __global const uint *restrict old_touches, \
    __global const float *restrict old_contacts, \
    uint n_old, \
    __global const uint *restrict starts, \
    __global const uint *restrict others, \
    __global uint *restrict touches, \
    __global float *restrict contacts
#line 1 "kernels/common.clh"
#line 1 "kernels/dynamics/records.h"
#line 1 "kernels/dynamics/contact.clh"
#line 1 "kernels/dynamics/match_contacts.cl.in"
// as in the template: 60
#line 64 "kernels/dynamics/match_contacts.cl.in"
// as in the template: 1
#line 70 "kernels/dynamics/match_contacts.cl.in"
// as in the template: 2
