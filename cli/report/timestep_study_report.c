// SPDX-License-Identifier: MIT
#include "cli/timestep_study.h"

#include "base/text.h"
#include "cli/draw/canvas.h"
#include "cli/report/json.h"
#include "cli/report/rendering.h"
#include "cli/report/table.h"
#include "cli/say.h"
#include "runtime/scene/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

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

bool timestep_study_report_tell(const timestep_study_report *r, bool json, duet_error *err)
{
    const timestep_study *p = r->study;
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("scene", r->scene->name), NUMBER("objects", r->scene->n));
    json_add_devices(o, r->pair);
    json_add(o, NUMBER("time", p->time), NUMBER("asked", p->n_asked), FLAG("contact", p->contact));
    cJSON_AddItemToObject(o, "reference", row_json(&p->reference));
    cJSON *rows = cJSON_AddArrayToObject(o, "timesteps");
    for (uint32_t i = 0; i < p->n; ++i)
        cJSON_AddItemToArray(rows, row_json(&p->rows[i]));
    return rendering_tell(o, json, "cli/report/timesteps.lua", err);
}

bool timestep_study_report_csv(const timestep_study_report *r, const char *path, duet_error *err)
{
    text lines = {0};
    text_add(
        &lines,
        "dt,substeps,integrator,own,ms_a_second,noise_ms,error,energy,gain,depth,finite,front\n");
    for (uint32_t i = 0; i < r->study->n; ++i) {
        const timestep_run *row = &r->study->rows[i];
        text_add(&lines, "%.9g,%u,%s,%d,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%d,%d\n", row->dt,
                 row->substeps, scene_integrator_name(row->integrator), row->own, row->ms,
                 row->noise, row->error, row->energy, row->gain, row->depth, row->finite,
                 row->front);
    }
    return say_to_file(&lines, path, err);
}

// ---------------------------------------------------------------- as a picture

// The error of each run over its time, both by powers of ten. Contacts: a
// colour a dt, and the substeps as a number; free flight: a colour an
// integrator, and the steps a second.

enum { WIDTH = 860, HEIGHT = 560, WORDS = 13 };

static const double left = 84, right = 640, top = 70, bottom = 484;
static const colour pale = {0.87, 0.88, 0.90, 1};
static const colour paper = {1, 1, 1, 1};
// Okabe and Ito's, which most colour-blind people can tell apart.
static const colour hues[] = {
    {0.00, 0.45, 0.70, 1}, {0.90, 0.62, 0.00, 1}, {0.00, 0.62, 0.45, 1}, {0.80, 0.40, 0.00, 1}};
enum { N_HUES = sizeof hues / sizeof hues[0] };

typedef struct axis {
    double least; // powers of ten
    double most;
    double from; // pixels
    double to;
} axis;

static double place(const axis *a, double value)
{
    double part = (log10(value) - a->least) / (a->most - a->least);
    return a->from + fmin(1.0, fmax(0.0, part)) * (a->to - a->from);
}

static void widen(axis *a, double value)
{
    if (!(value > 0) || !isfinite(value))
        return;
    a->least = fmin(a->least, log10(value) - 0.15);
    a->most = fmax(a->most, log10(value) + 0.15);
}

static axis axis_of(const timestep_study *p, bool of_error, double from, double to)
{
    axis a = {INFINITY, -INFINITY, from, to};
    for (uint32_t i = 0; i < p->n; ++i)
        if (p->rows[i].finite)
            widen(&a, of_error ? p->rows[i].error : p->rows[i].ms);
    if (!(a.least < a.most))
        a.least = -1, a.most = 1;
    return a;
}

// A line and its value at 1, 2 and 5 of each power of ten; of many powers at 1.
static void draw_ticks(canvas *c, const axis *a, bool across)
{
    static const double steps[] = {1, 2, 5};
    bool wide = a->most - a->least > 2.5;
    for (double power = floor(a->least); power <= a->most; ++power) {
        for (int i = 0; i < (wide ? 1 : 3); ++i) {
            double value = steps[i] * pow(10, power);
            if (log10(value) < a->least || log10(value) > a->most)
                continue;
            double at = place(a, value);
            char words[32];
            snprintf(words, sizeof words, "%.4g", value);
            if (across)
                canvas_line(c, (point){at, top}, (point){at, bottom}, pale, 1);
            else
                canvas_line(c, (point){left, at}, (point){right, at}, pale, 1);
            canvas_words(c, across ? (point){at - 10, bottom + 20} : (point){left - 56, at + 4},
                         WORDS, canvas_grey, words);
        }
    }
}

static void draw_frame(canvas *c, const timestep_study_report *r, const axis *x, const axis *y)
{
    char words[256];
    snprintf(words, sizeof words, "What accuracy costs: %.60s, %s, %.3g s", r->scene->name,
             table_things(r->scene->n, "box", "boxes").chars, r->study->time);
    canvas_words(c, (point){24, 32}, 19, canvas_ink, words);
    canvas_words(c, (point){24, 56}, WORDS, canvas_ink,
                 "distance from the reference at the end (root mean square)");
    draw_ticks(c, x, true);
    draw_ticks(c, y, false);
    canvas_line(c, (point){left, top}, (point){left, bottom}, canvas_grey, 1);
    canvas_line(c, (point){left, bottom}, (point){right, bottom}, canvas_grey, 1);
    canvas_words(c, (point){left + 180, bottom + 46}, WORDS, canvas_ink,
                 "ms that a second of the scene takes");
}

static int by_ms(const void *a, const void *b)
{
    double x = ((const timestep_run *)a)->ms, y = ((const timestep_run *)b)->ms;
    return (x > y) - (x < y);
}

static void draw_front(canvas *c, const timestep_study *p, const axis *x, const axis *y)
{
    timestep_run front[TIMESTEP_RUNS];
    size_t n = 0;
    for (uint32_t i = 0; i < p->n; ++i)
        if (p->rows[i].front)
            front[n++] = p->rows[i];
    qsort(front, n, sizeof *front, by_ms);
    for (size_t i = 1; i < n; ++i)
        canvas_line(c, (point){place(x, front[i - 1].ms), place(y, front[i - 1].error)},
                    (point){place(x, front[i].ms), place(y, front[i].error)}, canvas_grey, 1.5);
}

static void draw_timestep(canvas *c, const timestep_study *p, const timestep_run *row,
                          const axis *x, const axis *y)
{
    char words[32];
    point at = {place(x, row->ms), row->finite ? place(y, row->error) : top};
    if (row->own)
        canvas_dot(c, at, 11, canvas_ink);
    if (row->own)
        canvas_dot(c, at, 9, paper);
    canvas_dot(c, at, row->front ? 7 : 5, hues[row->group]);
    if (p->flies)
        snprintf(words, sizeof words, "1/%.4g", row->substeps / row->dt);
    else
        snprintf(words, sizeof words, "%u%s", row->substeps, row->finite ? "" : " lost");
    canvas_words(c, (point){at.x + 12, at.y + 4}, WORDS, canvas_ink, words);
}

static void draw_key(canvas *c, const timestep_study *p)
{
    bool drawn[N_HUES] = {false};
    double y = top + 10;
    char words[48];
    for (uint32_t i = 0; i < p->n; ++i) {
        const timestep_run *row = &p->rows[i];
        if (drawn[row->group])
            continue;
        drawn[row->group] = true;
        if (p->flies)
            snprintf(words, sizeof words, "%s", scene_integrator_name(row->integrator));
        else
            snprintf(words, sizeof words, "dt 1/%.4g s", 1 / row->dt);
        canvas_dot(c, (point){right + 30, y - 4}, 6, hues[row->group]);
        canvas_words(c, (point){right + 44, y}, WORDS, canvas_ink, words);
        y += 24;
    }
    y += 8;
    const char *const notes[] = {p->flies ? "at a point: the substep" : "at a point: substeps",
                                 "ring: the scene's own", "line: nothing is both",
                                 "faster and nearer"};
    for (int i = 0; i < 4; ++i)
        canvas_words(c, (point){right + 24, y + 20 * i}, WORDS, canvas_grey, notes[i]);
}

bool timestep_study_report_plot(const timestep_study_report *r, const char *path, duet_error *err)
{
    const timestep_study *p = r->study;
    axis x = axis_of(p, false, left, right);
    axis y = axis_of(p, true, bottom, top);
    canvas *c = canvas_open(path, WIDTH, HEIGHT, err);
    if (!c)
        return false;
    draw_frame(c, r, &x, &y);
    draw_front(c, p, &x, &y);
    for (uint32_t i = 0; i < p->n; ++i)
        draw_timestep(c, p, &p->rows[i], &x, &y);
    draw_key(c, p);
    return canvas_close(c, true, err);
}
