// SPDX-License-Identifier: MIT
#include "cli/report/level_costs_report.h"

#include "base/text.h"
#include "cli/draw/canvas.h"
#include "cli/interrupt.h"
#include "cli/report/table.h"
#include "cli/say.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

typedef struct watched {
    progress shown;
    const level_costs *costs;
    uint32_t rounds;
} watched;

static bool watch(void *context, const duet_tune_progress *p)
{
    watched *w = context;
    w->shown.total = (uint64_t)w->rounds * w->costs->n;
    progress_show(&w->shown, p->launches);
    return !interrupt_asked();
}

bool level_costs_show(level_costs *p, duet_device_pair *pair, const duet_scene *scene,
                      uint32_t rounds, duet_error *err)
{
    watched w = {progress_begin("step", 0), p, rounds};
    level_costs_def def = {.pair = pair,
                           .scene = scene,
                           .alone = true,
                           .rounds = rounds,
                           .watch = watch,
                           .watch_context = &w};
    bool ok = level_costs_measure(p, &def, err);
    progress_end(&w.shown);
    return ok;
}

static const char *name_of(const level_cost *row)
{
    return duet_level_get_info(row->level)->name;
}

static double undecided_share(const level_cost *row)
{
    return row->candidates ? (double)row->undecided / (double)row->candidates : 0;
}

// ---------------------------------------------------------------- as data

static void add_row(cJSON *list, const level_cost *row)
{
    cJSON *o = json_add_row(list);
    json_add(o, STRING("level", name_of(row)), STRING("device", row->device == 0 ? "A" : "B"),
             NUMBER("step_ms", row->step_ms), NUMBER("relative", row->relative),
             FLAG("same", row->same), NUMBER("relative_low", row->relative_low));
    if (isfinite(row->relative_high))
        json_add(o, NUMBER("relative_high", row->relative_high));
    json_add(o, NUMBER("pairs", row->pairs), NUMBER("missed", row->missed),
             NUMBER("false", row->added), NUMBER("deepest_missed", row->deepest_missed),
             NUMBER("widest_false", row->widest_added),
             NUMBER("undecided_share", undecided_share(row)), FLAG("front", row->front));
}

cJSON *level_costs_report_json(const level_costs_report *r)
{
    cJSON *o = cJSON_CreateObject();
    json_add(o, STRING("type", LEVEL_COSTS_TYPE), STRING("scene", r->scene->name),
             NUMBER("objects", r->scene->n), NUMBER("pairs", r->costs->truth));
    json_add_devices(o, r->pair);
    json_add(o, NUMBER("rounds", r->costs->rounds));
    json_add_cores(o, &r->costs->cores);
    cJSON *levels = cJSON_AddArrayToObject(o, "levels");
    for (uint32_t i = 0; i < r->costs->n; ++i)
        add_row(levels, &r->costs->rows[i]);
    return o;
}

bool level_costs_report_check(const cJSON *o, const char *path, duet_error *err)
{
    static const json_field whole[] = {
        {"scene", cJSON_IsString, "a string"},
        {"objects", JSON_COUNT},
        {"pairs", JSON_COUNT},
        {"a", cJSON_IsString, "a string"},
        {"b", cJSON_IsString, "a string"},
        {"levels", cJSON_IsArray, "a list"},
        {0},
    };
    static const json_field row[] = {
        {"level", cJSON_IsString, "a string"},
        {"device", cJSON_IsString, "a string"},
        {"step_ms", JSON_AMOUNT},
        {"relative", JSON_AMOUNT},
        {"missed", JSON_COUNT},
        {"false", JSON_COUNT},
        {0},
    };
    return json_require(o, whole, path, err) &&
           json_require_each(json_list(o, "levels"), row, path, "level", err);
}

bool level_costs_report_csv(const level_costs_report *r, const char *path, duet_error *err)
{
    text lines = {0};
    text_add(&lines, "device,level,step_ms,relative,same,pairs,missed,false,deepest_missed,"
                     "widest_false,undecided_share,front\n");
    for (uint32_t i = 0; i < r->costs->n; ++i) {
        const level_cost *row = &r->costs->rows[i];
        text_add(&lines,
                 "%s,%s,%.9g,%.9g,%d,%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%.9g,%.9g,%.9g,%d\n",
                 duet_device_pair_get_info(r->pair, row->device)->selector, name_of(row),
                 row->step_ms, row->relative, row->same, row->pairs, row->missed, row->added,
                 row->deepest_missed, row->widest_added, undecided_share(row), row->front);
    }
    return say_to_file(&lines, path, err);
}

// ---------------------------------------------------------------- as a picture

// A row a level, its time to the left and what it gets wrong to the right, by powers
// of ten from one pair on.
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
    canvas_words(c, (point){names_x, y}, words_px, canvas_ink,
                 duet_level_get_info(row->level)->name);
    double length = bar_px * row->step_ms / greatest(p, time_of);
    draw_bar(c, times_x, y, length, row->front ? time_fill : beaten_fill);
    snprintf(words, sizeof words, "%.3g ms, %.2f x", row->step_ms, row->relative);
    canvas_words(c, (point){times_x + length + 8, y}, words_px, canvas_ink, words);
    double most = greatest(p, digits_of_wrong);
    length = most > 0 ? bar_px * digits_of_wrong(row) / most : 0;
    draw_bar(c, wrongs_x, y, length, wrong_fill);
    snprintf(words, sizeof words, "%s", table_count(row->missed + row->added).chars);
    canvas_words(c, (point){wrongs_x + length + 8, y}, words_px, canvas_ink,
                 row->missed + row->added ? words : "none");
}

// "A: pocl:0[0], its name", without the letter if the device is the only one.
static text device_words(const level_costs_report *r, int device)
{
    const duet_device_info *info = duet_device_pair_get_info(r->pair, device);
    text words = {0};
    if (!duet_device_pair_is_one(r->pair))
        text_add(&words, "%c alone: ", "AB"[device]);
    text_add(&words, "%.60s, %.120s", info->selector, info->name);
    return words;
}

static void draw_device(canvas *c, const level_costs_report *r, int device, double *y)
{
    text words = device_words(r, device);
    canvas_words(c, (point){names_x, *y}, words_px, canvas_grey, text_chars(&words));
    text_free(&words);
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
    const int first = duet_device_pair_is_one(r->pair);
    double height = HEAD + (2 - first) * DEVICE_HEAD + ROW * (double)r->costs->n + FOOT;
    canvas *c = canvas_open(path, WIDTH, height, err);
    if (!c)
        return false;
    char words[256];
    snprintf(words, sizeof words, "What accuracy costs: %.80s, %s", r->scene->name,
             table_things(r->scene->n, "box", "boxes").chars);
    canvas_words(c, (point){names_x, 34}, 20, canvas_ink, words);
    canvas_words(c, (point){times_x, 66}, words_px, canvas_ink, "time a step, and against sat15");
    canvas_words(c, (point){wrongs_x, 66}, words_px, canvas_ink, "wrong pairs, by powers of ten");
    double y = HEAD;
    for (int device = first; device < 2; ++device)
        draw_device(c, r, device, &y);
    canvas_words(c, (point){names_x, y}, words_px, canvas_grey,
                 "Pale: another level on that device is at least as fast and as right.");
    return canvas_close(c, true, err);
}
