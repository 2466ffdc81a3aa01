// SPDX-License-Identifier: MIT
// What a scene does not call for is not there: not in its kernels' arguments, not
// in memory, and not in a single bit of its state.
#define _POSIX_C_SOURCE 200809L
#include "support/mover.h"
#include "support/test.h"

#include "runtime/broadphase/world.h"
#include "runtime/dynamics/motion.h"

static const char path[] = "motion"; // name of the file that a test saves

// ---------------------------------------------------------------- inference

static uint32_t effects_of(mover *m)
{
    mover_run(m, 0);
    return duet_motion_get_effects(m->motion);
}

// A ground that reaches up to the lowest bodies.
static const float uneven_heights[] = {-0.51f, -0.5f,  -0.52f, -0.51f, -0.5f,
                                       -0.52f, -0.51f, -0.5f,  -0.51f};
static const duet_heights uneven = {
    .nx = 3, .ny = 3, .origin = {-1, -1, 0}, .spacing = {2, 2}, .heights = uneven_heights};

TEST(a_still_scene_calls_for_nothing)
{
    mover *m = mover_new(3);
    mover_add_cube(m, 0, 0, 0, 1);
    assert_int_equal(effects_of(m), 0);
}

// Each cause calls for its effect, and for nothing but that and what it needs.
TEST(each_cause_calls_for_its_effect)
{
    enum {
        VELOCITY,
        TURNED,
        TURNING,
        GRAVITY,
        DRAG,
        WALLS,
        ROUGH,
        QUICK,
        GROUPS,
        SKIN,
        RESISTING,
        CONVEYING,
        MADE,
        GROUND,
        CAUSES
    };
    const uint32_t motion = DUET_EFFECT_MOTION;
    const uint32_t push = DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_CONTACT | DUET_EFFECT_MOTION |
                          DUET_EFFECT_ANGULAR_VELOCITY | DUET_EFFECT_ROTATION;
    const uint32_t expected[CAUSES] = {
        [VELOCITY] = motion,
        [TURNED] = motion | DUET_EFFECT_ROTATION,
        [TURNING] = motion | DUET_EFFECT_ANGULAR_VELOCITY | DUET_EFFECT_ROTATION,
        [GRAVITY] = motion | DUET_EFFECT_GRAVITY,
        [DRAG] = motion | DUET_EFFECT_DRAG,
        [WALLS] = motion | DUET_EFFECT_BOUNDARY,
        [ROUGH] = push | DUET_EFFECT_FRICTION,
        [QUICK] = push | DUET_EFFECT_CONTINUOUS,
        [GROUPS] = motion | DUET_EFFECT_CONTACT | DUET_EFFECT_FILTER,
        [RESISTING] = push | DUET_EFFECT_RADIUS | DUET_EFFECT_ROLLING_RESISTANCE,
        [CONVEYING] = push | DUET_EFFECT_FRICTION | DUET_EFFECT_SURFACE_VELOCITY,
        [MADE] = push | DUET_EFFECT_MATERIALS,
        [SKIN] = motion | DUET_EFFECT_CONTACT | DUET_EFFECT_SKIN,
        [GROUND] = motion | DUET_EFFECT_CONTACT | DUET_EFFECT_GROUND,
    };
    for (int cause = 0; cause < CAUSES; ++cause) {
        mover *m = mover_new(3);
        mover_add_cube(m, 0, 0, 0, 1);
        m->bodies[0].velocity[0] = cause == QUICK ? 1000.0f : 1.0f;
        if (cause == TURNED)
            mover_turn(m, 0, 1, 0, 0, 0.5);
        m->bodies[0].angular_velocity[1] = cause == TURNING ? 1.0f : 0.0f;
        m->def.gravity[2] = cause == GRAVITY ? -1.0 : 0.0;
        m->def.drag = cause == DRAG ? 1.0 : 0.0;
        m->def.boundary = cause == WALLS ? DUET_BOUNDARY_WALLS : DUET_BOUNDARY_NONE;
        m->def.upper[0] = m->def.upper[1] = m->def.upper[2] = 10.0;
        m->bodies[0].friction = cause == ROUGH || cause == CONVEYING ? 0.5f : 0.0f;
        m->bodies[0].surface_velocity[1] = cause == CONVEYING ? 0.5f : 0.0f;
        m->bodies[0].material = m->def.n_materials = cause == MADE;
        m->def.materials[1].restitution = 0.5f;
        m->bodies[0].mask = cause == GROUPS ? 1u : UINT32_MAX;
        m->def.skin = cause == SKIN ? 0.1 : 0.0;
        m->bodies[0].rolling_resistance = cause == RESISTING ? 0.1f : 0.0f;
        m->bodies[0].radius = cause == RESISTING ? 0.1f : 0.0f;
        if (cause == QUICK || cause == RESISTING)
            m->def.wants = DUET_EFFECT_CONTACT_RESPONSE;
        m->def.heights = cause == GROUND ? &uneven : NULL;
        if (cause == GROUPS || cause == SKIN || cause == GROUND)
            m->def.wants = DUET_EFFECT_CONTACT;
        uint32_t found = effects_of(m);
        if (found != expected[cause])
            fail_msg("cause %d calls for %x, not %x", cause, found, expected[cause]);
    }
}

// ---------------------------------------------------------------- bit by bit

// The form of a scene: 2D or 3D, floats or doubles.
typedef struct medium {
    uint32_t dims;
    bool doubles;
} medium;

static const medium usual = {3, false};

// A scene in which only the effects of a set are anything but null.
static mover *make_scene_in(medium in, uint32_t set)
{
    mover *m = mover_new(in.dims);
    bool pushes = set & DUET_EFFECT_CONTACT_RESPONSE;
    bool flat = in.dims == 2;
    double apart = pushes ? 1.02 : 6.0;
    const int side = flat ? 5 : 3, n = flat ? 25 : 27;
    m->def.doubles = in.doubles;
    m->def.wants = set & (DUET_EFFECT_SENSORS | DUET_EFFECT_CONTACT | DUET_EFFECT_CONTACT_RESPONSE |
                          DUET_EFFECT_SLEEP | DUET_EFFECT_EVENTS | DUET_EFFECT_SHOCKS |
                          DUET_EFFECT_DEPENETRATION);
    m->def.n_materials = 2;
    m->def.materials[1].friction = set & DUET_EFFECT_FRICTION ? 0.6f : 0.0f;
    m->def.materials[2] = m->def.materials[1];
    m->def.materials[2].friction_rule = DUET_COMBINE_MIN;
    m->def.gravity[1] = set & DUET_EFFECT_GRAVITY ? -3.0 : 0.0;
    m->def.drag = set & DUET_EFFECT_DRAG ? 0.3 : 0.0;
    m->def.skin = set & DUET_EFFECT_SKIN ? 0.1 : 0.0;
    m->def.boundary = set & DUET_EFFECT_BOUNDARY ? DUET_BOUNDARY_WALLS : DUET_BOUNDARY_NONE;
    for (int k = 0; k < 3; ++k) {
        m->def.lower[k] = pushes ? -0.51 : -10.0;
        m->def.upper[k] = pushes ? 1.02 * side - 0.36 : 30.0;
    }
    for (int i = 0; i < n; ++i) {
        uint32_t id = mover_add_cube(m, apart * (i % side), apart * (i / side % side),
                                     apart * (i / side / side), 1);
        duet_body *b = &m->bodies[id];
        for (int k = 0; k < 3; ++k)
            b->velocity[k] = 0.3f * (float)sin(3 * i + 7 * k);
        b->fixed_rotation = !(pushes && (set & DUET_EFFECT_ANGULAR_VELOCITY));
        if (set & DUET_EFFECT_ROTATION)
            mover_turn(m, id, !flat, flat ? 0 : i % 4, flat ? 1 : i % 3,
                       (pushes ? 0.001 : 0.05) * i);
        if (set & DUET_EFFECT_ANGULAR_VELOCITY)
            b->angular_velocity[flat ? 2 : i % 3] = 0.5f + 0.1f * (float)i;
        b->friction = set & DUET_EFFECT_FRICTION ? 0.4f : 0.0f;
        b->rolling_resistance = set & DUET_EFFECT_ROLLING_RESISTANCE ? 0.05f : 0.0f;
        b->material = set & DUET_EFFECT_MATERIALS ? (uint32_t)i % 3 : 0;
        b->surface_velocity[i % 2] = set & DUET_EFFECT_SURFACE_VELOCITY ? 0.3f : 0.0f;
        if (set & DUET_EFFECT_RADIUS) {
            b->radius = i % 2 ? 0.1f : 0.5f; // a sphere
            for (int k = 0; k < 3; ++k)
                m->poses[id].half_extents[k] = 0.5f - b->radius;
        }
        b->group = set & DUET_EFFECT_FILTER ? 1u << i % 2 : UINT32_MAX;
        b->mask = set & DUET_EFFECT_FILTER ? 1u << i % 3 : UINT32_MAX;
    }
    if (set & DUET_EFFECT_GROUND && !flat)
        m->def.heights = &uneven;
    if (set & DUET_EFFECT_CONTINUOUS)
        m->bodies[n - 1].velocity[in.dims - 1] = -200.0f;
    return m;
}

static mover *make_scene(uint32_t set)
{
    return make_scene_in(usual, set);
}

static void assert_same_state(medium in, uint32_t set, uint32_t more)
{
    mover *special = make_scene_in(in, set);
    mover *general = make_scene_in(in, set);
    general->def.wants |= more;
    for (int k = 0; k < 4; ++k) {
        mover_run(special, 4);
        mover_run(general, 4);
        if (mover_hash(special) != mover_hash(general))
            fail_msg("%uD, %s: effects %x and %x differ after %d steps", in.dims,
                     in.doubles ? "doubles" : "floats", duet_motion_get_effects(special->motion),
                     duet_motion_get_effects(general->motion), 4 * (k + 1));
    }
    assert_int_equal(duet_motion_get_effects(general->motion) & more, more);
    assert_int_not_equal(duet_motion_get_effects(special->motion),
                         duet_motion_get_effects(general->motion));
}

static const uint32_t effects[] = {
    DUET_EFFECT_ROTATION,
    DUET_EFFECT_ANGULAR_VELOCITY,
    DUET_EFFECT_GRAVITY,
    DUET_EFFECT_DRAG,
    DUET_EFFECT_BOUNDARY,
    DUET_EFFECT_CONTACT,
    DUET_EFFECT_CONTACT_RESPONSE,
    DUET_EFFECT_FRICTION,
    DUET_EFFECT_CONTINUOUS,
    DUET_EFFECT_FILTER,
    DUET_EFFECT_SLEEP,
    DUET_EFFECT_SKIN,
    DUET_EFFECT_EVENTS,
    DUET_EFFECT_SENSORS,
    DUET_EFFECT_RADIUS,
    DUET_EFFECT_ROLLING_RESISTANCE,
    DUET_EFFECT_SURFACE_VELOCITY,
    DUET_EFFECT_MATERIALS,
    DUET_EFFECT_SHOCKS,
    DUET_EFFECT_DEPENETRATION,
    DUET_EFFECT_GROUND,
};

enum { N_EFFECTS = sizeof effects / sizeof effects[0] };

static uint32_t with_needs(uint32_t set)
{
    const uint32_t needs_response = DUET_EFFECT_FRICTION | DUET_EFFECT_CONTINUOUS |
                                    DUET_EFFECT_SLEEP | DUET_EFFECT_ROLLING_RESISTANCE |
                                    DUET_EFFECT_SURFACE_VELOCITY | DUET_EFFECT_MATERIALS |
                                    DUET_EFFECT_SHOCKS | DUET_EFFECT_DEPENETRATION;
    set |= set & DUET_EFFECT_ROLLING_RESISTANCE ? DUET_EFFECT_RADIUS | DUET_EFFECT_ANGULAR_VELOCITY
                                                : 0;
    set |= set & DUET_EFFECT_SURFACE_VELOCITY ? DUET_EFFECT_FRICTION | DUET_EFFECT_ROTATION : 0;
    set |= set & DUET_EFFECT_SENSORS ? DUET_EFFECT_EVENTS : 0;
    const uint32_t needs_contact = DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_FILTER |
                                   DUET_EFFECT_SKIN | DUET_EFFECT_EVENTS | DUET_EFFECT_RADIUS |
                                   DUET_EFFECT_GROUND;
    set |= set & needs_response ? DUET_EFFECT_CONTACT_RESPONSE : 0;
    return set | (set & needs_contact ? DUET_EFFECT_CONTACT : 0);
}

static bool is_in(uint32_t set, const uint32_t *sets, int n)
{
    for (int i = 0; i < n; ++i)
        if (sets[i] == set)
            return true;
    return false;
}

// Pairs of effects: the step with these alone equals the step with every effect, bit
// for bit. All pairs are some hundreds of kernels.
TEST(pairs_of_effects_equal_the_general_step)
{
    uint32_t done[N_EFFECTS * N_EFFECTS];
    int n_done = 0;
    for (int i = 0; i < N_EFFECTS; ++i)
        for (int j = i; j < N_EFFECTS; ++j) {
            uint32_t set = with_needs(effects[i] | effects[j]);
            if (!is_in(set, done, n_done) && test_takes((uint64_t)i + j, 10))
                assert_same_state(usual, set, DUET_EFFECT_ALL);
            done[n_done++] = set;
        }
}

TEST(sampled_sets_equal_the_general_step)
{
    uint64_t seed = test_seed();
    for (int round = 0; round < 2; ++round) {
        seed = seed * UINT64_C(6364136223846793005) + 1442695040888963407u;
        assert_same_state(usual,
                          with_needs((uint32_t)(seed >> 33) & (DUET_EFFECT_ALL ^ DUET_EFFECT_SKIN)),
                          DUET_EFFECT_ALL);
    }
}

// Contacts are solved in float, so that with doubles a flight alone is another
// one than in a step that could push.
static uint32_t general_in(medium in, uint32_t set)
{
    const uint32_t pushes = DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_FRICTION |
                            DUET_EFFECT_CONTINUOUS | DUET_EFFECT_SLEEP |
                            DUET_EFFECT_ROLLING_RESISTANCE | DUET_EFFECT_SURFACE_VELOCITY |
                            DUET_EFFECT_MATERIALS | DUET_EFFECT_SHOCKS | DUET_EFFECT_DEPENETRATION;
    bool flies = in.doubles && !(set & DUET_EFFECT_CONTACT_RESPONSE);
    return flies ? DUET_EFFECT_ALL & ~pushes : DUET_EFFECT_ALL;
}

// Each effect with what it needs, in the other media.
TEST(each_effect_equals_the_general_step_in_2d_and_in_doubles)
{
    static const medium media[] = {{2, false}, {2, true}, {3, true}};
    for (int k = 0; k < 3; ++k) {
        uint32_t done[N_EFFECTS];
        for (int i = 0; i < N_EFFECTS; ++i) {
            uint32_t set = with_needs(effects[i]);
            if (!is_in(set, done, i) && test_takes((uint64_t)i + k, 6))
                assert_same_state(media[k], set, general_in(media[k], set));
            done[i] = set;
        }
    }
}

// ---------------------------------------------------------------- kernels

static bool has_param(gen *g, const char *name, const gen_limits *limits, const char *param)
{
    const gen_param *params = NULL;
    uint32_t n = 0;
    must(gen_params(g, name, limits, &params, &n, ERR));
    for (uint32_t i = 0; i < n; ++i)
        if (strcmp(params[i].name, param) == 0 && params[i].n_values > 1)
            return true;
    return false;
}

// Every effect's parameter, its name, and a word of the arguments that only it calls for.
static const struct {
    const char *param;
    const char *effect;
    const char *word;    // NULL: it has no arguments of its own
    const char *off_too; // effects that need it
} words[] = {
    {"ANGULAR_VELOCITY", "angular_velocity", "angular_velocit", "GYRO ROLLING"},
    {"GRAVITY", "gravity", "gravity", NULL},
    {"DRAG", "drag", "drag", NULL},
    {"BOUNDARY", "boundary", "upper", NULL},
    {"CONTACT_RESPONSE", "contact_response", "colours",
     "FRICTION CONVEYS MATERIALS ROLLING CONTINUOUS SLEEP HITS"},
    {"FRICTION", "friction", "friction", "CONVEYS"},
    {"CONTINUOUS", "continuous", NULL, NULL},
    {"FILTER", "filter", "filter", NULL},
    {"SLEEP", "sleep", "asleep", NULL},
    {"SKIN", "skin", "skin", NULL},
    {"HITS", "events", "hits", NULL},
    {"FORCES", "forces", "forces", NULL},
    {"SENSORS", "sensors", "sensors", NULL},
    {"ROUNDED", "radius", NULL, NULL},
    {"MATERIALS", "materials", "material", NULL},
    {"CONVEYS", "surface_velocity", "surface_velocities", NULL},
    {"ROLLING", "rolling_resistance", "rolling_resistances", NULL},
    {"GROUND", "ground", "ground_origin", NULL},
    {"ROTATED", "rotation", "rotations", "ANGULAR_VELOCITY GYRO ROLLING"},
};

enum { N_WORDS = sizeof words / sizeof words[0] };

static const char *const kernels[] = {
    "integrate_free_flight", "fat_aabbs",      "contact_graph",  "match_contacts",
    "build_manifolds",       "update_sleep",   "graph_colour",   "colour_contacts",
    "prepare_contacts",      "bodies",         "solve_contacts", "solve_substeps",
    "integrate_positions",   "contact_events", "awake"};

enum { N_KERNELS = sizeof kernels / sizeof kernels[0] };

// The kernel with every effect on, or with all but one.
static gen_variant variant_without(gen *g, const char *name, const gen_limits *limits, int off)
{
    gen_setting settings[N_WORDS + 1];
    uint32_t n = 0;
    for (int i = 0; i <= N_WORDS; ++i) {
        const char *param = i < N_WORDS ? words[i].param : "GYRO";
        if (!has_param(g, name, limits, param))
            continue;
        bool is_off = off >= 0 && (strcmp(param, words[off].param) == 0 ||
                                   (words[off].off_too && strstr(words[off].off_too, param)));
        settings[n++] = (gen_setting){param, !is_off};
    }
    gen_variant v = {0};
    must(gen_make(g, name, settings, n, limits, &v, ERR));
    return v;
}

static bool takes(const gen_variant *v, const char *word)
{
    for (uint32_t e = 0; e < v->n_entries; ++e)
        for (uint32_t i = 0; i < v->entries[e].n_args; ++i)
            if (strstr(v->entries[e].args[i].name, word))
                return true;
    return false;
}

static uint32_t n_arguments(const gen_variant *v)
{
    uint32_t n = 0;
    for (uint32_t e = 0; e < v->n_entries; ++e)
        n += v->entries[e].n_args;
    return n;
}

// The parameter is the constant 0 in the text, so its code is not compiled, and no kernel takes
// what the effect alone would read.
TEST(kernels_take_no_argument_of_what_is_left_out)
{
    const gen_limits limits = {.max_group = 1024, .local_bytes = 49152, .fp64 = true};
    gen *g = kept(gen_open(NULL, ERR));
    int checked = 0;
    for (size_t k = 0; k < N_KERNELS; ++k) {
        own(gen_variant) all = variant_without(g, kernels[k], &limits, -1);
        for (int w = 0; w < N_WORDS; ++w) {
            if (!has_param(g, kernels[k], &limits, words[w].param))
                continue;
            own(gen_variant) v = variant_without(g, kernels[k], &limits, w);
            char defined[80];
            snprintf(defined, sizeof defined, "#define %s 1\n", words[w].param);
            assert_says(all.text, defined);
            assert_null(strstr(v.text, defined));
            assert_true(n_arguments(&v) <= n_arguments(&all));
            if (words[w].word && takes(&all, words[w].word)) {
                if (takes(&v, words[w].word))
                    fail_msg("%s without %s takes '%s'", kernels[k], words[w].param, words[w].word);
                ++checked;
            }
        }
    }
    assert_true(checked >= 20);
}

// The kernel with every effect on but the ground, or with heights.
static gen_variant variant_of_ground(gen *g, const char *name, const gen_limits *limits, int ground)
{
    gen_setting settings[N_WORDS + 1];
    uint32_t n = 0;
    for (int i = 0; i < N_WORDS; ++i)
        if (has_param(g, name, limits, words[i].param))
            settings[n++] =
                (gen_setting){words[i].param, strcmp(words[i].param, "GROUND") == 0 ? ground : 1};
    gen_variant v = {0};
    must(gen_make(g, name, settings, n, limits, &v, ERR));
    return v;
}

// Not even as a member of a struct, which a kernel with a mesh has.
TEST(no_text_names_a_mesh_or_a_ground_that_is_not_there)
{
    static const char *const of_mesh[] = {"mesh_", "MESH_", "carrier", "CARRIED"};
    static const char *const of_ground[] = {"ground_", "heights"};
    const gen_limits limits = {.max_group = 1024, .local_bytes = 49152, .fp64 = true};
    gen *g = kept(gen_open(NULL, ERR));
    for (size_t k = 0; k < N_KERNELS; ++k)
        for (int ground = 0; ground < 2; ++ground) {
            own(gen_variant) v = variant_of_ground(g, kernels[k], &limits, ground);
            for (size_t w = 0; w < sizeof of_mesh / sizeof *of_mesh; ++w)
                if (strstr(v.text, of_mesh[w]))
                    fail_msg("%s with GROUND %d names '%s'", kernels[k], ground, of_mesh[w]);
            for (size_t w = 0; ground == 0 && w < sizeof of_ground / sizeof *of_ground; ++w)
                if (strstr(v.text, of_ground[w]))
                    fail_msg("%s without a ground names '%s'", kernels[k], of_ground[w]);
        }
}

// Every kernel that an effect changes is among those that explain names.
TEST(an_effect_names_all_its_kernels)
{
    const gen_limits limits = {.max_group = 1024, .local_bytes = 49152, .fp64 = true};
    gen *g = kept(gen_open(NULL, ERR));
    mover *m = make_scene(0);
    mover_run(m, 1);
    int checked = 0;
    for (int w = 0; w < N_WORDS; ++w) {
        duet_effect_info info = {0};
        uint32_t i = 0;
        while (duet_motion_explain(m->motion, i, &info) && strcmp(info.name, words[w].effect) != 0)
            ++i;
        assert_string_equal(info.name, words[w].effect);
        for (size_t k = 0; k < N_KERNELS; ++k) {
            if (!has_param(g, kernels[k], &limits, words[w].param))
                continue;
            if (!strstr(info.kernels, kernels[k]))
                fail_msg("%s: '%s' lacks %s", info.name, info.kernels, kernels[k]);
            ++checked;
        }
    }
    assert_in_range(checked, 30, 100);
}

// ---------------------------------------------------------------- memory

// An effect adds its buffers, and without it they are empty.
TEST(buffers_are_those_that_are_called_for)
{
    static const struct {
        uint32_t effect;
        motion_buffer buffer;
    } owned[] = {
        {DUET_EFFECT_ROTATION, ROTATIONS},
        {DUET_EFFECT_ANGULAR_VELOCITY, ANGULAR_VELOCITIES},
        {DUET_EFFECT_ANGULAR_VELOCITY, INERTIAS},
        {DUET_EFFECT_CONTACT, BOXES},
        {DUET_EFFECT_CONTACT, CONTACTS},
        {DUET_EFFECT_CONTACT, FLAG_WORDS},
        {DUET_EFFECT_CONTACT_RESPONSE, BODIES},
        {DUET_EFFECT_CONTACT_RESPONSE, BLOCKS},
        {DUET_EFFECT_FRICTION, FRICTIONS},
        {DUET_EFFECT_ROLLING_RESISTANCE, ROLLING_RESISTANCES},
        {DUET_EFFECT_SURFACE_VELOCITY, SURFACE_VELOCITIES},
        {DUET_EFFECT_MATERIALS, MATERIALS_OF},
        {DUET_EFFECT_MATERIALS, MATERIAL_RULES},
        {DUET_EFFECT_SHOCKS, SHOCKED},
        {DUET_EFFECT_FILTER, FILTERS},
        {DUET_EFFECT_SLEEP, ASLEEP},
        {DUET_EFFECT_SLEEP, AWAKE},
        {DUET_EFFECT_EVENTS, TOUCHING},
        {DUET_EFFECT_SENSORS, SENSORS},
        {DUET_EFFECT_FORCES, FORCES},
    };
    for (int i = 0; i < N_EFFECTS; ++i) {
        mover *m = make_scene(with_needs(effects[i]));
        mover_run(m, 1);
        for (size_t k = 0; k < sizeof owned / sizeof owned[0]; ++k) {
            bool called = duet_motion_get_effects(m->motion) & owned[k].effect;
            assert_int_equal(m->motion->buffers[owned[k].buffer].mem != NULL, called);
        }
    }
}

// Kernels too: free flight is one, and a still scene has none.
TEST(kernels_are_those_that_are_called_for)
{
    mover *m = make_scene(0);
    mover_run(m, 1);
    motion_kernels only = {{NULL}};
    only.of[INTEGRATE_FREE_FLIGHT] = m->motion->kernels.of[INTEGRATE_FREE_FLIGHT];
    assert_memory_equal(&m->motion->kernels, &only, sizeof only);
    cl_uint n_args = 0;
    clGetKernelInfo(only.of[INTEGRATE_FREE_FLIGHT]->cl, CL_KERNEL_NUM_ARGS, sizeof n_args, &n_args,
                    NULL);
    assert_int_equal(n_args, 5); // centres, velocities, times, substeps, n
    assert_int_equal(m->last.n_stages, 1);
    m = mover_new(3);
    mover_add_cube(m, 0, 0, 0, 1);
    mover_run(m, 1);
    only.of[INTEGRATE_FREE_FLIGHT] = NULL;
    assert_memory_equal(&m->motion->kernels, &only, sizeof only);
    assert_int_equal(m->last.n_stages, 0);
}

// On a device with memory of its own each step has times only where that is asked for.
TEST(stages_have_times_where_they_are_asked_for)
{
    bool *host = &default_pair()->devices[1].info.host_memory, had = *host;
    *host = false;
    mover *m = make_scene(0);
    for (int k = 0; k < 36; ++k) {
        double last_ms = k > 0 ? m->last.stages[0].ms : 0.0;
        if (k > 0)
            m->motion->def.stage_times = k > 33;
        mover_run(m, 1);
        assert_int_equal(m->last.n_stages, 1);
        assert_true(m->last.timed == (k % 16 == 0 || k > 33));
        assert_true(m->last.timed || m->last.stages[0].ms == last_ms);
    }
    *host = had;
}

TEST(explain_tells_effects_and_bytes)
{
    static const uint32_t four_bytes[] = {DUET_EFFECT_FRICTION, DUET_EFFECT_SENSORS};
    for (int k = 0; k < 2; ++k) {
        mover *m = make_scene(with_needs(four_bytes[k]));
        mover_run(m, 1);
        duet_effect_info info;
        uint32_t active = 0;
        for (uint32_t i = 0; duet_motion_explain(m->motion, i, &info); ++i) {
            active += info.active;
            assert_true(strlen(info.called_by) > 3 && strlen(info.kernels) > 3);
            assert_true(info.active || info.bytes == 0);
            if (strcmp(info.name, duet_effect_name(four_bytes[k])) == 0)
                assert_int_equal(info.bytes, 4);
        }
        assert_int_equal(active, __builtin_popcount(duet_motion_get_effects(m->motion)));
    }
}

// ---------------------------------------------------------------- launches

// The commands of a step to B: kernels, and reads that the host waits for.
typedef struct traffic {
    uint32_t launches, waits;
} traffic;

static traffic step_once(mover *m)
{
    must(duet_motion_advance(m->motion, &m->last, ERR));
    const timeline *own = &m->motion->times, *search = &m->motion->graph.world->parts[1].times;
    bool searched = m->last.rebuilt;
    return (traffic){own->n_launches + (searched ? search->n_launches : 0),
                     own->n_waits + (searched ? search->n_waits : 0)};
}

// A pile this small has no colour that needs more than a work-group. Only the number of rounds
// of the colouring varies, at two launches each; a launch for each colour and
// substep would be 50 more.
TEST(launches_do_not_grow_with_colours)
{
    mover *m = mover_new(3);
    mover_add_pile(m, 100);
    m->def.wants |= DUET_EFFECT_SLEEP;
    m->def.skin = 0.05;
    m->def.plan.share = 0;
    m->def.plan.mode = DUET_MODE_OWN;
    mover_run(m, 60);
    uint32_t colours = 0;
    for (int step = 0; step < 20; ++step) {
        traffic t = step_once(m);
        colours = m->last.colours > colours ? m->last.colours : colours;
        if (t.launches > 90 || t.waits > 5)
            fail_msg("step %d: %u launches, %u reads", step, t.launches, t.waits);
    }
    assert_true(colours >= 6);
    assert_null(m->motion->buffers[PAIRS].mem); // they stayed where B found them
}

static mover *make_sleepers(void)
{
    mover *m = mover_new(3);
    mover_add_floor(m, 10);
    for (int i = 0; i < 4; ++i)
        mover_add_rough_cube(m, 2 * i, 0, 0.5);
    m->def.wants |= DUET_EFFECT_SLEEP;
    m->def.skin = 0.05;
    return m;
}

// A change of a motion from outside is a load.
TEST(a_step_at_rest_sends_nothing)
{
    mover *m = make_sleepers();
    mover_run(m, 9);
    assert_true(step_once(m).launches > 0);
    must(duet_motion_save(m->motion, path, ERR));
    mover_run(m, 50);
    uint64_t hash = mover_hash(m);
    traffic t = step_once(m);
    assert_int_equal(m->last.step, 61);
    assert_int_equal(m->last.contacts, 0);
    assert_int_equal(t.launches, 0);
    assert_int_equal(t.waits, 0);
    assert_true(mover_hash(m) == hash);
    must(duet_motion_load(m->motion, path, ERR));
    assert_true(step_once(m).launches > 0);
    assert_int_equal(m->last.step, 11);
}

// A cube slides over a floor where others sleep: nothing begins to push, and nothing falls asleep.
TEST(a_step_like_the_last_one_waits_once)
{
    mover *m = make_sleepers();
    uint32_t cube = mover_add_cube(m, 0, 4, 0.5, 1);
    m->bodies[cube].velocity[0] = 1.0f;
    mover_run(m, 100);
    for (int step = 0; step < 20; ++step) {
        traffic t = step_once(m);
        assert_int_equal(m->last.contacts, 1);
        if (!m->last.rebuilt && (t.launches > 7 || t.waits != 1))
            fail_msg("step %d: %u launches, %u reads", step, t.launches, t.waits);
    }
}

static uint32_t count_searches(mover *m, uint32_t steps)
{
    uint32_t searches = 0;
    for (uint32_t step = 0; step < steps; ++step) {
        step_once(m);
        searches += m->last.rebuilt;
    }
    return searches;
}

// 2 000 cubes sleep in rows along x, where y is 0 or more.
static mover *make_many_sleepers(void)
{
    mover *m = mover_new(3);
    mover_add_floor(m, 100);
    for (int i = 0; i < 2000; ++i)
        mover_add_rough_cube(m, 1.5 * (i % 50), 1.5 * (i / 50), 0.5);
    m->def.wants |= DUET_EFFECT_SLEEP;
    m->def.skin = 0.05;
    return m;
}

TEST(pairs_are_searched_seldom_where_few_are_awake)
{
    mover *m = make_many_sleepers();
    uint32_t ball = mover_add(m, 0, -3, 0.5, 0, 0, 0);
    m->bodies[ball].radius = 0.5f;
    m->bodies[ball].friction = 0.5f;
    m->bodies[ball].velocity[0] = 0.5f;
    m->bodies[ball].angular_velocity[1] = 1.0f;
    mover_run(m, 100);
    uint32_t searches = count_searches(m, 500);
    mover_run(m, 0);
    assert_close(m->states[ball].centre[0], 5.0, 0.1); // it rolls on
    if (searches > 5)
        fail_msg("%u searches in 500 steps", searches);
}

TEST(pairs_are_searched_seldom_for_what_fell_off_the_floor)
{
    mover *m = make_many_sleepers();
    uint32_t cube = mover_add_cube(m, 0, -300, 0.5, 1);
    mover_run(m, 200);
    uint32_t searches = count_searches(m, 600);
    mover_run(m, 0);
    assert_true(m->states[cube].centre[2] < -800.0);
    if (searches > 7)
        fail_msg("%u searches in 600 steps", searches);
}

// The cubes fly past each other so fast that each step searches pairs. The second one comes near
// later on.
TEST(rows_without_contacts_are_made_once)
{
    mover *m = mover_new(3);
    mover_add_cube(m, 0, 0, 0, 1);
    mover_add_cube(m, 60, 0, 0, 1);
    m->def.wants |= DUET_EFFECT_CONTACT_RESPONSE;
    m->def.skin = 0.001;
    m->bodies[0].velocity[0] = 60.0f;
    uint32_t left_out = 0, most_pairs = 0;
    for (int step = 0; step < 80; ++step) {
        mover_run(m, 1);
        assert_true(m->last.rebuilt);
        left_out += !mover_has_stage(m, "contact_graph");
        most_pairs = m->last.pairs > most_pairs ? m->last.pairs : most_pairs;
        assert_true(mover_has_stage(m, "contact_graph") || m->last.pairs == 0);
    }
    assert_int_equal(most_pairs, 1);
    assert_true(left_out > 50);
    assert_close(m->states[0].velocity[0] + m->states[1].velocity[0], 60.0, 1e-3);
    assert_true(m->states[1].velocity[0] > 1.0f); // they met
}

TEST(what_moves_without_mass_keeps_a_step_from_resting)
{
    mover *m = make_sleepers();
    uint32_t cart = mover_add_fixed(m, 0, 5, 3, 0.5, 0.5, 0.5);
    m->bodies[cart].velocity[0] = 0.5f;
    mover_run(m, 60);
    assert_int_equal(m->last.contacts, 0); // the others sleep
    assert_true(step_once(m).launches > 0);
    assert_close(m->states[cart].centre[0], 0.5, 1e-4);
}

// ---------------------------------------------------------------- files

// Saved in the middle, loaded into another motion, it goes on bit for bit.
TEST(a_loaded_motion_goes_on_as_the_saved_one)
{
    static const uint32_t wants[] = {0, DUET_EFFECT_SLEEP, DUET_EFFECT_EVENTS};
    for (int i = 0; i < 6; ++i) {
        uint32_t set =
            with_needs(DUET_EFFECT_ROTATION | DUET_EFFECT_ANGULAR_VELOCITY |
                       DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_GRAVITY | DUET_EFFECT_BOUNDARY |
                       wants[i % 3] | (i < 3 ? 0 : DUET_EFFECT_SKIN));
        mover *saved = make_scene(set);
        mover *loaded = make_scene(set);
        mover_run(saved, 60);
        must(duet_motion_save(saved->motion, path, ERR));
        mover_run(loaded, 0);
        must(duet_motion_load(loaded->motion, path, ERR));
        for (int k = 0; k < 3; ++k) {
            assert_true(mover_hash(saved) == mover_hash(loaded));
            mover_run(saved, 20);
            mover_run(loaded, 20);
        }
        assert_int_equal(loaded->last.step, 120);
    }
}

TEST(a_damaged_file_is_refused)
{
    mover *m = make_scene(with_needs(DUET_EFFECT_CONTACT_RESPONSE));
    mover_run(m, 5);
    must(duet_motion_save(m->motion, path, ERR));
    FILE *f = fopen(path, "r+b");
    assert_non_null(f);
    fseek(f, 200, SEEK_SET);
    fputc(0x55, f);
    fclose(f);
    must_fail(duet_motion_load(m->motion, path, ERR), DUET_STATUS_BAD_INPUT, "");
    mover *other = make_scene(0);
    mover_run(other, 1);
    must_fail(duet_motion_load(other->motion, path, ERR), DUET_STATUS_BAD_INPUT, "effects");
}
