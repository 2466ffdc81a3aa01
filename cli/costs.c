// SPDX-License-Identifier: MIT
#include "cli/costs.h"

#include "base/compare.h"
#include "base/error.h"
#include "cli/interrupt.h"
#include "cli/say.h"
#include "runtime/scene/scene.h"
#include "runtime/scene/scene_fields.h"
#include "tuner/measure.h"

#include <stdlib.h>
#include <string.h>

// Steps done so far, of all motions.
typedef struct tally {
    progress shown;
    uint64_t done;
    core_watch *cores;
} tally;

// A scene's motion, which may be changed.
typedef struct subject {
    tally *tally;
    duet_motion_def def;
    const duet_scene *scene;
    duet_body *bodies;
    uint32_t n;
} subject;

static bool advance(const subject *s, duet_motion *m, double *ms, duet_error *err)
{
    duet_motion_result result;
    measure_watch(s->tally->cores, s->def.pair);
    bool ok = duet_motion_advance(m, &result, err);
    core_watch_stop(s->tally->cores);
    *ms = ok ? result.total_ms : 0;
    return ok && interrupt_check(err);
}

enum { WARM = 2 };

static duet_motion *begin(const subject *s, duet_error *err)
{
    return duet_motion_create_from_scene(&s->def, s->scene, s->bodies, err);
}

// The median of the steps' times, after two to warm up. Beside another subject
// it is the median of how many times as long the other's steps take: the two
// step in turn, so that whatever slows one slows both.
static bool measure(const subject *s, const subject *beside, uint64_t steps, double *median,
                    duet_error *err)
{
    double *times = calloc(steps, sizeof *times);
    if (!times)
        return no_memory(err, "the times of steps");
    duet_motion *m = begin(s, err);
    duet_motion *other = beside ? begin(beside, err) : NULL;
    bool ok = m && (other || !beside);
    for (uint64_t k = 0; ok && k < steps + WARM; ++k) {
        double own = 0, others = 0;
        ok = advance(s, m, &own, err) && (!other || advance(beside, other, &others, err));
        if (ok && k >= WARM)
            times[k - WARM] = other ? others / own : own;
        progress_show(&s->tally->shown, ++s->tally->done);
    }
    qsort(times, steps, sizeof *times, compare_double);
    *median = times[steps / 2];
    duet_motion_destroy(other);
    duet_motion_destroy(m);
    free(times);
    return ok;
}

static void change_body(duet_body *b, uint32_t effect)
{
    if (effect == DUET_EFFECT_MATERIALS)
        b->material = 0;
    if (effect == DUET_EFFECT_FRICTION)
        b->friction = 0.0f;
    if (effect == DUET_EFFECT_ROLLING_RESISTANCE)
        b->rolling_resistance = 0.0f;
    if (effect == DUET_EFFECT_SURFACE_VELOCITY)
        memset(b->surface_velocity, 0, sizeof b->surface_velocity);
    if (effect == DUET_EFFECT_FILTER)
        b->group = b->mask = UINT32_MAX;
    if (effect == DUET_EFFECT_ANGULAR_VELOCITY) {
        b->fixed_rotation = true;
        memset(b->angular_velocity, 0, sizeof b->angular_velocity);
    }
    if (effect == DUET_EFFECT_CONTACT_RESPONSE) {
        b->friction = b->restitution = 0.0f;
        b->material = 0;
    }
}

static void smooth_materials(duet_motion_def *def)
{
    for (uint32_t i = 1; i <= def->n_materials; ++i)
        def->materials[i].friction = 0.0f;
    for (uint32_t i = 0; i < def->n_material_pairs; ++i)
        def->material_pairs[i].friction = 0.0f;
}

// Takes away what calls for the effect.
static void take_away(subject *s, uint32_t effect)
{
    s->def.wants &= ~effect;
    if (effect == DUET_EFFECT_CONTACT_RESPONSE)
        s->def.wants &=
            ~(uint32_t)(DUET_EFFECT_CONTINUOUS | DUET_EFFECT_SLEEP | DUET_EFFECT_FRICTION |
                        DUET_EFFECT_ROLLING_RESISTANCE | DUET_EFFECT_SURFACE_VELOCITY |
                        DUET_EFFECT_MATERIALS | DUET_EFFECT_SHOCKS | DUET_EFFECT_DEPENETRATION);
    if (effect == DUET_EFFECT_FRICTION)
        smooth_materials(&s->def);
    if (effect == DUET_EFFECT_GRAVITY) {
        memset(s->def.gravity, 0, sizeof s->def.gravity);
        s->def.attraction = 0.0;
    }
    if (effect == DUET_EFFECT_DRAG)
        s->def.drag = 0.0;
    if (effect == DUET_EFFECT_BOUNDARY)
        s->def.boundary = DUET_BOUNDARY_NONE;
    if (effect == DUET_EFFECT_SKIN)
        s->def.skin = 0.0;
    if (effect == DUET_EFFECT_GROUND) {
        s->def.heights = NULL;
        s->def.mesh = NULL;
    }
    for (uint32_t i = 0; i < s->n; ++i)
        change_body(&s->bodies[i], effect);
}

// False in *measured where other effects call for this one too.
static bool measure_effect(const subject *whole, double whole_ms, cost *row, uint64_t steps,
                           duet_error *err)
{
    uint32_t effect = scene_effect_named(row->info.name);
    subject s = *whole;
    s.bodies = malloc(s.n * sizeof *s.bodies + 1);
    if (!s.bodies)
        return no_memory(err, "%u bodies", s.n);
    memcpy(s.bodies, whole->bodies, s.n * sizeof *s.bodies);
    take_away(&s, effect);
    duet_motion *m = begin(&s, err);
    bool ok = m;
    double without = 1;
    row->measured = m && !(duet_motion_get_effects(m) & effect);
    duet_motion_destroy(m);
    if (m && !row->measured)
        s.tally->done += steps + WARM;
    ok = ok && (!row->measured || measure(whole, &s, steps, &without, err));
    row->ms = whole_ms * (1 - without);
    free(s.bodies);
    return ok;
}

static bool is_measured(const cost *row)
{
    return row->info.active && scene_effect_named(row->info.name);
}

static bool measure_effects(costs *c, const subject *s, duet_error *err)
{
    uint64_t runs = 1;
    for (uint32_t i = 0; i < c->n; ++i)
        runs += is_measured(&c->rows[i]);
    s->tally->shown = progress_begin("step", runs * (c->steps + WARM));
    bool ok = measure(s, NULL, c->steps, &c->step_ms, err);
    for (uint32_t i = 0; ok && i < c->n; ++i)
        ok = !is_measured(&c->rows[i]) || measure_effect(s, c->step_ms, &c->rows[i], c->steps, err);
    progress_end(&s->tally->shown);
    return ok;
}

static bool fill_subject(subject *s, const duet_motion_def *def, const duet_scene *scene,
                         duet_error *err)
{
    *s = (subject){.def = *def, .scene = scene, .n = duet_scene_get_info(scene)->n};
    s->bodies = malloc(s->n * sizeof *s->bodies + 1);
    if (!s->bodies)
        return no_memory(err, "%u bodies", s->n);
    const duet_body *given = duet_scene_get_bodies(scene);
    for (uint32_t i = 0; i < s->n; ++i)
        s->bodies[i] = given ? given[i] : duet_default_body();
    return true;
}

bool costs_measure(costs *c, const duet_motion_def *def, const duet_scene *scene, uint64_t steps,
                   duet_error *err)
{
    tally t = {.cores = steps > 0 ? core_watch_open() : NULL};
    subject s = {.n = 0};
    *c = (costs){.steps = steps};
    bool ok = fill_subject(&s, def, scene, err);
    s.tally = &t;
    duet_motion *m = ok ? begin(&s, err) : NULL;
    while (m && c->n < COSTS_MOST && duet_motion_explain(m, c->n, &c->rows[c->n].info))
        ++c->n;
    if (duet_motion_get_effects(m) && duet_motion_explain_substeps(m, &c->substeps))
        s.def.substeps = c->substeps.substeps;
    duet_motion_destroy(m);
    ok = m && (steps == 0 || measure_effects(c, &s, err));
    c->cores = core_watch_tally(t.cores);
    core_watch_close(t.cores);
    free(s.bodies);
    return ok;
}

// ---------------------------------------------------------------- as data

static void add_row(cJSON *list, const cost *row)
{
    cJSON *o = json_add_row(list);
    json_add(o, STRING("effect", row->info.name), FLAG("active", row->info.active),
             STRING("called_by", row->info.called_by), NUMBER("bytes", row->info.bytes),
             STRING("kernels", row->info.active ? row->info.kernels : ""));
    if (row->measured)
        json_add(o, NUMBER("ms", row->ms));
}

static void add_substeps(cJSON *o, const duet_substep_info *s)
{
    cJSON *its = cJSON_AddObjectToObject(o, "substeps");
    json_add(its, NUMBER("n", s->substeps), FLAG("chosen", s->chosen));
    if (!s->chosen)
        return;
    json_add(its, NUMBER("layers", s->layers), NUMBER("edge", s->edge));
}

cJSON *costs_report_json(const costs *c, const duet_scene_info *scene, const duet_device_pair *pair)
{
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("type", COSTS_TYPE), STRING("scene", scene->name),
             NUMBER("objects", scene->n));
    json_add_devices(o, pair);
    json_add(o, NUMBER("steps", c->steps));
    if (c->steps > 0)
        json_add(o, NUMBER("step_ms", c->step_ms));
    if (c->substeps.substeps > 0)
        add_substeps(o, &c->substeps);
    json_add_cores(o, &c->cores);
    cJSON *effects = cJSON_AddArrayToObject(o, "effects");
    for (uint32_t i = 0; i < c->n; ++i)
        add_row(effects, &c->rows[i]);
    return o;
}

bool costs_report_check(const cJSON *o, const char *path, duet_error *err)
{
    static const json_field whole[] = {
        {"scene", cJSON_IsString, "a string"},
        {"objects", JSON_COUNT},
        {"effects", cJSON_IsArray, "a list"},
        {0},
    };
    static const json_field row[] = {
        {"effect", cJSON_IsString, "a string"},
        {"called_by", cJSON_IsString, "a string"},
        {"bytes", JSON_COUNT},
        {0},
    };
    bool ok = json_require(o, whole, path, err);
    if (ok && json_number(o, "steps") < 1)
        ok = bad_input(err, "%s: no times; 'duet explain --measure' takes them", path);
    return ok && json_require_each(json_list(o, "effects"), row, path, "effect", err);
}
