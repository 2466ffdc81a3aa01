// SPDX-License-Identifier: MIT
// duet explain: which effects a scene calls for, by what, and what each costs.
//
// An effect's time is that of the steps with it less that of the steps of the
// same scene with what calls for it taken away.
#include "runtime/base/error.h"
#include "runtime/duet.h"
#include "tuner/cli/commands.h"
#include "tuner/cli/inputs.h"
#include "tuner/cli/options.h"
#include "tuner/cli/say.h"
#include "tuner/cli/table.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct arguments {
    scene_options scene;
    const char *pair;
    bool measure;
    uint64_t steps;
} arguments;

static const option options[] = {
    SCENE_OPTION_ROWS(scene),
    PAIR_OPTION_ROW(pair),
    OPTION_FLAG("measure", measure, "run the scene with and without each effect, and compare"),
    OPTION_COUNT("steps", steps, "K", "steps of each such run (20)", 3, 100000),
    {0},
};

static const command_line line = {
    .name = "explain",
    .operands = "SCENE",
    .least_operands = 1,
    .most_operands = 1,
    .about = "Tells the effects that a scene calls for: why, their kernels, bytes an object.",
    .options = options,
};

// A scene's motion, which may be changed.
typedef struct subject {
    duet_motion_def def;
    const duet_pose *poses;
    duet_body *bodies;
    uint32_t n;
} subject;

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a;
    double y = *(const double *)b;
    return (x > y) - (x < y);
}

// The least of the steps' times, after two to warm up: what else the machine does
// only adds.
static bool measure(const subject *s, uint64_t steps, double *ms, duet_error *err)
{
    double *times = calloc(steps, sizeof *times);
    duet_motion *m = duet_motion_create(&s->def, s->poses, s->bodies, s->n, err);
    duet_motion_result result;
    bool ok = times && m;
    for (uint64_t k = 0; ok && k < steps + 2; ++k) {
        ok = duet_motion_advance(m, &result, err);
        if (ok && k >= 2)
            times[k - 2] = result.total_ms;
    }
    if (ok) {
        qsort(times, steps, sizeof *times, by_value);
        *ms = times[0];
    }
    duet_motion_destroy(m);
    free(times);
    return ok;
}

static void change_body(duet_body *b, uint32_t effect)
{
    if (effect == DUET_EFFECT_FRICTION)
        b->friction = 0.0f;
    if (effect == DUET_EFFECT_FILTER)
        b->group = b->mask = UINT32_MAX;
    if (effect == DUET_EFFECT_SPIN) {
        b->upright = true;
        memset(b->spin, 0, sizeof b->spin);
    }
    if (effect == DUET_EFFECT_RESPONSE)
        b->friction = b->restitution = 0.0f;
}

// Takes away what calls for the effect.
static void take_away(subject *s, uint32_t effect)
{
    s->def.wants &= ~effect;
    if (effect == DUET_EFFECT_RESPONSE)
        s->def.wants &= ~(uint32_t)(DUET_EFFECT_FAST | DUET_EFFECT_SLEEP | DUET_EFFECT_FRICTION);
    if (effect == DUET_EFFECT_GRAVITY) {
        memset(s->def.gravity, 0, sizeof s->def.gravity);
        s->def.attraction = 0.0;
    }
    if (effect == DUET_EFFECT_DRAG)
        s->def.drag = 0.0;
    if (effect == DUET_EFFECT_BOUNDS)
        s->def.edge = DUET_EDGE_NONE;
    if (effect == DUET_EFFECT_SKIN)
        s->def.skin = 0.0;
    for (uint32_t i = 0; i < s->n; ++i)
        change_body(&s->bodies[i], effect);
}

static uint32_t effect_named(const char *name)
{
    for (uint32_t bit = 1; bit < DUET_EFFECT_ALL; bit <<= 1)
        if (strcmp(duet_effect_name(bit), name) == 0)
            return bit;
    return 0;
}

// What the scene takes without the effect; *possible is false where others call
// for it too.
static bool measure_without(const subject *whole, uint32_t effect, uint64_t steps, double *ms,
                            bool *possible, duet_error *err)
{
    subject s = *whole;
    s.bodies = malloc(s.n * sizeof *s.bodies + 1);
    if (!s.bodies)
        return error_set(err, DUET_NO_MEMORY, "%u bodies: no memory", s.n);
    memcpy(s.bodies, whole->bodies, s.n * sizeof *s.bodies);
    take_away(&s, effect);
    duet_motion *m = duet_motion_create(&s.def, s.poses, s.bodies, s.n, err);
    *possible = m && !(duet_motion_effects(m) & effect);
    bool ok = m;
    duet_motion_destroy(m);
    ok = ok && (!*possible || measure(&s, steps, ms, err));
    free(s.bodies);
    return ok;
}

static bool add_cost(table *t, const subject *s, const duet_effect_info *info, double whole,
                     uint64_t steps, duet_error *err)
{
    double without = 0.0;
    bool possible = false;
    if (!measure_without(s, effect_named(info->name), steps, &without, &possible, err))
        return false;
    if (possible)
        table_cell(t, "%.3f", whole - without);
    else
        table_cell(t, "-");
    return true;
}

static bool tell(const arguments *args, const subject *s, const duet_motion *m, duet_error *err)
{
    table t = table_begin(args->measure ? "lllrlr" : "lllrl");
    static const char *const heads[] = {"effect",          "",        "called for by",
                                        "bytes an object", "kernels", "ms a step"};
    double whole = 0.0;
    bool ok = !args->measure || measure(s, args->steps, &whole, err);
    for (int i = 0; i < 5 + args->measure; ++i)
        table_cell(&t, "%s", heads[i]);
    duet_effect_info info;
    for (uint32_t i = 0; ok && duet_motion_explain(m, i, &info); ++i) {
        table_cell(&t, "%s", info.name);
        table_cell(&t, "%s", info.active ? "yes" : "-");
        table_cell(&t, "%s", info.called_by);
        table_cell(&t, "%u", info.bytes);
        table_cell(&t, "%s", info.active ? info.kernels : "-");
        if (args->measure && info.active)
            ok = add_cost(&t, s, &info, whole, args->steps, err);
        else if (args->measure)
            table_cell(&t, "-");
    }
    table_print(&t, stdout);
    if (ok && args->measure)
        printf("\n%.3f ms a step with all of them\n", whole);
    return ok;
}

static bool fill_subject(subject *s, const duet_scene *scene, duet_device_pair *pair,
                         duet_error *err)
{
    const duet_scene_info *info = duet_scene_describe(scene);
    *s = (subject){
        .def = duet_scene_motion_def(scene, pair), .poses = duet_scene_poses(scene), .n = info->n};
    if (!s->poses)
        return error_set(err, DUET_BAD_ARGUMENT,
                         "%s: its objects are corners, which do not move; right would be centres "
                         "and half extents",
                         info->name);
    s->bodies = malloc(s->n * sizeof *s->bodies + 1);
    if (!s->bodies)
        return error_set(err, DUET_NO_MEMORY, "%u bodies: no memory", s->n);
    const duet_body *given = duet_scene_bodies(scene);
    for (uint32_t i = 0; i < s->n; ++i)
        s->bodies[i] = given ? given[i] : duet_default_body();
    return true;
}

static bool explain(const arguments *args, const char *path, duet_error *err)
{
    subject s = {.n = 0};
    duet_device_pair *pair = inputs_open_pair(args->pair, err);
    duet_scene *scene = pair ? inputs_load_scene(path, &args->scene, err) : NULL;
    bool ok = scene && fill_subject(&s, scene, pair, err);
    duet_motion *m = ok ? duet_motion_create(&s.def, s.poses, s.bodies, s.n, err) : NULL;
    ok = m && tell(args, &s, m, err);
    duet_motion_destroy(m);
    free(s.bodies);
    duet_scene_destroy(scene);
    duet_device_pair_close(pair);
    return ok;
}

int command_explain(int argc, char **argv)
{
    arguments args = {.scene = SCENE_OPTIONS_DEFAULT, .steps = 20};
    char **operands = NULL;
    int n_operands = 0;
    int exit_code = EXIT_OK;
    if (!options_parse(&line, argc, argv, &args, &operands, &n_operands, &exit_code))
        return exit_code;
    duet_error err = {0};
    return explain(&args, operands[0], &err) ? EXIT_OK : say_failed(&err);
}
