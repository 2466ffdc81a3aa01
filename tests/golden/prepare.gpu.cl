// prepare.DIMS3.SPIN0.FRICTION0.LANES1.BLOCK32.WG64.PER_ITEM1
#define DIMS 3
#define SPIN 0
#define FRICTION 0
#define RESPONSE 1
#define LANES 1
#define BLOCK 32
#define WG 64
#define PER_ITEM 1
#line 1 "kernels/common.clh"
#line 1 "kernels/lanes.clh"
#line 1 "kernels/vector.clh"
#line 1 "kernels/contact.clh"
#line 1 "kernels/constraint.clh"
#line 1 "kernels/prepare.cl.in"
// SPDX-License-Identifier: MIT
// Contacts of a colour into blocks before they are solved, and what the next
// step begins with back out of them.
//
// What the last step pushed with becomes the bodies' first shoves: colour by
// colour, for none of a colour share an object that moves.
//
//   list    contacts by colour; this one's are list[first, first + count)
//   blocks  constraints (constraint.clh); the colour's begin at first_slot and are
//           `apart` slots from each other, `each` a work-item
typedef struct {
    __global const uint2 *links;
    __global const uint *touches;
    __global const float *contacts;
    __global const float *bounces;
#line 19 "kernels/prepare.cl.in"
    uint objects;
} source;

// One lane; `most` points are written, those that the contact lacks as 0.
static inline void fill_lane(__global float *lane, const source *from, uint i, int most)
{
    uint2 link = from->links[i];
    uint partner = link.y < from->objects ? link.y : link.x; // a wall has the properties of what touches it
    int n = (int)(from->touches[i] & TOUCH_POINTS);
    __global const float *record = from->contacts + (size_t)i * RECORD;
    lane[IN_OWNER * BLOCK] = as_float(link.x);
    lane[IN_OTHER * BLOCK] = as_float(link.y);
    lane[IN_POINTS * BLOCK] = as_float((uint)n);
    lane[IN_BOUNCE * BLOCK] = fmax(from->bounces[link.x], from->bounces[partner]);
#line 36 "kernels/prepare.cl.in"
    for (int j = 0; j < 3; ++j) {
        lane[(IN_NORMAL + j) * BLOCK] = record[AT_NORMAL + j];
        lane[(IN_APART + j) * BLOCK] = record[AT_APART + j];
    }
    for (int k = 0; k < most; ++k) {
        __global const float *part = record + HEAD + k * PART;
        __global float *point = point_at(lane, k);
        for (int j = 0; j < 3; ++j)
            point[(BY_ARM + j) * BLOCK] = k < n ? part[OF_ARM + j] : 0.0f;
        point[BY_GAP * BLOCK] = k < n ? part[OF_GAP] : 0.0f;
        point[BY_PUSH * BLOCK] = k < n ? part[OF_PUSH] : 0.0f;
#line 51 "kernels/prepare.cl.in"
    }
}

// A lane that no contact is left for: no points, between walls.
static inline void fill_empty(__global float *lane, uint wall, int most)
{
    for (int j = 0; j < FIELDS; ++j)
        lane[j * BLOCK] = 0.0f;
    lane[IN_OWNER * BLOCK] = lane[IN_OTHER * BLOCK] = as_float(wall);
    for (int j = 0; j < most * BY_FIELDS; ++j)
        lane[(FIELDS + j) * BLOCK] = 0.0f;
}

// The first n lanes are contacts.
static inline void fill_lanes(__global float *constraint, const source *from, __global const uint *list, uint n)
{
    int most = 0;
    for (uint k = 0; k < n; ++k)
        most = max(most, (int)(from->touches[list[k]] & TOUCH_POINTS));
    for (uint k = 0; k < n; ++k)
        fill_lane(constraint + k, from, list[k], most);
    for (uint k = n; k < LANES; ++k)
        fill_empty(constraint + k, from->objects, most);
}
#line 98 "kernels/prepare.cl.in"

static inline real mass_along(const pair *p, vec arm, vec direction, mask where)
{
    real yield = yield_along(&p->a, arm, direction) + yield_along(&p->b, vec_less(arm, p->apart), direction);
    return select((real)(0.0f), inverse(yield), where & (yield > 0.0f));
}

static inline void weigh(const pair *p, __global float *point, mask where)
{
    vec arm = get_vec(point, BY_ARM);
    put(point, BY_MASS, mass_along(p, arm, p->normal, where));
    put(point, BY_SPEED, vec_dot(velocity_between(p, arm), p->normal));
    put(point, BY_MOST, get(point, BY_PUSH));
    put(point, BY_IMPACT, 0.0f);
#line 118 "kernels/prepare.cl.in"
}

static inline void prepare_lanes(__global float *constraint, const source *from, __global const uint *list, uint n,
                                 __global float4 *bodies)
{
    fill_lanes(constraint, from, list, n);
#line 127 "kernels/prepare.cl.in"
    pair p;
    load_pair(&p, constraint, bodies);
    for (int k = 0; k < p.most; ++k)
        weigh(&p, point_at(constraint, k), has_point(&p, k));
    leave_shoves(&p, constraint, bodies);
}

__kernel void prepare(__global const uint2 *restrict links, __global const uint *restrict touches,
                      __global const float *restrict contacts, __global const float *restrict bounces,
#line 139 "kernels/prepare.cl.in"
                      uint objects, __global const uint *restrict list, uint first, uint count,
                      uint first_slot, uint each, uint apart, __global float *restrict blocks,
                      __global float4 *restrict bodies)
{
    source from = {links, touches, contacts, bounces,
#line 147 "kernels/prepare.cl.in"
                   objects};
    uint begin = get_global_id(0) * each;
    uint end = min(begin + each, count);
    for (uint k = begin; k < end; k += STRIDE(apart))
        prepare_lanes(constraint_at(blocks, first_slot + k * apart), &from, list + first + k,
                      min(end - k, (uint)STRIDE(apart)), bodies);
}

// Pushes of the last substep.
__kernel void store(__global const uint *restrict touches, __global const uint *restrict list, uint first, uint count,
                    uint first_slot, uint each, uint apart, __global float *restrict blocks,
                    __global float *restrict contacts)
{
    uint begin = get_global_id(0) * each;
    uint end = min(begin + each, count);
    for (uint k = begin; k < end; ++k) {
        uint i = list[first + k];
        __global float *constraint = constraint_at(blocks, first_slot + k * apart);
        for (int p = 0; p < (int)(touches[i] & TOUCH_POINTS); ++p) {
            __global const float *point = point_at(constraint, p);
            __global float *part = contacts + (size_t)i * RECORD + HEAD + p * PART;
            part[OF_PUSH] = point[BY_PUSH * BLOCK];
            part[OF_MOST] = point[BY_MOST * BLOCK];
#line 174 "kernels/prepare.cl.in"
        }
    }
}
