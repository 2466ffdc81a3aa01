// SPDX-License-Identifier: MIT
// duet cluster as a person runs it; cluster_ranks.c has what must hold for its ranks. Skipped
// where Duet was built without MPI or, of simulated ranks, without SimGrid. --all: more of these.
#define _POSIX_C_SOURCE 200809L
#include "support/json.h"
#include "support/store.h"
#include "support/test.h"

#include "base/npy.h"
#include "base/text_file.h"
#include "profiles/cluster_run.h"
#include "profiles/duet_profiles.h"
#include "profiles/sql.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static bool asks_all;

static void skip_without(const char *name, const char *what)
{
    char path[4096];
    const char *duet = getenv("DUET_PROGRAM");
    snprintf(path, sizeof path, "%.*s%s", (int)(strrchr(duet, '/') + 1 - duet), duet, name);
    if (access(path, X_OK) != 0) {
        print_message("%s: Duet was built without %s\n", path, what);
        skip();
    }
}

static void skip_without_mpi(void)
{
    skip_without("duet-cluster", "MPI");
}

static void assert_same_pairs(const char *scene, int ranks, int parts)
{
    program one = program_run("run --repeat 1 --json %s", scene);
    program all =
        program_run("cluster --ranks %d --parts %d --repeat 1 --json %s", ranks, parts, scene);
    cJSON *expected = json_of_program(&one);
    cJSON *found = json_of_program(&all);
    assert_true(json_number(expected, "pairs") > 0);
    assert_string_equal(json_string(found, "hash"), json_string(expected, "hash"));
    assert_true(json_number(found, "pairs") == json_number(expected, "pairs"));
    assert_true(json_number(found, "objects") == json_number(expected, "objects"));
    cJSON_Delete(expected);
    cJSON_Delete(found);
}

static void ranks_with_devices_find_the_pairs_of_run(void **state)
{
    (void)state;
    skip_without_mpi();
    assert_same_pairs("paper -n 900 --set world=18", 2, 1);
    assert_same_pairs("paper2d -n 900 --set world=40", 3, 4);
    assert_same_pairs("spheres -n 900 --set world=14", 2, 3);
}

// ---------------------------------------------------------------- simulated ranks

#define FABRIC "fabric.xml"
#define APART "apart.xml"

static void write_platform(const char *path, const char *inside)
{
    duet_error err = {0};
    text file = {0};
    text_add(&file,
             "<?xml version='1.0'?>"
             "<!DOCTYPE platform SYSTEM \"https://simgrid.org/simgrid.dtd\">"
             "<platform version='4.1'><config><prop id='network/model' value='CM02'/></config>"
             "<zone id='all' routing='Full'>%s</zone></platform>",
             inside);
    assert_ok(text_write_file(path, text_chars(&file), file.length, &err), err);
    text_free(&file);
}

static void write_fabric(void)
{
    write_platform(FABRIC, "<cluster id='hosts' prefix='host' suffix='' radical='0-63' "
                           "speed='1Gf' bw='1GBps' lat='10us'/>");
}

static void simulated_ranks_find_the_pairs_of_run(void **state)
{
    (void)state;
    skip_without("duet-simulate", "SimGrid");
    static const char *const scenes[] = {
        "paper -n 900 --set world=18", "clustered -n 900",       "mixed -n 900",
        "paper -n 5 --set world=1",    "paper -n 0 2>/dev/null", "rounded -n 63"};
    write_fabric();
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; ++i)
        for (int ranks = 64; ranks <= (asks_all ? 256 : 64); ranks *= 4) {
            program one = program_run("cluster --plain --repeat 1 --check --json %s", scenes[i]);
            program simulated = program_run("cluster --simulate " FABRIC " --ranks %d --repeat 1 "
                                            "--json %s",
                                            ranks, scenes[i]);
            cJSON *expected = json_of_program(&one), *found = json_of_program(&simulated);
            json_array(found, "ranks", ranks);
            assert_true(json_true(cJSON_GetObjectItem(expected, "check"), "right"));
            assert_string_equal(json_string(found, "hash"), json_string(expected, "hash"));
            assert_true(json_number(found, "pairs") == json_number(expected, "pairs"));
            assert_true(json_number(found, "total_ms") > 0.01 && // what one message takes
                        json_number(found, "total_ms") < 1000);
            cJSON_Delete(expected);
            cJSON_Delete(found);
        }
    remove(FABRIC);
}

static cJSON *forecast(const char *path, const char *uid, const char *arguments)
{
    char variables[160];
    snprintf(variables, sizeof variables, "DUET_PROFILE=%s", path);
    program p = program_run_with(
        variables, "cluster --simulate " FABRIC " --profile %.8s --json %s", uid, arguments);
    return json_of_program(&p);
}

// One object that stands for K travels as K would, and takes a device as long.
static void a_forecast_takes_the_times_of_a_profile(void **state)
{
    (void)state;
    skip_without("duet-simulate", "SimGrid");
    test_folder folder = test_folder_make();
    duet_error err = {0};
    store *s = test_store_open(folder.store, STORE_WRITE);
    profile_pair pair = test_pair();
    profile_workload workload = test_workload(1000);
    test_tune(s, &pair, &workload);
    store_close(s);
    duet_profile_list *list = duet_profile_list_create(folder.store, false, &err);
    assert_ok(list, err);
    const duet_stored_profile *profile = duet_profile_list_get_profile(list, 0);
    write_fabric();

    cJSON *one = forecast(folder.store, profile->uid, "--ranks 1 paper -n 4000");
    assert_true(json_number(one, "total_ms") >= 4 * profile->step_ms * 0.999);
    assert_true(json_number(one, "total_ms") <= 4 * profile->step_ms + 1);
    assert_null(cJSON_GetObjectItem(one, "hash"));
    char variables[160];
    snprintf(variables, sizeof variables, "DUET_PROFILE=%s", folder.store);
    program p =
        program_run_with(variables, "cluster --simulate " FABRIC " --ranks 2 --profile none still");
    program_assert_refused(&p, 2, "--profile 'none': 0 profiles begin so");
    p = program_run_with(variables,
                         "cluster --simulate " FABRIC " --ranks 2 --profile %.8s paper2d -n 9",
                         profile->uid);
    program_assert_refused(&p, 2, "': a profile in 3D, and paper2d is in 2D; expected the same");
    p = program_run_with(
        variables, "cluster --simulate " FABRIC " --ranks 2 --profile %.8s paper -n 9 --level aabb",
        profile->uid);
    program_assert_refused(&p, 2,
                           "': a profile at level certified, and this is at level aabb; expected "
                           "the same");
    cJSON *two = forecast(folder.store, profile->uid, "--ranks 2 paper -n 4000 --set world=32");
    cJSON *many = forecast(folder.store, profile->uid,
                           "--ranks 2 --stands-for 1000 paper -n 4000 --set world=320");
    assert_true(json_number(two, "efficiency") < 1);
    assert_true(json_number(many, "objects") == 4e6);
    assert_true(json_number(many, "total_ms") > 2000 * profile->step_ms);
    double bytes = 0; // at 1 GB/s
    for (int i = 0; i < 2; ++i) {
        double sent =
            json_number(cJSON_GetArrayItem(cJSON_GetObjectItem(many, "ranks"), i), "sent_bytes");
        bytes = sent > bytes ? sent : bytes;
    }
    assert_true(bytes > 0);
    assert_true(json_number(many, "total_ms") > 2000 * profile->step_ms + bytes * 1e-6 * 0.99);
    cJSON_Delete(one);
    cJSON_Delete(two);
    cJSON_Delete(many);
    s = test_store_open(folder.store, STORE_WRITE);
    assert_ok(sql_script(s, "UPDATE workload SET query = 'rays closest', boxes = 9", &err), err);
    p = program_run_with(variables, "cluster --simulate " FABRIC " --ranks 2 --profile %.8s still",
                         profile->uid);
    program_assert_refused(&p, 2,
                           "': a profile of the query 'rays closest'; expected one of steps");
    assert_ok(sql_script(s, "UPDATE workload SET query = NULL, boxes = 0", &err), err);
    store_close(s);
    static const char *const hostile[] = {"profile SET median_ns = 9e999",
                                          "profile SET median_ns = -5", "profile SET median_ns = 0",
                                          "profile SET median_ns = 7; UPDATE workload SET n = 0"};
    for (size_t i = 0; i < sizeof hostile / sizeof *hostile; ++i) {
        char change[160];
        s = test_store_open(folder.store, STORE_WRITE);
        snprintf(change, sizeof change, "PRAGMA ignore_check_constraints = ON; UPDATE %s",
                 hostile[i]);
        assert_ok(sql_script(s, change, &err), err);
        store_close(s);
        p = program_run_with(variables,
                             "cluster --simulate " FABRIC " --ranks 2 --profile %.8s still",
                             profile->uid);
        program_assert_refused(&p, 1, "its time of a step or its objects cannot be");
    }
    duet_profile_list_destroy(list);
    test_folder_remove(&folder);
    remove(FABRIC);
}

static void a_platform_that_is_none_is_one_line(void **state)
{
    (void)state;
    skip_without("duet-simulate", "SimGrid");
    static const struct {
        const char *arguments;
        int exit_code;
        const char *says;
    } wrong[] = {
        {"no.xml --ranks 2 still", 1, "no.xml: No such file or directory"},
        {"/dev/null --ranks 2 still", 1, "/dev/null: no platform of SimGrid: "},
        {APART " --ranks 2 still", 1, APART ": no platform of SimGrid: no route leads from a to b"},
        {FABRIC " still", 2, "--simulate does nothing without --ranks"},
        {FABRIC " --ranks 2 --pair cpu still", 2, "--simulate and --pair do not go together"},
        {FABRIC " --ranks 2 --keep still", 2, "--simulate and --keep do not go together"},
        {FABRIC " --ranks 2 papr", 2, "rank 0 on host0: papr: no such file or scene"},
        {FABRIC " --ranks 2 --stands-for 9 still", 2, "--stands-for does nothing without "},
    };
    write_fabric();
    write_platform(APART, "<host id='a' speed='1Gf'/><host id='b' speed='1Gf'/>");
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        program p = program_run("cluster --simulate %s", wrong[i].arguments);
        program_assert_refused(&p, wrong[i].exit_code, wrong[i].says);
    }
    remove(FABRIC);
    remove(APART);
}

// ---------------------------------------------------------------- kept runs

// One of two ranks, the first of which is the busiest: for 2 ms of each step's 2.5.
static void keep_test_run(store *s, double latency_ns, double byte_ns, uint32_t n_ranks,
                          char uid[9])
{
    duet_error err = {0};
    char whole[PROFILE_ID];
    static const char *const places[] = {"0", "one", "two"};
    profile_fabric fabric = {.mpi = "Some MPI",
                             .place = places[n_ranks],
                             .hosts = 1,
                             .ranks = n_ranks,
                             .latency_ns = latency_ns,
                             .byte_ns = byte_ns};
    profile_cluster_run run = {.scene = "paper",
                               .dims = 3,
                               .n = 100,
                               .level = "certified",
                               .parts = 1,
                               .steps = 3,
                               .median_ns = 2.5e6,
                               .low_ns = 1e6,
                               .high_ns = 9e6};
    static const profile_cluster_rank rows[] = {{"a:0,a:0", 60, 20, 9, 120, 4e6, 1e6},
                                                {"a:0,a:0", 40, 0, 8, 160, 3e6, 2e6}};
    assert_ok(cluster_run_put(s, &fabric, &run, rows, whole, &err), err);
    snprintf(uid, 9, "%.8s", whole);
}

static cJSON *simulate(const char *path, const char *arguments, const char *uid)
{
    char variables[160];
    snprintf(variables, sizeof variables, "DUET_PROFILE=%s", path);
    program p =
        program_run_with(variables, "cluster --simulate %s --repeat 1 --json %s", uid, arguments);
    return json_of_program(&p);
}

static double simulated_ms(const char *path, const char *arguments, const char *uid)
{
    cJSON *json = simulate(path, arguments, uid);
    double ms = json_number(json, "total_ms");
    cJSON_Delete(json);
    return ms;
}

static double rank_number(const cJSON *run, int rank, const char *name)
{
    return json_number(cJSON_GetArrayItem(cJSON_GetObjectItem(run, "ranks"), rank), name);
}

// Messages that follow each other take k latencies and the time of their bytes, no matter where
// the ranks are.
static void a_kept_network_shows_in_the_times(void **state)
{
    (void)state;
    skip_without("duet-simulate", "SimGrid");
    enum { MS = 1000000 };
    static const struct {
        double latency_ns, byte_ns;
    } networks[] = {{2 * MS, 10}, {5 * MS, 10}, {2 * MS, 30}};
    test_folder folder = test_folder_make();
    double ms[3];
    char uid[9];
    for (int i = 0; i < 3; ++i) {
        store *s = test_store_open(folder.store, STORE_WRITE);
        keep_test_run(s, networks[i].latency_ns, networks[i].byte_ns, 2, uid);
        store_close(s);
        ms[i] = simulated_ms(folder.store, "--ranks 2 paper -n 900 --set world=18", uid);
    }
    double latencies = (ms[1] - ms[0]) / 3, bytes = (ms[2] - ms[0]) * 1e6 / 20;
    assert_true(latencies > 0.5 && fabs(latencies - round(latencies)) < 1e-5);
    assert_true(bytes > 100 && fabs(ms[0] - 2 * latencies - bytes * 10e-6) < 1e-3);

    // Rank 1 sends ghosts to rank 0, and then takes twice as long for each of its objects.
    char arguments[128];
    cJSON *at[2];
    for (int i = 0; i < 2; ++i) {
        snprintf(arguments, sizeof arguments,
                 "--ranks 2 --profile %s --stands-for %d paper -n 900 --set world=180", uid,
                 1000 * (i + 1));
        at[i] = simulate(folder.store, arguments, uid);
    }
    double busy = rank_number(at[1], 1, "busy_ms") - rank_number(at[0], 1, "busy_ms");
    double sent = rank_number(at[1], 1, "sent_bytes") - rank_number(at[0], 1, "sent_bytes");
    double more = json_number(at[1], "total_ms") - json_number(at[0], "total_ms");
    assert_true(busy > 0 && sent > 0 && rank_number(at[1], 0, "sent_bytes") == 0);
    assert_true(fabs(more - busy - sent * 30e-6) < 1e-6 * more);
    cJSON_Delete(at[0]);
    cJSON_Delete(at[1]);
    test_folder_remove(&folder);
}

// 2 ms a step for 60 objects with 20 ghosts, each of which takes as long as 3, and for 40 objects,
// where two ranks shared the host.
static void a_kept_run_shows_in_a_forecast(void **state)
{
    (void)state;
    skip_without("duet-simulate", "SimGrid");
    test_folder folder = test_folder_make();
    store *s = test_store_open(folder.store, STORE_WRITE);
    char uid[9], arguments[128];
    keep_test_run(s, 1000, 1, 2, uid);
    store_close(s);
    static const double object_ms[] = {2.0 / 120, 2.0 / 40};
    for (int ranks = 1; ranks <= 4; ranks += 3) {
        snprintf(arguments, sizeof arguments, "--ranks %d --profile %s paper -n 900 --set world=18",
                 ranks, uid);
        cJSON *run = simulate(folder.store, arguments, uid);
        double own_ms = 0, most_ms = 0, total_ms = json_number(run, "total_ms");
        for (int i = 0; i < ranks; ++i) {
            double n = rank_number(run, i, "objects"), ghosts = rank_number(run, i, "ghosts");
            double ms = object_ms[i % 2] * ranks / 2;
            assert_true(fabs(rank_number(run, i, "busy_ms") - ms * (n + 3 * ghosts)) < 1e-3);
            own_ms += ms * n;
            most_ms = fmax(most_ms, ms * (n + 3 * ghosts));
        }
        assert_true(total_ms >= most_ms - 1e-3 && total_ms < most_ms + 1);
        assert_true(fabs(json_number(run, "efficiency") - own_ms / ranks / total_ms) < 1e-3);
        cJSON_Delete(run);
    }
    char variables[160];
    snprintf(variables, sizeof variables, "DUET_PROFILE=%s", folder.store);
    program p = program_run_with(variables,
                                 "cluster --simulate %s --profile %s --ranks 2 paper "
                                 "-n 60",
                                 uid, uid);
    assert_int_equal(p.exit_code, 0);
    assert_non_null(strstr(p.out, "ranks as in run "));
    assert_non_null(strstr(p.out, ": paper, 100 boxes, 2 ranks on 1 host"));
    program_free(&p);
    test_folder_remove(&folder);
}

// Ranks of a host that were measured by themselves: 50 objects took one 1 ms, each of two 1.2 ms,
// and each of four 2 ms, so each of three 1.6.
static void company_shows_in_a_forecast(void **state)
{
    (void)state;
    skip_without("duet-simulate", "SimGrid");
    test_folder folder = test_folder_make();
    store *s = test_store_open(folder.store, STORE_WRITE);
    duet_error err = {0};
    char whole[PROFILE_ID], uid[9], arguments[128], variables[160];
    profile_fabric fabric = {.mpi = "Some MPI",
                             .place = "four",
                             .hosts = 1,
                             .ranks = 4,
                             .latency_ns = 1000,
                             .byte_ns = 1};
    profile_cluster_run kept = {.scene = "paper",
                                .dims = 3,
                                .n = 50,
                                .level = "certified",
                                .parts = 1,
                                .steps = 3,
                                .median_ns = 2e6,
                                .low_ns = 1e6,
                                .high_ns = 9e6};
    static const profile_cluster_rank rows[] = {{"a:0,a:0", 50, 0, 9, 0, 1e6, 0},
                                                {"a:0,a:0", 50, 0, 9, 0, 1.2e6, 0},
                                                {"a:0,a:0", 50, 0, 9, 0, 2e6, 0},
                                                {"a:0,a:0", 50, 0, 9, 0, 2e6, 0}};
    assert_ok(cluster_run_put(s, &fabric, &kept, rows, whole, &err), err);
    store_close(s);
    snprintf(uid, sizeof uid, "%.8s", whole);
    static const double object_ms[] = {0, 1.0 / 50, 1.2 / 50, 1.6 / 50, 2.0 / 50};
    for (int ranks = 1; ranks <= 4; ++ranks) {
        snprintf(arguments, sizeof arguments, "--ranks %d --profile %s paper -n 900 --set world=18",
                 ranks, uid);
        cJSON *run = simulate(folder.store, arguments, uid);
        for (int i = 0; i < ranks; ++i) {
            double n = rank_number(run, i, "objects"), ghosts = rank_number(run, i, "ghosts");
            double ms = object_ms[ranks] * (n + 3 * ghosts);
            assert_true(n > 0 && fabs(rank_number(run, i, "busy_ms") - ms) < 1e-3);
        }
        cJSON_Delete(run);
    }
    snprintf(variables, sizeof variables, "DUET_PROFILE=%s", folder.store);
    program p = program_run_with(
        variables, "cluster --simulate %s --profile %s --ranks 2 paper -n 60", uid, uid);
    assert_int_equal(p.exit_code, 0);
    assert_non_null(strstr(p.out, ": paper, 50 boxes, 4 ranks apart on 1 host"));
    program_free(&p);
    p = program_run_with(variables, "cluster --simulate %s --profile %s --ranks 5 paper -n 60", uid,
                         uid);
    program_assert_refused(&p, 2, "was measured with up to 4 ranks on a host, and here are 5");
    test_folder_remove(&folder);
}

static void a_run_that_does_not_fit_is_one_line(void **state)
{
    (void)state;
    skip_without("duet-simulate", "SimGrid");
    test_folder folder = test_folder_make();
    store *s = test_store_open(folder.store, STORE_WRITE);
    duet_error err = {0};
    char uid[9], alone[9], variables[160], arguments[128];
    snprintf(variables, sizeof variables, "DUET_PROFILE=%s", folder.store);
    keep_test_run(s, 1000, 1, 2, uid);
    keep_test_run(s, 0, 0, 1, alone);
    store_close(s);
    const struct {
        const char *network, *of, *arguments;
        int exit_code;
        const char *says;
    } wrong[] = {
        {"0000000000", uid, "paper", 2, "'0000000000': no such file, and no kept run begins so"},
        {alone, uid, "paper", 2, "': that run had one rank and no network"},
        {uid, "none", "paper", 2, "--profile 'none': 0 profiles begin so"},
        {uid, uid, "paper2d -n 9", 2, "': a run in 3D, and paper2d is in 2D; expected the same"},
        {uid, uid, "paper -n 9 --level aabb", 2,
         "': a run at level certified, and this is at level "},
        {uid, uid, "paper -n 9 --parts 2", 2, "': a run with --parts 1; expected the same"},
        {uid, uid, "paper -n 9 --resident", 2, "': a run without --resident; expected the same"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        snprintf(arguments, sizeof arguments, "--simulate %s --profile %s %s", wrong[i].network,
                 wrong[i].of, wrong[i].arguments);
        program p = program_run_with(variables, "cluster --ranks 2 %s", arguments);
        program_assert_refused(&p, wrong[i].exit_code, wrong[i].says);
    }
    static const struct {
        const char *change;
        const char *says;
    } hostile[] = {
        {"fabric SET latency_ns = -1", "its network's latency or bandwidth cannot be"},
        {"fabric SET latency_ns = 9e999", "its network's latency or bandwidth cannot be"},
        {"fabric SET latency_ns = 1, byte_ns = 1e300", "its network's latency or bandwidth cannot"},
        {"fabric SET byte_ns = 1, hosts = 0", "its number of ranks or hosts cannot be"},
        {"fabric SET hosts = 1; UPDATE cluster_rank SET busy_ns = -1",
         "objects or times of a rank"},
        {"cluster_rank SET busy_ns = 9e999", "its objects or times of a rank cannot be"},
        {"cluster_rank SET busy_ns = 1, ghosts = -1", "its objects or times of a rank cannot be"},
        {"cluster_rank SET ghosts = 0, n = 0", "no rank had an object, so nothing was timed"},
        {"cluster_rank SET n = 9; UPDATE cluster_run SET median_ns = 1e300",
         "its time of a step cannot be"},
    };
    for (size_t i = 0; i < sizeof hostile / sizeof *hostile; ++i) {
        s = test_store_open(folder.store, STORE_WRITE);
        snprintf(arguments, sizeof arguments, "PRAGMA ignore_check_constraints = ON; UPDATE %s",
                 hostile[i].change);
        assert_ok(sql_script(s, arguments, &err), err);
        store_close(s);
        program p = program_run_with(
            variables, "cluster --ranks 2 --simulate %s --profile %s still", uid, uid);
        program_assert_refused(&p, 1, hostile[i].says);
    }
    test_folder_remove(&folder);
}

// ---------------------------------------------------------------- what is told

// Corners, or boxes with a radius of which the first have no extents.
static double number_of_row(int columns, int i, int k)
{
    double at = i * 37 % 100 * 0.3;
    if (columns == 6)
        return at + (k < 3 ? 0 : 1);
    return k < 3 ? at : k < 6 ? (i > 60 ? 0.25 : 0) : k < 9 ? 0 : k == 9 ? 1 : 0.5;
}

// Each rank reads its rows; with --check rank 0 reads all.
static void an_array_is_read_in_parts(void **state)
{
    (void)state;
    skip_without_mpi();
    for (int columns = 6; columns <= 11; columns += 5) {
        text file = {0};
        duet_error err = {0};
        npy_add_header(&file, NPY_FLOAT64, 100, (uint64_t)columns);
        for (int i = 0; i < 100 * columns; ++i) {
            double number = number_of_row(columns, i / columns, i % columns);
            text_add_bytes(&file, (const char *)&number, sizeof number);
        }
        assert_ok(text_write_file("rows.npy", text_chars(&file), file.length, &err), err);
        program one = program_run("cluster --plain --repeat 1 --check --json rows.npy");
        program three = program_run("cluster --plain --repeat 1 --ranks 3 --json rows.npy");
        cJSON *expected = json_of_program(&one), *found = json_of_program(&three);
        assert_true(json_true(cJSON_GetObjectItem(expected, "check"), "right"));
        assert_true(json_number(expected, "pairs") > 100);
        assert_true(json_number(found, "objects") == 100);
        assert_string_equal(json_string(found, "hash"), json_string(expected, "hash"));
        cJSON_Delete(expected);
        cJSON_Delete(found);
        text_free(&file);
    }
    remove("rows.npy");
}

// Its pair, the sums of all ranks, and nothing of stdin lost.
static void each_rank_has_its_row_and_its_part_of_the_devices(void **state)
{
    (void)state;
    skip_without_mpi();
    program p =
        program_run_with("printf '0,0,0,1,1,1\\n.5,.5,.5,2,2,2\\n9,9,9,9,9,9\\n' | DUET_PAIR=",
                         "cluster --ranks 2 --weights 1,2 --check --json -");
    cJSON *o = json_of_program(&p);
    const cJSON *rows = json_array(o, "ranks", 2);
    const cJSON *first = cJSON_GetArrayItem(rows, 0), *second = cJSON_GetArrayItem(rows, 1);
    program list = program_run("devices --json");
    cJSON *devices = json_of_program(&list);
    const cJSON *device = cJSON_GetArrayItem(cJSON_GetObjectItem(devices, "devices"), 0);
    if (cJSON_GetArraySize(cJSON_GetObjectItem(devices, "devices")) == 1 &&
        json_number(device, "units") > 1)
        assert_string_not_equal(json_string(first, "pair"), json_string(second, "pair"));
    assert_string_equal(json_string(first, "host"), json_string(second, "host"));
    assert_true(json_number(second, "rank") == 1);
    assert_true(json_number(first, "objects") + json_number(second, "objects") == 3);
    assert_true(json_number(first, "pairs") + json_number(second, "pairs") == 1);
    assert_true(json_number(o, "pairs") == 1);
    assert_true(json_true(cJSON_GetObjectItem(o, "check"), "right"));
    cJSON_Delete(devices);
    cJSON_Delete(o);
}

static void a_rank_that_is_bound_to_one_core_of_several_is_told_of(void **state)
{
    (void)state;
    skip_without_mpi();
    program list = program_run("devices --json");
    cJSON *devices = json_of_program(&list);
    double units =
        json_number(cJSON_GetArrayItem(cJSON_GetObjectItem(devices, "devices"), 0), "units");
    program p = program_run_with("DUET_PAIR=pocl:0 taskset -c 0", "cluster --repeat 1 still -n 3");
    assert_int_equal(p.exit_code, 0);
    assert_true((units > 1) == (strstr(p.err, "duet: rank 0 may use 1 of the ") != NULL));
    assert_non_null(strstr(p.out, "  pocl:0  ")); // the device that does it all is named once
    cJSON_Delete(devices);
    program_free(&p);
}

static void a_person_reads_a_table(void **state)
{
    (void)state;
    skip_without_mpi();
    program p = program_run("cluster --ranks 3 --plain --check --resident planes -n 60");
    assert_int_equal(p.exit_code, 0);
    assert_string_equal(p.err, "");
    assert_non_null(strstr(p.out, "3 ranks"));
    assert_non_null(strstr(p.out, "   2  "));
    assert_non_null(strstr(p.out, "same "));
    program_free(&p);
}

static void the_file_of_pairs_is_that_of_one_rank(void **state)
{
    (void)state;
    skip_without_mpi();
    text files[2] = {{0}, {0}};
    duet_error err = {0};
    for (int i = 0; i < 2; ++i) {
        program p = program_run("cluster --plain --repeat 1 --json --ranks %d --sorted "
                                "--pairs test_cluster.npy planes -n 90",
                                2 * i + 1);
        cJSON *o = json_of_program(&p);
        assert_ok(text_read_file(&files[i], "test_cluster.npy", &err), err);
        assert_int_equal(files[i].length, 128 + 16 * (size_t)json_number(o, "pairs"));
        cJSON_Delete(o);
        remove("test_cluster.npy");
    }
    assert_int_equal(files[0].length, files[1].length);
    assert_memory_equal(files[0].chars, files[1].chars, files[0].length);
    text_free(&files[0]);
    text_free(&files[1]);
}

// Nothing is kept unless asked for.
static void what_is_kept_of_a_run_is_listed_and_forgotten(void **state)
{
    (void)state;
    skip_without_mpi();
    test_folder folder = test_folder_make();
    char variables[160];
    snprintf(variables, sizeof variables, "DUET_PROFILE=%s", folder.store);
    program p = program_run_with(variables, "cluster --ranks 3 --plain --repeat 1 planes -n 60");
    assert_int_equal(p.exit_code, 0);
    assert_int_equal(access(folder.store, F_OK), -1);
    program_free(&p);
    p = program_run_with(variables, "cluster --ranks 3 --plain --repeat 2 --keep planes -n 60");
    assert_int_equal(p.exit_code, 0);
    assert_non_null(strstr(p.err, "duet: kept as "));
    program_free(&p);

    p = program_run_with(variables, "profiles list --json");
    cJSON *list = json_of_program(&p);
    const cJSON *run = cJSON_GetArrayItem(json_array(list, "cluster_runs", 1), 0);
    const cJSON *fabric = cJSON_GetObjectItem(run, "fabric");
    assert_string_equal(json_string(run, "scene"), "planes");
    assert_true(json_number(run, "objects") == 60 && json_number(run, "steps") == 2);
    assert_true(json_number(run, "efficiency") > 0 && json_number(run, "efficiency") < 1);
    assert_true(json_number(fabric, "ranks") == 3 && json_number(fabric, "hosts") == 1);
    assert_true(json_number(fabric, "latency_us") > 0 && json_number(fabric, "mb_per_s") > 0);
    assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(fabric, "times_ns")), 7);
    char uid[9];
    snprintf(uid, sizeof uid, "%s", json_string(run, "uid"));
    cJSON_Delete(list);

    p = program_run_with(variables, "profiles show %s", uid);
    assert_int_equal(p.exit_code, 0);
    assert_non_null(strstr(p.out, "3 ranks on 1 host: "));
    assert_non_null(strstr(p.out, "   2  plain"));
    program_free(&p);
    p = program_run_with(variables, "profiles show %s --json", uid);
    cJSON *shown = json_of_program(&p);
    json_array(shown, "ranks", 3);
    cJSON_Delete(shown);
    p = program_run_with(variables, "profiles forget %s", uid);
    assert_int_equal(p.exit_code, 0);
    program_free(&p);
    p = program_run_with(variables, "profiles show %s", uid);
    program_assert_refused(&p, 2, "no profile begins with '");

    p = program_run_with("DUET_PROFILE=/dev/null", "cluster --plain --keep still -n 3 >/dev/null");
    program_assert_refused(&p, 1, "/dev/null: is a device or a pipe; a profile store is a file");
    test_folder_remove(&folder);
}

// Each rank finds all pairs of the scene, first one of them, then two, then all three.
static void ranks_apart_show_what_company_costs(void **state)
{
    (void)state;
    skip_without_mpi();
    test_folder folder = test_folder_make();
    char variables[160];
    snprintf(variables, sizeof variables, "DUET_PROFILE=%s", folder.store);
    program p = program_run_with("", "run --repeat 1 --json planes -n 60");
    cJSON *one = json_of_program(&p);
    p = program_run_with(variables,
                         "cluster --ranks 3 --plain --apart --keep --repeat 2 --json planes -n 60");
    assert_non_null(strstr(p.err, "duet: kept as "));
    *p.err = '\0';
    cJSON *apart = json_of_program(&p);
    assert_string_equal(json_string(apart, "hash"), json_string(one, "hash"));
    const cJSON *company = json_array(apart, "company", 3);
    static const int at_work[] = {1, 2, 3};
    for (int i = 0; i < 3; ++i) {
        const cJSON *row = cJSON_GetArrayItem(company, i);
        assert_true(json_number(row, "ranks") == at_work[i] && json_number(row, "ms") > 0);
        assert_true(rank_number(apart, i, "busy_ms") == json_number(row, "ms"));
        assert_true(rank_number(apart, i, "objects") == 60);
        assert_true(rank_number(apart, i, "ghosts") + rank_number(apart, i, "wait_ms") == 0);
    }
    assert_true(json_number(apart, "total_ms") ==
                json_number(cJSON_GetArrayItem(company, 2), "ms"));
    cJSON_Delete(one);
    cJSON_Delete(apart);
    p = program_run_with(variables, "profiles list --json");
    cJSON *list = json_of_program(&p);
    const cJSON *kept = cJSON_GetArrayItem(json_array(list, "cluster_runs", 1), 0);
    assert_true(json_number(kept, "objects") == 60 && json_number(kept, "efficiency") == 1);
    cJSON_Delete(list);
    p = program_run_with("", "cluster --ranks 3 --plain --apart --repeat 2 planes -n 60");
    assert_int_equal(p.exit_code, 0);
    assert_non_null(strstr(p.out, "\n3 ranks apart, each with all of them\n"));
    assert_non_null(strstr(p.out, "at work"));
    program_free(&p);
    test_folder_remove(&folder);
}

static void a_failure_is_one_line(void **state)
{
    (void)state;
    skip_without_mpi();
    static const struct {
        const char *arguments;
        int exit_code;
        const char *says;
    } wrong[] = {
        {"cluster --ranks 2 papr", 2, "duet: rank 0 on "},
        {"cluster --ranks 2 papr", 2, "papr: no such file or scene; did you mean 'paper'?"},
        {"cluster papr", 2, "duet: papr: no such file or scene"},
        {"cluster --ranks 3 --pair abacus still -n 2", 2, ": no device 'abacus'; there is "},
        {"cluster --ranks 2 --plain --weights 1,1,1 still", 2, "3 numbers for 2 ranks"},
        {"cluster --ranks 2 --plain --weights 1,0 still", 2, "give numbers above 0"},
        {"cluster --ranks 2 --plain --weights 1,inf still", 2, "give numbers above 0"},
        {"cluster --ranks 2 --plain --pairs no/such/p.npy papr", 1, "p.npy: cannot be written"},
        {"cluster --pairs p.csv still", 2, "expected a file whose name ends in .npy"},
        {"cluster --sorted still", 2, "--sorted does nothing without --pairs"},
        {"cluster --hosts one still", 2, "--hosts does nothing without --ranks"},
        {"cluster --ranks 2 --hosts '' still", 2,
         "--hosts: expected names of machines, as one,two"},
        {"cluster --verbose still", 2, "--verbose does nothing without --ranks"},
        {"cluster --apart --weights 1,1 still", 2, "--apart and --weights do not go together"},
        {"cluster --apart --pairs p.npy still", 2, "--apart and --pairs do not go together"},
        {"cluster --ranks 2 --apart papr", 2, "duet: rank 0 on "},
        {"cluster --plain --mode own still", 2, "--plain and --mode do not go together"},
        {"cluster --mode abacus still", 2, "--mode 'abacus': the modes are"},
        {"cluster --level abacus still", 2, "--level 'abacus': the levels are"},
        {"cluster --ranks 0 still", 2, "--ranks '0': give a whole number"},
        {"cluster --parts 1025 still", 2, "--parts '1025': give a whole number"},
        {"cluster", 2, "SCENE|FILE is missing"},
        {"lua -e 'duet.cluster()'", 1, "duet.cluster needs 'duet lua --trust'"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        program p = program_run("%s", wrong[i].arguments);
        program_assert_refused(&p, wrong[i].exit_code, wrong[i].says);
    }
    program p = program_run_with("printf '0,0,0,1,1,1\\n0,0,0,1,1,inf\\n' |",
                                 "cluster --ranks 3 --plain -");
    program_assert_refused(&p, 1, "stdin:2: object 1: ");
    p = program_run_with("OMPI_COMM_WORLD_SIZE=3 OMPI_COMM_WORLD_RANK=0",
                         "cluster --ranks 2 still");
    program_assert_refused(&p, 2, "this is rank 0 of 3 of an MPI job already");
}

// One rank of a job says so, and no other is in its way.
static void run_is_refused_in_a_job(void **state)
{
    (void)state;
    program p = program_run_with("OMPI_COMM_WORLD_SIZE=4 OMPI_COMM_WORLD_RANK=0", "run still");
    program_assert_refused(&p, 2,
                           "an MPI job of 4 ranks, and each would find all pairs; expected "
                           "'mpirun -np 4 duet cluster'");
    p = program_run_with("PMI_SIZE=4 PMI_RANK=0", "run still");
    program_assert_refused(&p, 2, "expected 'mpirun -np 4 duet cluster'");
    p = program_run_with("PMI_SIZE=4 PMI_RANK=3", "run still");
    assert_int_equal(p.exit_code, 0);
    assert_string_equal(p.out, "");
    assert_string_equal(p.err, "");
    program_free(&p);
    p = program_run_with("PMI_SIZE=1 PMI_RANK=0", "run still -n 3 --repeat 1 --json");
    assert_int_equal(p.exit_code, 0);
    program_free(&p);
}

// mpirun is the program's child, and the ranks are mpirun's. Some seconds later that one would
// still be at work. It may have no name for a rank that has just been started.
static void a_rank_that_is_killed_ends_the_job_and_leaves_no_file(void **state)
{
    (void)state;
    skip_without_mpi();
    static const char kill_one[] =
        "& job=$!; children() { cat /proc/$1/task/*/children 2>/dev/null; }; rank=; "
        "until [ -n \"$rank\" ]; do for child in $(children $job); do "
        "for rank in $(children $child); do :; done; done; done; kill -9 $rank; wait $job";
    program p = program_run("cluster --ranks 3 --plain --repeat 100000 --pairs killed.npy paper "
                            "-n 30000 %s",
                            kill_one);
    assert_string_equal(p.out, "");
    program_assert_refused(&p, 1, " was ended by signal 9 (Killed), and with it the job");
    assert_int_equal(access("killed.npy", F_OK), -1);
    assert_int_equal(system("ls killed.npy* >/dev/null 2>&1") == 0, 0);
}

// The ranks are there once rank 0 opens the scene, which is a pipe.
static void a_rank_that_is_stopped_is_told_of_and_goes_on(void **state)
{
    (void)state;
    skip_without_mpi();
    static const char stop_one[] =
        "2>stopped.says & job=$!; "
        "children() { cat /proc/$1/task/*/children 2>/dev/null; }; "
        "exec 3>stopped.csv; "
        "for child in $(children $job); do for rank in $(children $child); do :; done; done; "
        "says() { until grep -q \"rank [0-2] of 3 (host [^ ]*, pid $rank) $1\" stopped.says; "
        "do sleep .1; done; }; "
        "kill -STOP $rank; says 'has not answered for 2 s'; "
        "kill -CONT $rank; says 'answers again'; "
        "printf '0 0 0 1 1 1\\n1 1 1 2 2 2\\n' >&3; exec 3>&-; wait $job";
    remove("stopped.csv");
    assert_int_equal(mkfifo("stopped.csv", 0600), 0);
    program p =
        program_run_with("DUET_RANK_SILENCE=2",
                         "cluster --ranks 3 --plain --repeat 1 --json stopped.csv %s", stop_one);
    assert_int_equal(p.exit_code, 0);
    cJSON *o = json_of_program(&p);
    assert_true(json_number(o, "pairs") == 1);
    cJSON_Delete(o);
    remove("stopped.csv");
    remove("stopped.says");
}

// On a slow machine nothing may have been timed yet. In the foreground timeout(1) sends its signal
// to the program alone, else to mpirun, too, as a terminal does, which then ends the ranks soon.
static void ctrl_c_shows_what_was_timed(void **state)
{
    (void)state;
    skip_without_mpi();
    static const struct {
        const char *how, *arguments;
        bool shows;
    } runs[] = {
        {"--foreground", "", true}, {"--foreground", "--ranks 2", true}, {"", "--ranks 2", false}};
    for (size_t i = 0; i < sizeof runs / sizeof *runs; ++i) {
        char variables[80];
        snprintf(variables, sizeof variables, "timeout %s --preserve-status -s INT 2", runs[i].how);
        program p =
            program_run_with(variables, "cluster %s --plain still -n 3000 --repeat 100000 --json",
                             runs[i].arguments);
        assert_int_equal(p.exit_code, 130);
        assert_string_equal(p.err, "duet: stopped\n");
        assert_true(*p.out || !runs[i].shows);
        cJSON *o = *p.out ? cJSON_Parse(p.out) : NULL;
        if (o) {
            double n = json_number(o, "repeat");
            assert_true(n > 0 && n < 100000 && json_number(o, "total_ms") > 0);
        }
        cJSON_Delete(o);
        program_free(&p);
    }
}

int main(int argc, char **argv)
{
    asks_all = argc > 1 && strcmp(argv[1], "--all") == 0;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ranks_with_devices_find_the_pairs_of_run),
        cmocka_unit_test(simulated_ranks_find_the_pairs_of_run),
        cmocka_unit_test(a_forecast_takes_the_times_of_a_profile),
        cmocka_unit_test(a_platform_that_is_none_is_one_line),
        cmocka_unit_test(a_kept_network_shows_in_the_times),
        cmocka_unit_test(a_kept_run_shows_in_a_forecast),
        cmocka_unit_test(company_shows_in_a_forecast),
        cmocka_unit_test(a_run_that_does_not_fit_is_one_line),
        cmocka_unit_test(an_array_is_read_in_parts),
        cmocka_unit_test(each_rank_has_its_row_and_its_part_of_the_devices),
        cmocka_unit_test(a_rank_that_is_bound_to_one_core_of_several_is_told_of),
        cmocka_unit_test(a_person_reads_a_table),
        cmocka_unit_test(the_file_of_pairs_is_that_of_one_rank),
        cmocka_unit_test(what_is_kept_of_a_run_is_listed_and_forgotten),
        cmocka_unit_test(ranks_apart_show_what_company_costs),
        cmocka_unit_test(a_failure_is_one_line),
        cmocka_unit_test(a_rank_that_is_stopped_is_told_of_and_goes_on),
        cmocka_unit_test(run_is_refused_in_a_job),
        cmocka_unit_test(ctrl_c_shows_what_was_timed),
        cmocka_unit_test(a_rank_that_is_killed_ends_the_job_and_leaves_no_file),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
