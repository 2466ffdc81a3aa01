// SPDX-License-Identifier: MIT
#include "profiles/row_line.h"

#include <string.h>

// clang-format off
#define SUBJECT \
    " JOIN workload ON workload.id = t.workload_id JOIN pair ON pair.id = t.pair_id" ENVS
#define ENVS " JOIN env a ON a.id = env_a JOIN env b ON b.id = env_b"

const line_type line_types[LINE_TYPES] = {
    {"device", "key kind vendor name arch units max_group local_bytes global_bytes", "",
     .order = "t.key"},
    {"env", "key seat device platform platform_version driver cl_version part part_units limits",
     " JOIN device ON device.id = t.device_id", .order = "t.key"},
    {"pair", "a b", ENVS, .order = "a.key, b.key"},
    {"workload", "key family name dims n cells_x cells_y cells_z cell occ_mean occ_p99 size_ratio "
     "shape rotated effects level query boxes", "", .order = "t.key"},
    {"level_cost", "a b workload kernels level step_ns true_pairs missed invented created_ns",
     SUBJECT, .order = "workload.key, a.key, b.key, t.kernels, t.level"},
    {"script", "key body", "", .order = "t.key"},
    {"session", "id state a b workload kernels strategy objective options seed script tool_version "
     "host pid pid_start resumed load timer_ns started_ns heartbeat_ns ended_ns",
     SUBJECT, .order = "t.started_ns, t.id"},
    {"trial", "session number timestamp created_ns configuration times invalidity reason launches "
     "outliers measurements objectives terms samples disturbed focus_ns spent_ns scope", "", "t.session_id, t.number",
     "INSERT INTO sample (trial_id, number, total_ns, a_ns, b_ns, transfer_ns, merge_ns, flags, "
     "at_ns, cpu_ns, wait_ns) SELECT ?2, value ->> 0, value ->> 1, value ->> 2, value ->> 3, "
     "value ->> 4, value ->> 5, value ->> 6, value ->> 7, coalesce(value ->> 8, 0), "
     "coalesce(value ->> 9, 0) FROM json_each(?1, '$.samples')"},
    {"profile", "uid a b workload kernels objective level share mode variant_a variant_b median_ns "
     "low_ns high_ns gain gain_low gain_high verdict missed_rate false_rate true_pairs single_ns "
     "best_share best_mode terms rounds whole_ns whole_gain whole_gain_low whole_gain_high origin "
     "session trial created_ns live dead_reason watched disturbed", SUBJECT,
     .order = "t.created_ns, t.uid"},
};
// clang-format on

const line_type *line_type_named(const char *name)
{
    for (int i = 0; i < LINE_TYPES; ++i)
        if (strcmp(line_types[i].name, name) == 0)
            return &line_types[i];
    return NULL;
}

// ---------------------------------------------------------------- fields

// A field that is not just the column of its name.
typedef struct line_field {
    const char *type; // the line's; NULL: any
    const char *name;
    const char *out;     // its value, of the row t
    const char *columns; // that it fills; NULL: none
    const char *in;      // their values, of line ?1
    bool is_object;
} line_field;

// clang-format off
#define ROW(table, field) "(SELECT id FROM " table " WHERE key = ?1 ->> '" field "')"
#define WORKLOAD ROW("workload", "workload")
#define PAIR \
    "(SELECT id FROM pair WHERE env_a = " ROW("env", "a") " AND env_b = " ROW("env", "b") ")"
#define OR_0(name) NULL, name, .out = "t." name, name, "coalesce(?1 ->> '" name "', 0)"
#define OBJECT_OR(none, name)                                                                   \
    NULL, name, .out = "CASE WHEN json_valid(t." name ") THEN CASE json_type(t." name ") WHEN "  \
    "'object' THEN json(t." name ") ELSE " none " END ELSE " none " END", name,                  \
    "?1 ->> '" name "'", true
#define CONFIGURED(name) "?1 ->> '$.configuration." name "'"
#define MEASUREMENT(name) "json_object('name', '" name "', 'value', " name "_ns, 'unit', 'ns')"
#define MEASURED(name) "(SELECT value ->> 'value' FROM json_each(?1, '$.measurements') " \
    "WHERE value ->> 'name' = '" name "')"
#define UNTRUSTED "?1 ->> 'verdict' = 'ambiguous'"
#define HAS_OWN "EXISTS (SELECT 1 FROM profile WHERE workload_id = " WORKLOAD " AND pair_id = "  \
    PAIR " AND objective = ?1 ->> 'objective' AND kernels = ?1 ->> 'kernels' AND "               \
    "level = ?1 ->> 'level' AND live = 1)"

static const line_field line_fields[] = {
    {"env", "device", .out = "device.key", "device_id", ROW("device", "device")},
    {"pair", "a", .out = "a.key", "env_a", ROW("env", "a")},
    {"pair", "b", .out = "b.key", "env_b", ROW("env", "b")},
    {NULL, "a", .out = "a.key", "pair_id", PAIR},
    {NULL, "b", .out = "b.key"},
    {NULL, "workload", .out = "workload.key", "workload_id", WORKLOAD},
    {NULL, "session", .out = "t.session_id", "session_id", "?1 ->> 'session'"},
    {OR_0("boxes")},
    {OR_0("watched")},
    {OR_0("disturbed")},
    {OR_0("focus_ns")},
    {OR_0("spent_ns")},
    {NULL, "scope", .out = "t.scope", "scope", "coalesce(?1 ->> 'scope', 65536)"},
    {OBJECT_OR("json('{}')", "options")},
    {OBJECT_OR("NULL", "terms")},
    // A trial has the form in which auto-tuners hand on what they measured.
    {"trial", "timestamp",
     .out = "strftime('%Y-%m-%dT%H:%M:%SZ', t.created_ns / 1000000000, 'unixepoch')"},
    {"trial", "configuration", .out = "json_object('share', share, 'mode', mode, 'level', level, "
     "'variant_a', variant_a, 'variant_b', variant_b)", "share, mode, level, variant_a, variant_b",
     CONFIGURED("share") "," CONFIGURED("mode") "," CONFIGURED("level") "," CONFIGURED("variant_a")
     "," CONFIGURED("variant_b")},
    {"trial", "times", .out = "json_object('compilation', build_ms, 'runtimes', "
     "(SELECT json_group_array(total_ns * 1e-6) FROM sample WHERE trial_id = t.id AND "
     "flags & 5 = 0))", "build_ms", "?1 ->> '$.times.compilation'"},
    {"trial", "invalidity", .out = "CASE outcome WHEN 'ok' THEN 'correct' WHEN 'build' "
     "THEN 'compile' WHEN 'launch' THEN 'runtime' WHEN 'wrong' THEN 'correctness' WHEN 'timeout' "
     "THEN 'timeout' ELSE 'constraints' END",
     "outcome", "CASE ?1 ->> 'invalidity' WHEN 'correct' THEN 'ok' WHEN 'compile' THEN 'build' "
     "WHEN 'runtime' THEN 'launch' WHEN 'correctness' THEN 'wrong' WHEN 'timeout' THEN 'timeout' "
     "WHEN 'constraints' THEN 'pruned' END"},
    {"trial", "measurements", .out = "iif(outcome = 'ok', json_array(" MEASUREMENT("median") ","
     MEASUREMENT("mad") "," MEASUREMENT("low") "," MEASUREMENT("high") "," MEASUREMENT("a") ","
     MEASUREMENT("b") "), json_array())", "median_ns, mad_ns, low_ns, high_ns, a_ns, b_ns",
     MEASURED("median") "," MEASURED("mad") "," MEASURED("low") "," MEASURED("high") ","
     MEASURED("a") "," MEASURED("b")},
    {"trial", "objectives", .out = "json_array('median')"},
    {"trial", "samples", .out = "(SELECT json_group_array(json_array(number, total_ns, a_ns, b_ns, "
     "transfer_ns, merge_ns, flags, at_ns, cpu_ns, wait_ns)) FROM sample WHERE trial_id = t.id)"},
    // The store's own live profile of a key stays live. A plan without a verdict never is.
    {"profile", "live", .out = "t.live", "live",
     "iif(" HAS_OWN " OR " UNTRUSTED ", 0, ?1 ->> 'live')"},
    {"profile", "dead_reason", .out = "t.dead_reason", "dead_reason",
     "iif(NOT ?1 ->> 'live', ?1 ->> 'dead_reason', iif(" UNTRUSTED
     ", 'too few rounds for a verdict', iif(" HAS_OWN
     ", 'the store had one of its own', ?1 ->> 'dead_reason')))"},
};
// clang-format on

// NULL: the field is the column of that name.
static const line_field *find_special(const line_type *type, const char *name, size_t n)
{
    for (size_t i = 0; i < sizeof line_fields / sizeof line_fields[0]; ++i) {
        const line_field *f = &line_fields[i];
        if (strncmp(f->name, name, n) == 0 && f->name[n] == '\0' &&
            (!f->type || strcmp(f->type, type->name) == 0))
            return f;
    }
    return NULL;
}

bool line_is_object(const line_type *type, const char *name)
{
    const line_field *special = find_special(type, name, strlen(name));
    return special && special->is_object;
}

// ---------------------------------------------------------------- statements

// The length of the next field's name at *at, which moves to it; 0: that was the last.
static int next_field(const char **at, int before)
{
    *at += before;
    *at += strspn(*at, " ");
    return (int)strcspn(*at, " ");
}

void line_add_select(text *t, const line_type *type)
{
    const char *at = type->fields;
    text_add(t, "SELECT json_object('type', '%s'", type->name);
    for (int n = 0; (n = next_field(&at, n)) > 0;) {
        const line_field *special = find_special(type, at, (size_t)n);
        text_add(t, ", '%.*s', ", n, at);
        if (special)
            text_add(t, "%s", special->out);
        else
            text_add(t, "t.%.*s", n, at);
    }
    text_add(t, ") FROM %s t%s ORDER BY %s", type->name, type->joins, type->order);
}

void line_add_insert(text *t, const line_type *type)
{
    const char *at = type->fields;
    text values = {0};
    text_add(t, "INSERT INTO %s (", type->name);
    for (int n = 0; (n = next_field(&at, n)) > 0;) {
        const line_field *special = find_special(type, at, (size_t)n);
        const char *comma = values.length > 0 ? ", " : "";
        if (!special) {
            text_add(t, "%s%.*s", comma, n, at);
            text_add(&values, "%s?1 ->> '%.*s'", comma, n, at);
        } else if (special->columns) {
            text_add(t, "%s%s", comma, special->columns);
            text_add(&values, "%s%s", comma, special->in);
        }
    }
    text_add(t, ") SELECT %s WHERE true ON CONFLICT DO NOTHING", text_chars(&values));
    t->failed = t->failed || values.failed;
    text_free(&values);
}
