// SPDX-License-Identifier: MIT
// duet tune, as a person calls it, and tune files.
#define _POSIX_C_SOURCE 200809L
#include "support/devices.h"
#include "support/json.h"
#include "support/store.h"
#include "support/test.h"

#include "base/text_file.h"
#include "cli/tune_config.h"

#define SCENE "test_tune.scene.lua"
#define STORE "test_tune.db"
#define CONFIG "test_tune.tune.lua"
#define STRATEGY "test_tune.strategy.lua"
#define AWKWARD "-test_tune's $HOME \t\xff.lua"
#define AWKWARD_WORD "\"$(printf -- '-test_tune\\047s $HOME \\t\\377.lua')\""
#define QUICK "--variants auto --profile " STORE " "
#define FEW "--trials 65 " // the fewest from which a verdict follows

static const char scene_text[] =
    "local p = parameters { n = 2000, seed = 1 }\n"
    "local random = random(p.seed)\n"
    "for _ = 1, p.n do\n"
    "  local x, y, z = random.uniform(0, 15), random.uniform(0, 15), random.uniform(0, 15)\n"
    "  add(x, y, z, 0.5, 0.5, 0.5, random.quaternion())\n"
    "end\n"
    "return { dims = 3 }\n";

static void begin_afresh(void)
{
    test_enter_folder();
    test_write_file(SCENE, scene_text);
}

// The rows of "workloads".
static const cJSON *tune_json(const char *arguments)
{
    const cJSON *rows = json_field(json_of_run("tune --json %s", arguments), "workloads");
    assert_true(cJSON_IsArray(rows));
    return rows;
}

TEST(a_workload_is_tuned_once_and_known_ever_after)
{
    const cJSON *rows = tune_json(QUICK FEW SCENE " -n 1000,2000");
    assert_int_equal(cJSON_GetArraySize(rows), 2);
    const cJSON *row = cJSON_GetArrayItem(rows, 1);
    assert_int_equal(json_number(row, "objects"), 2000);
    assert_true(json_number(row, "launches") > 0 && json_number(row, "seconds") > 0);
    assert_true(json_number(row, "gain_low") <= json_number(row, "gain"));
    assert_true(json_number(row, "gain") <= json_number(row, "gain_high"));
    assert_false(json_true(row, "known") || json_true(row, "resumed"));
    double share = json_number(row, "share");
    rows = tune_json(QUICK FEW SCENE " -n 2000");
    row = cJSON_GetArrayItem(rows, 0);
    assert_true(json_true(row, "known"));
    assert_int_equal(json_number(row, "launches"), 0);
    assert_true(json_number(row, "share") == share);
    rows = tune_json(QUICK FEW SCENE " -n 2000 --fresh");
    row = cJSON_GetArrayItem(rows, 0);
    assert_true(json_number(row, "launches") > 0);
    program_done(program_run("profiles forget --profile " STORE " %s", json_string(row, "uid")));
    rows = tune_json(QUICK FEW SCENE " -n 2000"); // the one before is none either
    assert_false(json_true(cJSON_GetArrayItem(rows, 0), "known"));
}

static double launches_of(const char *arguments)
{
    const cJSON *rows = tune_json(arguments);
    const cJSON *row = cJSON_GetArrayItem(rows, 0);
    double launches = json_number(row, "launches");
    assert_int_equal(launches == 0, json_true(row, "known"));
    return launches;
}

// And what is not the default search changes nothing that applications load, unless it
// is to.
TEST(what_was_not_asked_before_is_measured)
{
    skip_on_one_device();
    static const char *const questions[] = {
        "",
        "--strategy grid",
        "--strategy-lua " STRATEGY,
        "--trials 66",
    };
    enum { N = sizeof questions / sizeof *questions };
    test_write_file(STRATEGY, "return function(history)\n"
                              "  if #history < 3 then return #history / 2 end\nend\n");
    for (int again = 0; again < 2; ++again) {
        for (size_t i = 0; i < N; ++i) {
            char arguments[256];
            snprintf(arguments, sizeof arguments, QUICK FEW SCENE " -n 1000 %s", questions[i]);
            if ((launches_of(arguments) == 0) != again)
                fail_msg("%s: launches the %d. time", arguments, again + 1);
        }
    }
    cJSON *o = json_of_run("profiles list --dead --json --profile " STORE);
    const cJSON *row;
    int research = 0;
    cJSON_ArrayForEach(row, json_array(o, "profiles", N))
    {
        research +=
            !json_true(row, "live") && strstr(json_string(row, "dead_reason"), "without --keep");
    }
    assert_int_equal(research, 2);
    // A line says what is known, and how to measure it again.
    program p = program_run("tune " QUICK FEW SCENE " -n 1000");
    assert_says(p.out, "known: the same was measured before; --fresh measures it");
    remove(STORE);
    p = program_run("tune " QUICK FEW SCENE " -n 1000 --strategy grid --keep");
    assert_null(strstr(p.out, "not used by applications"));
}

TEST(every_line_of_the_table_fits_a_terminal)
{
    program p = program_done(program_run(
        "tune " FEW "--variants auto,simd --trials 80 --profile " STORE " " SCENE " -n 1000,2000"));
    assert_says(p.out, "plan: A's part of the work; B does the rest.");
    for (const char *at = p.out; *at; at += strcspn(at, "\n") + 1)
        assert_in_range(strcspn(at, "\n"), 0, 80);
}

// Gives what follows "duet " of the k-th command that was printed, with its continued lines.
static char *printed_command(const char *out, const char *name, int k)
{
    char begin[32];
    int length = snprintf(begin, sizeof begin, "\n  duet %s ", name);
    const char *from = strstr(out, begin);
    for (; from && k > 0; --k)
        from = strstr(from + 1, begin);
    if (!from)
        fail_msg("no 'duet %s' in:\n%s", name, out);
    const char *end = from + length;
    for (; *end && (*end != '\n' || end[-1] == '\\');)
        ++end;
    return strndup(from + strlen("\n  duet "), (size_t)(end - from) - strlen("\n  duet "));
}

// The pasted command against the tuning's row, and against the scene run as it was asked for.
static void assert_runs_as_printed(const char *command, const cJSON *row, const char *asked)
{
    cJSON *ran = json_of_run("%s --check --json", command),
          *plain = json_of_run("run --json %s", asked);
    const char *a = json_string(row, "variant_a"), *b = json_string(row, "variant_b");
    bool one = json_true(row, "one_device");
    char variant[600];
    snprintf(variant, sizeof variant, "%s%s%s", one ? b : a, one || !strcmp(a, b) ? "" : ",",
             one || !strcmp(a, b) ? "" : b);
    assert_string_equal(json_string(ran, "profile"), "given");
    assert_string_equal(json_string(ran, "variant"), variant);
    assert_true(json_number(ran, "share") == json_number(row, "share"));
    assert_string_equal(json_string(ran, "mode"), json_string(row, "mode"));
    assert_string_equal(json_string(ran, "level"), json_string(row, "level"));
    assert_int_equal(json_number(ran, "objects"), json_number(row, "objects"));
    assert_string_equal(json_string(ran, "hash"), json_string(plain, "hash"));
    assert_int_equal(json_true(ran, "ordered"), json_true(plain, "ordered"));
    assert_string_equal(json_string(ran, "pair"), json_string(plain, "pair"));
}

static void assert_tuning_prints_what_runs(const char *tuning, const char *asked, int k)
{
    program told = program_run("tune %s", tuning);
    const cJSON *rows = tune_json(tuning); // the same, which is known
    const cJSON *row = cJSON_GetArrayItem(rows, k);
    assert_true(json_true(row, "known"));
    char *command = printed_command(told.out, "run", k);
    assert_runs_as_printed(command, row, asked);
    assert_int_equal(strncmp(json_string(row, "command"), "duet run ", 9), 0);
    assert_runs_as_printed(json_string(row, "command") + strlen("duet "), row, asked);
    free(command);
}

TEST(a_plan_that_is_printed_runs_as_printed)
{
    static const struct {
        const char *tuning, *asked;
        int k; // which of its workloads
    } calls[] = {
        {SCENE " -n 1000,2000 --variants auto", SCENE " -n 2000", 1},
        {SCENE " -n 1000 --set seed=9 --pair halves --variants simd",
         SCENE " -n 1000 --seed 9 --pair halves", 0},
        {SCENE " --seed 4 --pair cpu --variants auto,simd,'auto sort=radix' --trials 90",
         SCENE " --seed 4 --pair cpu", 0},
        {SCENE " --pair 'pocl:0[1/2],pocl:0[2/2]' --variants 'simd sort=radix' --ordered",
         SCENE " --pair 'pocl:0[1/2],pocl:0[2/2]' --ordered", 0},
        {SCENE " --variants auto --level sat6", SCENE " --level sat6", 0},
        {"--config " CONFIG, SCENE " -n 600 --set seed=3 --pair halves", 1},
        {"--variants auto -- " AWKWARD_WORD, "-- " AWKWARD_WORD, 0},
    };
    test_write_file(CONFIG, "return {\n  workloads = { { scene = '" SCENE
                            "', n = { 500, 600 }, set = { seed = 3 } } },\n"
                            "  variants = { 'auto' }, pair = 'halves',\n}\n");
    test_write_file(AWKWARD, scene_text);
    for (size_t i = 0; i < sizeof calls / sizeof *calls; ++i) {
        char tuning[512];
        print_message("duet tune %s\n", calls[i].tuning);
        snprintf(tuning, sizeof tuning, FEW "--profile " STORE " %s", calls[i].tuning);
        assert_tuning_prints_what_runs(tuning, calls[i].asked, calls[i].k);
    }
}

TEST(the_tuning_that_a_run_names_measures_what_it_then_loads)
{
    static const char *const runs[] = {SCENE " -n 500 --set seed=3 --pair cpu",
                                       SCENE " -n 500 --pair halves --ordered --false-rate .1"};
    for (size_t i = 0; i < sizeof runs / sizeof *runs; ++i) {
        program p = program_run_with("DUET_PROFILE=" STORE, "run %s", runs[i]);
        char *tuning = printed_command(p.out, "tune", 0);
        program_done(program_run_with("DUET_PROFILE=" STORE, "%s --variants auto " FEW, tuning));
        cJSON *o = json_of_run_with("DUET_PROFILE=" STORE, "run --json %s", runs[i]);
        assert_string_equal(json_string(o, "profile"), "exact");
        free(tuning);
    }
}

TEST(the_command_that_uses_a_plan_names_its_store)
{
    skip_on_one_device();
    program p = program_run("tune " QUICK FEW SCENE " -n 500 --strategy grid");
    char *command = printed_command(p.out, "profiles", 0);
    program_done(program_run_with("DUET_PROFILE=nowhere.db", "%s", command));
    cJSON *o = json_of_run_with("DUET_PROFILE=" STORE, "run --json " SCENE " -n 500");
    assert_string_equal(json_string(o, "profile"), "exact");
    free(command);
}

TEST(the_terms_of_a_known_workload_are_those_that_were_measured)
{
    const cJSON *rows = tune_json(QUICK FEW SCENE);
    const cJSON *measured = cJSON_GetArrayItem(rows, 0);
    rows = tune_json(QUICK FEW SCENE);
    const cJSON *known = cJSON_GetArrayItem(rows, 0);
    static const char *const same[] = {"best_share", "gain", "gain_low", "gain_high", "single_ms"};
    for (size_t i = 0; i < sizeof same / sizeof *same; ++i)
        assert_true(fabs(json_number(known, same[i]) - json_number(measured, same[i])) < 1e-9);
    const cJSON *term, *terms = json_field(measured, "terms");
    double sum = 0;
    cJSON_ArrayForEach(term, terms)
    {
        const cJSON *other = json_field(known, "terms");
        assert_true(fabs(json_number(other, term->string) - term->valuedouble) < 1e-6);
        sum += fabs(term->valuedouble);
    }
    assert_true(sum > 0);
}

// Every level but certified is within it; what is chosen is stored at its level.
TEST(an_accuracy_chooses_a_level_and_serves_who_asks_for_no_more)
{
    const cJSON *rows = tune_json(QUICK FEW "--level sat6,aabb --false-rate 99 " SCENE);
    const cJSON *row = cJSON_GetArrayItem(rows, 0);
    char level[16];
    snprintf(level, sizeof level, "%s", json_string(row, "level"));
    assert_true(strcmp(level, "sat6") == 0 || strcmp(level, "aabb") == 0);
    double false_rate = json_number(row, "false_rate");
    assert_true(json_number(row, "missed_rate") == 0 && false_rate > 0.01);
    assert_true(json_number(row, "true_pairs") > 100);
    rows = tune_json(QUICK FEW "--level sat6,aabb --false-rate 99 " SCENE);
    assert_true(json_true(cJSON_GetArrayItem(rows, 0), "known"));
    assert_string_equal(json_string(cJSON_GetArrayItem(rows, 0), "level"), level);
    static const struct {
        const char *asked;
        bool served;
    } cases[] = {{"--false-rate 99", true},
                 {"--missed 0 --false-rate 0.001", false},
                 {"", false},
                 {"--level sat15", false}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        cJSON *o =
            json_of_run_with("DUET_PROFILE=" STORE, "run --json --check %s " SCENE, cases[i].asked);
        assert_int_equal(strcmp(json_string(o, "level"), level) == 0, cases[i].served);
        assert_int_equal(strcmp(json_string(o, "profile"), "exact") == 0, cases[i].served);
    }
    program why = program_run("profiles why --profile " STORE " --false-rate 0.001 " SCENE);
    assert_says(why.out, "no: for each true pair it misses 0 and adds ", "above 0 or 0.001");
}

TEST(an_accuracy_out_of_reach_names_the_nearest_level)
{
    program_assert_refused(program_run("tune " QUICK "--level aabb,sat6,sphere --missed 0 " SCENE),
                           1, "'sat6' comes nearest, with 0 and 0.");
}

TEST(a_scene_says_which_level_it_wants)
{
    char scene[1024];
    snprintf(scene, sizeof scene, "%.*s{ dims = 3, level = 'sat6' }\n",
             (int)(strstr(scene_text, "{ dims") - scene_text), scene_text);
    test_write_file(SCENE, scene);
    const cJSON *rows = tune_json(QUICK FEW SCENE);
    assert_string_equal(json_string(cJSON_GetArrayItem(rows, 0), "level"), "sat6");
    assert_true(json_number(cJSON_GetArrayItem(rows, 0), "false_rate") > 0.01);
    cJSON *o = json_of_run_with("DUET_PROFILE=" STORE, "run --json --check " SCENE);
    assert_string_equal(json_string(o, "level"), "sat6");
    assert_string_equal(json_string(o, "profile"), "exact");
}

static int64_t count_trials(void)
{
    store *s = store_open(STORE, STORE_READ, NULL);
    int64_t n = s ? test_count(s, "trial") : 0;
    store_close(s);
    return n;
}

// Stopped at several moments, by kill -9 and by Ctrl-C; what was measured
// before each stays measured. A slow machine is given more time, until it has measured.
TEST(a_stopped_tuning_is_taken_up_again)
{
    static const char *const signals[] = {"KILL", "INT", "KILL", "KILL", "INT"};
    enum { STOPS = sizeof signals / sizeof *signals };
    const char *duet = getenv("DUET_PROGRAM");
    assert_non_null(duet);
    double after = 0.3;
    for (int i = 0; i < STOPS || count_trials() == 0; ++i, after *= 1.3) {
        own(text) command = {0};
        text_add(&command,
                 "timeout -s %s %g '%s' tune " QUICK FEW "--repeat 32 " SCENE " >/dev/null 2>&1",
                 signals[i % STOPS], after, duet);
        int status = system(text_chars(&command));
        (void)status; // stopped, or finished before on a fast machine
    }
    const cJSON *rows = tune_json(QUICK FEW "--repeat 32 " SCENE);
    assert_true(json_true(cJSON_GetArrayItem(rows, 0), "resumed") ||
                json_true(cJSON_GetArrayItem(rows, 0), "known"));
}

// A loop of tunings in a shell ends with the first, as its user meant; nothing is stored
// of what was not measured. Tests that run in the background may have the signal ignored.
TEST(ctrl_c_ends_a_loop_of_tunings)
{
    own(text) command = {0};
    text_add(&command,
             "setsid --wait env --default-signal=INT bash -c '(sleep 1; kill -INT 0) & "
             "for i in 1 2 3; do \"%s\" tune " QUICK "--repeat 32 -n 300000 lua/scenes/paper.lua "
             ">/dev/null 2>>%s; echo $i >>%s; done' 2>/dev/null",
             getenv("DUET_PROGRAM"), STRATEGY, CONFIG);
    assert_int_not_equal(system(text_chars(&command)), 0);
    own(text) said = {0};
    assert_false(text_read_file(&said, CONFIG, NULL)); // not even the first went on
    assert_true(text_read_file(&said, STRATEGY, NULL));
    assert_says(text_chars(&said), "stopped");
    assert_null(strstr(strstr(text_chars(&said), "stopped") + 1, "stopped"));
    duet_error err = {0};
    store *s = store_open(STORE, STORE_WRITE, &err);
    if (s)
        assert_int_equal(test_count(s, "trial WHERE outcome <> 'ok'"), 0);
    store_close(s);
}

TEST(a_budget_of_trials_is_kept)
{
    skip_on_one_device();
    const cJSON *rows = tune_json(QUICK FEW "--repeat 1 --strategy fig12 " SCENE);
    const cJSON *row = cJSON_GetArrayItem(rows, 0);
    assert_in_range(json_number(row, "launches"), 20, 2 * 65);
    assert_string_not_equal(json_string(row, "verdict"), "ambiguous");
}

// Beside each other the other way round, the devices are the same.
static void assert_other_way_round_is_known(const char *search)
{
    cJSON *root = json_of_run("tune --pair 'pocl:0[2/2],pocl:0[1/2]' --json %s", search);
    const cJSON *row = cJSON_GetArrayItem(json_array(root, "workloads", 1), 0);
    assert_true(json_number(row, "launches") > 0);
    json_array(row, "kernels", 0);
}

// Searched once, followed by a run, and not searched again; what was tuned without
// a search is.
TEST(kernels_are_searched_once_and_runs_follow)
{
    static const char search[] = "--variants simd --trials 80 --repeat 1 --profile " STORE
                                 " --search pair_search_simd " SCENE;
    const cJSON *rows = tune_json("--variants simd --trials 66 --profile " STORE " " SCENE);
    assert_int_equal(json_size(cJSON_GetArrayItem(rows, 0), "kernels"), 0);
    rows = tune_json(search);
    const cJSON *row = cJSON_GetArrayItem(rows, 0), *one;
    const cJSON *kernels = json_field(row, "kernels");
    assert_true(json_number(row, "launches") > 0);
    assert_true(cJSON_GetArraySize(kernels) > 0);
    cJSON_ArrayForEach(one, kernels)
    {
        assert_int_equal(json_number(one, "configs"), 48);
        assert_in_range(json_number(one, "tried"), 2, 47);
        assert_true(json_number(one, "gain_low") <= json_number(one, "gain_high"));
        bool used = strstr(json_string(one, "variant"), " pair_search_simd.");
        assert_int_equal(used, strcmp(json_string(one, "verdict"), "faster") == 0);
    }
    rows = tune_json(search);
    assert_int_equal(json_number(cJSON_GetArrayItem(rows, 0), "launches"), 0);
    if (devices_are_two())
        assert_other_way_round_is_known(search);
    cJSON *o = json_of_run_with("DUET_PROFILE=" STORE, "run --json --check " SCENE);
    assert_string_equal(json_string(o, "profile"), "exact");
}

TEST(a_tune_file_sweeps_with_a_strategy_of_its_own)
{
    skip_on_one_device();
    test_write_file(CONFIG, "return {\n"
                            "  workloads = { { scene = '" SCENE
                            "', n = { 500, 600 }, set = { seed = 3 } },\n"
                            "    { scene = '" SCENE "', n = 500, query = 'boxes itself' } },\n"
                            "  variants = { 'auto' }, modes = { 'own' }, repeats = 1,\n"
                            "  budget = { trials = 43 },\n"
                            "  strategy = function(history)\n"
                            "    if #history < 3 then return #history / 2 end\n"
                            "  end,\n"
                            "}\n");
    const cJSON *rows = tune_json("--profile " STORE " --config " CONFIG);
    assert_int_equal(cJSON_GetArraySize(rows), 3);
    assert_int_equal(json_number(cJSON_GetArrayItem(rows, 0), "objects"), 500);
    assert_int_equal(json_number(cJSON_GetArrayItem(rows, 1), "objects"), 600);
    assert_string_equal(json_string(cJSON_GetArrayItem(rows, 2), "query"), "boxes itself");
    assert_int_equal(json_number(cJSON_GetArrayItem(rows, 2), "items"), 500);
}

// No share, and so no column about one.
TEST(one_device_is_told_its_kernels)
{
    program p = program_done(program_run("tune " QUICK SCENE " --pair cpu"));
    assert_int_equal(strncmp(p.out, "workload  ", 10), 0);
    assert_says(p.out, "  kernels  ", "  auto  ");
    assert_null(strstr(p.out, "gain"));
    assert_null(strstr(p.out, "verdict"));
}

// The plan of a motion, and what is said of it.
static void assert_runs(const char *arguments, const char *plan)
{
    program p = program_done(program_run_with("DUET_PROFILE=" STORE, "run %s", arguments));
    if (!strstr(p.out, plan))
        fail_msg("run %s: no '%s' in %s", arguments, plan, p.out);
}

TEST(a_motion_is_tuned_by_runs_and_run_follows)
{
    static const char motion[] = QUICK "falling -n 30 --pair cpu --search bodies --repeat 1 ";
    char arguments[256];
    for (int known = 0; known < 2; ++known) {
        snprintf(arguments, sizeof arguments, "%s --steps 4", motion);
        const cJSON *rows = tune_json(arguments);
        const cJSON *row = cJSON_GetArrayItem(rows, 0);
        assert_int_equal(json_true(row, "known"), known);
        assert_true(json_number(row, "steps") == 4 && json_number(row, "step_ms") > 0);
        assert_string_equal(json_string(row, "unused"), "");
    }
    assert_runs("falling -n 30 --pair cpu --steps 4", "plan: from the profile, exact: ");
    assert_runs("falling -n 50 --pair cpu --steps 4",
                "plan: from the profile, interpolated: that of another number of bodies");
    assert_runs("falling -n 30 --pair cpu", "plan: the default; to measure a better one:");
    assert_runs("marbles -n 31 --set friction=0.4 --pair cpu --steps 4",
                "plan: the default; to measure a better one:\n"
                "  duet tune marbles -n 31 --set friction=0.4 --pair pocl:0 --steps 60\n");
    assert_runs("falling -n 30 --pair halves --share 0 --steps 2",
                "plan: as given; A has nothing to do");
    program p = program_run("profiles why falling -n 30 --pair cpu --moving --profile " STORE);
    assert_says(p.out, " moving ", "\nexact: kernels ");
    p = program_run("profiles why falling -n 50 --pair cpu --moving --profile " STORE);
    assert_says(p.out, "yes: the plan of such a motion of 30 bodies",
                "\nthe plan of another workload: what a step takes and gains here is not known\n");
    p = program_run("profiles list --profile " STORE);
    assert_says(p.out, "falling, 30, moving");
    p = program_run("tune %s --steps 5", motion);
    assert_says(p.out, ", runs of 5 steps, ",
                "\n  duet run falling -n 30 --pair pocl:0 --steps 5 --share");
}

TEST(what_is_wrong_on_the_command_line_is_one_line)
{
    static const program_refusal rows[] = {
        {"tune", 2, "give a scene"},
        {"tune " QUICK SCENE " -n 10,x", 2, "--objects '10,x'"},
        {"tune " QUICK SCENE " --pair cpu --strategy grid", 2, "is one device and has no share"},
        {"tune " QUICK SCENE " --pair cpu --strategy foo", 2, "strategy 'foo': there is none"},
        {"tune --variants nonsense --profile " STORE " " SCENE, 2, "nonsense"},
        {"tune " QUICK " no/such.lua", 1, "no/such.lua"},
        {"tune --profile " SCENE " " SCENE, 1, SCENE},
        {"tune " QUICK SCENE " --trials 12", 2, "a budget of 12 trials ends before a verdict"},
        {"tune " QUICK SCENE " --trials 1", 2, "a budget of 1 trial ends before a verdict"},
        {"tune " SCENE " --items 9", 2, "--items: give --query"},
        {"tune " SCENE " --query rays --pair cpu", 2, "is one device and has no share"},
        {"tune --config " CONFIG " --query rays", 2, "with --config the file says"},
        {"tune --config " CONFIG " --steps 5", 2, "--steps: with --config the file says"},
        {"tune " QUICK SCENE " --steps 1", 2, "--steps '1'"},
        {"tune " QUICK SCENE " --steps 5", 2, "has no profile; expected bodies that something"},
        {"tune --profile " STORE " falling --steps 5 --query rays --pair halves", 2,
         "steps of a motion have no query"},
        {"tune " QUICK "falling --steps 5 --level sat6", 2, "have no level or accuracy"},
        {"tune " QUICK SCENE " --search abacus", 2, "search 'abacus': expected 'kernels' or"},
        {"tune " QUICK SCENE " --search cell_start", 1, "search 'cell_start': neither device"},
        {"tune " QUICK SCENE " --search kernels --budget 0", 2, "--budget '0'"},
        {"tune " QUICK SCENE " --search kernels --trials 0", 2, "--trials '0'"},
        {"tune " QUICK SCENE " --level gjk", 2, "--level 'gjk': the levels are"},
        {"tune " QUICK SCENE " --level sat6,", 2, "--level ''"},
        {"tune " QUICK SCENE " --level sat6,aabb", 2, "give --missed or --false-rate"},
        {"tune " QUICK SCENE " --missed 2", 2, "--missed"},
        {"tune " QUICK SCENE " --false-rate -1", 2, "--false-rate"},
        {"run --level sat6 --missed 0 " SCENE, 2, "--level sat6: give a level, or"},
    };
    program_assert_refusals("", "", rows);
}

TEST(a_strategy_or_query_that_there_is_not_is_one_line)
{
    skip_on_one_device();
    program_assert_refused(program_run("tune " QUICK SCENE " --strategy guess"), 2,
                           "there are balance, fig12");
    test_write_file(STRATEGY, "\nreturn function(history) x.y = 1 end\n");
    program_assert_refused(program_run("tune " QUICK SCENE " --strategy-lua " STRATEGY), 1,
                           "duet: " STRATEGY ":2: attempt to index");
    program_assert_refused(program_run("tune " SCENE " --query 'rays both'"), 2,
                           "query 'rays both': expected 'rays closest'");
}

TEST(a_wait_that_is_no_time_is_wrong_usage)
{
    static const char *const wrong[] = {"abc", "-1", "nan", "1e400", "1 s"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        char variable[32], says[64];
        snprintf(variable, sizeof variable, "DUET_WAIT='%s'", wrong[i]);
        snprintf(says, sizeof says, "DUET_WAIT is '%s'; expected a number of seconds", wrong[i]);
        program_assert_refused(program_run_with(variable, "tune " QUICK SCENE), 2, says);
    }
}

TEST(what_is_wrong_in_a_tune_file_is_said_with_its_line)
{
    static const refusal rows[] = {
        {"return 1", CONFIG},
        {"return {}", "workloads"},
        {"return {\n workloads = {{scene = 'a.lua'}},\n stratgy = 'grid' }", CONFIG ":3:"},
        {"return {\n workloads = {{scene = 'a.lua', m = 3}} }", CONFIG ":2:"},
        {"return {\n workloads = {{scene = 'a.lua', n = 'many'}} }", CONFIG ":2:"},
        {"return {\n workloads = {{scene = 'a.lua'}},\n strategy = 'best' }",
         CONFIG ":3: strategy 'best': there is none; there are balance"},
        {"return {\n workloads = {{scene = 'a.lua'}},\n modes = {'both'} }", CONFIG ":3:"},
        {"return {\n workloads = {{scene = 'a.lua'}},\n budget = {minutes = 1} }", CONFIG ":3:"},
        {"return {\n workloads = {{scene = 'a.lua'}},\n objective = 'beauty' }", CONFIG ":3:"},
        {"return {\n workloads = {{scene = 'a.lua', items = 3}} }", CONFIG ":2:"},
        {"return {\n workloads = {{scene = 'a.lua', n = 9},\n {scene = 'b.lua', n = -1}} }",
         CONFIG ":3: workload 2: n is -1; expected a number of objects, or a list of them"},
        {"return {\n workloads = {{scene = 'a.lua'},\n {}} }",
         CONFIG ":3: workload 2: it has no scene and no task; expected a scene or a task"},
        {"return {\n workloads = {{scene = 'a.lua', set = {n = 1}},\n {scene = 'b.lua', "
         "set = {a = 'b\\0'}}} }",
         CONFIG ":3: workload 2: set: a is 'b\\x00'; expected a value without NUL"},
        {"return {\n workloads = {{scene = 'a.lua', steps = 1}} }", CONFIG ":2: workload 1: steps"},
        {"return {\n workloads = {{scene = 'a.lua', steps = 9, query = 'rays'}} }", CONFIG ":2:"},
        {"return {\n workloads = {} }", CONFIG ":2:"},
        {"return {\n workloads = {{scene = 'a.lua'}},\n level = 'best' }",
         CONFIG ":3: level is 'best'; expected one of certified, aabb"},
        {"return {\n workloads = {{scene = 'a.lua'}},\n level = {'sat6', 'gjk'} }", CONFIG ":3:"},
        {"return {\n workloads = {{scene = 'a.lua'}},\n level = {'sat6', 'aabb'} }", "accuracy"},
        {"return {\n workloads = {{scene = 'a.lua'}},\n accuracy = {fals_rate = 1} }",
         CONFIG ":3: accuracy has no field 'fals_rate'"},
        {"return {\n workloads = {{scene = 'a.lua'}},\n accuracy = {missed = 2} }", CONFIG ":3:"},
        {"return {\n workloads = {{scene = 'a.lua'}},\n accuracy = 0 }", CONFIG ":3:"},
        {"return {", CONFIG ":1:"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; ++i) {
        static tune_config config;
        test_write_file(CONFIG, rows[i].given);
        must_fail(tune_config_load(&config, CONFIG, ERR), DUET_STATUS_BAD_INPUT, rows[i].says);
    }
}

TEST_EACH(begin_afresh, NULL)
