// prepare_contacts.DIMS3.ANGULAR_VELOCITY0.FRICTION0.LANES1.BLOCK32.WG128.PER_ITEM1
#define DIMS 3
#define ANGULAR_VELOCITY 0
#define FRICTION 0
#define CONTACT_RESPONSE 1
#define LANES 1
#define BLOCK 32
#define WG 128
#define PER_ITEM 1
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
// SPDX-License-Identifier: MIT
// Gathers the contacts of a colour into blocks of constraints before they are solved,
// and scatters the impulses for the next step's warm start afterwards.
//
// Impulses of the last step are added up for each body, colour by colour, because no
// two contacts of a colour share a body that moves: the first substep's warm start.
//
//   spans   of each colour: first in the list, count, first slot
//   list    contacts by colour
//   blocks  constraints (constraint.clh)
//   each    contacts of a colour that a work-item takes
typedef struct {
    __global const uint2 *links;
    __global const uint *touches;
    __global const float *contacts;
    __global const float *restitutions;
#line 20 "kernels/dynamics/prepare_contacts.cl.in"
    uint objects;
} source;

// What a lane has one number of; lanes that no contact is left for have no
// points and are between walls.
static inline void fill_lane(__global float *lane, const source *from, uint i, bool empty)
{
    uint2 link = from->links[i];
    uint partner = link.y < from->objects ? link.y : link.x; // a wall has the properties of what touches it
    lane[IN_OWNER * BLOCK] = as_float(empty ? from->objects : link.x);
    lane[IN_OTHER * BLOCK] = as_float(empty ? from->objects : link.y);
    lane[IN_POINTS * BLOCK] = as_float(empty ? 0u : from->touches[i] & TOUCH_POINTS);
    lane[IN_RESTITUTION * BLOCK] = fmax(from->restitutions[link.x], from->restitutions[partner]);
#line 36 "kernels/dynamics/prepare_contacts.cl.in"
}

static inline void fill_point(__global float *point, const source *from, const uint places[LANES], int k, mask where)
{
    const real zero = 0.0f;
    real saved[8]; // or what follows it: there is one record more than contacts
    load_eight(from->contacts, places, RECORD, HEAD + k * POINT_FLOATS, saved);
    put_vec(point, BY_ANCHOR,
            (vec){select(zero, saved[OF_ANCHOR], where), select(zero, saved[OF_ANCHOR + 1], where),
                  select(zero, saved[OF_ANCHOR + 2], where)});
    put(point, BY_SEPARATION, select(zero, saved[OF_SEPARATION], where));
    put(point, BY_NORMAL_IMPULSE, select(zero, saved[OF_NORMAL_IMPULSE], where));
#line 52 "kernels/dynamics/prepare_contacts.cl.in"
}

// The first n lanes are contacts.
static inline void fill_lanes(__global float *constraint, const source *from, __global const uint *list, uint n)
{
    uint places[LANES];
    for (uint k = 0; k < LANES; ++k) {
        places[k] = list[k < n ? k : 0];
        fill_lane(constraint + k, from, places[k], k >= n);
    }
    real head[8];
    load_eight(from->contacts, places, RECORD, 0, head);
    put_vec(constraint, IN_NORMAL, (vec){head[AT_NORMAL], head[AT_NORMAL + 1], head[AT_NORMAL + 2]});
    put_vec(constraint, IN_OFFSET, (vec){head[AT_OFFSET], head[AT_OFFSET + 1], head[AT_OFFSET + 2]});
    word points = points_of(constraint);
    int most = most_points(points);
    for (int k = 0; k < most; ++k)
        fill_point(point_at(constraint, k), from, places, k, points > (word)(uint)k);
}
#line 94 "kernels/dynamics/prepare_contacts.cl.in"

static inline real mass_along(const pair *p, vec anchor, vec direction, mask where)
{
    real inverse_effective_mass = inverse_mass_along(&p->a, anchor, direction) + inverse_mass_along(&p->b, vec_less(anchor, p->apart), direction);
    return select((real)(0.0f), inverse(inverse_effective_mass), where & (inverse_effective_mass > 0.0f));
}

static inline void weigh(const pair *p, __global float *constraint, int k)
{
    __global float *point = point_at(constraint, k);
    mask where = has_point(p, k);
    vec anchor = get_vec(point, BY_ANCHOR);
    put(point, BY_NORMAL_MASS, mass_along(p, anchor, p->normal, where));
    put(point, BY_CURRENT, get(point, BY_SEPARATION));
    put(point, BY_MAX_IMPULSE, get(point, BY_NORMAL_IMPULSE));
    put(constraint, IN_SPEEDS + k, vec_dot(velocity_between(p, anchor), p->normal));
#line 116 "kernels/dynamics/prepare_contacts.cl.in"
}

static inline void prepare_lanes(__global float *constraint, const source *from, __global const uint *list, uint n,
                                 __global float4 *bodies)
{
    fill_lanes(constraint, from, list, n);
#line 125 "kernels/dynamics/prepare_contacts.cl.in"
    pair p;
    load_pair(&p, constraint, bodies);
    load_warm_impulses(&p, bodies);
    for (int k = 0; k < p.most; ++k)
        weigh(&p, constraint, k);
    points all = take_points(constraint, p.n);
    store_warm_impulses(&p, &all, bodies);
}

#if LANES > 1

// Records and bodies are read at random: those of the blocks that come next are
// asked for in time, the records first.
static inline void ask_for_records(const source *from, __global const uint *list)
{
    for (uint k = 0; k < LANES; ++k)
        for (uint at = 0; at < RECORD; at += 16)
            ask_for(from->contacts + (size_t)list[k] * RECORD + at);
}

static inline void ask_for_bodies(const source *from, __global const uint *list, __global const float4 *bodies)
{
    for (uint k = 0; k < LANES; ++k) {
        uint2 link = from->links[list[k]];
        ask_for(bodies + (size_t)link.x * BODY);
        ask_for(bodies + (size_t)link.x * BODY + BODY - 1);
        ask_for(bodies + (size_t)link.y * BODY);
        ask_for(bodies + (size_t)link.y * BODY + BODY - 1);
    }
}
#endif

__kernel void prepare_contacts(PREPARE_CONTACTS_ARGS)
{
    source from = {links, touches, contacts, restitutions,
#line 163 "kernels/dynamics/prepare_contacts.cl.in"
                   n};
    for (uint colour = from_colour; colour < to_colour; ++colour) {
        uint4 where = SPAN_OF(colour);
        uint first = where.x, apart = APART(colour);
        uint begin = get_global_id(0) * each;
        uint end = min(begin + each, where.y);
        for (uint k = begin; k < end; k += STRIDE(apart)) {
#if LANES > 1
            if (k + 3 * LANES <= end)
                ask_for_records(&from, list + first + k + 2 * LANES);
            if (k + 2 * LANES <= end)
                ask_for_bodies(&from, list + first + k + LANES, bodies);
#endif
            prepare_lanes(constraint_at(blocks, where.z + k * apart), &from, list + first + k,
                          min(end - k, (uint)STRIDE(apart)), bodies);
        }
        END_COLOUR;
    }
}

static inline void store_contact(__global float *constraint, __global float *record)
{
    uint n = as_uint(constraint[IN_POINTS * BLOCK]);
    for (uint p = 0; p < n; ++p) {
        __global const float *point = point_at(constraint, p);
        __global float *saved = record + HEAD + p * POINT_FLOATS;
        saved[OF_NORMAL_IMPULSE] = point[BY_NORMAL_IMPULSE * BLOCK];
        saved[OF_MAX_IMPULSE] = point[BY_MAX_IMPULSE * BLOCK];
#line 195 "kernels/dynamics/prepare_contacts.cl.in"
    }
}

// Pushes of the last substep. A work-item takes its contacts of every colour.
__kernel void store_impulses(STORE_IMPULSES_ARGS)
{
    for (uint colour = from_colour; colour < to_colour; ++colour) {
        uint4 where = SPAN_OF(colour);
        uint first = where.x;
        uint begin = get_global_id(0) * each;
        uint end = min(begin + each, where.y);
        for (uint k = begin; k < end; ++k) {
            ask_for(contacts + (size_t)list[first + min(k + 8, end - 1)] * RECORD + HEAD);
            store_contact(constraint_at(blocks, where.z + k * APART(colour)),
                          contacts + (size_t)list[first + k] * RECORD);
        }
    }
}
