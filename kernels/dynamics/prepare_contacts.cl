// SPDX-License-Identifier: MIT
// Gathers the contacts of a colour into blocks of constraints before they are solved, and scatters
// the impulses for the next step's warm start afterwards.
//
//   contacts, in rows' order        blocks, by colour (constraint.clh)
//   record: head, points     ---->  prepare_contacts: fields, effective masses
//                            <----  store_impulses
//
// Impulses of the last step are added up for each body, colour by colour, because no two contacts of
// a colour share a body that moves: the first substep's warm start.
//
//   spans   of each colour: first in the list, count, first slot
//   list    contacts by colour
//   blocks  constraints
//   each    contacts of a colour that a work-item takes
#if DOUBLE
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#endif

typedef struct {
    ARG_FIELDS
} source;

#if CONVEYS
// The velocity of a surface against its body, along the world's axes; a wall has none.
static inline float4 surface_velocity_of(const source *from, uint id)
{
    if (id >= from->n)
        return (float4)(0.0f);
    float4 velocity = from->surface_velocities[id], q = convert_float4(from->rotations[id]);
    float4 axis = (float4)(q.xyz, 0.0f), t = 2.0f * cross_float(axis, velocity);
    return velocity + add_float(cross_float(axis, t), q.w, t);
}
#endif

#if MATERIALS
// Combines the numbers of both bodies by a rule. Below 0 it stands for the root of its amount.
static inline float combined(float rule, float given, float a, float b)
{
    if (rule == RULE_GIVEN)
        return given;
    if (rule == RULE_AVERAGE)
        return 0.5f * (a + b);
    if (rule == RULE_MIN)
        return fmin(a, b);
    if (rule == RULE_MAX)
        return fmax(a, b);
    return rule == RULE_PRODUCT ? a * b : -(a * b);
}

static inline void fill_materials(__global float *lane, const source *from, uint a, uint b)
{
    __global const float *row =
        from->material_rules + MATERIAL_ROW * (from->materials[a] * MATERIALS_MOST + from->materials[b]);
    lane[IN_RESTITUTION * BLOCK] = combined(row[RULE_RESTITUTION], row[GIVEN_RESTITUTION], from->restitutions[a],
                                            from->restitutions[b]);
#if FRICTION
    lane[IN_FRICTION * BLOCK] =
        combined(row[RULE_FRICTION], row[GIVEN_FRICTION], from->frictions[a], from->frictions[b]);
#endif
}
//@ if GROUND_MATERIAL == 1 then

static inline void fill_ground_material(__global float *lane, const source *from, uint a)
{
    float4 ground = from->ground_surface; // friction, restitution, material
    __global const float *row =
        from->material_rules + MATERIAL_ROW * (from->materials[a] * MATERIALS_MOST + (uint)ground.z);
    lane[IN_RESTITUTION * BLOCK] =
        combined(row[RULE_RESTITUTION], row[GIVEN_RESTITUTION], from->restitutions[a], ground.y);
#if FRICTION
    lane[IN_FRICTION * BLOCK] = combined(row[RULE_FRICTION], row[GIVEN_FRICTION], from->frictions[a], ground.x);
#endif
}
//@ end
#endif

// Fills what a lane has one number of; lanes that no contact is left for have no points and are
// between walls.
static inline void fill_lane(__global float *lane, const source *from, uint i, bool empty)
{
    uint2 link = from->links[i];
    uint partner = link.y < from->n ? link.y : link.x; // a wall has the properties of what touches it
    lane[IN_OWNER * BLOCK] = as_float(empty ? from->n : link.x);
//@ if CARRIED == 1 then
    lane[IN_OTHER * BLOCK] = as_float(empty ? from->n : link.y >= from->n + AT_GROUND ? from->carrier : link.y);
//@ else
    lane[IN_OTHER * BLOCK] = as_float(empty ? from->n : link.y);
//@ end
    lane[IN_POINTS * BLOCK] = as_float(empty ? 0u : from->touches[i] & TOUCH_POINTS);
#if MATERIALS
    fill_materials(lane, from, link.x, partner);
//@ if GROUND_MATERIAL == 1 then
    if (link.y >= from->n + AT_GROUND)
        fill_ground_material(lane, from, link.x);
//@ end
#else
    lane[IN_RESTITUTION * BLOCK] = fmax(from->restitutions[link.x], from->restitutions[partner]);
    if (FRICTION)
        lane[IN_FRICTION * BLOCK] = from->frictions[link.x] * from->frictions[partner];
#endif
#if ROLLING
    lane[IN_ROLLING * BLOCK] = fmax(from->rolling_resistances[link.x], from->rolling_resistances[partner]) *
                               fmax(from->halves[link.x].w, from->halves[partner].w);
#endif
#if CONVEYS
    float4 belt = surface_velocity_of(from, link.y) - surface_velocity_of(from, link.x);
    lane[IN_BELT * BLOCK] = belt.x;
    lane[(IN_BELT + 1) * BLOCK] = belt.y;
    lane[(IN_BELT + 2) * BLOCK] = belt.z;
#endif
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
    for (int j = 0; FRICTION && j < DIMS - 1; ++j)
        put(point, BY_TANGENT_IMPULSE + j, select(zero, saved[OF_TANGENT_IMPULSE + j], where));
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
    if (ROLLING)
        put_vec(constraint, IN_ROLLING + 1, (vec){0.0f, 0.0f, 0.0f});
    word points = points_of(constraint);
    int most = most_points(points);
    for (int k = 0; k < most; ++k)
        fill_point(point_at(constraint, k), from, places, k, points > (word)(uint)k);
}

static inline vec tangent_of(vec normal)
{
    if (DIMS == 2)
        return (vec){normal.y, -normal.x, 0.0f};
    const real zero = 0.0f, one = 1.0f;
    mask x = fabs(normal.x) < 0.57f;
    mask y = !x & (fabs(normal.y) < 0.57f);
    vec other = {select(zero, one, x), select(zero, one, y), select(zero, one, !x & !y)};
    vec t = vec_cross(normal, other);
    return vec_times(inverse_root(vec_dot(t, t)), t);
}

// The root of a number above 0; else 0.
static inline real root_of(real x)
{
    return select((real)(0.0f), x * inverse_root(x), x > 0.0f);
}

// Takes the roots that combined() left.
static inline void take_root(__global float *constraint, uint field)
{
    real x = get(constraint, field);
    put(constraint, field, select(fabs(x), root_of(-x), x < 0.0f));
}

static inline void prepare_friction(__global float *constraint)
{
    if (MATERIALS)
        take_root(constraint, IN_FRICTION);
    else
        put(constraint, IN_FRICTION, root_of(get(constraint, IN_FRICTION)));
    put_vec(constraint, IN_TANGENT, tangent_of(get_vec(constraint, IN_NORMAL)));
}

static inline real effective_mass(const pair *p, vec anchor, vec direction, mask where)
{
    real inverse_mass = inverse_effective_mass(p, anchor, direction);
    return select((real)(0.0f), inverse(inverse_mass), where & (inverse_mass > 0.0f));
}

static inline void prepare_point(const pair *p, __global float *constraint, int k)
{
    __global float *point = point_at(constraint, k);
    mask where = has_point(p, k);
    vec anchor = get_vec(point, BY_ANCHOR);
    put(point, BY_NORMAL_MASS, effective_mass(p, anchor, p->normal, where));
    put(point, BY_CURRENT, get(point, BY_SEPARATION));
    put(point, BY_MAX_IMPULSE, get(point, BY_NORMAL_IMPULSE));
    put(constraint, IN_SPEEDS + k, vec_dot(velocity_between(p, anchor), p->normal));
    if (FRICTION)
        put(point, BY_TANGENT_MASS, effective_mass(p, anchor, p->tangent, where));
    if (FRICTION && DIMS == 3)
        put(point, BY_TANGENT_MASS + 1, effective_mass(p, anchor, p->bitangent, where));
}

static inline void prepare_lanes(__global float *constraint, const source *from, __global const uint *list, uint n)
{
    fill_lanes(constraint, from, list, n);
    if (MATERIALS)
        take_root(constraint, IN_RESTITUTION);
    if (FRICTION)
        prepare_friction(constraint);
    pair p;
    load_pair(&p, constraint, from->bodies);
    if (LANES == 1)
        load_warm_impulses(&p, from->bodies);
    for (int k = 0; k < p.most; ++k)
        prepare_point(&p, constraint, k);
    points all = take_points(constraint, p.n);
    store_warm_impulses(&p, &all, from->bodies);
}

#if LANES > 1

// Records and bodies are read at random: those of the blocks that come next are
// asked for in time, the records first.
static inline void ask_for_records(const source *from, __global const uint *list)
{
    for (uint k = 0; k < LANES; ++k) {
        uint words = HEAD + (from->touches[list[k]] & TOUCH_POINTS) * POINT_FLOATS;
        for (uint at = 0; at < words; at += 16)
            ask_for(from->contacts + (size_t)list[k] * RECORD + at);
    }
}

static inline void ask_for_bodies(const source *from, __global const uint *list)
{
    __global const float4 *bodies = from->bodies;
    for (uint k = 0; k < LANES; ++k) {
        uint2 link = from->links[list[k]];
        ask_for(bodies + (size_t)link.x * BODY);
        ask_for(bodies + (size_t)link.x * BODY + BODY - 1);
        ask_for(bodies + (size_t)link.y * BODY);
        ask_for(bodies + (size_t)link.y * BODY + BODY - 1);
    }
}
#endif

static inline void prepare_part(__global float *blocks, const source *from, __global const uint *list,
                                const colour_part *part, uint k)
{
    __global const uint *contacts_here = list + part->first + k;
#if LANES > 1
    if (k + 3 * LANES <= part->to)
        ask_for_records(from, contacts_here + 2 * LANES);
    if (k + 2 * LANES <= part->to)
        ask_for_bodies(from, contacts_here + LANES);
#endif
    prepare_lanes(constraint_at(blocks, part, k), from, contacts_here, min(part->to - k, part->stride));
}

__kernel void prepare_contacts(PREPARE_CONTACTS_ARGS)
{
    const source from = {PREPARE_CONTACTS_VALUES};
    colour_parts parts = COLOUR_PARTS;
    colour_part part;
    for (uint colour = from_colour; colour < to_colour; ++colour) {
        BEGIN_COLOUR(parts, colour);
        while (next_part(&parts, &part))
            for (uint k = part.from; k < part.to; k += part.stride)
                prepare_part(blocks, &from, list, &part, k);
        END_COLOUR(parts);
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
        for (int j = 0; FRICTION && j < DIMS - 1; ++j)
            saved[OF_TANGENT_IMPULSE + j] = point[(BY_TANGENT_IMPULSE + j) * BLOCK];
    }
}

// The impulses of the last substep. A work-item takes its contacts of every colour, one by one.
__kernel void store_impulses(STORE_IMPULSES_ARGS)
{
    for (uint colour = from_colour; colour < to_colour; ++colour) {
        const colour_part part = PART_OF(colour);
        for (uint k = part.from; k < part.to; ++k) {
            ask_for(contacts + (size_t)list[part.first + min(k + 8, part.to - 1)] * RECORD + HEAD);
            store_contact(constraint_at(blocks, &part, k), contacts + (size_t)list[part.first + k] * RECORD);
        }
    }
}
