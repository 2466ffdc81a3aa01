// SPDX-License-Identifier: MIT
// What results of `duet bench` tell.
#include "cli/draw/chart.h"
#include "cli/draw/page.h"
#include "cli/report/html.h"
#include "cli/report/table.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { POINTS_MOST = 64, STAGES_MOST = 12 };

static const cJSON *cases_of(const cJSON *results)
{
    return cJSON_GetObjectItemCaseSensitive(results, "cases");
}

static bool is_measured(const cJSON *one)
{
    return !*json_string(one, "failed");
}

// The first case of its scene, among the measured.
static bool is_first_of_scene(const cJSON *results, const cJSON *one)
{
    const cJSON *other;
    cJSON_ArrayForEach(other, cases_of(results))
    {
        if (other == one)
            return is_measured(one);
        if (is_measured(other) &&
            strcmp(json_string(other, "scene"), json_string(one, "scene")) == 0)
            return false;
    }
    return false;
}

static void scene_words(const cJSON *one, char words[128])
{
    snprintf(words, 128, "%.60s, %.40s objects", json_string(one, "scene"),
             table_count((uint64_t)json_number(one, "objects")).chars);
}

static bool same(const cJSON *a, const cJSON *b, const char *field)
{
    return strcmp(json_string(a, field), json_string(b, field)) == 0;
}

// ---------------------------------------------------------------- shares

static chart_point point_of(const cJSON *one, const char *field)
{
    chart_point p = {.x = json_number(one, "share"), .y = json_number(one, field)};
    snprintf(p.says, sizeof p.says, "share %.2f: %.3f ms", p.x, p.y);
    return p;
}

// Over the share, by the mode and kernels of the scene's first case.
static void draw_shares(text *page, const cJSON *results, const cJSON *first)
{
    static const char *const fields[] = {"a_ms", "b_ms", "median_ms"};
    chart_point points[3][POINTS_MOST];
    char title[128];
    uint32_t n = 0;
    const cJSON *one;
    cJSON_ArrayForEach(one, cases_of(results))
    {
        if (n == POINTS_MOST || !is_measured(one) || !same(one, first, "scene") ||
            !same(one, first, "mode") || !same(one, first, "variant_a") ||
            !same(one, first, "variant_b"))
            continue;
        for (int k = 0; k < 3; ++k)
            points[k][n] = point_of(one, fields[k]);
        ++n;
    }
    scene_words(first, title);
    chart c = {.title = title, .x_label = "share of A", .y_label = "ms", .n_series = 3};
    c.series[0] = (chart_series){"A", "a", points[0], n, false};
    c.series[1] = (chart_series){"B", "b", points[1], n, false};
    c.series[2] = (chart_series){"step", "step", points[2], n, false};
    chart_draw(page, &c);
}

// ---------------------------------------------------------------- stages

// Stage names in the order in which results first have them: a name keeps its
// colour on the whole page. More than there are colours share the last.
typedef struct stage_names {
    const char *names[STAGES_MOST];
    uint32_t n;
} stage_names;

static uint32_t colour_of(const stage_names *names, const char *name)
{
    uint32_t i = 0;
    while (i < names->n && strcmp(names->names[i], name) != 0)
        ++i;
    return i < STAGES_MOST ? i : STAGES_MOST - 1;
}

static stage_names find_stages(const cJSON *results)
{
    stage_names found = {0};
    const cJSON *one;
    const cJSON *stage;
    cJSON_ArrayForEach(one, cases_of(results))
        cJSON_ArrayForEach(stage, cJSON_GetObjectItemCaseSensitive(one, "stages"))
    {
        const char *name = json_string(stage, "name");
        if (found.n < STAGES_MOST && colour_of(&found, name) == found.n)
            found.names[found.n++] = name;
    }
    return found;
}

static double device_ms(const cJSON *one, const char *device)
{
    double ms = 0;
    const cJSON *stage;
    cJSON_ArrayForEach(stage, cJSON_GetObjectItemCaseSensitive(one, "stages")) ms +=
        strcmp(json_string(stage, "device"), device) == 0 ? json_number(stage, "ms") : 0;
    return ms;
}

// Stages of one name are one part, however often they ran.
static void draw_device(chart_bars *bars, const cJSON *one, const char *device,
                        const stage_names *names)
{
    chart_part parts[STAGES_MOST] = {{0}};
    uint32_t n = 0;
    const cJSON *stage;
    cJSON_ArrayForEach(stage, cJSON_GetObjectItemCaseSensitive(one, "stages"))
    {
        uint32_t colour = colour_of(names, json_string(stage, "name"));
        uint32_t i = 0;
        if (strcmp(json_string(stage, "device"), device) != 0)
            continue;
        while (i < n && parts[i].colour != colour)
            ++i;
        n += i == n;
        parts[i].name = json_string(stage, "name");
        parts[i].colour = colour;
        parts[i].value += json_number(stage, "ms");
    }
    chart_bar(bars, device, parts, n);
}

static void case_words(const cJSON *one, char words[160])
{
    const char *b = json_string(one, "variant_b");
    bool both = strcmp(json_string(one, "variant_a"), b) == 0;
    snprintf(words, 160, "share %.2f, %s, %.40s%s%.40s: %.3f ms", json_number(one, "share"),
             json_string(one, "mode"), json_string(one, "variant_a"), both ? "" : " | ",
             both ? "" : b, json_number(one, "median_ms"));
}

static void draw_stages(text *page, const cJSON *results, const cJSON *first,
                        const stage_names *names)
{
    char words[160];
    double most = 0;
    uint32_t n = 0;
    const cJSON *one;
    cJSON_ArrayForEach(one, cases_of(results))
    {
        if (!is_measured(one) || !same(one, first, "scene"))
            continue;
        most = fmax(most, fmax(device_ms(one, "A"), device_ms(one, "B")));
        ++n;
    }
    scene_words(first, words);
    chart_bars bars = chart_bars_begin(page, words, most, "ms", n);
    cJSON_ArrayForEach(one, cases_of(results))
    {
        if (!is_measured(one) || !same(one, first, "scene"))
            continue;
        case_words(one, words);
        chart_bars_row(&bars, words);
        draw_device(&bars, one, "A", names);
        draw_device(&bars, one, "B", names);
    }
    chart_bars_end(&bars);
}

static void add_key(text *page, const stage_names *names)
{
    text_add(page, "<p>");
    for (uint32_t i = 0; i < names->n; ++i) {
        text_add(page, "<span class=\"key\"><i style=\"background:var(--s%u)\"></i>", i);
        page_words(page, "%s", names->names[i]);
        text_add(page, "</span>");
    }
    text_add(page, "</p>\n");
}

// ---------------------------------------------------------------- history

// The best step of a scene in each of the results.
static void draw_history(text *page, cJSON *const *results, uint32_t n, const cJSON *first)
{
    chart_point points[POINTS_MOST];
    char title[128];
    uint32_t n_points = 0;
    for (uint32_t i = 0; i < n && n_points < POINTS_MOST; ++i) {
        const cJSON *best = NULL;
        const cJSON *one;
        cJSON_ArrayForEach(one, cases_of(results[i]))
        {
            bool alike = is_measured(one) && same(one, first, "scene") &&
                         json_number(one, "objects") == json_number(first, "objects");
            if (alike && (!best || json_number(one, "median_ms") < json_number(best, "median_ms")))
                best = one;
        }
        if (!best)
            continue;
        chart_point *p = &points[n_points++];
        *p = (chart_point){.x = i + 1, .y = json_number(best, "median_ms")};
        snprintf(p->says, sizeof p->says, "%.30s, Duet %.20s: %.3f ms",
                 json_string(results[i], "time"), json_string(results[i], "duet"), p->y);
    }
    scene_words(first, title);
    chart c = {.title = title,
               .x_label = "result, the latest last",
               .y_label = "ms",
               .counted = true,
               .n_series = 1};
    c.series[0] = (chart_series){"best plan", "step", points, n_points, false};
    chart_draw(page, &c);
}

// ---------------------------------------------------------------- all of it

static void add_devices(text *page, const cJSON *results)
{
    const cJSON *device;
    char letter = 'A';
    cJSON_ArrayForEach(device, cJSON_GetObjectItemCaseSensitive(results, "devices"))
        page_paragraph(page, "%c: %s, %s, driver %s, %s", letter++, json_string(device, "selector"),
                       json_string(device, "name"), json_string(device, "driver"),
                       json_string(device, "platform"));
}

void report_bench(text *page, cJSON *const *results, uint32_t n)
{
    const cJSON *latest = results[n - 1];
    stage_names names = find_stages(latest);
    const cJSON *one;

    page_section(page, "Standard set: shares");
    page_paragraph(page, "Measured %s by Duet %s.", json_string(latest, "time"),
                   json_string(latest, "duet"));
    add_devices(page, latest);
    page_charts(page);
    cJSON_ArrayForEach(one, cases_of(latest)) if (is_first_of_scene(latest, one))
        draw_shares(page, latest, one);
    page_charts_end(page);
    page_section_end(page);

    page_section(page, "Standard set: stages");
    add_key(page, &names);
    page_charts(page);
    cJSON_ArrayForEach(one, cases_of(latest)) if (is_first_of_scene(latest, one))
        draw_stages(page, latest, one, &names);
    page_charts_end(page);
    page_section_end(page);

    page_section(page, "Standard set: history");
    page_charts(page);
    cJSON_ArrayForEach(one, cases_of(latest)) if (is_first_of_scene(latest, one))
        draw_history(page, results, n, one);
    page_charts_end(page);
    page_section_end(page);
}
