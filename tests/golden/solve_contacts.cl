#ifndef GPU
// solve_contacts.DIMS2.ANGULAR_VELOCITY0.FRICTION0.LANES8.BLOCK8.WG1.PER_ITEM256
#define DIMS 2
#else /* GPU */
// solve_contacts.DIMS3.ANGULAR_VELOCITY0.FRICTION0.LANES1.BLOCK32.WG128.PER_ITEM1
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
#define APPLY_RESTITUTION_ARGS \
    __global const uint4 *restrict spans, \
    int4 span, \
    uint from_colour, \
    uint to_colour, \
    uint each, \
    __global float *restrict blocks, \
    __global float4 *restrict bodies, \
    float4 fall, \
    float least_speed
#define SOLVE_CONTACTS_ARGS \
    __global const uint4 *restrict spans, \
    int4 span, \
    uint from_colour, \
    uint to_colour, \
    uint each, \
    __global float *restrict blocks, \
    __global float4 *restrict bodies, \
    uint soft, \
    float per_h, \
    float4 spring, \
    float4 hard_spring, \
    float load_speed
#line 1 "kernels/common.clh"
#line 1 "kernels/lanes.clh"
#line 1 "kernels/dynamics/vector.clh"
#line 1 "kernels/dynamics/records.h"
#line 1 "kernels/dynamics/contact.clh"
#line 1 "kernels/dynamics/constraint.clh"
#line 1 "kernels/dynamics/solve_contacts.cl.in"
// as in the template: 1
#line 8 "kernels/dynamics/solve_contacts.cl.in"
// as in the template: 27
#line 96 "kernels/dynamics/solve_contacts.cl.in"
// as in the template: 1
static inline real find_separation(const pair *p, point one, vec anchor)
// as in the template: 1
    vec way = vec_less(way_of(&p->b, vec_less(anchor, p->apart)), way_of(&p->a, anchor));
// as in the template: 6
                               float4 hard_spring, float load_speed)
// as in the template: 8
    real separation = soft ? get_of(one, BY_CURRENT) : find_separation(p, one, anchor);
// as in the template: 31
#line 207 "kernels/dynamics/solve_contacts.cl.in"
// as in the template: 9
#line 223 "kernels/dynamics/solve_contacts.cl.in"
// as in the template: 10
#line 241 "kernels/dynamics/solve_contacts.cl.in"
// as in the template: 4
#line 252 "kernels/dynamics/solve_contacts.cl.in"
// as in the template: 3
        demands[k] = demand_of(&p, point_of(&all, k), soft, per_h, spring, hard_spring, load_speed);
// as in the template: 4
#line 265 "kernels/dynamics/solve_contacts.cl.in"
// as in the template: 2
#line 273 "kernels/dynamics/solve_contacts.cl.in"
// as in the template: 3
#line 279 "kernels/dynamics/solve_contacts.cl.in"
// as in the template: 1
#line 281 "kernels/dynamics/solve_contacts.cl.in"
// as in the template: 126
#line 414 "kernels/dynamics/solve_contacts.cl.in"
// as in the template: 10
#line 427 "kernels/dynamics/solve_contacts.cl.in"
// as in the template: 20
