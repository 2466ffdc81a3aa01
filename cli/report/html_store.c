// SPDX-License-Identifier: MIT
// What the profile store tells.
#include "base/error.h"
#include "cli/commands/profiles.h"
#include "cli/draw/chart.h"
#include "cli/draw/page.h"
#include "cli/report/html.h"
#include "cli/report/table.h"
#include "profiles/profile.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// A profile as the charts need it, live or replaced.
typedef struct kept {
    int64_t pair_id;
    int64_t workload_id;
    char title[512];
    char scene[64];
    char session[PROFILE_ID];
    profile_plan plan;
    double ms;
    double wrong; // pairs missed and in excess, by true pairs
    int64_t created_ns;
    bool live;
} kept;

typedef struct kept_list {
    kept *items;
    uint32_t n;
    uint32_t capacity;
    bool failed;
} kept_list;

static kept *next_kept(kept_list *list)
{
    if (list->n == list->capacity) {
        uint32_t capacity = list->capacity ? 2 * list->capacity : 64;
        kept *items = realloc(list->items, capacity * sizeof *items);
        list->failed = !items;
        if (!items)
            return NULL;
        list->items = items;
        list->capacity = capacity;
    }
    kept *item = &list->items[list->n++];
    *item = (kept){0};
    return item;
}

static bool keep(void *context, const profile_entry *e)
{
    kept *k = next_kept(context);
    if (!k)
        return false;
    k->pair_id = e->row.pair_id;
    k->workload_id = e->row.workload_id;
    snprintf(k->scene, sizeof k->scene, "%s", e->scene ? e->scene : "a scene");
    snprintf(k->title, sizeof k->title, "%.60s, %s objects: %s | %s, %s, level %s", k->scene,
             table_count((uint64_t)e->n).chars, e->row.plan.variant_a, e->row.plan.variant_b,
             e->row.plan.mode, e->row.plan.level);
    snprintf(k->session, sizeof k->session, "%s", e->session.id ? e->session.id : "");
    k->plan = e->row.plan;
    k->ms = e->row.median_ns * 1e-6;
    k->wrong = e->row.missed_rate + e->row.false_rate;
    k->created_ns = e->created_ns;
    k->live = e->dead_reason == NULL;
    return true;
}

// ---------------------------------------------------------------- profiles

static void device_words(const profile_entry_device *d, char *words, size_t size)
{
    snprintf(words, size, "%s%s%s%s, driver %s", d->name, d->part ? " [" : "",
             d->part ? d->part : "", d->part ? "]" : "", d->driver);
}

static void plan_cells(page_table *t, const profile_entry *e)
{
    const profile_plan *plan = &e->row.plan;
    page_cell(t, "%.4f", plan->share / (double)PROFILE_SHARE_ONE);
    page_cell(t, "%s", plan->mode);
    page_cell(t, "%s", plan->variant_a);
    page_cell(t, "%s", plan->variant_b);
    page_cell(t, "%s", plan->level);
}

static bool add_profile(void *context, const profile_entry *e)
{
    page_table *t = context;
    char device[512];
    page_cell(t, "%s", e->scene ? e->scene : "-");
    page_cell(t, "%s", table_count((uint64_t)e->n).chars);
    plan_cells(t, e);
    page_cell(t, "%.3f", e->row.median_ns * 1e-6);
    page_cell(t, "%.3f to %.3f", e->row.low_ns * 1e-6, e->row.high_ns * 1e-6);
    page_cell(t, "%+.1f %%", 100 * e->row.gain);
    page_cell(t, "%+.1f to %+.1f", 100 * e->row.gain_low, 100 * e->row.gain_high);
    page_cell(t, "%s", e->row.verdict);
    page_cell(t, "%s", profiles_when(e->created_ns).chars);
    device_words(&e->a, device, sizeof device);
    page_cell(t, "%s", device);
    device_words(&e->b, device, sizeof device);
    page_cell(t, "%s", device);
    return true;
}

static bool add_profiles(text *page, store *s, duet_error *err)
{
    static const char *const heads[] = {
        "scene",    "objects", "share",    "mode",    "A's kernels", "B's kernels", "level", "ms",
        "interval", "gain",    "interval", "verdict", "measured",    "A",           "B"};
    page_section(page, "Profiles");
    page_paragraph(page, "What applications load. The share is A's part of the work; the gain is "
                         "over the better of the two devices alone.");
    page_table t = page_table_begin(page, "lrrllllrrrrllll");
    for (size_t i = 0; i < sizeof heads / sizeof *heads; ++i)
        page_cell(&t, "%s", heads[i]);
    bool ok = profile_entry_each(s, NULL, false, add_profile, &t, err);
    page_table_end(&t);
    page_section_end(page);
    return ok;
}

// ---------------------------------------------------------------- searches

enum { TRIALS_MOST = 512 };

// A search's trials as points over the share; those of the profile's mode and
// kernels are lines, the others dots.
typedef struct trace {
    const profile_plan *plan;
    chart_point a[TRIALS_MOST];
    chart_point b[TRIALS_MOST];
    chart_point step[TRIALS_MOST];
    chart_point other[TRIALS_MOST];
    uint32_t n;
    uint32_t n_other;
} trace;

static chart_point point_of(const char *what, int64_t number, const profile_trial *trial, double ns)
{
    chart_point p = {.x = trial->plan.share / (double)PROFILE_SHARE_ONE, .y = ns * 1e-6};
    snprintf(p.says, sizeof p.says, "trial %" PRId64 ": share %.4f, %s %.3f ms", number, p.x, what,
             p.y);
    return p;
}

static bool trace_trial(void *context, int64_t number, const profile_trial *trial)
{
    trace *t = context;
    bool own = strcmp(trial->plan.mode, t->plan->mode) == 0 &&
               strcmp(trial->plan.variant_a, t->plan->variant_a) == 0 &&
               strcmp(trial->plan.variant_b, t->plan->variant_b) == 0;
    if (strcmp(trial->outcome, "ok") != 0)
        return true;
    if (!own && t->n_other < TRIALS_MOST)
        t->other[t->n_other++] = point_of(trial->plan.mode, number, trial, trial->median_ns);
    if (own && t->n < TRIALS_MOST) {
        t->a[t->n] = point_of("A", number, trial, trial->a_ns);
        t->b[t->n] = point_of("B", number, trial, trial->b_ns);
        t->step[t->n++] = point_of("step", number, trial, trial->median_ns);
    }
    return true;
}

static int by_x(const void *a, const void *b)
{
    double x = ((const chart_point *)a)->x;
    double y = ((const chart_point *)b)->x;
    return (x > y) - (x < y);
}

static int by_y(const void *a, const void *b)
{
    double x = ((const chart_point *)a)->y;
    double y = ((const chart_point *)b)->y;
    return (x > y) - (x < y);
}

// Trials of one share become one point, the one with their median time. Returns
// how many are left, by share.
static uint32_t merge_points(chart_point *points, uint32_t n)
{
    uint32_t left = 0;
    qsort(points, n, sizeof *points, by_x);
    for (uint32_t from = 0; from < n;) {
        uint32_t to = from + 1;
        while (to < n && points[to].x == points[from].x)
            ++to;
        qsort(points + from, to - from, sizeof *points, by_y);
        points[left++] = points[from + (to - from - 1) / 2];
        from = to;
    }
    return left;
}

static void draw_trace(text *page, const kept *k, trace *t)
{
    chart c = {.title = k->title,
               .x_label = "share of A",
               .y_label = "ms",
               .marked = true,
               .mark = k->plan.share / (double)PROFILE_SHARE_ONE,
               .n_series = 4};
    uint32_t n_a = merge_points(t->a, t->n);
    uint32_t n_b = merge_points(t->b, t->n);
    uint32_t n_step = merge_points(t->step, t->n);
    c.series[0] = (chart_series){"other plans", "s9", t->other, t->n_other, true};
    c.series[1] = (chart_series){"A", "a", t->a, n_a, false};
    c.series[2] = (chart_series){"B", "b", t->b, n_b, false};
    c.series[3] = (chart_series){"step", "step", t->step, n_step, false};
    chart_draw(page, &c);
}

static bool add_searches(text *page, store *s, const kept_list *list, duet_error *err)
{
    trace *t = malloc(sizeof *t);
    bool ok = t || error_set(err, DUET_STATUS_NO_MEMORY, "the traces of searches: no memory");
    page_section(page, "Searches");
    page_paragraph(page,
                   "The median time of each share that was tried: of A's part, of B's, and of the "
                   "step. The dashed line is the share that was chosen.");
    page_charts(page);
    for (uint32_t i = 0; ok && i < list->n; ++i) {
        const kept *k = &list->items[i];
        if (!k->live || !*k->session)
            continue;
        t->n = t->n_other = 0;
        t->plan = &k->plan;
        ok = profile_trial_each(s, k->session, trace_trial, t, err);
        if (ok && t->n + t->n_other > 0)
            draw_trace(page, k, t);
    }
    page_charts_end(page);
    page_section_end(page);
    free(t);
    return ok;
}

// ---------------------------------------------------------------- accuracy

static bool has_levels(const kept_list *list)
{
    for (uint32_t i = 1; i < list->n; ++i)
        if (strcmp(list->items[i].plan.level, list->items[0].plan.level) != 0)
            return true;
    return false;
}

// Only where more than one level was measured.
static void add_accuracy(text *page, const kept_list *list)
{
    if (!has_levels(list))
        return;
    page_section(page, "Accuracy against time");
    page_table t = page_table_begin(page, "llrr");
    static const char *const heads[] = {"workload", "level", "ms", "wrong pairs"};
    for (size_t i = 0; i < sizeof heads / sizeof *heads; ++i)
        page_cell(&t, "%s", heads[i]);
    for (uint32_t i = 0; i < list->n; ++i) {
        const kept *k = &list->items[i];
        if (!k->live)
            continue;
        page_cell(&t, "%s", k->title);
        page_cell(&t, "%s", k->plan.level);
        page_cell(&t, "%.3f", k->ms);
        page_cell(&t, "%.3g %%", 100 * k->wrong);
    }
    page_table_end(&t);
    page_section_end(page);
}

// ---------------------------------------------------------------- history

enum { HISTORY_MOST = 256 };

// The profiles of one workload on one pair, by age; true where there are two.
static bool draw_history(text *page, const kept_list *list, const kept *live)
{
    chart_point points[HISTORY_MOST];
    uint32_t n = 0;
    for (uint32_t i = 0; i < list->n && n < HISTORY_MOST; ++i) {
        const kept *k = &list->items[i];
        if (k->pair_id != live->pair_id || k->workload_id != live->workload_id)
            continue;
        points[n] = (chart_point){.x = (double)k->created_ns, .y = k->ms};
        snprintf(points[n].says, sizeof points[n].says, "%s: %.3f ms, share %.4f",
                 profiles_when(k->created_ns).chars, k->ms,
                 k->plan.share / (double)PROFILE_SHARE_ONE);
        ++n;
    }
    if (n < 2)
        return false;
    qsort(points, n, sizeof *points, by_x);
    for (uint32_t i = 0; i < n; ++i)
        points[i].x = i + 1;
    chart c = {.title = live->title,
               .x_label = "profile, the live one last",
               .y_label = "ms a step",
               .counted = true,
               .n_series = 1};
    c.series[0] = (chart_series){"profiles", "step", points, n, false};
    chart_draw(page, &c);
    return true;
}

static void add_history(text *page, const kept_list *list)
{
    bool any = false;
    page_section(page, "What became of the profiles");
    page_charts(page);
    for (uint32_t i = 0; i < list->n; ++i)
        if (list->items[i].live)
            any = draw_history(page, list, &list->items[i]) || any;
    page_charts_end(page);
    if (!any)
        page_paragraph(page, "No profile was replaced yet.");
    page_section_end(page);
}

bool report_store(text *page, store *s, duet_error *err)
{
    kept_list list = {0};
    bool ok = profile_entry_each(s, NULL, true, keep, &list, err);
    if (ok && list.failed)
        ok = error_set(err, DUET_STATUS_NO_MEMORY, "the profiles: no memory");
    if (ok && list.n == 0)
        page_paragraph(page, "%s: no profiles yet; duet tune makes them.", store_path(s));
    if (ok && list.n > 0) {
        ok = add_profiles(page, s, err) && add_searches(page, s, &list, err);
        add_accuracy(page, &list);
        add_history(page, &list);
    }
    free(list.items);
    return ok;
}
