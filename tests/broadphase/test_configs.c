// SPDX-License-Identifier: MIT
// Whatever config a kernel has, a step that runs it finds the reference's pairs
// and writes nothing beside its buffers.
//
// By itself the program takes a sample of each kernel's configs. With --all it
// takes every config of small spaces and a larger sample of the others; a kernel's
// name behind it leaves out the other kernels.
#include "guard/guard.h"
#include "support/devices.h"
#include "support/test.h"

#include "base/text.h"
#include "runtime/broadphase/world.h"
#include "runtime/scene/reference.h"

// Slabs have space for some hundred objects more than they get.
enum {
    FEW = 700,
    OBJECTS = 3000,
    MOST_PARAMS = 24,
    SAMPLE = 1,
    WHOLE_SPACE = 64,
    LARGE_SAMPLE = 64
};

static gen *generator;

static void begin(void)
{
    generator = kept(gen_open(NULL, ERR));
}

// ------------------------------------------------------------ configs

// The kernels of a step, and the searches that run them.
typedef struct subject {
    const char *kernel;
    const char *searches[3];
} subject;

static const subject subjects[] = {
    {"clear", {"gpu", "simd", "paper"}},
    {"hash", {"gpu", "simd"}},
    {"scan", {"gpu", "simd", "paper"}},
    {"scatter", {"gpu", "simd"}},
    {"radix", {"gpu sort=radix", "simd sort=radix", "paper"}},
    {"cell_start", {"gpu sort=radix", "simd sort=radix", "paper"}},
    {"bounds", {"paper"}},
    {"reorder", {"gpu"}},
    {"reorder_simd", {"simd"}},
    {"pair_search_paper", {"paper"}},
    {"pair_search_gpu", {"gpu"}},
    {"pair_search_simd", {"simd"}},
    {"narrow", {"gpu pair_search_gpu.FUSED=0"}},
    {"narrow_simd", {"simd pair_search_simd.FUSED=0"}},
};

enum { SUBJECTS = sizeof subjects / sizeof *subjects };

typedef struct config {
    const char *kernel;
    const char *const *searches;
    const gen_param *params;
    uint32_t n;
    gen_setting settings[MOST_PARAMS];
} config;

static int64_t value_of(const config *c, const char *name, int64_t otherwise)
{
    for (uint32_t i = 0; i < c->n; ++i)
        if (strcmp(c->settings[i].name, name) == 0)
            return c->settings[i].value;
    return otherwise;
}

static bool is_tested(const config *c)
{
    return value_of(c, "SHAPE", 0) == DUET_SHAPE_POSES &&
           value_of(c, "ACCURACY", 0) != DUET_LEVEL_AABB;
}

// Whether there is a scene that runs it: where nothing is rotated most levels
// are one, bounds have none, and what is not tested is listed by id.
static bool is_called_for(const config *c)
{
    duet_level level = (duet_level)value_of(c, "ACCURACY", DUET_LEVEL_CERTIFIED);
    bool narrow = strncmp(c->kernel, "narrow", 6) == 0;
    if (level != DUET_LEVEL_CERTIFIED && !value_of(c, "ROTATED", 1) && !level_tests_upright(level))
        return false;
    if (level != DUET_LEVEL_CERTIFIED && value_of(c, "SHAPE", 0) == DUET_SHAPE_BOUNDS)
        return false;
    if (value_of(c, "PACKED", 0) && (value_of(c, "GRID", 0) || value_of(c, "LEVELS", 0)))
        return false;
    if (strcmp(c->kernel, "pair_search_gpu") == 0 && value_of(c, "IDS", 0) == is_tested(c))
        return false;
    return !narrow || is_tested(c);
}

// ------------------------------------------------------------ scenes

typedef struct scene {
    uint32_t dims;
    duet_shape shape;
    bool rotated;
    duet_level level;
    bool hashed, levels, roomy, packed;
    duet_pose_form form;
    bool fixed; // its cells are compiled in
    uint32_t n;
    duet_pose poses[OBJECTS];
    duet_bounds bounds[OBJECTS];
} scene;

// Extents of one size stay in one octave however they are turned.
static float half_of(const scene *s, rng *r)
{
    if (!s->levels)
        return 0.55f;
    return rng_below(r, 32) ? 0.05f : 1.6f;
}

static duet_pose random_pose(const scene *s, rng *r)
{
    double width = s->dims == 3 ? cbrt(s->n) : 1.2 * sqrt(s->n);
    float half = half_of(s, r);
    duet_pose p = {.half_extents = {half, half, half}, .rotation = {0, 0, 0, 1}};
    for (int k = 0; k < 3; ++k)
        p.centre[k] = (float)rng_between(r, 0, k == 0 && !s->roomy ? 2.0 : width);
    for (int k = 0; s->rotated && k < 4; ++k)
        p.rotation[k] = (float)rng_normal(r);
    // Compact ones are these very numbers.
    for (int k = 0; s->rotated && s->form == DUET_POSE_COMPACT && k < 4; ++k)
        p.rotation[k] = k < 3 ? 32767.0f - (float)rng_below(r, 65535) : 32767.0f;
    return p;
}

static void fill(scene *s, rng *r)
{
    for (uint32_t i = 0; i < s->n; ++i) {
        s->poses[i] = random_pose(s, r);
        s->bounds[i] = bounds_of_upright(&s->poses[i]);
    }
}

// A scene that calls for the config; what the config leaves open is drawn.
static void make_scene(scene *s, const config *c, rng *r)
{
    *s = (scene){
        .dims = (uint32_t)value_of(c, "DIMS", 2 + rng_below(r, 2)),
        .level = (duet_level)value_of(c, "ACCURACY", DUET_LEVEL_CERTIFIED),
        .hashed = value_of(c, "GRID", 0),
        .levels = value_of(c, "LEVELS", 0),
        .packed = value_of(c, "PACKED", 0),
        .form = (duet_pose_form)value_of(c, "APART", 0),
    };
    int64_t bounds = strcmp(c->kernel, "pair_search_paper") == 0 ? value_of(c, "IDS", 0) : 0;
    s->shape = (duet_shape)value_of(c, "SHAPE", bounds);
    s->rotated = s->shape == DUET_SHAPE_POSES && value_of(c, "ROTATED", rng_below(r, 2));
    s->roomy = value_of(c, "ROOMY", s->hashed || s->levels || rng_below(r, 4));
    s->fixed = !s->hashed && !s->levels && !s->packed && rng_below(r, 2);
    bool of_many = s->levels || value_of(c, "ROOMY", 0);
    s->n = s->packed ? OBJECTS : of_many ? FEW : 1 + rng_below(r, FEW);
    fill(s, r);
}

// ------------------------------------------------------------ steps

static bool is_decided_by_scene(const char *name)
{
    static const char *const decided[] = {"DIMS",   "SHAPE",  "ROTATED", "ACCURACY",
                                          "GRID",   "LEVELS", "ROOMY",   "RANK",
                                          "SORTED", "IDS",    "PACKED",  "APART"};
    for (size_t i = 0; i < sizeof decided / sizeof *decided; ++i)
        if (strcmp(decided[i], name) == 0)
            return true;
    return false;
}

static const char *choose_search(const config *c, rng *r)
{
    if (value_of(c, "PACKED", 0))
        return "gpu send=packed";
    if (strcmp(c->kernel, "narrow") == 0)
        return value_of(c, "SORTED", 1) ? c->searches[0] : "paper";
    uint32_t n = c->searches[2] ? 3 : c->searches[1] ? 2 : 1;
    return c->searches[rng_below(r, n)];
}

// Settings where the card does otherwise. Only one kernel of a step has the longer names.
static void add_setting(text *t, const config *c, uint32_t i)
{
    const gen_setting *setting = &c->settings[i];
    bool untested = strcmp(setting->name, "FUSED") == 0 && !is_tested(c);
    if (untested || is_decided_by_scene(setting->name) || setting->value == c->params[i].fallback)
        return;
    bool shared = strcmp(setting->name, "WG") == 0 || strcmp(setting->name, "PER_ITEM") == 0 ||
                  strcmp(setting->name, "BATCH") == 0 || strcmp(setting->name, "LANES") == 0;
    text_add(t, " %s%s%s=%" PRId64, shared ? c->kernel : "", shared ? "." : "", setting->name,
             setting->value);
}

static void write_variant(char *words, size_t capacity, const config *c, const scene *s,
                          const char *search)
{
    own(text) t = {0};
    text_add(&t, "%s", search);
    if (value_of(c, "RANK", 1) == 0)
        text_add(&t, " sort=radix");
    if (strcmp(search, "paper") != 0 && !s->packed)
        text_add(&t, " grid=%s", s->hashed ? "hashed" : s->levels ? "dense" : "uniform");
    for (uint32_t i = 0; i < c->n; ++i)
        add_setting(&t, c, i);
    static const char fixed[] = " cells=fixed";
    if (s->fixed && t.length + sizeof fixed <= capacity)
        text_add(&t, "%s", fixed);
    assert_true(t.length < capacity);
    memcpy(words, t.chars, t.length + 1);
}

static uint64_t true_hash(const scene *s)
{
    const reference_objects objects = {.dims = s->dims,
                                       .shape = s->shape,
                                       .n = s->n,
                                       .poses = s->poses,
                                       .bounds = s->bounds,
                                       .level = s->level,
                                       .rotated = s->rotated};
    uint64_t n;
    return reference_hash(&objects, REFERENCE_EACH_WITH_EACH, &n);
}

static duet_world *open_world(const scene *s, const duet_plan *plan)
{
    duet_error err = {0};
    duet_world_def def = devices_def(s->dims);
    def.shape = s->shape;
    def.rotated = s->rotated;
    def.level = s->level;
    def.pose_form = s->form;
    def.plan = *plan;
    for (int side = 0; side < 2; ++side)
        default_pair()->devices[side].info.host_memory = !s->packed;
    duet_world *world = duet_world_create(&def, &err);
    if (!world)
        fail_msg("%s: %s", plan->variant_b, err.text);
    must(s->shape == DUET_SHAPE_POSES
             ? duet_world_set_objects(world, DUET_OBJECT_POSES, s->poses, s->n, ERR)
             : duet_world_set_objects(world, DUET_OBJECT_BOUNDS, s->bounds, s->n, ERR));
    return world;
}

// That the step ran what was meant.
static void assert_ran(const duet_world *world, const gen_variant *v, const char *words)
{
    const part *p = &world->parts[1];
    const part_kernels *k = &p->kernels;
    const kernel *all[] = {k->clear,  k->hash,  SCAN_LAST(&p->scan), k->scatter, p->radix.count,
                           k->starts, k->place, k->candidates,      k->narrow};
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
        if (all[i] && strcmp(all[i]->name, v->name) == 0)
            return;
    fail_msg("'%s' does not run %s", words, v->name);
}

static void try_config(const config *c, rng *r)
{
    static scene s;
    make_scene(&s, c, r);
    own(gen_variant) v;
    duet_error err = {0};
    gen_limits limits = program_limits(&default_pair()->devices[1].info);
    must(gen_make(generator, c->kernel, c->settings, c->n, &limits, &v, ERR));
    duet_plan plan = {.mode = DUET_MODE_OWN};
    if (s.packed)
        plan = (duet_plan){.mode = DUET_MODE_SLAB, .share = DUET_SHARE_ONE / 2};
    else if (test_takes_all() && rng_below(r, 2))
        plan.share = DUET_SHARE_ONE / 3;
    write_variant(plan.variant_b, sizeof plan.variant_b, c, &s, choose_search(c, r));
    strcpy(plan.variant_a, plan.variant_b);
    duet_world *world = open_world(&s, &plan);
    duet_result result;
    if (!duet_world_step(world, &result, &err))
        fail_msg("%s with '%s': %s", v.name, plan.variant_b, err.text);
    assert_ran(world, &v, plan.variant_b);
    if (duet_result_get_hash(&result) != true_hash(&s))
        fail_msg("%s with '%s', %" PRIu32 " objects in %" PRIu32 "D: %" PRIu64
                 " pairs are not the reference's",
                 v.name, plan.variant_b, s.n, s.dims, result.pairs);
    duet_world_destroy(world);
    guard_assert_whole(v.name);
}

// ------------------------------------------------------------ spaces

static bool get_config(config *c, const gen_limits *limits, uint64_t index)
{
    must(gen_params(generator, c->kernel, limits, &c->params, &c->n, ERR));
    assert_true(c->n <= MOST_PARAMS);
    must(gen_config(generator, c->kernel, limits, index, c->settings, ERR));
    return is_called_for(c);
}

// One config of each of as many equal parts of the space, or all of them.
static uint32_t try_subject(const subject *of, rng *r)
{
    config c = {.kernel = of->kernel, .searches = of->searches};
    gen_limits limits = program_limits(&default_pair()->devices[1].info);
    uint64_t count = 0;
    must(gen_count(generator, c.kernel, &limits, &count, ERR));
    uint64_t most = !test_takes_all() ? SAMPLE : count <= WHOLE_SPACE ? count : LARGE_SAMPLE;
    uint32_t tried = 0;
    for (uint64_t i = 0; i < most; ++i) {
        uint64_t from = count * i / most, to = count * (i + 1) / most;
        uint64_t index = from + rng_below(r, (uint32_t)(to - from));
        for (int again = 0; again < 64 && !get_config(&c, &limits, index); ++again)
            index = from + rng_below(r, (uint32_t)(to - from));
        if (!is_called_for(&c))
            continue;
        try_config(&c, r);
        ++tried;
    }
    return tried;
}

TEST(any_config_finds_the_pairs_and_writes_nothing_else)
{
    rng r = rng_seed(test_seed());
    const char *only = test_argument(2);
    for (uint32_t k = 0; k < SUBJECTS; ++k) {
        if (only && strcmp(only, subjects[k].kernel) != 0)
            continue;
        uint32_t tried = try_subject(&subjects[k], &r);
        print_message("%s: %" PRIu32 " configs\n", subjects[k].kernel, tried);
        assert_true(tried > 0);
    }
}

TEST_BEGIN(begin)
