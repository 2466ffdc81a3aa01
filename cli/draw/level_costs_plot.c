// SPDX-License-Identifier: MIT
// The table of level costs as a picture: a row a level, its time to the left and what it
// gets wrong to the right, by powers of ten from one pair on.
#include "cli/report/level_costs_report.h"

#include "cli/draw/canvas.h"
#include "cli/report/table.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

static const colour ink = {0.13, 0.14, 0.16, 1};
static const colour grey = {0.42, 0.45, 0.50, 1};
static const colour paper = {1, 1, 1, 1};
static const colour time_fill = {0.36, 0.53, 0.74, 1};
static const colour beaten_fill = {0.74, 0.80, 0.87, 1};
static const colour wrong_fill = {0.80, 0.30, 0.20, 1};

enum { WIDTH = 960, ROW = 30, HEAD = 96, DEVICE_HEAD = 44, FOOT = 46 };
static const double names_x = 24, times_x = 120, wrongs_x = 560, bar_px = 260, words_px = 14;

static void draw_bar(canvas *c, double x, double y, double length, colour fill)
{
    const point corners[] = {{x, y - 15}, {x + length, y - 15}, {x + length, y + 5}, {x, y + 5}};
    canvas_polygon(c, corners, 4, fill, fill);
}

static double greatest(const level_costs *p, double (*of)(const level_cost *row))
{
    double most = 0;
    for (uint32_t i = 0; i < p->n; ++i)
        most = fmax(most, of(&p->rows[i]));
    return most;
}

static double time_of(const level_cost *row)
{
    return row->step_ms;
}

static double digits_of_wrong(const level_cost *row)
{
    return log10(1.0 + (double)(row->missed + row->added));
}

static void draw_row(canvas *c, const level_costs *p, const level_cost *row, double y)
{
    char words[160];
    canvas_words(c, (point){names_x, y}, words_px, ink, duet_level_get_info(row->level)->name);
    double length = bar_px * row->step_ms / greatest(p, time_of);
    draw_bar(c, times_x, y, length, row->front ? time_fill : beaten_fill);
    snprintf(words, sizeof words, "%.3g ms, %.2f x", row->step_ms, row->relative);
    canvas_words(c, (point){times_x + length + 8, y}, words_px, ink, words);
    double most = greatest(p, digits_of_wrong);
    length = most > 0 ? bar_px * digits_of_wrong(row) / most : 0;
    draw_bar(c, wrongs_x, y, length, wrong_fill);
    snprintf(words, sizeof words, "%s", table_count(row->missed + row->added).chars);
    canvas_words(c, (point){wrongs_x + length + 8, y}, words_px, ink,
                 row->missed + row->added ? words : "none");
}

static void draw_device(canvas *c, const level_costs_report *r, int device, double *y)
{
    char words[256];
    const duet_device_info *info = duet_device_pair_get_info(r->pair, device);
    snprintf(words, sizeof words, "%c: %.60s, %.120s", "AB"[device], info->selector,
             info->name);
    canvas_words(c, (point){names_x, *y}, words_px, grey, words);
    *y += ROW;
    for (uint32_t i = 0; i < r->costs->n; ++i) {
        if (r->costs->rows[i].device != device)
            continue;
        draw_row(c, r->costs, &r->costs->rows[i], *y);
        *y += ROW;
    }
    *y += DEVICE_HEAD - ROW;
}

bool level_costs_report_plot(const level_costs_report *r, const char *path, duet_error *err)
{
    double height = HEAD + 2 * DEVICE_HEAD + ROW * (double)r->costs->n + FOOT;
    canvas *c = canvas_open(path, WIDTH, height, err);
    if (!c)
        return false;
    const point page[] = {{0, 0}, {WIDTH, 0}, {WIDTH, height}, {0, height}};
    canvas_polygon(c, page, 4, paper, paper);
    char words[256];
    snprintf(words, sizeof words, "What accuracy costs: %.80s, %s boxes", r->scene->name,
             table_count(r->scene->n).chars);
    canvas_words(c, (point){names_x, 34}, 20, ink, words);
    canvas_words(c, (point){times_x, 66}, words_px, ink, "time a step, and against sat15");
    canvas_words(c, (point){wrongs_x, 66}, words_px, ink, "wrong pairs, by powers of ten");
    double y = HEAD;
    draw_device(c, r, 0, &y);
    draw_device(c, r, 1, &y);
    canvas_words(c, (point){names_x, y}, words_px, grey,
                 "Pale: another level on that device is at least as fast and as right.");
    return canvas_close(c, true, err);
}
