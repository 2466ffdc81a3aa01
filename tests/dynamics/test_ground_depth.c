// SPDX-License-Identifier: MIT
// How bodies that are deep in a ground leave it, against truth made another way, in double: depths
// in an edge by directions drawn densely over the arc between its sides' normals, overlaps by
// cutting triangles or by steps from one convex set to the other, and what all contacts of a body
// ask for together by Hildreth's method.
#include "support/ground.h"
#include "support/real.h"
#include "support/shape.h"
#include "support/test.h"

static const double half_slop = 0.0025;

// ---------------------------------------------------------------- vectors

static vector plus(vector a, double s, vector b)
{
    return (vector){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}

static vector crossed(vector a, vector b)
{
    return (vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static vector unit(vector a)
{
    return plus((vector){0, 0, 0}, 1 / sqrt(vector_dot(a, a)), a);
}

static vector any_direction(rng *r)
{
    vector v = {rng_normal(r), rng_normal(r), rng_normal(r)};
    return unit(v);
}

// ---------------------------------------------------------------- a box

typedef struct box {
    vector axis[3], centre;
    double half[3], radius;
} box;

static box box_of(const mover *m, uint32_t id)
{
    const duet_pose *p = &m->poses[id];
    real axis[3][3];
    box b = {.centre = {(double)p->centre[0], (double)p->centre[1], (double)p->centre[2]},
             .radius = (double)m->bodies[id].radius};
    real_axes(axis, p->rotation);
    for (int k = 0; k < 3; ++k) {
        b.axis[k] = (vector){(double)axis[k][0], (double)axis[k][1], (double)axis[k][2]};
        b.half[k] = (double)p->half_extents[k];
    }
    return b;
}

static double reach(const box *b, vector along)
{
    double far = b->radius;
    for (int k = 0; k < 3; ++k)
        far += b->half[k] * fabs(vector_dot(b->axis[k], along));
    return far;
}

// How far it reaches below a place, against a direction.
static double depth_along(const box *b, vector place, vector out)
{
    return reach(b, out) - vector_dot(vector_less(b->centre, place), out);
}

static vector nearest_in_core(const box *b, vector to)
{
    vector way = vector_less(to, b->centre), at = b->centre;
    for (int k = 0; k < 3; ++k)
        at = plus(at, fmax(-b->half[k], fmin(b->half[k], vector_dot(way, b->axis[k]))), b->axis[k]);
    return at;
}

// ---------------------------------------------------------------- overlap with a triangle

static int cut(const vector *in, int n, vector *out, vector inward, double limit)
{
    int m = 0;
    for (int i = 0; i < n; ++i) {
        vector p = in[i], q = in[(i + 1) % n];
        double a = vector_dot(p, inward) - limit, c = vector_dot(q, inward) - limit;
        if (a >= 0)
            out[m++] = p;
        if ((a >= 0) != (c >= 0))
            out[m++] = plus(p, a / (a - c), vector_less(q, p));
    }
    return m;
}

static bool core_reaches(const box *b, const vector t[3], double less)
{
    vector one[16], two[16];
    int n = 3;
    memcpy(one, t, 3 * sizeof *t);
    for (int k = 0; k < 3 && n > 0; ++k) {
        double middle = vector_dot(b->centre, b->axis[k]), half = b->half[k] - less;
        if (half < 0)
            return false;
        n = cut(one, n, two, b->axis[k], middle - half);
        n = cut(two, n, one, plus((vector){0, 0, 0}, -1, b->axis[k]), -middle - half);
    }
    return n > 0;
}

static vector nearest_on_edge(vector p, vector a, vector b)
{
    vector along = vector_less(b, a);
    double t = vector_dot(vector_less(p, a), along) / vector_dot(along, along);
    return plus(a, fmax(0, fmin(1, t)), along);
}

static vector nearest_on_triangle(vector p, const vector t[3])
{
    vector up = unit(crossed(vector_less(t[1], t[0]), vector_less(t[2], t[0])));
    bool inside = true;
    vector best = t[0];
    double least = INFINITY;
    for (int e = 0; e < 3; ++e) {
        vector along = vector_less(t[(e + 1) % 3], t[e]);
        inside = inside && vector_dot(crossed(up, along), vector_less(p, t[e])) >= 0;
        vector at = nearest_on_edge(p, t[e], t[(e + 1) % 3]), way = vector_less(p, at);
        if (vector_dot(way, way) < least) {
            least = vector_dot(way, way);
            best = at;
        }
    }
    return inside ? plus(p, -vector_dot(vector_less(p, t[0]), up), up) : best;
}

// Whether the body, made smaller by a length all around, still meets the triangle.
static bool reaches(const box *b, const vector t[3], double less)
{
    if (b->radius <= less)
        return core_reaches(b, t, less - b->radius);
    vector on = t[0];
    double far = INFINITY;
    for (int i = 0; i < 300 && far > b->radius - less; ++i) {
        vector in = nearest_in_core(b, on);
        on = nearest_on_triangle(in, t);
        vector way = vector_less(in, on);
        far = sqrt(vector_dot(way, way));
    }
    return far <= b->radius - less;
}

// ---------------------------------------------------------------- what contacts ask for

typedef struct asked {
    vector out[4];
    double depth[4];
    int n;
} asked;

// The shortest way that fulfils all: each in turn takes what it lacks.
static vector way_out(const asked *a)
{
    vector way = {0, 0, 0};
    double push[4] = {0};
    for (int i = 0; i < 4000; ++i)
        for (int k = 0; k < a->n; ++k) {
            double more = a->depth[k] - vector_dot(a->out[k], way);
            more = fmax(more, -push[k]);
            push[k] += more;
            way = plus(way, more, a->out[k]);
        }
    return way;
}

static void ask(mover *m, asked *of)
{
    uint64_t n;
    mover_run(m, 1);
    memset(of, 0, m->n * sizeof *of);
    const duet_contact *contacts = mover_contacts(m, &n);
    for (uint64_t i = 0; i < n; ++i) {
        const duet_contact *c = &contacts[i];
        asked *a = &of[c->a];
        if (c->b != m->n + 6)
            continue;
        assert_true(a->n < 4);
        a->out[a->n] =
            (vector){-(double)c->normal[0], -(double)c->normal[1], -(double)c->normal[2]};
        a->depth[a->n++] = -ground_least_of(c);
    }
}

// ---------------------------------------------------------------- bodies

static mover *still(void)
{
    mover *m = mover_new(3);
    m->def.wants = DUET_EFFECT_CONTACT | DUET_EFFECT_RADIUS;
    m->def.slop = ground_slop;
    m->def.dt = 1e-6;
    return m;
}

static uint32_t add_any(mover *m, rng *r, double least, double most, double radius)
{
    double h[3];
    for (int k = 0; k < 3; ++k)
        h[k] = least * pow(most / least, rng_unit(r));
    uint32_t id = mover_add(m, 0, 0, 0, h[0], h[1], h[2]);
    m->bodies[id].radius = (float)radius;
    m->bodies[id].mask = 0;
    vector about = any_direction(r);
    mover_turn(m, id, about.x, about.y, about.z, rng_between(r, 0, 6.28));
    return id;
}

static void put(mover *m, uint32_t id, vector at)
{
    m->poses[id].centre[0] = (float)at.x;
    m->poses[id].centre[1] = (float)at.y;
    m->poses[id].centre[2] = (float)at.z;
}

// ---------------------------------------------------------------- ridges

typedef struct ridge {
    vector along, out[2], apex;
} ridge;

static double depth_at(const box *b, const ridge *e, double angle)
{
    vector side = unit(crossed(e->along, e->out[0]));
    vector out = plus(plus((vector){0, 0, 0}, cos(angle), e->out[0]), sin(angle), side);
    return depth_along(b, e->apex, out);
}

// The least depth over the directions between both sides' normals.
static double depth_in_ridge(const box *b, const ridge *e)
{
    enum { DRAWN = 2000 };
    double bend = acos(fmax(-1, fmin(1, vector_dot(e->out[0], e->out[1])))), least = INFINITY;
    int best = 0;
    for (int i = 0; i <= DRAWN; ++i) {
        double depth = depth_at(b, e, bend * i / DRAWN);
        if (depth < least) {
            least = depth;
            best = i;
        }
    }
    double from = bend * fmax(0, best - 1) / DRAWN, to = bend * fmin(DRAWN, best + 1) / DRAWN;
    for (int i = 0; i < 60; ++i) {
        double one = from + (to - from) / 3, two = to - (to - from) / 3;
        if (depth_at(b, e, one) < depth_at(b, e, two))
            to = two;
        else
            from = one;
    }
    return fmin(least, depth_at(b, e, from));
}

typedef struct frame {
    vector x, y, z;
} frame;

static frame any_frame(rng *r)
{
    frame f = {.z = any_direction(r)};
    f.x = unit(crossed(any_direction(r), f.z));
    f.y = crossed(f.z, f.x);
    return f;
}

static vector seen(const frame *f, double x, double y, double z)
{
    return plus(plus(plus((vector){0, 0, 0}, x, f->x), y, f->y), z, f->z);
}

static uint32_t put_vertex(shape *s, vector at)
{
    return shape_vertex(s, at.x, at.y, at.z);
}

// Two sides that fall by angles from an edge along y, of cells of any length.
static shape *ridge_shape(rng *r, const frame *f, double left, double right, ridge *e)
{
    shape *s = shape_new();
    const double far[2] = {rng_between(r, 0.4, 1.5), 4};
    uint32_t rows = 0;
    for (double y = -6; y < 6; y += rng_between(r, 0.2, 1.5), ++rows) {
        for (int i = -2; i <= 2; ++i) {
            double x = i == 0 ? 0 : far[abs(i) - 1], angle = i < 0 ? left : right;
            put_vertex(s, seen(f, (i < 0 ? -x : x) * cos(angle), y, -x * sin(angle)));
        }
    }
    for (uint32_t j = 0; j + 1 < rows; ++j)
        for (uint32_t i = 0; i < 4; ++i) {
            uint32_t a = 5 * j + i;
            if ((i + j) % 2)
                shape_quad(s, a, a + 1, a + 6, a + 5);
            else
                shape_quad(s, a + 1, a + 6, a + 5, a);
        }
    e->along = plus((vector){0, 0, 0}, -1, f->y);
    e->out[0] = seen(f, sin(right), 0, cos(right));
    e->out[1] = seen(f, -sin(left), 0, cos(left));
    if (vector_dot(crossed(e->along, e->out[0]), e->out[1]) < 0)
        e->along = f->y;
    e->apex = (vector){0, 0, 0};
    return s;
}

// Puts a box into a ridge: the corner furthest down a direction between the normals is below the
// edge.
static bool put_in_ridge(mover *m, uint32_t id, rng *r, const ridge *e, const frame *f, double deep)
{
    double part = rng_unit(r);
    vector out = unit(plus(plus((vector){0, 0, 0}, part, e->out[0]), 1 - part, e->out[1]));
    box b = box_of(m, id);
    double below = rng_between(r, 1.5, deep) * ground_slop;
    vector aside = crossed(out, f->y);
    vector at =
        plus(plus((vector){0, 0, 0}, reach(&b, out) - below, out), rng_between(r, -2, 2), f->y);
    at = plus(at, rng_between(r, -0.3, 0.3) * reach(&b, aside), aside);
    put(m, id, at);
    b = box_of(m, id);
    double depth = depth_in_ridge(&b, e);
    bool front = true; // of the sides along whose normals it leaves by least
    for (int k = 0; k < 2; ++k)
        front = front && (vector_dot(b.centre, e->out[k]) > 1e-4 ||
                          depth_along(&b, e->apex, e->out[k]) > depth + ground_slop);
    return front && depth > ground_slop && depth < deep * ground_slop;
}

// Fails unless a body leaves by the least depth.
static void check_ridge(const mover *m, uint32_t id, const asked *of, const ridge *e)
{
    box b = box_of(m, id);
    double depth = depth_in_ridge(&b, e);
    vector way = way_out(of);
    double far = sqrt(vector_dot(way, way));
    if (of->n == 0)
        fail_msg("body %u, half %g %g %g, is %g deep and has no contact", id, b.half[0], b.half[1],
                 b.half[2], depth);
    if (!(fabs(far - depth) <= half_slop + 1e-5))
        fail_msg("body %u, half %g %g %g, is %g deep; %d contacts take it %g away", id, b.half[0],
                 b.half[1], b.half[2], depth, of->n, far);
}

// 160 bodies on each of 14 ridges of 3 to 160 degrees, up to 4 and up to 40 slops deep.
static void check_ridges(double deep, bool rounded)
{
    rng r = rng_seed(test_seed());
    asked *of = test_alloc(MOVER_MOST * sizeof *of);
    for (int round = 0; round < 14; ++round) {
        frame f = any_frame(&r);
        ridge e;
        double left = rng_between(&r, 0, 1.4), right = rng_between(&r, 0.05, 1.4);
        shape *s = ridge_shape(&r, &f, left, right, &e);
        mover *m = still();
        m->def.mesh = &s->mesh;
        while (m->n < 160) {
            uint32_t id = add_any(m, &r, 0.05, 0.6, rounded ? rng_between(&r, 0.02, 0.1) : 0);
            if (!put_in_ridge(m, id, &r, &e, &f, deep))
                --m->n;
        }
        ask(m, of);
        for (uint32_t id = 0; id < m->n; ++id)
            check_ridge(m, id, &of[id], &e);
        mover_free(m);
    }
}

TEST(boxes_leave_a_ridge_by_its_least_depth)
{
    check_ridges(4, false);
    check_ridges(40, false);
}

TEST(rounded_boxes_leave_a_ridge_by_its_least_depth)
{
    check_ridges(4, true);
    check_ridges(40, true);
}

// ---------------------------------------------------------------- sheets

// A level sheet that looks both ways: its lower side at height 0, its upper at `thick`.
static shape *sheet_of(rng *r, double thick)
{
    shape *s = shape_new();
    const uint32_t n = 2 + rng_below(r, 8);
    shape_grid(s, n + 1, 8.0 / n, ground_flat);
    uint32_t half = s->mesh.n_triangles, vertices = s->mesh.n_vertices;
    for (uint32_t i = 0; i < vertices; ++i)
        shape_vertex(s, (double)s->vertices[3 * i], (double)s->vertices[3 * i + 1], thick);
    for (uint32_t i = 0; i < half; ++i) {
        const uint32_t *t = s->triangles + 3 * i;
        shape_triangle(s, t[0] + vertices, t[1] + vertices, t[2] + vertices);
    }
    for (uint32_t i = 0; i < half; ++i) { // the lower side looks down
        uint32_t *t = s->triangles + 3 * i, kept = t[1];
        t[1] = t[2];
        t[2] = kept;
    }
    return s;
}

// They leave downward, as deep as they reach above its lower side.
static void check_sheet(const mover *m, uint32_t id, const asked *of, double thick)
{
    box b = box_of(m, id);
    double depth = b.centre.z + reach(&b, (vector){0, 0, 1});
    vector way = way_out(of);
    if (!(fabs(way.z + depth) <= half_slop && hypot(way.x, way.y) <= half_slop))
        fail_msg("body %u is %g deep in a sheet of %g; %d contacts take it %g %g %g away", id,
                 depth, thick, of->n, way.x, way.y, way.z);
}

TEST(bodies_whose_centre_is_below_a_sheet_leave_it_downward)
{
    rng r = rng_seed(test_seed());
    asked *of = test_alloc(MOVER_MOST * sizeof *of);
    static const double thick[] = {0, 0.0005, 0.005, 0.02, 0.06};
    for (int round = 0; round < 20; ++round) {
        shape *s = sheet_of(&r, thick[round % 5]);
        mover *m = still();
        m->def.mesh = &s->mesh;
        for (int i = 0; i < 100; ++i) {
            uint32_t id = add_any(m, &r, 0.05, 0.6, round % 2 ? rng_between(&r, 0.02, 0.1) : 0);
            box b = box_of(m, id);
            double up = reach(&b, (vector){0, 0, 1});
            double deep = rng_between(&r, 1.5 * ground_slop, 0.95 * up);
            put(m, id, (vector){rng_between(&r, -2.5, 2.5), rng_between(&r, -2.5, 2.5), deep - up});
        }
        ask(m, of);
        for (uint32_t id = 0; id < m->n; ++id)
            check_sheet(m, id, &of[id], thick[round % 5]);
        mover_free(m);
    }
}

// ---------------------------------------------------------------- rough ground

static void triangle_of(const shape *s, uint32_t i, vector t[3])
{
    for (int k = 0; k < 3; ++k) {
        const float *v = s->vertices + 3 * s->triangles[3 * i + k];
        t[k] = (vector){(double)v[0], (double)v[1], (double)v[2]};
    }
}

// Whether a body, made smaller all around, meets a triangle that it also meets as `was`, in front
// of which that has its centre.
static bool reaches_any(const shape *s, const box *b, const box *was, double less)
{
    double far = was->radius + sqrt(was->half[0] * was->half[0] + was->half[1] * was->half[1] +
                                    was->half[2] * was->half[2]);
    for (uint32_t i = 0; i < s->mesh.n_triangles; ++i) {
        vector t[3];
        triangle_of(s, i, t);
        vector up = crossed(vector_less(t[1], t[0]), vector_less(t[2], t[0]));
        vector way = vector_less(nearest_on_triangle(was->centre, t), was->centre);
        if (vector_dot(way, way) < far * far &&
            vector_dot(vector_less(was->centre, t[0]), up) > 0 && reaches(was, t, less) &&
            (b == was || reaches(b, t, less)))
            return true;
    }
    return false;
}

enum { PLACES = 9 };

// Rough triangles, and the same as heights.
static shape *rough_shape(double spacing, float values[PLACES * PLACES], duet_heights *h)
{
    const double half = (PLACES - 1) * spacing / 2;
    shape *s = shape_new();
    shape_grid(s, PLACES, spacing, ground_rough);
    for (int i = 0; i < PLACES * PLACES; ++i)
        values[i] = s->vertices[3 * i + 2];
    *h = (duet_heights){.nx = PLACES,
                        .ny = PLACES,
                        .origin = {-half, -half, 0},
                        .spacing = {spacing, spacing},
                        .heights = values};
    return s;
}

// Lets a body down until it touches, and 1 to 6 slops further; false: it is not a slop deep.
static bool sink(mover *m, uint32_t id, rng *r, const shape *s, double half)
{
    double x = rng_between(r, -half, half), y = rng_between(r, -half, half), above = 2, below = -1;
    for (int k = 0; k < 30; ++k) {
        double z = (above + below) / 2;
        put(m, id, (vector){x, y, z});
        box b = box_of(m, id);
        if (reaches_any(s, &b, &b, 0))
            below = z;
        else
            above = z;
    }
    put(m, id, (vector){x, y, above - rng_between(r, 1, 6) * ground_slop});
    box b = box_of(m, id);
    return reaches_any(s, &b, &b, ground_slop);
}

static uint32_t check_rough(bool heights, bool rounded, double spacing, rng *r)
{
    float values[PLACES * PLACES];
    duet_heights h;
    shape *s = rough_shape(spacing, values, &h);
    asked *of = test_alloc(MOVER_MOST * sizeof *of);
    mover *m = still();
    m->def.mesh = heights ? NULL : &s->mesh;
    m->def.heights = heights ? &h : NULL;
    for (int i = 0; i < 100; ++i) {
        uint32_t id = add_any(m, r, 0.05, 0.4, rounded ? rng_between(r, 0.02, 0.1) : 0);
        if (!sink(m, id, r, s, (PLACES - 1) * spacing / 4))
            --m->n;
    }
    ask(m, of);
    uint32_t n = m->n;
    for (uint32_t id = 0; id < n; ++id) {
        const box was = box_of(m, id);
        box b = was;
        b.centre = plus(b.centre, 1, way_out(&of[id]));
        if (of[id].n == 0 || reaches_any(s, &b, &was, ground_slop))
            fail_msg("body %u, half %g %g %g, stays deep with %d contacts; spacing %g, heights %d",
                     id, b.half[0], b.half[1], b.half[2], of[id].n, spacing, heights);
    }
    mover_free(m);
    return n;
}

// What contacts ask for together clears every triangle that a body is deeper in than a slop.
TEST(bodies_leave_every_triangle_of_rough_ground)
{
    rng r = ground_drawn = rng_seed(test_seed());
    uint32_t deep = 0;
    for (int i = 0; i < 16; ++i)
        deep += check_rough(i / 8, i / 4 % 2, 0.3 + 0.2 * (i % 4), &r);
    assert_true(deep > 500);
}
