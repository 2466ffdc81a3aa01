// SPDX-License-Identifier: MIT
// Bodies that sleep deep in others (update_sleep.cl) go out of them in rounds, each from the ways of the round before.
// Only what goes has a way; ways are kept where the solver will have its bodies. One more round moves what goes to where
// the last one has brought it.
//
// A launch takes the rounds from from_round up to to_round: one, or all by a team of a CPU's groups (team.clh) or by a
// GPU's that meet (meet.clh).
//
//   bodies  [n + FIXED][BODY] ways, of even rounds in the first vector and of odd ones in the next
typedef struct {
    ARG_FIELDS
} scene;

#define LEFT 0.5f // of the margin, which is not pushed out

static inline bool is_pushed_out(const scene *s, uint id)
{
    return id < s->n && (s->asleep[id] & PRESSED);
}

static inline float4 way_of(const scene *s, uint id, uint round)
{
    bool goes = round > 0 && is_pushed_out(s, id);
    return goes ? s->bodies[(size_t)id * BODY + (round & 1u)] : (float4)(0.0f);
}

// The body's part of a way that both go, where the other goes as well.
static inline float share_of(const scene *s, uint id, uint other)
{
    real mass = s->velocities[id].w;
    return is_pushed_out(s, other) ? (float)(mass * inverse(mass + s->velocities[other].w)) : 1.0f;
}

static inline bool is_pushing(const scene *s, uint word, uint other)
{
    return !IS_SENSOR(s, other) && (word & TOUCH_POINTS);
}

static inline float depth_of(__global const float *record, uint word)
{
    float deepest = 0.0f;
    for (uint k = 0; k < (word & TOUCH_POINTS); ++k)
        deepest = fmax(deepest, -record[HEAD + k * POINT_FLOATS + OF_SEPARATION]);
    return deepest;
}

// The other's way against the body's, along the normal away from the body; side -1: the
// body owns the contact, 1: the other does.
static inline float way_apart(float4 normal, float4 way, float4 others, float side)
{
    float4 between = others - way;
    return -side * fma(between.x, normal.x, fma(between.y, normal.y, between.z * normal.z));
}

static inline float4 push_of(const scene *s, uint contact, uint word, uint2 link, uint id, float4 way, uint round)
{
    const uint other = other_of(link, id);
    if (!(word & TOUCH_DEEP) || !is_pushing(s, word, other))
        return (float4)(0.0f);
    __global const float *record = s->contacts + (size_t)contact * RECORD;
    const float side = link.x == id ? -1.0f : 1.0f;
    float4 normal = float4_at(record + AT_NORMAL);
    float excess = depth_of(record, word) - way_apart(normal, way, way_of(s, other, round), side) - LEFT * s->margin;
    return excess > 0.0f ? 0.5f * side * excess * share_of(s, id, other) * normal : (float4)(0.0f);
}

// Lessens a contact's impulses by as much as it is less deep, for when its bodies wake.
static inline void lessen_pushes(const scene *s, uint contact, uint word, uint other, float4 way)
{
    __global float *record = s->contacts + (size_t)contact * RECORD;
    float depth = depth_of(record, word);
    if (!is_pushing(s, word, other) || !(depth > 0.0f))
        return;
    float apart = way_apart(float4_at(record + AT_NORMAL), way, way_of(s, other, PRESSED_ROUNDS), -1.0f);
    float part = clamp((depth - apart) * (float)inverse((real)depth), 0.0f, 1.0f);
    for (uint k = 0; k < (word & TOUCH_POINTS); ++k) {
        __global float *point = record + HEAD + k * POINT_FLOATS;
        point[OF_NORMAL_IMPULSE] *= part;
        for (int j = 0; FRICTION && j < DIMS - 1; ++j)
            point[OF_TANGENT_IMPULSE + j] *= part;
    }
}

static inline void push(const scene *s, uint id, uint round)
{
    float4 way = way_of(s, id, round), push = (float4)(0.0f);
    const body_row row = row_of(s->starts, s->return_starts, s->returns, id);
    for (uint i = 0; i < row.n; i += ROW_AHEAD) {
        const contacts_ahead next = look_ahead(&row, i, s->links, s->touches);
        EACH_AHEAD(j, next)
            push += push_of(s, next.contacts[j], next.words[j], next.links[j], id, way, round);
    }
    s->bodies[(size_t)id * BODY + (~round & 1u)] = way + push;
}

static inline void move(const scene *s, uint id)
{
    float4 way = way_of(s, id, PRESSED_ROUNDS);
    const body_row own = own_row_of(s->starts, id);
    for (uint i = 0; i < own.n; i += ROW_AHEAD) {
        const contacts_ahead next = look_ahead(&own, i, s->links, s->touches);
        EACH_AHEAD(j, next)
            lessen_pushes(s, next.contacts[j], next.words[j], next.links[j].y, way);
    }
    real4 centre = s->centres[id];
    centre.xyz += convert_real4(way).xyz;
    if (ORIGIN)
        normalize_offset(&centre, s->cells + id);
    s->centres[id] = centre;
    if (s->rests[id] > 0.0f)
        s->rests[id] += s->dt;
}

static inline void take_body(const scene *s, uint id, uint round)
{
    if (!is_pushed_out(s, id))
        return;
    if (round < PRESSED_ROUNDS)
        push(s, id, round);
    else
        move(s, id);
}

__kernel void push_sleepers(PUSH_SLEEPERS_ARGS)
{
    const scene s = {PUSH_SLEEPERS_VALUES};
    if (WAITS_FOR_HOST)
        return;
#if TEAM && WG == 1
    team_member t = TEAM_MEMBER;
    const uint each = parts_of(&t, N_AWAKE, TEAM_LEAST_BODIES);
    for (uint round = from_round, part; round < to_round; ++round) {
        IN_STAGE(&t, &part, each) {
            const uint2 range = range_of(&t, part, N_AWAKE);
            for (uint k = range.x; k < range.y; ++k)
                take_body(&s, AWAKE_AT(k), round);
        }
        END_STAGE(&t);
    }
#else
#if MEET
    meeting groups = begin_meetings(team);
#endif
    for (uint round = from_round; round < to_round; ++round) {
        for (uint k = get_global_id(0); k < N_AWAKE; k += get_global_size(0))
            take_body(&s, AWAKE_AT(k), round);
#if MEET
        if (round + 1 < to_round)
            meet(&groups);
#endif
    }
#endif
}
