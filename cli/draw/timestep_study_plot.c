// SPDX-License-Identifier: MIT
// The error of each run over its time, both by powers of ten. Contacts: a
// colour a dt, and the substeps as a number; free flight: a colour an
// integrator, and the steps a second.
#include "cli/draw/canvas.h"
#include "cli/report/table.h"
#include "cli/report/timestep_study_report.h"

#include <math.h>
#include <stdio.h>

enum { WIDTH = 860, HEIGHT = 560, WORDS = 13 };

static const double left = 84, right = 640, top = 70, bottom = 484;
static const colour ink = {0.13, 0.14, 0.16, 1};
static const colour grey = {0.42, 0.45, 0.50, 1};
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

static axis axis_of(const timestep_study *p, double (*of)(const timestep_run *row), double from,
                    double to)
{
    axis a = {INFINITY, -INFINITY, from, to};
    for (uint32_t i = 0; i < p->n; ++i)
        if (p->rows[i].finite)
            widen(&a, of(&p->rows[i]));
    if (!(a.least < a.most))
        a.least = -1, a.most = 1;
    return a;
}

static double time_of(const timestep_run *row)
{
    return row->ms;
}

static double error_of(const timestep_run *row)
{
    return row->error;
}

// ---------------------------------------------------------------- the frame

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
                         WORDS, grey, words);
        }
    }
}

static void draw_frame(canvas *c, const timestep_study_report *r, const axis *x, const axis *y)
{
    const point page[] = {{0, 0}, {WIDTH, 0}, {WIDTH, HEIGHT}, {0, HEIGHT}};
    char words[256];
    canvas_polygon(c, page, 4, paper, paper);
    snprintf(words, sizeof words, "What accuracy costs: %.60s, %s boxes, %.3g s", r->scene->name,
             table_count(r->scene->n).chars, r->study->time);
    canvas_words(c, (point){24, 32}, 19, ink, words);
    canvas_words(c, (point){24, 56}, WORDS, ink,
                 "distance from the reference at the end (root mean square)");
    draw_ticks(c, x, true);
    draw_ticks(c, y, false);
    canvas_line(c, (point){left, top}, (point){left, bottom}, grey, 1);
    canvas_line(c, (point){left, bottom}, (point){right, bottom}, grey, 1);
    canvas_words(c, (point){left + 180, bottom + 46}, WORDS, ink,
                 "ms that a second of the scene takes");
}

// ---------------------------------------------------------------- the study

// Free flight has no contacts, and compares integrators.
static bool by_integrator(const timestep_study *p)
{
    for (uint32_t i = 0; i < p->n; ++i)
        if (p->rows[i].integrator != DUET_INTEGRATOR_EULER)
            return true;
    return false;
}

// The dt's in their order, as they come.
static int hue_of(const timestep_study *p, const timestep_run *row)
{
    double seen[TIMESTEP_RUNS];
    int n = 0;
    if (by_integrator(p))
        return (int)row->integrator;
    for (uint32_t i = 0; i < p->n; ++i) {
        int k = 0;
        while (k < n && seen[k] != p->rows[i].dt)
            ++k;
        if (k == n)
            seen[n++] = p->rows[i].dt;
        if (p->rows[i].dt == row->dt)
            return k % N_HUES;
    }
    return 0;
}

static void draw_front(canvas *c, const timestep_study *p, const axis *x, const axis *y)
{
    const timestep_run *last = NULL; // the next faster one
    for (;;) {
        const timestep_run *next = NULL;
        for (uint32_t i = 0; i < p->n; ++i) {
            const timestep_run *row = &p->rows[i];
            if (row->front && (!last || row->ms > last->ms) && (!next || row->ms < next->ms))
                next = row;
        }
        if (!next)
            return;
        if (last)
            canvas_line(c, (point){place(x, last->ms), place(y, last->error)},
                        (point){place(x, next->ms), place(y, next->error)}, grey, 1.5);
        last = next;
    }
}

static void draw_timestep(canvas *c, const timestep_study *p, const timestep_run *row,
                          const axis *x, const axis *y)
{
    char words[32];
    point at = {place(x, row->ms), row->finite ? place(y, row->error) : top};
    if (row->own)
        canvas_dot(c, at, 11, ink);
    if (row->own)
        canvas_dot(c, at, 9, paper);
    canvas_dot(c, at, row->front ? 7 : 5, hues[hue_of(p, row)]);
    if (by_integrator(p))
        snprintf(words, sizeof words, "1/%.4g", row->substeps / row->dt);
    else
        snprintf(words, sizeof words, "%u%s", row->substeps, row->finite ? "" : " lost");
    canvas_words(c, (point){at.x + 12, at.y + 4}, WORDS, ink, words);
}

static void draw_key(canvas *c, const timestep_study *p)
{
    bool drawn[N_HUES] = {false};
    double y = top + 10;
    char words[48];
    for (uint32_t i = 0; i < p->n; ++i) {
        const timestep_run *row = &p->rows[i];
        int hue = hue_of(p, row);
        if (drawn[hue])
            continue;
        drawn[hue] = true;
        if (by_integrator(p))
            snprintf(words, sizeof words, "%s", timestep_integrator(row));
        else
            snprintf(words, sizeof words, "dt 1/%.4g s", 1 / row->dt);
        canvas_dot(c, (point){right + 30, y - 4}, 6, hues[hue]);
        canvas_words(c, (point){right + 44, y}, WORDS, ink, words);
        y += 24;
    }
    y += 8;
    const char *const notes[] = {
        by_integrator(p) ? "at a point: the substep" : "at a point: substeps",
        "ring: the scene's own", "line: nothing is both", "faster and nearer"};
    for (int i = 0; i < 4; ++i)
        canvas_words(c, (point){right + 24, y + 20 * i}, WORDS, grey, notes[i]);
}

bool timestep_study_report_plot(const timestep_study_report *r, const char *path, duet_error *err)
{
    const timestep_study *p = r->study;
    axis x = axis_of(p, time_of, left, right);
    axis y = axis_of(p, error_of, bottom, top);
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
