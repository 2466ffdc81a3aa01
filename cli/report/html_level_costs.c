// SPDX-License-Identifier: MIT
// What results of `duet accuracy` and `duet explain --measure` tell: the costs
// of being right, and of each effect.
#include "cli/draw/chart_rows.h"
#include "cli/draw/page.h"
#include "cli/report/html.h"
#include "cli/report/json.h"
#include "cli/report/table.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static double greatest(const cJSON *list, double of(const cJSON *row))
{
    double most = 0;
    const cJSON *row;
    cJSON_ArrayForEach(row, list) most = fmax(most, of(row));
    return most;
}

static double part_of(double value, double most)
{
    return most > 0 && value > 0 ? value / most : 0;
}

// ---------------------------------------------------------------- levels

static double step_ms(const cJSON *row)
{
    return json_number(row, "step_ms");
}

static double wrong(const cJSON *row)
{
    return json_number(row, "missed") + json_number(row, "false");
}

static double digits_of_wrong(const cJSON *row)
{
    return log10(1 + wrong(row));
}

static void add_level(chart_rows *rows, const cJSON *levels, const cJSON *row, const char *colour)
{
    char says[160];
    bool beaten = !json_true(row, "front");
    chart_cell cells[2] = {
        {part_of(step_ms(row), greatest(levels, step_ms)), colour, beaten, ""},
        {part_of(digits_of_wrong(row), greatest(levels, digits_of_wrong)), "mark", beaten, ""},
    };
    snprintf(cells[0].words, sizeof cells[0].words, "%.3g ms  %.2f×", step_ms(row),
             json_number(row, "relative"));
    snprintf(cells[1].words, sizeof cells[1].words, "%.31s",
             wrong(row) > 0 ? table_count((uint64_t)wrong(row)).chars : "none");
    snprintf(says, sizeof says, "%.20s: %.4g ms a step; %.0f pairs missed, %.0f false",
             json_string(row, "level"), step_ms(row), json_number(row, "missed"),
             json_number(row, "false"));
    chart_rows_add(rows, json_string(row, "level"), says, cells);
}

static void draw_levels(text *page, const cJSON *one, const char *letter, const char *selector,
                        const char *colour)
{
    static const char *const heads[] = {"a step, and against sat15", "wrong pairs"};
    char title[256];
    uint32_t n = 0;
    const cJSON *row;
    const cJSON *levels = json_list(one, "levels");
    cJSON_ArrayForEach(row, levels) n += strcmp(json_string(row, "device"), letter) == 0;
    snprintf(title, sizeof title, "%.60s, %.20s objects, %.20s pairs; %s: %.60s",
             json_string(one, "scene"), table_count((uint64_t)json_number(one, "objects")).chars,
             table_count((uint64_t)json_number(one, "pairs")).chars, letter, selector);
    chart_rows rows = chart_rows_begin(page, title, heads, 2, n);
    cJSON_ArrayForEach(row, levels)
    {
        if (strcmp(json_string(row, "device"), letter) == 0)
            add_level(&rows, levels, row, colour);
    }
    chart_rows_end(&rows);
}

void report_levels(text *page, const cJSON *const *results, uint32_t n)
{
    page_section(page, "Accuracy against time");
    page_paragraph(page, "Each level of accuracy, alone on each device: the median time of a step, "
                         "and how many pairs it gets wrong, by powers of ten. Pale: another level "
                         "there is at least as fast and as right.");
    page_charts(page);
    for (uint32_t i = 0; i < n; ++i) {
        draw_levels(page, results[i], "A", json_string(results[i], "a"), "a");
        draw_levels(page, results[i], "B", json_string(results[i], "b"), "b");
    }
    page_charts_end(page);
    page_section_end(page);
}

// ---------------------------------------------------------------- effects

static double effect_ms(const cJSON *row)
{
    return json_number(row, "ms");
}

static double bytes(const cJSON *row)
{
    return json_number(row, "bytes");
}

static void add_effect(chart_rows *rows, const cJSON *effects, const cJSON *row)
{
    char says[256];
    chart_cell cells[2] = {
        {part_of(effect_ms(row), greatest(effects, effect_ms)), "step", false, "with others"},
        {part_of(bytes(row), greatest(effects, bytes)), "a", false, ""},
    };
    if (cJSON_HasObjectItem(row, "ms"))
        snprintf(cells[0].words, sizeof cells[0].words, "%.3f ms", effect_ms(row));
    snprintf(cells[1].words, sizeof cells[1].words, "%.0f bytes", bytes(row));
    snprintf(says, sizeof says, "%.20s, called for by: %.200s", json_string(row, "effect"),
             json_string(row, "called_by"));
    chart_rows_add(rows, json_string(row, "effect"), says, cells);
}

static void draw_effects(text *page, const cJSON *one)
{
    static const char *const heads[] = {"a step", "an object"};
    char title[256];
    uint32_t n = 0;
    const cJSON *row;
    const cJSON *effects = json_list(one, "effects");
    cJSON_ArrayForEach(row, effects) n += json_true(row, "active");
    snprintf(title, sizeof title, "%.60s, %.20s objects: %.3f ms a step with all of them",
             json_string(one, "scene"), table_count((uint64_t)json_number(one, "objects")).chars,
             json_number(one, "step_ms"));
    chart_rows rows = chart_rows_begin(page, title, heads, 2, n);
    cJSON_ArrayForEach(row, effects)
    {
        if (json_true(row, "active"))
            add_effect(&rows, effects, row);
    }
    chart_rows_end(&rows);
}

void report_effects(text *page, const cJSON *const *results, uint32_t n)
{
    page_section(page, "What effects cost");
    page_paragraph(page,
                   "The effects that each scene calls for: the time of a step less that of the "
                   "same scene without what calls for the effect, and the state that an object has "
                   "for it. An effect that others call for too has no time of its own.");
    page_charts(page);
    for (uint32_t i = 0; i < n; ++i)
        draw_effects(page, results[i]);
    page_charts_end(page);
    page_section_end(page);
}
