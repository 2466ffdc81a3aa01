// SPDX-License-Identifier: MIT
#include "support/test.h"

#include "support/hard_pairs.h"
#include "support/real.h"

#include "runtime/narrowphase/narrow.h"

// ------------------------------------------------------------ parts of a pose

static void set_random_turn(duet_pose *pose, rng *r, uint32_t dims)
{
    for (int i = 0; i < 4; ++i)
        pose->rotation[i] = dims == 2 && i < 2 ? 0 : (float)rng_normal(r);
}

static void set_halves(duet_pose *pose, rng *r, double from, double to)
{
    for (int i = 0; i < 3; ++i)
        pose->half_extents[i] = (float)(from * pow(to / from, rng_unit(r)));
}

static double edge_direction(const duet_pose *pose, int edge, int along)
{
    real axis[3][3];
    real_axes(axis, pose->rotation);
    return (double)axis[edge][along];
}

// A random point of the box, from its centre.
static void pick_point(const duet_pose *pose, rng *r, double point[3])
{
    for (int i = 0; i < 3; ++i)
        point[i] = 0;
    for (int edge = 0; edge < 3; ++edge) {
        double at = pose->half_extents[edge] * rng_between(r, -1, 1);
        for (int i = 0; i < 3; ++i)
            point[i] += at * edge_direction(pose, edge, i);
    }
}

static void pick_direction(rng *r, uint32_t dims, double direction[3])
{
    double length = 0;
    for (int i = 0; i < 3; ++i) {
        direction[i] = i < (int)dims ? rng_normal(r) : 0;
        length += direction[i] * direction[i];
    }
    for (int i = 0; i < 3; ++i)
        direction[i] /= sqrt(length);
}

// ------------------------------------------------------------ contact by search

static void place(hard_pair *p, const double start[3], const double direction[3], double way)
{
    for (int i = 0; i < 3; ++i)
        p->b.centre[i] = (float)(p->a.centre[i] + start[i] + way * direction[i]);
}

static int pick_sign(rng *r)
{
    return rng_below(r, 2) ? 1 : -1;
}

static void nudge(float *value, uint32_t ulps, rng *r)
{
    float towards = pick_sign(r) * INFINITY;
    for (; ulps > 0; --ulps)
        *value = nextafterf(*value, towards);
}

// Moves b from a place where it shares a point with a along a random line to
// where it just leaves a, or to some units of rounding around there.
static hard_pair bring_to_contact(hard_pair p, rng *r, uint32_t dims)
{
    double start[3], inside_b[3], direction[3], size = 0;
    pick_point(&p.a, r, start);
    pick_point(&p.b, r, inside_b);
    pick_direction(r, dims, direction);
    for (int i = 0; i < 3; ++i) {
        start[i] -= inside_b[i];
        size += (double)p.a.half_extents[i] + p.b.half_extents[i];
    }
    double in = 0, out = 4 * size;
    for (int step = 0; step < 40; ++step) {
        double middle = (in + out) / 2;
        place(&p, start, direction, middle);
        *(narrow_decide(&p.a, &p.b, dims) ? &in : &out) = middle;
    }
    double way = rng_below(r, 2) ? in : out;
    if (rng_below(r, 3) == 0)
        way += pick_sign(r) * size * 0x1p-24 * pow(2, rng_between(r, -2, 6));
    place(&p, start, direction, way);
    if (rng_below(r, 3) == 0)
        nudge(&p.b.centre[rng_below(r, dims)], 1 + rng_below(r, 3), r);
    return p;
}

static hard_pair random_pair(rng *r, uint32_t dims, double from, double to)
{
    hard_pair p = {0};
    set_halves(&p.a, r, from, to);
    set_halves(&p.b, r, from, to);
    set_random_turn(&p.a, r, dims);
    set_random_turn(&p.b, r, dims);
    return p;
}

static hard_pair random_contact(rng *r, uint32_t dims)
{
    return bring_to_contact(random_pair(r, dims, 0.3, 1), r, dims);
}

// b turned from a by an angle of 1e-1 to 1e-12, where float can hold it: at
// the identity a quaternion's x, y, z may be as small as one likes.
static void make_nearly_parallel(hard_pair *p, rng *r, uint32_t dims)
{
    double angle = pow(10, -rng_between(r, 1, 12));
    bool at_identity = rng_below(r, 2);
    if (at_identity)
        memcpy(p->a.rotation, (float[]){0, 0, 0, 1}, sizeof p->a.rotation);
    for (int i = 0; i < 4; ++i) {
        double turned = p->a.rotation[i] + angle * rng_normal(r);
        p->b.rotation[i] = dims == 2 && i < 2 ? 0 : (float)turned;
    }
}

static hard_pair nearly_parallel(rng *r, uint32_t dims)
{
    hard_pair p = random_pair(r, dims, 0.3, 1);
    make_nearly_parallel(&p, r, dims);
    return bring_to_contact(p, r, dims);
}

static hard_pair far_away(rng *r, uint32_t dims)
{
    hard_pair p = random_pair(r, dims, 0.3, 30);
    if (rng_below(r, 2))
        make_nearly_parallel(&p, r, dims);
    for (int i = 0; i < 3; ++i)
        p.a.centre[i] = (float)(rng_between(r, -1, 1) * pow(10, rng_between(r, 3, 7)));
    return bring_to_contact(p, r, dims);
}

static hard_pair plates(rng *r, uint32_t dims)
{
    hard_pair p = random_pair(r, dims, 5, 10);
    p.a.half_extents[rng_below(r, dims)] = (float)(10 * pow(10, -rng_between(r, 3, 6)));
    p.b.half_extents[rng_below(r, dims)] = (float)(10 * pow(10, -rng_between(r, 3, 6)));
    if (rng_below(r, 2))
        make_nearly_parallel(&p, r, dims);
    return bring_to_contact(p, r, dims);
}

static void make_needle(duet_pose *pose, rng *r, uint32_t dims)
{
    set_halves(pose, r, 1e-4, 1e-2);
    pose->half_extents[rng_below(r, dims)] = 100;
}

static hard_pair needles(rng *r, uint32_t dims)
{
    hard_pair p = random_pair(r, dims, 1, 1);
    make_needle(&p.a, r, dims);
    make_needle(&p.b, r, dims);
    if (rng_below(r, 2))
        make_nearly_parallel(&p, r, dims);
    return bring_to_contact(p, r, dims);
}

// Points, segments and rectangles, against each other and against boxes.
static hard_pair flat(rng *r, uint32_t dims)
{
    hard_pair p = random_pair(r, dims, 0.3, 1);
    for (int i = 0; i < 3; ++i) {
        p.a.half_extents[i] = rng_below(r, 2) ? 0 : p.a.half_extents[i];
        p.b.half_extents[i] = rng_below(r, 3) ? p.b.half_extents[i] : 0;
    }
    return bring_to_contact(p, r, dims);
}

static hard_pair of_very_different_size(rng *r, uint32_t dims)
{
    hard_pair p = random_pair(r, dims, 0.3, 1);
    set_halves(&p.b, r, 1e-6, 1e6);
    return bring_to_contact(p, r, dims);
}

static hard_pair at_any_scale(rng *r, uint32_t dims)
{
    double scale = pow(10, rng_between(r, -20, 18));
    return bring_to_contact(random_pair(r, dims, 0.3 * scale, scale), r, dims);
}

static hard_pair denormal(rng *r, uint32_t dims)
{
    double scale = pow(10, rng_between(r, -43, -36));
    hard_pair p = random_pair(r, dims, 0.3 * scale, scale);
    if (rng_below(r, 2))
        set_halves(&p.a, r, 0.3, 1);
    return bring_to_contact(p, r, dims);
}

static hard_pair near_the_greatest_float(rng *r, uint32_t dims)
{
    return bring_to_contact(random_pair(r, dims, 1e36, 2e37), r, dims);
}

static void scale_turn(duet_pose *pose, double by)
{
    for (int i = 0; i < 4; ++i)
        pose->rotation[i] = (float)(pose->rotation[i] * by);
}

static hard_pair odd_quaternions(rng *r, uint32_t dims)
{
    hard_pair p = random_pair(r, dims, 0.3, 1);
    scale_turn(&p.a, pow(10, rng_between(r, -44, 37)));
    scale_turn(&p.b, rng_below(r, 2) ? 1.001 : pow(10, rng_between(r, -6, 6)));
    p.a.rotation[3] = p.a.rotation[3] == 0 ? 0x1p-149f : p.a.rotation[3];
    p.b.rotation[rng_below(r, 3)] = 1e-30f;
    return bring_to_contact(p, r, dims);
}

// Parts of any size that a float has: the least count for nothing in float, and
// for everything where a needle's end touches a face.
static hard_pair parts_far_apart(rng *r, uint32_t dims)
{
    hard_pair p = random_pair(r, dims, 0.3, 1);
    bool needle = rng_below(r, 2);
    if (needle)
        p = (hard_pair){{{0}, {0.5f, 0.5f, dims == 3 ? 0.5f : 0}, {0, 0, 0, 1}},
                        {{1}, {0.5f, 0, 0}, {0, 0, 0, 1}}};
    for (int i = dims == 2 ? 2 : 0; i < 4; ++i)
        if (!needle || rng_below(r, 3))
            p.b.rotation[i] = ldexpf((float)rng_between(r, 1, 2) * (float)pick_sign(r),
                                     (int)rng_below(r, 277) - 149);
    if (p.b.rotation[2] == 0 && p.b.rotation[3] == 0)
        p.b.rotation[3] = 1;
    return needle ? p : bring_to_contact(p, r, dims);
}

static hard_pair nested(rng *r, uint32_t dims)
{
    hard_pair p = random_pair(r, dims, 1e-3, 1e-1);
    set_halves(&p.b, r, 1e2, 1e4);
    double inside[3];
    pick_point(&p.b, r, inside);
    for (int i = 0; i < 3; ++i)
        p.a.centre[i] = (float)inside[i];
    return p;
}

static hard_pair identical(rng *r, uint32_t dims)
{
    hard_pair p = random_pair(r, dims, 0.3, 1);
    for (int i = 0; i < 3; ++i)
        p.a.centre[i] = (float)rng_between(r, -1e3, 1e3);
    p.b = p.a;
    return p;
}

// Same turn, a face of one along a face of the other, apart by some ulps.
static hard_pair face_to_face(rng *r, uint32_t dims)
{
    hard_pair p = random_pair(r, dims, 0.3, 1);
    memcpy(p.b.rotation, p.a.rotation, sizeof p.b.rotation);
    int face = (int)rng_below(r, dims);
    double reach = ((double)p.a.half_extents[face] + p.b.half_extents[face]) *
                   (1 + rng_between(r, -3e-7, 3e-7));
    for (int i = 0; i < 3; ++i)
        p.b.centre[i] = (float)(reach * edge_direction(&p.a, face, i));
    return p;
}

// ------------------------------------------------------------ exact contact

// Boxes whose lengths are whole numbers of 1/64 and whose rotations come from
// small whole quaternions: points of theirs are whole numbers of 1/64 too.
typedef struct whole_box {
    int q[4];
    int norm;
    int axis[3][3];      // vectors of length norm
    int half_extents[3]; // in units of norm / 64
} whole_box;

static whole_box pick_whole_box(rng *r, uint32_t dims, int greatest)
{
    whole_box b = {.norm = 0};
    while (b.norm == 0) {
        for (int i = 0; i < 4; ++i) {
            b.q[i] = dims == 2 && i < 2 ? 0 : (int)rng_below(r, 2 * greatest + 1) - greatest;
            b.norm += b.q[i] * b.q[i];
        }
    }
    duet_pose pose = {.rotation = {(float)b.q[0], (float)b.q[1], (float)b.q[2], (float)b.q[3]}};
    for (int edge = 0; edge < 3; ++edge) {
        b.half_extents[edge] = dims == 2 && edge == 2 ? 0 : 1 + (int)rng_below(r, 8);
        for (int i = 0; i < 3; ++i)
            b.axis[edge][i] = (int)lrint(b.norm * edge_direction(&pose, edge, i));
    }
    return b;
}

static long dot(const int u[3], const int v[3])
{
    return (long)u[0] * v[0] + (long)u[1] * v[1] + (long)u[2] * v[2];
}

// A point of the box that is farthest along `normal`, from its centre in 1/64;
// where several edges lie across it, one of their points.
static void farthest_point(const whole_box *b, const int normal[3], rng *r, int point[3])
{
    for (int i = 0; i < 3; ++i)
        point[i] = 0;
    for (int edge = 0; edge < 3; ++edge) {
        long along = dot(normal, b->axis[edge]);
        int at =
            along ? b->half_extents[edge] : (int)rng_below(r, (uint32_t)b->half_extents[edge] + 1);
        int sign = along ? (along > 0 ? 1 : -1) : pick_sign(r);
        for (int i = 0; i < 3; ++i)
            point[i] += sign * at * b->axis[edge][i];
    }
}

static duet_pose pose_of(const whole_box *b, const int centre[3])
{
    duet_pose pose = {0};
    for (int i = 0; i < 4; ++i)
        pose.rotation[i] = (float)b->q[i];
    for (int i = 0; i < 3; ++i) {
        pose.centre[i] = (float)centre[i] / 64;
        pose.half_extents[i] = (float)(b->half_extents[i] * b->norm) / 64;
    }
    return pose;
}

// Joins the points of both boxes that lie farthest along `normal` and against it.
static hard_pair join(const whole_box *a, const whole_box *b, const int normal[3], rng *r)
{
    const int against[3] = {-normal[0], -normal[1], -normal[2]};
    int on_a[3], on_b[3], centre_a[3], centre_b[3];
    farthest_point(a, normal, r, on_a);
    farthest_point(b, against, r, on_b);
    for (int i = 0; i < 3; ++i) {
        centre_a[i] = (int)rng_below(r, 1001) - 500;
        centre_b[i] = centre_a[i] + on_a[i] - on_b[i];
    }
    return (hard_pair){pose_of(a, centre_a), pose_of(b, centre_b)};
}

static void cross(const int u[3], const int v[3], int out[3])
{
    for (int i = 0; i < 3; ++i)
        out[i] = u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3];
}

static hard_pair touching_upright(rng *r, uint32_t dims)
{
    whole_box a = {{0, 0, 0, 1}, 1, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0}};
    for (uint32_t i = 0; i < dims; ++i)
        a.half_extents[i] = (int)rng_below(r, 9);
    whole_box b = a;
    b.half_extents[0] = (int)rng_below(r, 9);
    int normal[3];
    for (uint32_t i = 0; i < 3; ++i)
        normal[i] = i < dims ? (int)rng_below(r, 3) - 1 : 0;
    return join(&a, &b, normal, r);
}

static hard_pair touching_faces(rng *r, uint32_t dims)
{
    whole_box a = pick_whole_box(r, dims, 4), b = pick_whole_box(r, dims, 4);
    int face = (int)rng_below(r, dims), sign = pick_sign(r);
    const int *axis = a.axis[face];
    const int normal[3] = {sign * axis[0], sign * axis[1], sign * axis[2]};
    return join(&a, &b, normal, r);
}

static hard_pair touching_edges(rng *r, uint32_t dims)
{
    if (dims == 2)
        return touching_faces(r, dims);
    whole_box a = pick_whole_box(r, dims, 4), b = pick_whole_box(r, dims, 4);
    int normal[3];
    cross(a.axis[rng_below(r, 3)], b.axis[rng_below(r, 3)], normal);
    return join(&a, &b, normal, r);
}

static hard_pair an_ulp_off(hard_pair p, rng *r, uint32_t dims)
{
    nudge(rng_below(r, 4) ? &p.b.centre[rng_below(r, dims)] : &p.b.half_extents[rng_below(r, dims)],
          1, r);
    for (int i = 0; i < 3; ++i)
        p.b.half_extents[i] = fabsf(p.b.half_extents[i]); // taken where an extent was 0
    return p;
}

static hard_pair an_ulp_off_upright(rng *r, uint32_t dims)
{
    return an_ulp_off(touching_upright(r, dims), r, dims);
}

static hard_pair an_ulp_off_faces(rng *r, uint32_t dims)
{
    return an_ulp_off(touching_faces(r, dims), r, dims);
}

static hard_pair an_ulp_off_edges(rng *r, uint32_t dims)
{
    return an_ulp_off(touching_edges(r, dims), r, dims);
}

// Cubes that only an axis across two edges can separate: each on its own edge,
// crossing.
static hard_pair edge_to_edge(rng *r, uint32_t dims)
{
    hard_pair p = {
        {{0}, {0.5f, 0.5f, 0.5f}, {0.3826834324f, 0, 0, 0.9238795325f}},
        {{0}, {0.5f, 0.5f, 0.5f}, {0, 0.3826834324f, 0, 0.9238795325f}},
    };
    if (dims == 2)
        return random_contact(r, dims);
    p.b.centre[0] = (float)rng_between(r, -0.2, 0.2);
    p.b.centre[1] = (float)rng_between(r, -0.2, 0.2);
    p.b.centre[2] = (float)(sqrt(2) * (1 + rng_between(r, -3e-7, 3e-7)));
    return p;
}

const hard_class hard_classes[] = {
    {"random contact", random_contact, false},
    {"touching, upright", touching_upright, true},
    {"touching, face by rational rotations", touching_faces, true},
    {"touching, edges by rational rotations", touching_edges, true},
    {"an ulp off, upright", an_ulp_off_upright, false},
    {"an ulp off, face by rational rotations", an_ulp_off_faces, false},
    {"an ulp off, edges by rational rotations", an_ulp_off_edges, false},
    {"nearly parallel", nearly_parallel, false},
    {"face to face", face_to_face, false},
    {"edge to edge", edge_to_edge, false},
    {"far away", far_away, false},
    {"plates", plates, false},
    {"needles", needles, false},
    {"points, segments, rectangles", flat, false},
    {"of very different size", of_very_different_size, false},
    {"at any scale", at_any_scale, false},
    {"denormal", denormal, false},
    {"near the greatest float", near_the_greatest_float, false},
    {"odd quaternions", odd_quaternions, false},
    {"nested", nested, true},
    {"identical", identical, true},
    {"parts of a quaternion far apart", parts_far_apart, false},
    {NULL, NULL, false},
};

static void print_pose(const char *name, const duet_pose *p)
{
    print_message("duet_pose %s = {{%a, %a, %a}, {%a, %a, %a}, {%a, %a, %a, %a}};\n", name,
                  p->centre[0], p->centre[1], p->centre[2], p->half_extents[0], p->half_extents[1],
                  p->half_extents[2], p->rotation[0], p->rotation[1], p->rotation[2],
                  p->rotation[3]);
}

static void print_numbers(const float *numbers, int n)
{
    for (int i = 0; i < n; ++i)
        print_message("%.9g ", numbers[i]);
}

static void print_row(const duet_pose *p)
{
    print_numbers(p->centre, 3);
    print_numbers(p->half_extents, 3);
    print_numbers(p->rotation, 4);
}

void hard_pair_print(const hard_pair *pair, uint32_t dims)
{
    print_pose("a", &pair->a);
    print_pose("b", &pair->b);
    print_message("dims %u\nfor duet query, in 3D: ", dims);
    duet_pose a = narrow_flat(&pair->a, dims), b = narrow_flat(&pair->b, dims);
    print_row(&a);
    print_row(&b);
    print_message("\n");
}

duet_pose random_box(rng *r, double spread)
{
    duet_pose pose;
    for (int i = 0; i < 3; ++i) {
        pose.centre[i] = (float)rng_between(r, 0, spread);
        pose.half_extents[i] = (float)rng_between(r, 0.1, 1);
    }
    for (int i = 0; i < 4; ++i)
        pose.rotation[i] = (float)rng_normal(r);
    return pose;
}
