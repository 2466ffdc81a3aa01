// SPDX-License-Identifier: MIT
// duet profiles: looks into the profile store, and moves rows in and out.
#include "cli/commands/profiles.h"

#include "base/clock.h"
#include "base/error.h"
#include "cli/commands.h"
#include "cli/options.h"
#include "cli/report/json.h"
#include "cli/report/rendering.h"
#include "cli/say.h"
#include "profiles/exchange.h"
#include "profiles/profile.h"
#include "profiles/t4.h"
#include "profiles/upkeep.h"

#include <errno.h>
#include <inttypes.h>
#include <string.h>

typedef struct verb verb;
typedef profiles_arguments arguments;

store *profiles_open(const char *path, store_access access, duet_error *err)
{
    store *s = store_open(path, access, err);
    if (s && store_note(s))
        fprintf(stderr, "duet: %s\n", say_name(store_note(s)).chars);
    return s;
}

// --------------------------------------------------------------------------- list

static const option list_options[] = {
    PROFILE_OPTION_ROW(store),
    OPTION_FLAG("dead", dead, "list unused profiles too, with the reason"),
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

static const command_line list_line = {
    .name = "profiles list",
    .about = "Lists the profiles of the store by device pair and size.",
    .options = list_options,
};

// --------------------------------------------------------------------------- show

static const option json_options[] = {
    PROFILE_OPTION_ROW(store),
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

static const command_line show_line = {
    .name = "profiles show",
    .operands = "PROFILE",
    .takes_empty = true,
    .about = "Shows a profile, named by the first digits that 'duet profiles list' prints,\n"
             "with the session it comes from and all its trials.",
    .options = json_options,
};

// --------------------------------------------------------------------------- diff

static const command_line diff_line = {
    .name = "profiles diff",
    .operands = "PROFILE PROFILE",
    .takes_empty = true,
    .about = "Shows two profiles side by side, and which one is faster.",
    .options = json_options,
};

// --------------------------------------------------------------------- use, forget

static const option uid_options[] = {
    PROFILE_OPTION_ROW(store),
    {0},
};

static const command_line use_line = {
    .name = "profiles use",
    .operands = "PROFILE",
    .about = "Makes a stored profile the one that applications load in its place, as it was\n"
             "before another replaced it. 'duet profiles list --dead' shows unused ones.",
    .options = uid_options,
};

static const command_line forget_line = {
    .name = "profiles forget",
    .operands = "PROFILE",
    .takes_empty = true,
    .about = "Removes a profile. What was measured for it stays, and no other takes its\n"
             "place.",
    .options = uid_options,
};

static bool use(store *s, const arguments *args, char **operands, duet_error *err)
{
    (void)args;
    if (!profile_use(s, operands[0], err))
        return false;
    printf("applications load %s from now on\n", operands[0]);
    return true;
}

static bool forget(store *s, const arguments *args, char **operands, duet_error *err)
{
    (void)args;
    if (!profile_forget(s, operands[0], err))
        return false;
    printf("%s is forgotten; 'duet tune' measures again\n", operands[0]);
    return true;
}

// ------------------------------------------------------------------------- export

static const option export_options[] = {
    PROFILE_OPTION_ROW(store),
    OPTION_FLAG("t4", t4, "write the trials alone, as one T4 document for other tuners' tools"),
    {0},
};

static const command_line export_line = {
    .name = "profiles export",
    .operands = "[FILE]",
    .about = "Writes the whole store as JSON lines, to FILE or to stdout. 'duet profiles import'\n"
             "reads them; it does not read T4.",
    .options = export_options,
};

static bool export_rows(store *s, const arguments *args, char **operands, duet_error *err)
{
    const char *path = operands[0];
    profile_export_format *format = args->t4 ? profile_export_t4 : profile_export;
    return path ? profile_export_file(s, format, path, err) : format(s, stdout, "stdout", err);
}

// ------------------------------------------------------------------ import, merge

static const command_line import_line = {
    .name = "profiles import",
    .operands = "FILE|-",
    .about = "Adds the rows of an export: all of them or, if a line is wrong, none.",
    .options = json_options,
};

static const command_line merge_line = {
    .name = "profiles merge",
    .operands = "OTHER.db",
    .about = "Adds the rows of another store, which is only read. Every row stays with\n"
             "its own devices and machine; the store's own profiles stay live.",
    .options = json_options,
};

static bool tell_counts(const arguments *args, const profile_import_counts *counts, duet_error *err)
{
    if (!args->json) {
        printf("%s rows added, %s known already\n", say_count(counts->added).chars,
               say_count(counts->known).chars);
        return true;
    }
    cJSON *o = cJSON_CreateObject();
    json_add(o, NUMBER("added", counts->added), NUMBER("known", counts->known));
    return say_json(o, err);
}

static bool import_rows(store *s, const arguments *args, char **operands, duet_error *err)
{
    const char *path = operands[0];
    bool is_stdin = strcmp(path, "-") == 0;
    FILE *in = is_stdin ? stdin : fopen(path, "r");
    if (!in)
        return error_set(err, errno == ENOENT ? DUET_STATUS_NOT_FOUND : DUET_STATUS_IO_FAILED,
                         "%s: %s", path, strerror(errno));
    profile_import_counts counts;
    bool ok = profile_import(s, in, is_stdin ? "stdin" : path, &counts, err);
    if (!is_stdin)
        fclose(in);
    return ok && tell_counts(args, &counts, err);
}

static bool merge_rows(store *s, const arguments *args, char **operands, duet_error *err)
{
    profile_import_counts counts;
    return profile_merge(s, operands[0], &counts, err) && tell_counts(args, &counts, err);
}

// -------------------------------------------------------------------------- prune

static const option prune_options[] = {
    PROFILE_OPTION_ROW(store),
    OPTION_COUNT("samples", samples, "K", "launches of each trial to keep (16)", 0, UINT32_MAX),
    OPTION_COUNT("older", days, "DAYS", "only what is older than that (0: all)", 0, 36500),
    OPTION_FLAG("dead", dead, "forget profiles that were replaced, too"),
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

static const command_line prune_line = {
    .name = "profiles prune",
    .about = "Thins the single launches of finished trials, whose medians and intervals stay.",
    .options = prune_options,
};

static bool prune(store *s, const arguments *args, char **operands, duet_error *err)
{
    (void)operands;
    const int64_t day_ns = 86400000000000;
    profile_prune_counts counts;
    profile_prune_def def = {
        .keep_samples = (uint32_t)args->samples,
        .before_ns = args->days ? clock_calendar_ns() - (int64_t)args->days * day_ns : INT64_MAX,
        .drop_dead = args->dead,
    };
    if (!profile_prune(s, &def, &counts, err))
        return false;
    cJSON *o = cJSON_CreateObject();
    json_add(o, NUMBER("samples", counts.samples), NUMBER("profiles", counts.profiles),
             NUMBER("bytes", counts.bytes));
    return rendering_tell(o, args->json, "cli/report/prune.lua", err);
}

// -------------------------------------------------------------------------- check

static const command_line check_line = {
    .name = "profiles check",
    .about = "Whether the file is whole and its rows are what their keys say.",
    .options = json_options,
};

static bool print_report(const arguments *args, const char *report, duet_error *err)
{
    if (!args->json) {
        say_lines(*report ? report : "sound\n");
        return true;
    }
    cJSON *o = cJSON_CreateObject();
    json_add_lines(o, "problems", report);
    return say_json(o, err);
}

static bool check(store *s, const arguments *args, char **operands, duet_error *err)
{
    (void)operands;
    text report = {0};
    uint32_t problems = 0;
    bool ok =
        profile_check(s, &report, &problems, err) && print_report(args, text_chars(&report), err);
    if (ok && problems > 0)
        ok = error_set(err, DUET_STATUS_STORE_FAILED,
                       "%s: %" PRIu32 " rows are not sound; bring back a copy, or export what is "
                       "left and import it into a fresh file",
                       store_path(s), problems);
    text_free(&report);
    return ok;
}

// --------------------------------------------------------------------- the verbs

struct verb {
    const char *name;
    const char *about; // in the list of verbs
    const command_line *line;
    store_access access;
    profiles_call *run;
};

static const verb verbs[] = {
    {"list", "list the profiles", &list_line, STORE_READ, profiles_list},
    {"show", "show one, with its trials and where it comes from", &show_line, STORE_READ,
     profiles_show},
    {"diff", "compare two, side by side", &diff_line, STORE_READ, profiles_diff},
    {"use", "make one the profile that applications load", &use_line, STORE_WRITE, use},
    {"forget", "remove one", &forget_line, STORE_WRITE, forget},
    {"why", "say which profile a scene would get here, and why", NULL, STORE_READ, NULL},
    {"export", "write the store as JSON lines, or its trials as T4", &export_line, STORE_READ,
     export_rows},
    {"import", "add the rows of such lines", &import_line, STORE_WRITE, import_rows},
    {"merge", "add the rows of another store", &merge_line, STORE_WRITE, merge_rows},
    {"prune", "thin out the stored launches", &prune_line, STORE_WRITE, prune},
    {"check", "check that the store is sound", &check_line, STORE_READ, check},
};

enum { N_VERBS = sizeof verbs / sizeof verbs[0] };

static bool run(void *given, char **operands, duet_error *err)
{
    const arguments *args = given;
    store *s = profiles_open(args->store, args->verb->access, err);
    bool ok = s && args->verb->run(s, args, operands, err) && store_check_read(s, err);
    store_close(s);
    return ok;
}

static void print_verbs(void)
{
    printf("duet profiles VERB [arguments]\nWhat was measured, and what applications load.\n\n");
    for (int i = 0; i < N_VERBS; ++i)
        printf("  %-18s %s\n", verbs[i].name, verbs[i].about);
    printf("\n'duet profiles VERB --help' lists its options.\n");
}

static int refuse_verb(const char *name)
{
    text known = {0};
    for (int i = 0; i < N_VERBS; ++i)
        text_add(&known, "%s%s", i ? ", " : "", verbs[i].name);
    int exit_code =
        say_wrong("profiles", "%s%s%s: give one of %s", *name ? "there is no '" : "",
                  *name ? name : "what to do is missing", *name ? "'" : "", text_chars(&known));
    text_free(&known);
    return exit_code;
}

int command_profiles(int argc, char **argv)
{
    const char *name = argc > 1 ? argv[1] : "";
    if (strcmp(name, "why") == 0)
        return profiles_why(argc - 1, argv + 1);
    for (int i = 0; i < N_VERBS; ++i) {
        arguments args = {.verb = &verbs[i], .samples = 16};
        if (strcmp(name, verbs[i].name) == 0)
            return options_run(verbs[i].line, argc - 1, argv + 1, &args, run);
    }
    if (strcmp(name, "--help") != 0 && strcmp(name, "-h") != 0)
        return refuse_verb(name);
    print_verbs();
    return EXIT_OK;
}
