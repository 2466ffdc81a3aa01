// SPDX-License-Identifier: MIT
// duet profiles list: the profiles by device pair and size, and the runs of clusters.
#include "cli/commands/profiles.h"
#include "cli/report/profile_report.h"
#include "cli/report/table.h"
#include "cli/say.h"

#include <stdio.h>
#include <string.h>

enum { UID_SHOWN = 8 }; // digits that tell profiles of one store apart

// Rows are gathered while the pair stays the same.
typedef struct listing {
    table rows;
    text notes;
    uint64_t n;
    int64_t pair_id;
    bool dead;
    cJSON *json; // an array; NULL: prints
} listing;

static table begin_rows(void)
{
    table t = table_begin("lllrrlll");
    table_words(&t, "profile", "workload", "plan", "ms", "gain %", "verdict", "when", "where",
                NULL);
    return t;
}

// Certified is exact and the default, and is not mentioned.
static void add_workload(table *t, const profile_entry *e)
{
    const char *scene = e->scene && *e->scene ? e->scene : "-";
    if (e->query && e->boxes == 0) {
        table_cell(t, "%s, %s, %s", scene, table_count((uint64_t)e->n).chars,
                   say_name(e->query).chars);
        return;
    }
    if (e->query) {
        table_cell(t, "%s, %s: %s %s", scene, table_count((uint64_t)e->boxes).chars,
                   table_count((uint64_t)e->n).chars, say_name(e->query).chars);
        return;
    }
    bool certified = strcmp(e->row.plan.level, "certified") == 0;
    table_cell(t, "%s, %s%s%s%s", scene, table_count((uint64_t)e->n).chars,
               e->moving ? ", moving" : "", certified ? "" : ", ",
               certified ? "" : e->row.plan.level);
}

static void add_row(table *t, const profile_entry *e)
{
    enum { DAY = 10 }; // characters of a date without its time
    const profile_row *row = &e->row;
    uint32_t share = row->plan.share;
    bool shared = share > 0 && share < PROFILE_SHARE_ONE;
    table_cell(t, "%.*s", UID_SHOWN, e->uid);
    add_workload(t, e);
    if (shared)
        table_cell(t, "A %.2f %%", 100.0 * share / PROFILE_SHARE_ONE);
    else
        table_words(t,
                    profile_report_is_one(e) ? "one device"
                    : share == 0             ? "B alone"
                                             : "A alone",
                    NULL);
    table_cell(t, "%.3f", row->median_ns * 1e-6);
    if (shared)
        table_cell(t, "%+.1f", 100 * row->gain);
    else
        table_words(t, "-", NULL);
    table_words(t, shared ? row->verdict : "-", NULL);
    table_cell(t, "%.*s", DAY, profile_report_when(e->created_ns).chars);
    table_words(t,
                e->dead_reason              ? e->dead_reason
                : profile_report_is_here(e) ? "here"
                                            : "elsewhere",
                NULL);
}

// Below the table, because few rows have it.
static void note_whole(text *notes, const profile_entry *e)
{
    const profile_row *row = &e->row;
    if (row->whole_ns > 0 && row->whole_gain_high < 0)
        text_add(
            notes, "%.*s: %s\n", UID_SHOWN, e->uid,
            table_whole(e->a.name, NULL, row->whole_gain, row->whole_gain_low, row->whole_gain_high)
                .chars);
}

static void print_rows(listing *l)
{
    table_print(&l->rows, stdout);
    say_lines(text_chars(&l->notes));
    text_free(&l->notes);
}

static bool list_entry(void *context, const profile_entry *e)
{
    listing *l = context;
    ++l->n;
    if (l->json)
        return cJSON_AddItemToArray(l->json, profile_report_json(e));
    bool dead = e->dead_reason != NULL;
    if (l->n == 1 || e->row.pair_id != l->pair_id || dead != l->dead) {
        if (l->n > 1) {
            print_rows(l);
            printf("\n");
        }
        if (dead && (l->n == 1 || !l->dead))
            printf("not used:\n");
        profile_report_device(profile_report_is_one(e) ? "" : "A: ", &e->a);
        if (!profile_report_is_one(e))
            profile_report_device("B: ", &e->b);
        l->rows = begin_rows();
    }
    add_row(&l->rows, e);
    note_whole(&l->notes, e);
    l->pair_id = e->row.pair_id;
    l->dead = dead;
    return true;
}

static bool count_entry(void *context, const profile_entry *e)
{
    *(uint64_t *)context += e->dead_reason != NULL;
    return true;
}

// Says why there is nothing to list.
static bool print_none(store *s, duet_error *err)
{
    uint64_t n_dead = 0;
    if (!profile_entry_each(s, NULL, true, count_entry, &n_dead, err))
        return false;
    printf("%s: ", say_name(store_path(s)).chars);
    if (n_dead == 0)
        printf("no profiles yet; duet tune makes them\n");
    else
        printf("no profile is in use; --dead shows the %s that %s not\n", table_count(n_dead).chars,
               n_dead == 1 ? "is" : "are");
    return true;
}

bool profiles_list(store *s, bool dead, bool json, duet_error *err)
{
    cJSON *o = json ? cJSON_CreateObject() : NULL;
    listing l = {.json = o ? cJSON_AddArrayToObject(o, "profiles") : NULL};
    if (o)
        json_add(o, STRING("store", store_path(s)));
    bool ok = profile_entry_each(s, NULL, dead, list_entry, &l, err);
    if (!o && l.n > 0) {
        print_rows(&l);
        printf(
            "plan: A's part of the work; B does the rest. gain: over the better device alone.\n");
    }
    if (!o && ok && l.n == 0)
        ok = print_none(s, err);
    if (ok && o)
        return say_json(o, err);
    cJSON_Delete(o);
    return ok;
}
