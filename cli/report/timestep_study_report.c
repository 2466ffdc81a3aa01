// SPDX-License-Identifier: MIT
#include "cli/report/timestep_study_report.h"

#include "base/text.h"
#include "cli/report/table.h"
#include "cli/say.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>

enum { BAR = 16 };

const char *timestep_integrator(const timestep_run *row)
{
    static const char *const names[] = {[DUET_INTEGRATOR_EULER] = "euler",
                                        [DUET_INTEGRATOR_VERLET] = "verlet",
                                        [DUET_INTEGRATOR_YOSHIDA] = "yoshida"};
    return names[row->integrator];
}

// ---------------------------------------------------------------- as text

typedef struct range {
    double least;
    double most;
} range;

// Of the errors that are any.
static range errors_of(const timestep_study *p)
{
    range r = {INFINITY, 0};
    for (uint32_t i = 0; i < p->n; ++i)
        if (p->rows[i].finite && p->rows[i].error > 0) {
            r.least = fmin(r.least, p->rows[i].error);
            r.most = fmax(r.most, p->rows[i].error);
        }
    return r;
}

static double slowest_ms(const timestep_study *p)
{
    double ms = 0;
    for (uint32_t i = 0; i < p->n; ++i)
        ms = fmax(ms, p->rows[i].ms);
    return ms;
}

// By powers of ten: a character at the least error.
static double digits_part(const timestep_run *row, range errors)
{
    if (!row->finite)
        return 1.0;
    if (!(row->error > 0))
        return 0.0;
    double most = log10(errors.most / errors.least) + 0.2;
    return (log10(row->error / errors.least) + 0.2) / most;
}

static void wrong_cells(table *t, const timestep_study *p, const timestep_run *row)
{
    if (!row->finite) {
        table_cell(t, "lost");
        table_cell(t, "%s", table_bar(1.0, BAR).chars);
        for (int i = 0; i < 3; ++i)
            table_cell(t, "-");
        return;
    }
    table_cell(t, "%.2g", row->error);
    table_cell(t, "%s", table_bar(digits_part(row, errors_of(p)), BAR).chars);
    table_cell(t, "%+.2g %%", 100 * row->energy);
    table_cell(t, "%.2g %%", 100 * row->gain);
    if (p->contact)
        table_cell(t, "%.2g", row->depth);
    else
        table_cell(t, "-");
}

static void print_row(table *t, const timestep_study *p, const timestep_run *row)
{
    table_cell(t, "%s", row->front ? "*" : " ");
    table_cell(t, "1/%.4g", 1 / row->dt);
    table_cell(t, "%u%s", row->substeps, row->own ? " <" : "  ");
    table_cell(t, "%s", timestep_integrator(row));
    table_cell(t, "%.1f", row->ms);
    table_cell(t, "%s", table_bar(row->ms / slowest_ms(p), BAR).chars);
    wrong_cells(t, p, row);
}

void timestep_study_report_text(const timestep_study_report *r)
{
    static const char *const heads[] = {" ",     "dt", "substeps", "",     "ms a second", "",
                                        "error", "",   "energy",   "gain", "deepest"};
    const timestep_study *p = r->study;
    printf("%s: %s objects, %.3g s of the scene, on %s\n", r->scene->name,
           table_count(r->scene->n).chars, p->time,
           duet_device_pair_get_info(r->pair, 1)->selector);
    printf("reference: dt 1/%.4g, substeps %u, %s: %.1f ms a second, gain %.2g %%\n\n",
           1 / p->reference.dt, p->reference.substeps, timestep_integrator(&p->reference),
           p->reference.ms, 100 * p->reference.gain);
    table t = table_begin("lrrlrlrlrrr");
    for (size_t i = 0; i < sizeof heads / sizeof *heads; ++i)
        table_cell(&t, "%s", heads[i]);
    for (uint32_t i = 0; i < p->n; ++i)
        print_row(&t, p, &p->rows[i]);
    table_print(&t, stdout);
    if (p->n < p->n_asked)
        printf("\n%u dearer ones were not begun: the limit, or Ctrl-C, came before.\n",
               p->n_asked - p->n);
    printf(
        "\n* nothing is both faster and nearer to the reference; < the scene's own.\n"
        "error: root mean square distance of the centres from the reference's, by powers of ten;"
        "\nenergy: less the reference's at the end, gain: greatest rise on the way, both in the "
        "greatest\nkinetic energy; deepest: overlap of the worst contact, in the scene's unit.\n");
}

// ---------------------------------------------------------------- as data

static cJSON *row_json(const timestep_run *row)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddNumberToObject(o, "dt", row->dt);
    cJSON_AddNumberToObject(o, "substeps", row->substeps);
    cJSON_AddStringToObject(o, "integrator", timestep_integrator(row));
    cJSON_AddBoolToObject(o, "own", row->own);
    cJSON_AddNumberToObject(o, "ms_a_second", row->ms);
    cJSON_AddNumberToObject(o, "error", row->error);
    cJSON_AddNumberToObject(o, "energy", row->energy);
    cJSON_AddNumberToObject(o, "gain", row->gain);
    cJSON_AddNumberToObject(o, "depth", row->depth);
    cJSON_AddBoolToObject(o, "finite", row->finite);
    cJSON_AddBoolToObject(o, "front", row->front);
    return o;
}

bool timestep_study_report_json(const timestep_study_report *r, duet_error *err)
{
    const timestep_study *p = r->study;
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "scene", r->scene->name);
    cJSON_AddNumberToObject(o, "objects", r->scene->n);
    cJSON_AddStringToObject(o, "a", duet_device_pair_get_info(r->pair, 0)->selector);
    cJSON_AddStringToObject(o, "b", duet_device_pair_get_info(r->pair, 1)->selector);
    cJSON_AddNumberToObject(o, "time", p->time);
    cJSON_AddItemToObject(o, "reference", row_json(&p->reference));
    cJSON *rows = cJSON_AddArrayToObject(o, "timesteps");
    for (uint32_t i = 0; i < p->n; ++i)
        cJSON_AddItemToArray(rows, row_json(&p->rows[i]));
    return say_json(o, err);
}

bool timestep_study_report_csv(const timestep_study_report *r, const char *path, duet_error *err)
{
    text lines = {0};
    text_add(&lines,
             "dt,substeps,integrator,own,ms_a_second,error,energy,gain,depth,finite,front\n");
    for (uint32_t i = 0; i < r->study->n; ++i) {
        const timestep_run *row = &r->study->rows[i];
        text_add(&lines, "%.9g,%u,%s,%d,%.9g,%.9g,%.9g,%.9g,%.9g,%d,%d\n", row->dt, row->substeps,
                 timestep_integrator(row), row->own, row->ms, row->error, row->energy, row->gain,
                 row->depth, row->finite, row->front);
    }
    bool ok = text_ok(&lines, err) && text_write_file(path, text_chars(&lines), lines.length, err);
    text_free(&lines);
    return ok;
}
