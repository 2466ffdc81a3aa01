// SPDX-License-Identifier: MIT
#include "cli/report/cluster_run_report.h"

#include "cli/report/profile_report.h"
#include "cli/report/table.h"
#include "cli/say.h"

enum { UID_SHOWN = 8 };

static double megabytes_a_second(const profile_fabric *f)
{
    return f->byte_ns > 0 ? 1e3 / f->byte_ns : 0;
}

// ---------------------------------------------------------------- JSON

static cJSON *fabric_json(const cluster_run_entry *e)
{
    const profile_fabric *f = &e->fabric;
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "mpi", f->mpi);
    cJSON_AddNumberToObject(o, "hosts", f->hosts);
    cJSON_AddNumberToObject(o, "ranks", f->ranks);
    cJSON *times = f->times ? cJSON_Parse(f->times) : NULL;
    if (times) {
        cJSON_AddNumberToObject(o, "latency_us", f->latency_ns * 1e-3);
        cJSON_AddNumberToObject(o, "mb_per_s", megabytes_a_second(f));
        cJSON_AddItemToObject(o, "times_ns", times);
    }
    cJSON_AddStringToObject(o, "measured", profile_report_when(e->measured_ns).chars);
    return o;
}

static cJSON *run_json(const cluster_run_entry *e)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "uid", e->uid);
    cJSON_AddStringToObject(o, "scene", e->run.scene);
    cJSON_AddNumberToObject(o, "dims", e->run.dims);
    cJSON_AddNumberToObject(o, "objects", (double)e->run.n);
    cJSON_AddStringToObject(o, "level", e->run.level);
    cJSON_AddNumberToObject(o, "parts", e->run.parts);
    cJSON_AddBoolToObject(o, "resident", e->run.resident);
    cJSON_AddNumberToObject(o, "steps", (double)e->run.steps);
    cJSON_AddNumberToObject(o, "step_ms", e->run.median_ns * 1e-6);
    cJSON_AddNumberToObject(o, "least_ms", e->run.low_ns * 1e-6);
    cJSON_AddNumberToObject(o, "most_ms", e->run.high_ns * 1e-6);
    cJSON_AddNumberToObject(o, "efficiency", e->efficiency);
    cJSON_AddStringToObject(o, "measured", profile_report_when(e->created_ns).chars);
    cJSON_AddItemToObject(o, "fabric", fabric_json(e));
    return o;
}

static bool add_rank_json(void *context, uint32_t rank, const profile_cluster_rank *row)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddNumberToObject(o, "rank", rank);
    cJSON_AddStringToObject(o, "pair", row->devices);
    cJSON_AddNumberToObject(o, "objects", (double)row->n);
    cJSON_AddNumberToObject(o, "ghosts", (double)row->ghosts);
    cJSON_AddNumberToObject(o, "pairs", (double)row->pairs);
    cJSON_AddNumberToObject(o, "busy_ms", row->busy_ns * 1e-6);
    cJSON_AddNumberToObject(o, "wait_ms", row->wait_ns * 1e-6);
    cJSON_AddNumberToObject(o, "sent_bytes", (double)row->sent_bytes);
    return cJSON_AddItemToArray(context, o);
}

// ---------------------------------------------------------------- all of them

typedef struct listing {
    table rows;
    cJSON *json; // NULL: a table
    uint64_t n;
    bool apart;
} listing;

static bool list_run(void *context, const cluster_run_entry *e)
{
    enum { DAY = 10 }; // characters of a date without its time
    listing *l = context;
    ++l->n;
    if (l->json)
        return cJSON_AddItemToArray(l->json, run_json(e));
    if (l->n == 1) {
        printf("%sclusters:\n", l->apart ? "\n" : "");
        l->rows = table_begin("llrrrrl");
        table_words(&l->rows, "run", "workload", "ranks", "hosts", "ms", "busy %", "when", NULL);
    }
    table *t = &l->rows;
    table_cell(t, "%.*s", UID_SHOWN, e->uid);
    table_cell(t, "%s, %s", say_name(e->run.scene).chars, table_count(e->run.n).chars);
    table_words(t, table_count(e->fabric.ranks).chars, table_count(e->fabric.hosts).chars, NULL);
    table_cell(t, "%.3f", e->run.median_ns * 1e-6);
    table_cell(t, "%.1f", 100 * e->efficiency);
    table_cell(t, "%.*s", DAY, profile_report_when(e->created_ns).chars);
    return true;
}

bool cluster_run_report_list(store *s, bool apart, cJSON *json, uint64_t *n, duet_error *err)
{
    listing l = {.apart = apart,
                 .json = json ? cJSON_AddArrayToObject(json, "cluster_runs") : NULL};
    bool ok = cluster_run_each(s, NULL, list_run, &l, err);
    if (!json && l.n > 0)
        table_print(&l.rows, stdout);
    if (n)
        *n = l.n;
    return ok;
}

// ---------------------------------------------------------------- one of them

static bool add_rank_row(void *context, uint32_t rank, const profile_cluster_rank *row)
{
    table *t = context;
    table_cell(t, "%u", rank);
    table_words(t, say_name(row->devices).chars, table_count(row->n).chars,
                table_count(row->ghosts).chars, table_count(row->pairs).chars, NULL);
    table_cell(t, "%.3f", row->busy_ns * 1e-6);
    table_cell(t, "%.3f", row->wait_ns * 1e-6);
    table_words(t, table_bytes(row->sent_bytes).chars, NULL);
    return true;
}

static void print_fabric(const cluster_run_entry *e)
{
    const profile_fabric *f = &e->fabric;
    printf("\nfabric     %s, %s on %s", say_name(f->mpi).chars,
           table_things(f->ranks, "rank", "ranks").chars,
           table_things(f->hosts, "host", "hosts").chars);
    if (f->times)
        printf(": %.1f us, %.0f MB/s", f->latency_ns * 1e-3, megabytes_a_second(f));
    printf("; measured %s\n", profile_report_when(e->measured_ns).chars);
    cJSON *times = f->times ? cJSON_Parse(f->times) : NULL;
    if (!cJSON_IsObject(times) || !times->child) {
        cJSON_Delete(times);
        return;
    }
    table t = table_begin("rr");
    table_words(&t, "bytes", "us", NULL);
    for (const cJSON *time = times->child; time; time = time->next) {
        table_words(&t, say_name(time->string).chars, NULL);
        table_cell(&t, "%.1f", cJSON_IsNumber(time) ? time->valuedouble * 1e-3 : 0.0);
    }
    table_print(&t, stdout);
    cJSON_Delete(times);
}

static bool show_text(profile_showing *show, const cluster_run_entry *e)
{
    printf("run        %s, a cluster\n", say_name(e->uid).chars);
    printf("workload   %s, %uD, %s, level %s%s\n", say_name(e->run.scene).chars, e->run.dims,
           table_things(e->run.n, "box", "boxes").chars, say_name(e->run.level).chars,
           e->run.resident ? ", resident" : "");
    printf("step       %.3f ms, the median of %s; %.3f to %.3f\n", e->run.median_ns * 1e-6,
           table_count(e->run.steps).chars, e->run.low_ns * 1e-6, e->run.high_ns * 1e-6);
    printf("busy       %.1f %% of all ranks' time in the last step\n", 100 * e->efficiency);
    printf("when       %s\n\n", profile_report_when(e->created_ns).chars);
    table t = table_begin("rlrrrrrr");
    table_words(&t, "rank", "devices", "objects", "ghosts", "pairs", "busy ms", "wait ms", "sent",
                NULL);
    bool ok = cluster_rank_each(show->s, e->id, add_rank_row, &t, show->err);
    table_print(&t, stdout);
    print_fabric(e);
    return ok;
}

static bool show_json(profile_showing *show, const cluster_run_entry *e)
{
    cJSON *o = run_json(e);
    cJSON *ranks = cJSON_AddArrayToObject(o, "ranks");
    if (cluster_rank_each(show->s, e->id, add_rank_json, ranks, show->err))
        return say_json(o, show->err);
    cJSON_Delete(o);
    return false;
}

static bool show_run(void *context, const cluster_run_entry *e)
{
    profile_showing *show = context;
    show->ok = (show->json ? show_json : show_text)(show, e);
    return false;
}

bool cluster_run_report_show(store *s, const char *uid, bool json, duet_error *err)
{
    profile_showing show = {.s = s, .json = json, .err = err};
    return cluster_run_each(s, uid, show_run, &show, err) && show.ok;
}
