// SPDX-License-Identifier: MIT
// duet run, as a person calls it.
#define _POSIX_C_SOURCE 200809L
#include "support/devices.h"
#include "support/json.h"
#include "support/test.h"

#include "base/text_file.h"

#define SCENE "test_run.scene.lua"

// 400 boxes, drawn with the scene's own seed.
static const char scene_text[] =
    "local p = parameters { n = 400, seed = 1 }\n"
    "local random = random(p.seed)\n"
    "for _ = 1, p.n do\n"
    "  local x, y, z = random.uniform(0, 8), random.uniform(0, 8), random.uniform(0, 8)\n"
    "  add(x, y, z, 0.5, 0.5, 0.5, random.quaternion())\n"
    "end\n"
    "return { dims = 3 }\n";

static void make_scene(void)
{
    test_write_file(SCENE, scene_text);
}

TEST(json_has_what_a_script_needs)
{
    cJSON *o = json_of_run("run --json " SCENE
                           " --share 1/4 --mode own --variant auto --repeat 3 --check");
    assert_int_equal(json_number(o, "objects"), 400);
    assert_int_equal(json_number(o, "dims"), 3);
    assert_true(json_number(o, "candidates") >= json_number(o, "pairs"));
    assert_true(json_number(o, "pairs") > 0);
    assert_int_equal(strlen(json_string(o, "hash")), 16);
    assert_true(json_number(o, "share") == 0.25);
    assert_string_equal(json_string(o, "mode"), "own");
    assert_string_equal(json_string(o, "variant"), "auto");
    assert_non_null(strchr(json_string(o, "pair"), ','));
    assert_true(json_number(o, "total_ms") > 0);
    assert_int_equal(json_number(o, "repeat"), 3);
    assert_true(json_number(o, "bytes_a") > 0 && json_number(o, "bytes_b") > 0);
    const cJSON *check = json_field(o, "check");
    assert_true(json_true(check, "right"));
    const cJSON *stages = json_field(o, "stages");
    assert_true(cJSON_GetArraySize(stages) > 0);
    const cJSON *stage = NULL;
    cJSON_ArrayForEach(stage, stages)
    {
        assert_true(*json_string(stage, "name") != '\0');
        assert_true(strcmp(json_string(stage, "device"), "A") == 0 ||
                    strcmp(json_string(stage, "device"), "B") == 0);
        assert_true(json_number(stage, "ms") >= 0);
    }
}

TEST(share_is_a_decimal_or_a_fraction)
{
    static const struct {
        const char *given;
        double share;
    } shares[] = {{"0", 0},
                  {"1", 1},
                  {"0.5", 0.5},
                  {"1/65536", 1.0 / 65536},
                  {"3/4", 0.75},
                  {"65536/65536", 1},
                  {"1e-1", 6554.0 / 65536}};
    for (size_t i = 0; i < sizeof shares / sizeof shares[0]; ++i) {
        cJSON *o = json_of_run("run --json " SCENE " -n 20 --repeat 1 --share %s", shares[i].given);
        assert_true(json_number(o, "share") == shares[i].share);
    }
}

TEST(n_and_seed_choose_the_scene)
{
    cJSON *a = json_of_run("run --json " SCENE " -n 300 --seed 5 --repeat 1");
    cJSON *b = json_of_run("run --json " SCENE " --set n=300 --set seed=5 --repeat 1");
    cJSON *c = json_of_run("run --json " SCENE " -n 300 --seed=6 --repeat 1");
    assert_int_equal(json_number(a, "objects"), 300);
    assert_string_equal(json_string(a, "hash"), json_string(b, "hash"));
    assert_string_not_equal(json_string(a, "hash"), json_string(c, "hash"));
}

// Also for none, one and two objects.
TEST(any_number_of_objects_gives_the_references_pairs)
{
    static const int counts[] = {0, 1, 2, 3, 1000};
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; ++i) {
        program p = program_run("run %s -n %d --repeat 1 --check", SCENE, counts[i]);
        if (strstr(p.out, " \n") || (counts[i] < 10 && strstr(p.out, "million")))
            fail_msg("a line ends with a space, or few are millions:\n%s", p.out);
        if (p.exit_code != 0 || !strstr(p.out, "as the plain C reference"))
            fail_msg("%d objects: %s %s", counts[i], p.out, p.err);
    }
}

TEST(one_pair_is_no_pairs)
{
    program p =
        program_run_with("printf '0,0,0,1,1,1\\n1,1,1,2,2,2\\n' |", "run - --repeat 1 --check");
    assert_says(p.out, "check: the same 1 pair as the plain C reference\n");
}

TEST(an_accuracy_that_no_profile_knows_is_told_of)
{
    static const char *const plans[] = {"", "--share 0"};
    for (size_t i = 0; i < sizeof plans / sizeof *plans; ++i) {
        program p = program_run("run " SCENE " --repeat 1 --missed 1 %s", plans[i]);
        assert_says(p.out, "\nlevel: certified, since no profile says that a cheaper");
    }
    program p = program_run("run " SCENE " --repeat 1");
    assert_null(strstr(p.out, "level: certified, since"));
}

TEST(the_pairs_file_holds_each_pair_once_ascending)
{
    cJSON *o = json_of_run("run --json " SCENE " --pairs test_run.csv --repeat 1 --share 0.5");
    const text t = test_read_file("test_run.csv");
    uint64_t n = 0;
    uint64_t last = 0;
    duet_pair *pairs = test_alloc(t.length * sizeof *pairs);
    for (char *line = strtok(t.chars, "\n"); line; line = strtok(NULL, "\n")) {
        duet_pair *pair = &pairs[n];
        assert_int_equal(sscanf(line, "%" SCNu32 ",%" SCNu32, &pair->a, &pair->b), 2);
        assert_true(pair->a < pair->b);
        uint64_t key = (uint64_t)pair->a << 32 | pair->b;
        assert_true(n == 0 || key > last);
        last = key;
        ++n;
    }
    assert_int_equal(n, json_number(o, "pairs"));
    char hash[17];
    snprintf(hash, sizeof hash, "%016" PRIx64, duet_pairs_hash(pairs, n));
    assert_string_equal(hash, json_string(o, "hash"));
}

TEST(objects_in_order_keep_the_ids_of_the_scene)
{
    static const char *const orders[] = {"", "--ordered --mode slab"};
    text lines[2];
    cJSON *o[2];
    for (int i = 0; i < 2; ++i) {
        o[i] = json_of_run("run --json " SCENE
                           " --pairs test_run.csv --check --repeat 2 --share 0.5 %s",
                           orders[i]);
        lines[i] = test_read_file("test_run.csv");
        assert_int_equal(json_true(o[i], "ordered"), i);
    }
    assert_string_equal(lines[0].chars, lines[1].chars);
    assert_string_equal(json_string(o[0], "hash"), json_string(o[1], "hash"));
}

TEST(text_names_devices_stages_and_pairs)
{
    program p = program_done(program_run("run %s --repeat 2", SCENE));
    bool two = devices_are_two();
    const char *const says[] = {
        "400", two ? "A ms" : " ms", two ? "B ms" : "on  ", "candidates", "hash", "median of 2",
        NULL};
    assert_says_all(p.out, says);
}

// Stages of one device's queue follow each other, and all of them lie within the step.
static void check_stage_times(const cJSON *o)
{
    double ends[2] = {0, 0};
    const cJSON *stage = NULL;
    cJSON_ArrayForEach(stage, json_field(o, "stages"))
    {
        double begin = json_number(stage, "begin_ms"), end = json_number(stage, "end_ms");
        int device = json_string(stage, "device")[0] - 'A';
        if (end == 0)
            continue;
        assert_true(begin >= 0 && begin < end && end <= json_number(o, "total_ms") + 0.05);
        assert_true(json_number(stage, "ms") <= end - begin + 1e-6);
        if (!json_true(stage, "transfer")) {
            assert_true(end > ends[device] - 0.05); // host and device have clocks of their own
            ends[device] = end;
        }
    }
    assert_true(ends[1] > 0);
}

TEST(timeline_shows_each_stage_where_it_was)
{
    cJSON *o = json_of_run("run --json " SCENE
                           " --share 1/4 --mode own --repeat 3 --timeline test_run.svg");
    check_stage_times(o);
    const text svg = test_read_file("test_run.svg");
    assert_memory_equal(svg.chars, "<svg ", 5);
    const cJSON *stage = NULL;
    cJSON_ArrayForEach(stage, json_field(o, "stages"))
    {
        char bar[200];
        snprintf(bar, sizeof bar, "<title>%s: %.3f ms, from %.3f to %.3f</title>",
                 json_string(stage, "name"), json_number(stage, "ms"),
                 json_number(stage, "begin_ms"), json_number(stage, "end_ms"));
        assert_true(json_number(stage, "end_ms") == 0 || strstr(svg.chars, bar));
    }
    assert_says(svg.chars, "the host has the answer: ");
    program_assert_refused(program_run("run %s --steps 2 --timeline test_run.svg", SCENE), 2,
                           "--timeline");
    program p = program_done(program_run("run %s --repeat 1 --timeline -", SCENE));
    assert_memory_equal(p.out, "<svg ", 5);
}

TEST(wrong_usage_is_one_line_and_exit_2)
{
    static const char *const wrong[][2] = {
        {"run", "SCENE|FILE is missing"},
        {"run a.lua b.lua", "unexpected argument 'b.lua'"},
        {"run " SCENE " --share 1.5", "--share '1.5': give a part from 0 to 1"},
        {"run " SCENE " --share -0.1", "--share '-0.1'"},
        {"run " SCENE " --share nan", "--share 'nan'"},
        {"run " SCENE " --share 1/0", "--share '1/0'"},
        {"run " SCENE " --share ''", "--share ''"},
        {"run " SCENE " --share", "--share needs a value"},
        {"run " SCENE " --repeat 0", "--repeat '0': give a whole number from 1"},
        {"run " SCENE " --repeat 1x", "--repeat '1x'"},
        {"run " SCENE " -n -1", "--objects '-1'"},
        {"run " SCENE " -n 99999999999999999999", "--objects '99999999999999999999'"},
        {"run " SCENE " --set n", "--set 'n'"},
        {"run " SCENE " --mode both", "--mode 'both': the modes are "},
        {"run " SCENE " --variant abacus", "abacus"},
        {"run " SCENE " --pair cpu --variant-a gpu", "--variant-a: A and B are one device"},
        {"run " SCENE " --pair cpu --share 0.5",
         " is one device; expected --pair with two, or halves"},
        {"run " SCENE " --pair cpu --mode own", "--mode: "},
        {"run " SCENE " --pair cpu --steps 1 --share 0.5", "--share: "},
        {"run " SCENE " --pair pocl:0,", "device pair 'pocl:0,': expected two selectors"},
    };
    program_assert_refused_by(2, wrong);
}

// On a slow machine nothing may have been timed yet, which is said in the same
// line. All kernels are built before: a driver's compiler that hears of the signal
// has complaints of its own.
TEST(ctrl_c_and_sigterm_show_what_was_timed)
{
    json_of_run("run --json " SCENE " -n 3000 --repeat 20");
    // in the foreground timeout(1) sends its signal once, as a person does
    program p = program_run_with("timeout --foreground --preserve-status -s INT 2",
                                 "run %s -n 3000 --repeat 100000 --json", SCENE);
    assert_int_equal(p.exit_code, 130); // a shell's word for an end by SIGINT
    assert_string_equal(p.err, "duet: stopped\n");
    if (*p.out) {
        cJSON *o = json_of(p.out);
        assert_true(json_number(o, "repeat") > 0 && json_number(o, "repeat") < 100000);
    }
    p = program_run_with("timeout --foreground --preserve-status -s TERM 2",
                         "run %s -n 3000 --repeat 100000", SCENE);
    assert_int_equal(p.exit_code, 143); // likewise by SIGTERM
    assert_string_equal(p.err, "duet: stopped\n");
    assert_true(!*p.out || strstr(p.out, "median of "));
}

TEST(a_level_is_compared_with_its_own_reference)
{
    double found[DUET_LEVELS];
    for (int l = 0; l < DUET_LEVELS; ++l) {
        const char *name = duet_level_get_info((duet_level)l)->name;
        cJSON *o = json_of_run("run --json " SCENE " --check --repeat 1 --level %s", name);
        assert_string_equal(json_string(o, "level"), name);
        found[l] = json_number(o, "pairs");
    }
    assert_true(found[DUET_LEVEL_AABB] > found[DUET_LEVEL_SAT6]);
    assert_true(found[DUET_LEVEL_SAT6] > found[DUET_LEVEL_CERTIFIED]);
}

// One rank of a job says so, and no other is in its way.
TEST(run_is_refused_in_a_job)
{
    program_assert_refused(
        program_run_with("OMPI_COMM_WORLD_SIZE=4 OMPI_COMM_WORLD_RANK=0", "run still"), 2,
        "an MPI job of 4 ranks, and each would find all pairs; expected "
        "'mpirun -np 4 duet cluster'");
    program_assert_refused(program_run_with("PMI_SIZE=4 PMI_RANK=0", "run still"), 2,
                           "expected 'mpirun -np 4 duet cluster'");
    program p = program_done(program_run_with("PMI_SIZE=4 PMI_RANK=3", "run still"));
    assert_string_equal(p.out, "");
    assert_string_equal(p.err, "");
    program_done(program_run_with("PMI_SIZE=1 PMI_RANK=0", "run still -n 3 --repeat 1 --json"));
}

TEST_BEGIN(make_scene)
