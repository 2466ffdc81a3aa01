#ifndef GPU
// contact_events.DIMS2.DOUBLE0.ANGULAR_VELOCITY0.CONTACT_RESPONSE0.FRICTION0.HITS0.WG1.PER_ITEM16
#define DIMS 2
#else /* GPU */
// contact_events.DIMS3.DOUBLE0.ANGULAR_VELOCITY0.CONTACT_RESPONSE0.FRICTION0.HITS0.WG64.PER_ITEM1
#define DIMS 3
#endif /* GPU */
#define DOUBLE 0
#define ORIGIN 0
#define ANGULAR_VELOCITY 0
#define CONTACT_RESPONSE 0
#define FRICTION 0
#define HITS 0
#ifndef GPU
#define WG 1
#define PER_ITEM 16
#else /* GPU */
#define WG 64
#define PER_ITEM 1
#endif /* GPU */
#define CONTACT_EVENTS_ARGS \
    __global const uint *restrict touches, \
    __global const float *restrict contacts, \
    uint n_contacts, \
    __global uint *restrict touching
#line 1 "kernels/common.clh"
#line 1 "kernels/dynamics/motion.clh"
#line 1 "kernels/dynamics/records.h"
#line 1 "kernels/dynamics/contact.clh"
#line 1 "kernels/dynamics/contact_events.cl.in"
// as in the template: 8
#line 73 "kernels/dynamics/contact_events.cl.in"
// as in the template: 7
#line 83 "kernels/dynamics/contact_events.cl.in"
// as in the template: 9
#line 99 "kernels/dynamics/contact_events.cl.in"
// as in the template: 8
#line 131 "kernels/dynamics/contact_events.cl.in"
// as in the template: 4
