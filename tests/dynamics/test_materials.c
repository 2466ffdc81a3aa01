// SPDX-License-Identifier: MIT
// Materials against closed forms: how far a box slides and how high a ball comes up, for each two
// materials of a table.
#include "support/mover.h"
#include "support/test.h"

static const double g = 9.81;

static double combine(duet_combine rule, double a, double b)
{
    switch (rule) {
    case DUET_COMBINE_AVERAGE:
        return (a + b) / 2;
    case DUET_COMBINE_GEOMETRIC_MEAN:
        return sqrt(a * b);
    case DUET_COMBINE_MIN:
        return fmin(a, b);
    case DUET_COMBINE_PRODUCT:
        return a * b;
    default:
        return fmax(a, b);
    }
}

// Five materials, one for each rule, and a pair of numbers of its own.
static void set_table(duet_motion_def *def)
{
    static const float frictions[] = {0.2f, 0.9f, 0.5f, 0.7f, 0.35f};
    static const float restitutions[] = {0.9f, 0.3f, 0.6f, 0.8f, 0.45f};
    def->n_materials = 5;
    for (int i = 0; i < 5; ++i)
        def->materials[i + 1] = (duet_material){.friction = frictions[i],
                                                .restitution = restitutions[i],
                                                .friction_rule = (duet_combine)i,
                                                .restitution_rule = (duet_combine)(4 - i)};
    def->n_material_pairs = 2;
    def->material_pairs[0] = (duet_material_pair){4, 2, 1.0f, 1.0f}; // the second one counts
    def->material_pairs[1] = (duet_material_pair){2, 4, 0.15f, 0.7f};
}

typedef struct numbers {
    double friction, restitution;
} numbers;

// Said once more, in double: the later of both rules, unless the pair is listed. 0 stands for the
// body's own numbers, and leaves the rule to the other.
static numbers expected_of(const duet_motion_def *def, uint32_t a, uint32_t b, duet_body own)
{
    duet_material none = {own.friction, own.restitution, DUET_COMBINE_AVERAGE,
                          DUET_COMBINE_AVERAGE};
    const duet_material *of_a = a ? &def->materials[a] : &none;
    const duet_material *of_b = b ? &def->materials[b] : &none;
    duet_combine friction =
        of_a->friction_rule > of_b->friction_rule ? of_a->friction_rule : of_b->friction_rule;
    duet_combine restitution = of_a->restitution_rule > of_b->restitution_rule
                                   ? of_a->restitution_rule
                                   : of_b->restitution_rule;
    if (a + b == 6 && a != b && a * b == 8)
        return (numbers){0.15f, 0.7f};
    return (numbers){combine(friction, of_a->friction, of_b->friction),
                     combine(restitution, of_a->restitution, of_b->restitution)};
}

static duet_body own_surface(void)
{
    duet_body own = duet_default_body();
    own.friction = 0.6f;
    own.restitution = 0.5f;
    return own;
}

// A floor of material a with gravity, and something of material b on it.
static mover *make(uint32_t dims, uint32_t a)
{
    mover *m = mover_new(dims);
    set_table(&m->def);
    uint32_t floor = mover_add_floor(m, 100);
    m->bodies[floor].material = a;
    m->bodies[floor].friction = own_surface().friction;
    m->bodies[floor].restitution = own_surface().restitution;
    m->def.substeps = 4;
    m->def.wants |= DUET_EFFECT_FRICTION | DUET_EFFECT_CONTACT_RESPONSE;
    return m;
}

// The same of a ground.
static mover *make_ground(uint32_t a)
{
    static const float level[9] = {0};
    static duet_heights ground = {
        .nx = 3, .ny = 3, .origin = {-51, -52, 0}, .spacing = {50, 50}, .heights = level};
    mover *m = mover_new(3);
    set_table(&m->def);
    ground.material = a;
    m->def.heights = &ground;
    m->def.gravity[2] = -g;
    m->def.substeps = 4;
    m->def.wants |= DUET_EFFECT_CONTACT_RESPONSE;
    return m;
}

static uint32_t add(mover *m, double height, uint32_t material)
{
    double at[3] = {0, 0, 0};
    at[m->def.dims - 1] = height;
    bool solid = m->def.dims == 3;
    uint32_t id = mover_add(m, at[0], at[1], at[2], 0.5, solid ? 0.5 : 0.1, 0.1);
    m->bodies[id].material = material;
    m->bodies[id].friction = own_surface().friction;
    m->bodies[id].restitution = own_surface().restitution;
    return id;
}

// A box of material b on what is of material a, which it glides over: v^2 / (2 mu g).
static void assert_slides(mover *m, uint32_t a, uint32_t b)
{
    const double speed = 3.0, h = m->def.dt / m->def.substeps;
    uint32_t box = add(m, 0.1, b);
    m->bodies[box].velocity[0] = (float)speed;
    double slows = expected_of(&m->def, a, b, own_surface()).friction * g;
    double way = speed * speed / (2 * slows);
    mover_run(m, (uint32_t)(1.1 * speed / slows / m->def.dt) + 10);
    if (!(fabs(m->states[box].centre[0] - way) < speed * h + 0.002 * way))
        fail_msg("%u on %u slides %g m, not %g", b, a, m->states[box].centre[0], way);
    assert_close(m->states[box].velocity[0], 0.0, 1e-4);
    mover_free(m);
}

// The height that a ball which fell from `height` comes up to.
static double top_of_bounce(mover *m, uint32_t ball, double height)
{
    uint32_t up = m->def.dims - 1;
    double top = 0.0, radius = m->bodies[ball].radius;
    bool met = false;
    for (int step = 0; step < (int)(4 * sqrt(2 * height / g) / m->def.dt); ++step) {
        mover_run(m, 1);
        met |= m->states[ball].velocity[up] > 0.0;
        if (met)
            top = fmax(top, m->states[ball].centre[up] - radius);
        if (met && m->states[ball].velocity[up] < 0.0)
            break;
    }
    return top;
}

// Likewise a ball that falls: e^2 times the height.
static void assert_bounces(mover *m, uint32_t a, uint32_t b)
{
    const double height = 4.0, radius = 0.25, h = m->def.dt / m->def.substeps;
    uint32_t ball = add(m, height + radius, b);
    memset(m->poses[ball].half_extents, 0, sizeof m->poses[ball].half_extents);
    m->bodies[ball].radius = (float)radius;
    double e = expected_of(&m->def, a, b, own_surface()).restitution;
    double top = top_of_bounce(m, ball, height), right = e * e * height;
    // A step's view of the top may be half a step away from it.
    double seen = g * m->def.dt * m->def.dt / 8;
    if (!(fabs(top - right) < g * h * h / 2 + seen + 2e-3 * right))
        fail_msg("%u on %u comes up to %g m, not %g", b, a, top, right);
    mover_free(m);
}

// Every two of the table, and of it and bodies without a material.
TEST(a_box_slides_as_far_as_both_materials_say)
{
    for (uint32_t i = 1; i < 36; ++i)
        assert_slides(make(i % 2 ? 2 : 3, i / 6), i / 6, i % 6);
}

TEST(a_ball_comes_up_as_both_materials_say)
{
    for (uint32_t i = 1; i < 36; ++i)
        assert_bounces(make(i % 2 ? 2 : 3, i / 6), i / 6, i % 6);
}

// Bodies of every material, and without one, on grounds of every material.
TEST(a_ground_has_its_material)
{
    for (uint32_t i = 6; i < 36; ++i) {
        assert_slides(make_ground(i / 6), i / 6, i % 6);
        assert_bounces(make_ground(i / 6), i / 6, i % 6);
    }
}

TEST(a_ground_without_a_material_has_that_of_what_touches_it)
{
    mover *m = make_ground(0);
    uint32_t box = add(m, 0.1, 4); // product
    m->bodies[box].velocity[0] = 3.0f;
    mover_run(m, 120);
    double way = 9.0 / (2 * 0.49 * g);
    assert_close(m->states[box].centre[0], way, 3.0 * m->def.dt / 4 + 0.002 * way);
    mover_free(m);
    m = make_ground(6);
    add(m, 1, 1);
    must_fail(duet_motion_create(&m->def, m->poses, m->bodies, m->n, ERR), DUET_STATUS_BAD_ARGUMENT,
              "the ground's material is 6; expected one of the def's 5");
}

static uint64_t hash_of_pile(bool materials, uint32_t dims)
{
    mover *m = mover_new(dims);
    mover_add_floor(m, 20);
    for (int i = 0; i < 40; ++i) {
        double at[3] = {0.3 * (i % 5), 0.3 * (i / 5 % 2), 0.5 + 1.1 * i};
        uint32_t id =
            mover_add(m, at[0], dims == 3 ? at[1] : at[2], dims == 3 ? at[2] : 0, 0.5, 0.5, 0.5);
        m->bodies[id].velocity[dims - 1] = -3.0f;
    }
    m->def.n_materials = materials ? 3 : 0;
    for (uint32_t i = 0; i < m->n; ++i) {
        duet_material *one = &m->def.materials[1 + i % 3];
        one->friction = 0.25f + 0.2f * (float)(i % 3);
        one->restitution = 0.2f * (float)(i % 3);
        m->bodies[i].friction = materials && i % 2 ? 0.0f : one->friction;
        m->bodies[i].restitution = materials && i % 2 ? 0.0f : one->restitution;
        m->bodies[i].material = materials && i % 2 ? 1 + i % 3 : 0;
    }
    mover_run(m, 120);
    return mover_hash(m);
}

// Materials by the rules that bodies have leave no bit different from bodies of their own numbers.
TEST(materials_by_the_usual_rules_are_the_bodies_own_numbers)
{
    assert_true(hash_of_pile(true, 3) == hash_of_pile(false, 3));
    assert_true(hash_of_pile(true, 2) == hash_of_pile(false, 2));
}

// A wall has the material of what touches it.
TEST(a_wall_has_the_material_of_what_touches_it)
{
    mover *m = mover_new(3);
    set_table(&m->def);
    m->def.substeps = 4;
    m->def.boundary = DUET_BOUNDARY_WALLS;
    m->def.gravity[2] = -g;
    for (int k = 0; k < 3; ++k) {
        m->def.lower[k] = k == 2 ? 0 : -50;
        m->def.upper[k] = 50;
    }
    uint32_t box = add(m, 0.1, 4); // product
    m->bodies[box].velocity[0] = 3.0f;
    mover_run(m, 120);
    double way = 9.0 / (2 * 0.49 * g);
    assert_close(m->states[box].centre[0], way, 3.0 * m->def.dt / 4 + 0.002 * way);
}

// A command gives a body another material; a file keeps it.
TEST(a_command_changes_a_material_and_a_file_keeps_it)
{
    mover *m = make(3, 1), *loaded = make(3, 1);
    uint32_t box = add(m, 0.1, 2);
    add(loaded, 0.1, 2);
    m->bodies[box].velocity[0] = loaded->bodies[box].velocity[0] = 3.0f;
    mover_run(m, 0);
    duet_body body = m->bodies[box];
    duet_body_list list = {.first = box, .n = 1};
    body.material = 6;
    must_fail(duet_motion_set_bodies(m->motion, list, DUET_BODY_MATERIAL, &body, ERR),
              DUET_STATUS_BAD_OBJECT, "material");
    body.material = 3; // min(0.2, 0.5), where 2 has sqrt(0.18)
    must(duet_motion_set_bodies(m->motion, list, DUET_BODY_MATERIAL, &body, ERR));
    mover_run(m, 20);
    assert_close(m->states[box].velocity[0], 3.0 - 0.2 * g * m->last.time, 0.02);
    must(duet_motion_save(m->motion, "made", ERR));
    mover_run(loaded, 0);
    must(duet_motion_load(loaded->motion, "made", ERR));
    mover_run_alike(m, loaded, 60);
}

// What a def of materials may not say, and the words that refuse it.
TEST(a_wrong_table_is_refused)
{
    for (int i = 0; i < 7; ++i) {
        static const char *const words[] = {"n_materials", "friction from", "restitution from",
                                            "rules",       "two of",        "n_material_pairs",
                                            "material"};
        duet_pose pose = {.rotation = {0, 0, 0, 1}, .half_extents = {1, 1, 1}};
        duet_body body = duet_default_body();
        duet_motion_def def = duet_default_motion_def();
        def.pair = default_pair();
        set_table(&def);
        body.material = i == 6 ? 6 : 1;
        def.n_materials = i == 0 ? 16 : 5;
        def.materials[2].friction = i == 1 ? -1.0f : 0.0f;
        def.materials[5].restitution = i == 2 ? 1.5f : 0.0f;
        def.materials[5].friction_rule = i == 3 ? (duet_combine)5 : DUET_COMBINE_MIN;
        def.material_pairs[1].a = i == 4 ? 0 : 1;
        def.n_material_pairs = i == 5 ? 121 : 2;
        must_fail(duet_motion_create(&def, &pose, &body, 1, ERR), ANY_FAILURE, words[i]);
    }
}
