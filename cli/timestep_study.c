// SPDX-License-Identifier: MIT
#include "cli/timestep_study.h"

#include "base/clock.h"
#include "base/error.h"
#include "cli/interrupt.h"
#include "cli/say.h"
#include "runtime/scene/scene.h"
#include "runtime/scene/scene_fields.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// How much coarser than the scene's own the steps are, and how much finer.
static const double finer[] = {0.5, 1, 2, 4};
enum { N_FINER = sizeof finer / sizeof finer[0] };

// Parts of a run, in each of which the fastest step stands for all: what
// disturbs some of them is not the time step's.
enum { WINDOWS = 8 };

typedef struct survey {
    timestep_study *study;
    const duet_scene *scene;
    duet_motion_def def; // the scene's own
    uint64_t samples;    // in a run; one lasts two of the scene's own steps
    duet_state *truth;   // the reference's, at the end
    duet_state *states;
    double truth_energy;
    double kinetic; // greatest of the reference
    progress shown;
    uint64_t done; // substeps
} survey;

// ---------------------------------------------------------------- a run

typedef struct run {
    duet_motion *motion;
    double ms;          // the time of windows that are over
    double noise;       // the noise of ms
    bool noise_known;   // a part of the run had two steps
    double window_ms;   // least of a step in this one
    double window_next; // and the next above it
    uint64_t window_steps;
    double least; // energy so far
    double gain;
    double energy; // the last sample's
    double kinetic;
    double depth;
} run;

static duet_motion *begin(const survey *s, const timestep_run *row, bool doubles, duet_error *err)
{
    duet_motion_def def = s->def;
    def.dt = row->dt;
    def.substeps = row->substeps;
    def.integrator = row->integrator;
    def.doubles = doubles;
    return duet_motion_create_from_scene(&def, s->scene, NULL, err);
}

static bool sample_energy(run *r, duet_error *err)
{
    duet_energy e;
    if (!duet_motion_get_energy(r->motion, &e, err))
        return false;
    r->kinetic = fmax(r->kinetic, e.kinetic + e.turning);
    r->energy = e.kinetic + e.turning + e.potential;
    r->least = fmin(r->least, r->energy);
    r->gain = fmax(r->gain, r->energy - r->least);
    return true;
}

static bool sample_depth(run *r, duet_error *err)
{
    duet_contact *contacts = NULL;
    uint64_t n = 0;
    if (!(duet_motion_get_effects(r->motion) & DUET_EFFECT_CONTACT))
        return true;
    if (!duet_motion_get_contacts(r->motion, &contacts, &n, err))
        return false;
    for (uint64_t i = 0; i < n; ++i)
        for (uint32_t k = 0; k < contacts[i].n; ++k)
            r->depth = fmax(r->depth, -contacts[i].points[k].separation);
    duet_free(contacts);
    return true;
}

static void end_window(run *r)
{
    if (r->window_steps > 0)
        r->ms += r->window_ms * (double)r->window_steps;
    if (r->window_steps > 1) {
        r->noise += (r->window_next - r->window_ms) * (double)r->window_steps;
        r->noise_known = true;
    }
    r->window_ms = r->window_next = INFINITY;
    r->window_steps = 0;
}

static bool advance(survey *s, run *r, const timestep_run *row, uint64_t steps, duet_error *err)
{
    duet_motion_result result;
    for (uint64_t k = 0; k < steps; ++k) {
        if (!duet_motion_advance(r->motion, &result, err))
            return false;
        r->window_next = fmin(r->window_next, fmax(r->window_ms, result.total_ms));
        r->window_ms = fmin(r->window_ms, result.total_ms);
        ++r->window_steps;
        progress_show(&s->shown, s->done += row->substeps);
    }
    return true;
}

static uint64_t steps_of_sample(const survey *s, const timestep_run *row)
{
    return (uint64_t)llround(s->study->time / (double)s->samples / row->dt);
}

// All samples, and the states at the end.
static bool finish(survey *s, run *r, const timestep_run *row, duet_error *err)
{
    r->least = INFINITY;
    end_window(r);
    bool ok = sample_energy(r, err);
    for (uint64_t k = 0; ok && k < s->samples; ++k) {
        ok = interrupt_check(err) && advance(s, r, row, steps_of_sample(s, row), err) &&
             sample_energy(r, err) && sample_depth(r, err);
        if ((k + 1) * WINDOWS / s->samples > k * WINDOWS / s->samples)
            end_window(r);
    }
    return ok && duet_motion_get_states(r->motion, s->states, err);
}

// ---------------------------------------------------------------- right and wrong

static double rms_distance(const survey *s)
{
    uint32_t n = duet_scene_get_info(s->scene)->n;
    double sum = 0.0;
    for (uint32_t i = 0; i < n; ++i)
        for (uint32_t k = 0; k < s->def.dims; ++k) {
            double d = s->states[i].centre[k] - s->truth[i].centre[k];
            sum += d * d;
        }
    return n > 0 ? sqrt(sum / n) : 0.0;
}

static void judge(const survey *s, const run *r, timestep_run *row)
{
    row->ms = r->ms / s->study->time;
    row->noise = r->noise_known ? r->noise / s->study->time : INFINITY;
    row->error = rms_distance(s);
    row->energy = (r->energy - s->truth_energy) / s->kinetic;
    row->gain = r->gain / s->kinetic;
    row->depth = r->depth;
    row->finite = isfinite(row->error) && isfinite(row->energy) && isfinite(row->gain);
}

static void keep_truth(survey *s, const run *r)
{
    memcpy(s->truth, s->states, duet_scene_get_info(s->scene)->n * sizeof *s->truth);
    s->truth_energy = r->energy;
    s->kinetic = fmax(r->kinetic, 1e-300);
}

// The reference is in double if the device has it, whatever the scene's own is.
static bool run_timestep(survey *s, timestep_run *row, duet_error *err)
{
    bool is_truth = row == &s->study->reference;
    bool doubles = is_truth ? duet_device_pair_get_info(s->def.pair, 1)->fp64 : s->def.doubles;
    run r = {.motion = begin(s, row, doubles, err)};
    bool ok = r.motion && finish(s, &r, row, err);
    if (ok && is_truth)
        keep_truth(s, &r);
    if (ok)
        judge(s, &r, row);
    duet_motion_destroy(r.motion);
    return ok;
}

// ---------------------------------------------------------------- which time steps

static void add_row(survey *s, double dt, uint32_t substeps, duet_integrator integrator)
{
    timestep_study *p = s->study;
    for (uint32_t i = 0; i < p->n_asked; ++i)
        if (p->rows[i].dt == dt && p->rows[i].substeps == substeps &&
            p->rows[i].integrator == integrator)
            return;
    bool own = fabs(dt / substeps * s->def.substeps / s->def.dt - 1.0) < 1e-9 &&
               integrator == s->def.integrator;
    p->rows[p->n_asked++] = (timestep_run){
        .dt = dt, .substeps = substeps, .integrator = integrator, .own = own && dt == s->def.dt};
}

// Contacts are found once a step and solved in each substep, so both matter.
static void list_with_response(survey *s)
{
    for (uint32_t i = 0; i < N_FINER; ++i)
        for (uint32_t j = 0; j < N_FINER; ++j)
            add_row(s, s->def.dt / finer[i], (uint32_t)fmax(1.0, s->def.substeps * finer[j] / 2.0),
                    DUET_INTEGRATOR_EULER);
    s->study->reference = (timestep_run){.dt = s->def.dt / 8.0, .substeps = 4 * s->def.substeps};
}

// A flight knows only substeps, and may be of a higher order.
static void list_free_flight(survey *s)
{
    for (int order = DUET_INTEGRATOR_EULER; order <= DUET_INTEGRATOR_YOSHIDA; ++order)
        for (int i = 0; i < N_FINER; ++i)
            add_row(s, s->def.dt / finer[i], s->def.substeps, (duet_integrator)order);
    s->study->reference = (timestep_run){
        .dt = s->def.dt / 16.0, .substeps = s->def.substeps, .integrator = DUET_INTEGRATOR_YOSHIDA};
}

static double cost_of(const timestep_run *row)
{
    static const double parts[] = {
        [DUET_INTEGRATOR_EULER] = 1, [DUET_INTEGRATOR_VERLET] = 1, [DUET_INTEGRATOR_YOSHIDA] = 3};
    return row->substeps / row->dt * parts[row->integrator];
}

static int by_cost(const void *x, const void *y)
{
    double a = cost_of(x), b = cost_of(y);
    if (a != b)
        return a < b ? -1 : 1;
    return ((const timestep_run *)x)->dt > ((const timestep_run *)y)->dt ? -1 : 1;
}

static bool is_faster(const timestep_run *a, const timestep_run *b)
{
    return b->ms - a->ms > a->noise + b->noise;
}

// By time beyond noise, or by less error in a time that is not longer beyond noise.
static bool beats(const timestep_run *a, const timestep_run *b)
{
    return a->finite &&
           ((a->error <= b->error && is_faster(a, b)) || (a->error < b->error && !is_faster(b, a)));
}

static void find_front(timestep_study *p)
{
    for (uint32_t i = 0; i < p->n; ++i) {
        p->rows[i].front = p->rows[i].finite;
        for (uint32_t k = 0; k < p->n; ++k)
            p->rows[i].front &= !beats(&p->rows[k], &p->rows[i]);
    }
}

// ---------------------------------------------------------------- all of them

static void list_rows(survey *s, uint32_t effects)
{
    timestep_study *p = s->study;
    p->contact = effects & DUET_EFFECT_CONTACT;
    if (effects & DUET_EFFECT_CONTACT_RESPONSE)
        list_with_response(s);
    else
        list_free_flight(s);
    qsort(p->rows, p->n_asked, sizeof *p->rows, by_cost);
}

static uint64_t substeps_of_all(const survey *s)
{
    const timestep_study *p = s->study;
    uint64_t n = steps_of_sample(s, &p->reference) * p->reference.substeps;
    for (uint32_t i = 0; i < p->n_asked; ++i)
        n += steps_of_sample(s, &p->rows[i]) * p->rows[i].substeps;
    return n * s->samples;
}

static bool run_all(survey *s, double limit, duet_error *err)
{
    timestep_study *p = s->study;
    uint64_t begun = clock_steady_ns();
    s->shown = progress_begin("substep", substeps_of_all(s));
    bool ok = run_timestep(s, &p->reference, err);
    while (ok && p->n < p->n_asked &&
           (p->n == 0 || (double)(clock_steady_ns() - begun) * 1e-9 < limit)) {
        ok = run_timestep(s, &p->rows[p->n], err);
        p->n += ok;
    }
    progress_end(&s->shown);
    if (!ok && p->n > 0 && interrupt_asked()) {
        *err = (duet_error){0};
        return true;
    }
    return ok;
}

bool timestep_study_applies(duet_device_pair *pair, const duet_scene *scene, bool *moves,
                            duet_error *err)
{
    duet_motion_def def = duet_scene_motion_def(scene, pair);
    const duet_scene_info *info = duet_scene_get_info(scene);
    *moves = false;
    // A trajectory is compared with one in double, which has no origin cells.
    if (info->shape == DUET_SHAPE_BOUNDS || info->n == 0 || info->origin_edge > 0)
        return true;
    duet_motion *m = duet_motion_create_from_scene(&def, scene, NULL, err);
    *moves = m && (duet_motion_get_effects(m) & DUET_EFFECT_MOTION) && def.dt > 0.0;
    bool ok = m;
    duet_motion_destroy(m);
    return ok;
}

bool timestep_study_measure(timestep_study *p, duet_device_pair *pair, const duet_scene *scene,
                            double time, double limit, duet_error *err)
{
    *p = (timestep_study){0};
    survey s = {.study = p, .scene = scene, .def = duet_scene_motion_def(scene, pair)};
    uint32_t n = duet_scene_get_info(scene)->n;
    double sample = 2.0 * s.def.dt;
    s.samples = (uint64_t)fmax(1.0, round(time / sample));
    p->time = (double)s.samples * sample;
    s.truth = calloc((size_t)n + 1, sizeof *s.truth);
    s.states = calloc((size_t)n + 1, sizeof *s.states);
    duet_motion *m = duet_motion_create_from_scene(&s.def, scene, NULL, err);
    bool ok = m && ((s.truth && s.states) || no_memory(err, "the states of %u objects", n));
    if (ok) {
        s.def.substeps = duet_motion_get_def(m)->substeps;
        list_rows(&s, duet_motion_get_effects(m));
    }
    duet_motion_destroy(m);
    ok = ok && run_all(&s, limit, err);
    if (ok)
        find_front(p);
    free(s.truth);
    free(s.states);
    return ok;
}

// ---------------------------------------------------------------- as data

static cJSON *row_json(const timestep_run *row)
{
    cJSON *o = cJSON_CreateObject();
    json_add(o, NUMBER("dt", row->dt), NUMBER("substeps", row->substeps),
             STRING("integrator", scene_integrator_name(row->integrator)), FLAG("own", row->own),
             NUMBER("ms_a_second", row->ms));
    if (isfinite(row->noise))
        json_add(o, NUMBER("noise_ms", row->noise));
    json_add(o, NUMBER("error", row->error), NUMBER("energy", row->energy),
             NUMBER("gain", row->gain), NUMBER("depth", row->depth), FLAG("finite", row->finite),
             FLAG("front", row->front));
    return o;
}

cJSON *timestep_study_json(const timestep_study *p, const duet_scene_info *scene,
                           const duet_device_pair *pair)
{
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("scene", scene->name), NUMBER("objects", scene->n));
    json_add_devices(o, pair);
    json_add(o, NUMBER("time", p->time), NUMBER("asked", p->n_asked), FLAG("contact", p->contact));
    cJSON_AddItemToObject(o, "reference", row_json(&p->reference));
    cJSON *rows = cJSON_AddArrayToObject(o, "timesteps");
    for (uint32_t i = 0; i < p->n; ++i)
        cJSON_AddItemToArray(rows, row_json(&p->rows[i]));
    return o;
}
