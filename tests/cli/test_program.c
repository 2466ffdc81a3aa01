// SPDX-License-Identifier: MIT
#define _DEFAULT_SOURCE // S_IFMT
#include "support/json.h"
#include "support/store.h"
#include "support/test.h"

#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

TEST(help_and_version_are_printed)
{
    program p = program_done(program_run("--version"));
    assert_string_equal(p.out, "duet 0.9.0\n");
    p = program_run("--help");
    assert_says(p.out, "\nexit status: 0 done, 1 failed (or 'bench --against': slower), "
                       "2 wrong usage, 130 interrupted\n");
    assert_int_equal(p.exit_code, 0);
    assert_says(p.out, "devices");
}

TEST(without_a_subcommand_help_is_printed_and_that_is_wrong)
{
    program alone = program_run("%s", "");
    program help = program_run("--help");
    assert_int_equal(alone.exit_code, 2);
    assert_string_equal(alone.err, "duet: a subcommand is missing\n");
    assert_int_equal(strncmp(alone.out, help.out, strlen(help.out)), 0);
}

// Every subcommand that --help names has a --help of its own.
TEST(every_subcommand_has_help)
{
    program all = program_run("--help");
    int n = 0;
    for (char *line = strtok(all.out, "\n"); line; line = strtok(NULL, "\n")) {
        char name[32];
        if (strncmp(line, "  ", 2) != 0 || sscanf(line, " %31[a-z]", name) != 1)
            continue;
        program p = program_run("%s --help", name);
        char begin[64];
        snprintf(begin, sizeof begin, "duet %s", name);
        assert_int_equal(p.exit_code, 0);
        assert_int_equal(strncmp(p.out, begin, strlen(begin)), 0);
        assert_says(p.out, "--help");
        assert_true(!strstr(p.out, "SCENE|FILE") || strstr(p.out, "\nFILE has a box a row"));
        program other = program_run("help %s", name);
        assert_string_equal(other.out, p.out);
        ++n;
    }
    assert_true(n > 0);
}

TEST(wrong_usage_is_one_line_and_exit_2)
{
    static const char *const wrong[][2] = {
        {"abacus", "there is no subcommand 'abacus'; 'duet --help' lists"},
        {"help devcies", "there is no subcommand 'devcies'; did you mean 'devices'?"},
        {"devcies", "there is no subcommand 'devcies'; did you mean 'devices'?"},
        {"dev", "there is no subcommand 'dev'; did you mean 'devices'?"},
        {"run", "duet run: SCENE|FILE is missing; 'duet run --help' says what it is"},
        {"tune", "give a scene, as 'duet tune paper', or a tune file with --config"},
        {"run x --chekc", "there is no option '--chekc'; did you mean '--check'?"},
        {"run x --check-all=1", "there is no option '--check-all=1'; 'duet run --help' lists"},
        {"run x --JSON", "there is no option '--JSON'; did you mean '--json'?"},
        {"Run x", "there is no subcommand 'Run'; did you mean 'run'?"},
        {"run x -json", "there is no option '-json'; did you mean '--json'?"},
        {"run x --n 3", "there is no option '--n'; did you mean '-n'?"},
        {"run x -objects 3", "there is no option '-objects'; did you mean '--objects'?"},
        {"run x -nine", "--objects 'ine': give a whole number"},
        {"lua -ix", "there is no option '-ix'"},
        {"run x -p", "there is no option '-p'; 'duet run --help' lists"},
        {"run x --input sizes", "--input: give host (all of the objects), resident (nothing"},
        {"run x --input compact --check", "--check and --input compact do not go together"},
        {"run x --json --pairs -", "--pairs and --json would both write to stdout"},
        {"accuracy x --csv - --plot -", "--csv and --plot would both write to stdout"},
        {"accuracy x --still --time 2", "--time and --still do not go together"},
        {"explain x --steps 9", "--steps does nothing without --measure"},
        {"lua --trust --seconds 3 x", "--seconds and --trust do not go together"},
        {"source x --most 3", "--most does nothing without --check"},
        {"source x --seed 3", "--seed does nothing without --check"},
        {"source x --list --set A=1", "--set and --list do not go together"},
        {"scenes papr", "there is no scene 'papr'; did you mean 'paper'?"},
        {"scenes abacus", "there is no scene 'abacus'; 'duet scenes' lists"},
        {"scenes paper --json", "--json is of the list"},
        {"devices --abacus", "there is no option '--abacus'"},
        {"devices -x", "there is no option '-x'"},
        {"devices --json=1", "--json takes no value"},
        {"devices scene.lua", "devices: unexpected argument 'scene.lua'"},
        {"devices -- --json", "unexpected argument '--json'"},
        {"devices --=3", "there is no option '--=3'; 'duet devices --help' lists"},
        {"\"$(printf 'a\\033b\\nc')\"", "there is no subcommand 'a\\x1bb\\x0ac'"},
        {"devices \"$(printf -- '--a\\033b\\nc')\"", "there is no option '--a\\x1bb\\x0ac'"},
    };
    program_assert_refused_by(2, wrong);
}

// Whoever looks the name up. A file that does not exist is a failure instead.
TEST(an_unknown_name_is_exit_2_in_every_subcommand)
{
    static const char *const unknown[][2] = {
        {"abacus", "no subcommand 'abacus'"},
        {"--help abacus", "no subcommand 'abacus'"},
        {"run abacus", "abacus: no such file or scene"},
        {"run paper -n 9 --set abacus=1", "no parameter 'abacus'"},
        {"run paper -n 9 --set seed=abacus", "parameter seed is 'abacus'"},
        {"run paper -n 9 --pair abacus", "no device 'abacus'"},
        {"run paper -n 9 --pair cpu,abacus", "no device 'abacus'"},
        {"run paper -n 9 --pair abacus:0,abacus:1", "no device 'abacus:0'"},
        {"run paper -n 9 --mode abacus", "--mode 'abacus'"},
        {"run paper -n 9 --level abacus",
         "--level 'abacus': the levels are certified, aabb, sphere, sat6, sat15, double\n"},
        {"run paper -n 9 --variant abacus", "variant 'abacus'"},
        {"tune abacus", "abacus: no such file or scene"},
        {"tune paper -n 9 --strategy abacus", "strategy 'abacus'"},
        {"tune paper -n 9 --search abacus", "search 'abacus'"},
        {"tune paper -n 9 --variants abacus", "variant 'abacus'"},
        {"tune paper -n 9 --pair cpu,cpu --query abacus", "'abacus'"},
        {"accuracy abacus", "abacus: no such file or scene"},
        {"accuracy paper -n 9 --pair abacus", "no device 'abacus'"},
        {"bench --scene abacus", "--scene 'abacus'"},
        {"bench --scene paper --pair abacus", "no device 'abacus'"},
        {"explain abacus", "abacus: no such file or scene"},
        {"explain paper -n 9 --pair abacus", "no device 'abacus'"},
        {"picture abacus -o test_program_x.svg", "abacus: no such file or scene"},
        {"profiles abacus", "there is no 'abacus'"},
        {"profiles why abacus", "abacus: no such file or scene"},
        {"profiles why paper -n 9 --level abacus", "--level 'abacus'"},
        {"query abacus", "abacus: no such file or scene"},
        {"query abacus.npy --device abacus", "no device 'abacus'"},
        {"scenes abacus", "there is no scene 'abacus'"},
        {"source abacus", "no kernel 'abacus'"},
        {"source bounds --device abacus", "no device 'abacus'"},
        {"source bounds --scene abacus", "abacus: no such file or scene"},
        {"source bounds --set ABACUS=1", "no parameter 'ABACUS'"},
        {"source --check abacus", "no kernel 'abacus'"},
    };
    program_assert_refused_by(2, unknown);
}

TEST(an_argument_too_many_is_unexpected_in_every_subcommand)
{
    static const char *const full[] = {
        "--version",
        "help run",
        "--help run",
        "accuracy a",
        "bench",
        "cluster a",
        "devices",
        "explain a",
        "picture a",
        "profiles check",
        "profiles diff a b",
        "profiles export a",
        "profiles forget a",
        "profiles import a",
        "profiles list",
        "profiles merge a",
        "profiles prune",
        "profiles show a",
        "profiles use a",
        "profiles why a",
        "query a",
        "run a",
        "scenes a",
        "source a",
        "tune a",
    };
    for (size_t i = 0; i < sizeof full / sizeof *full; ++i)
        program_assert_refused(program_run("%s extra", full[i]), 2,
                               "unexpected argument 'extra'; 'duet ");
}

// Some of these would work for minutes first.
TEST(what_cannot_be_written_is_refused_before_the_work)
{
    static const char *const commands[] = {"bench -o no/such/x.json",
                                           "accuracy still -n 100 --csv no/such/x.csv",
                                           "accuracy still -n 100 --plot no/such/x.svg",
                                           "run falling -n 100 --steps 2 --record no/such/x",
                                           "run still -n 100 --pairs no/such/x.csv"};
    for (size_t i = 0; i < sizeof commands / sizeof *commands; ++i)
        program_assert_refused(program_run("%s", commands[i]), 1,
                               "cannot be written: No such file or directory");
}

static uint64_t objects_of(const char *arguments)
{
    cJSON *o = json_of_run("run --json --repeat 1 --share 0 %s", arguments);
    return (uint64_t)json_number(o, "objects");
}

TEST(numbers_are_written_as_people_write_them)
{
    static const struct {
        const char *written;
        uint64_t n; // UINT64_MAX: refused
    } counts[] = {
        {"250", 250},         {"1k", 1000},          {"1K", 1000},      {"0.3k", 300},
        {"1e2", 100},         {"2.5e2", 250},        {"1E+2", 100},     {"1.5", UINT64_MAX},
        {"1e-1", UINT64_MAX}, {"1kk", UINT64_MAX},   {"k", UINT64_MAX}, {".5k", UINT64_MAX},
        {"5G", UINT64_MAX},   {"1e400", UINT64_MAX}, {"", UINT64_MAX},  {"1 k", UINT64_MAX},
        {"0x10", UINT64_MAX}, {"1e", UINT64_MAX},    {"+5", UINT64_MAX}};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; ++i) {
        char arguments[64];
        snprintf(arguments, sizeof arguments, "still --objects '%s'", counts[i].written);
        if (counts[i].n != UINT64_MAX) {
            assert_int_equal(objects_of(arguments), counts[i].n);
            continue;
        }
        program_assert_refused(program_run("run %s", arguments), 2, "--objects '");
    }
}

TEST(scenes_are_known_by_name)
{
    program list = program_done(program_run("scenes"));
    int n = 0;
    for (char *row = strtok(list.out, "\n"); row; row = strtok(NULL, "\n"), ++n) {
        char name[32];
        assert_int_equal(sscanf(row, "%31[a-z0-9]  %*c", name), 1);
        assert_true(strlen(row) > strlen(name) + 20); // and what it is, in whole sentences
        assert_string_equal(row + strlen(row) - 1, ".");
        program shown = program_run("scenes %s", name);
        assert_int_equal(strncmp(shown.out, "-- SPDX", 7), 0);
    }
    assert_int_equal(n, 16);
    program_assert_refused(program_run("run papr"), 2,
                           "papr: no such file or scene; did you mean 'paper'?");
    program_assert_refused(program_run("run abacus"), 2,
                           "abacus: no such file or scene; 'duet scenes' lists");
}

// A file of that name is meant by a path.
TEST(a_name_is_a_scene_and_a_path_a_file)
{
    test_write_file("still", "0,0,0,1,1,1\n");
    test_write_file("unlike", "0,0,0,1,1,1\n");
    assert_int_equal(objects_of("still -n 20"), 20);
    assert_int_equal(objects_of("still -n20"), 20);
    assert_int_equal(objects_of("./still"), 1);
    assert_int_equal(objects_of("unlike"), 1);
}

TEST(a_dash_is_stdin_and_stdout)
{
    static const char *const inputs[] = {
        "printf '0,0,0,1,1,1\\n.5,.5,.5,2,2,2\\n'",
        "printf '# boxes\\n\\nlower_x x y z u v\\n0 0 0 1 1 1\\n-.5 0 0 2 2 2\\n'",
        "printf 'for i = 0, 1 do\\n add(i / 2, 0, 0, i + 1, 1, 1)\\nend\\nreturn { dims = 3 }'",
        "printf -- '-- two boxes\\nadd(0, 0, 0, 1, 1, 1) add(0, 0, 0, 2, 2, 2)\\nreturn {}'"};
    for (size_t i = 0; i < sizeof inputs / sizeof *inputs; ++i) {
        char before[256];
        snprintf(before, sizeof before, "%s |", inputs[i]);
        program p = program_run_with(before, "run - --pairs -");
        assert_string_equal(p.err, "");
        assert_string_equal(p.out, "0,1\n");
    }
    program p = program_run_with("printf 'print(6 * 7)' |", "lua -");
    assert_string_equal(p.out, "42\n");
    program_assert_refused(program_run_with("printf '1,2,x' |", "run -"), 1,
                           "stdin:1: column 3: 'x' is not a number");
    p = program_run("picture still -n 3 -o -");
    assert_string_equal(p.err, "");
    assert_says(p.out, "<svg");
}

TEST(an_empty_input_is_told_of)
{
    program p = program_done(program_run_with(": |", "run - --pairs -"));
    assert_string_equal(p.out, "");
    assert_string_equal(p.err, "duet: note: stdin: there are no objects\n");
    p = program_run("run paper -n 0"); // nothing was done that a table could tell of
    assert_int_equal(p.exit_code, 0);
    assert_string_equal(p.out, "paper: 0 boxes, 3D\n");
    static const char *const measuring[] = {"tune paper -n 0", "profiles why paper -n 0"};
    for (size_t i = 0; i < sizeof measuring / sizeof *measuring; ++i) {
        p = program_run("%s", measuring[i]);
        assert_string_equal(p.err, "duet: paper: there are no objects to measure\n");
        program_assert_refused(p, 2, "there are no objects to measure");
    }
    p = program_run_with(": |", "query - -o -");
    assert_string_equal(p.out, "");
    assert_string_equal(p.err, "duet: note: stdin: there are no pairs\n");
}

TEST(devices_are_listed_as_one_json_object)
{
    cJSON *o = json_of_run("devices --json");
    const cJSON *devices = json_field(o, "devices");
    assert_true(cJSON_GetArraySize(devices) > 0);
    const cJSON *selector = json_field(cJSON_GetArrayItem(devices, 0), "selector");
    assert_true(cJSON_IsString(selector));
}

TEST(a_machine_without_opencl_is_told_what_to_install)
{
    static const char *const commands[] = {"devices", "devices --json"};
    for (int i = 0; i < 2; ++i)
        program_assert_refused(program_run_with("OCL_ICD_FILENAMES= OCL_ICD_VENDORS=no/such/folder",
                                                "%s", commands[i]),
                               1, "apt install pocl-opencl-icd");
}

// PoCL, which cannot make its cache folder, lists no device: it is installed for all that.
TEST(a_cache_folder_that_cannot_be_made_is_told_of)
{
    program_assert_refused(program_run_with("HOME=/nonexistent POCL_CACHE_DIR=/proc/x", "devices"),
                           1, "its cache folder /proc/x cannot be written: No such file");
}

// A driver whose devices are elsewhere, or may not be opened.
TEST(a_platform_without_a_device_is_told_of)
{
    static const char here[] = "OCL_ICD_VENDORS=test_program.icds";
    static const char says[] = "the OpenCL platform 'Abacus' lists no device";
    assert_int_equal(system("rm -rf test_program.icds; mkdir test_program.icds && "
                            "cp ${OCL_ICD_VENDORS:-/etc/OpenCL/vendors}/*.icd test_program.icds && "
                            "echo " TEST_ABSENT " >test_program.icds/absent.icd"),
                     0);
    program p = program_done(program_run_with(here, "devices"));
    assert_says(p.out, "pocl:0  ", says);
    p = program_run_with(here, "devices --json");
    cJSON *o = json_of(p.out);
    const cJSON *absent = json_field(o, "absent");
    assert_int_equal(cJSON_GetArraySize(absent), 1);
    assert_string_equal(cJSON_GetArrayItem(absent, 0)->valuestring, says);
    p = program_run_with(here, "lua -e 'print(#duet.devices().absent, duet.devices().absent[1])'");
    assert_int_equal(strcmp(p.out, "1\tthe OpenCL platform 'Abacus' lists no device\n"), 0);
    program_assert_refused(program_run_with(here, "run paper -n 10 --pair abacus:0"), 2,
                           "; the OpenCL platform 'Abacus' lists no device");
    program_assert_refused(
        program_run_with(
            "HOME=/nonexistent POCL_CACHE_DIR=/proc/x OCL_ICD_VENDORS=test_program.icds",
            "devices"),
        1, "lists no device");
}

TEST(a_full_disk_is_a_failure)
{
    skip_without_device("/dev/full");
    program_assert_refused(program_run("devices --json >/dev/full"), 1,
                           "stdout: No space left on device");
}

static bool is_kind(const char *path, mode_t kind)
{
    struct stat info;
    return lstat(path, &info) == 0 && (info.st_mode & S_IFMT) == kind;
}

// OUT is a link: to a device, which is written and stays, or to a file.
TEST(outputs_are_written_through_links)
{
    skip_without_device("/dev/full");
    static const char *const commands[] = {
        "picture planes -n 20 -o OUT.svg",
        "run planes -n 20 --repeat 1 --pairs OUT.svg",
        "query program.pairs -o OUT.svg",
        "accuracy planes -n 20 --repeat 1 --csv OUT.svg",
        "accuracy planes -n 20 --repeat 1 --plot OUT.svg",
        "bench --quick --repeat 1 --scene planes -o OUT.svg",
        "profiles export --profile program.db OUT.svg",
        "report --profile program.db -o OUT.svg",
    };
    test_write_file("program.pairs", "0,0,0,1,1,1,0,0,0,1, 1,0,0,1,1,1,0,0,0,1\n");
    store_close(test_store_open("program.db", STORE_WRITE));
    for (size_t i = 0; i < sizeof commands / sizeof *commands; ++i) {
        remove("OUT.svg");
        assert_int_equal(symlink("/dev/full", "OUT.svg"), 0);
        program p = program_run("%s", commands[i]);
        if (p.exit_code != 1 || !strstr(p.err, "OUT.svg: cannot be written: No space left"))
            fail_msg("%s: %d %s", commands[i], p.exit_code, p.err);
        assert_true(is_kind("OUT.svg", S_IFLNK) && is_kind("/dev/full", S_IFCHR));
        remove("OUT.svg");
        test_write_file("program.out", "");
        assert_int_equal(symlink("program.out", "OUT.svg"), 0);
        program_done(program_run("%s", commands[i]));
        struct stat info;
        assert_true(is_kind("OUT.svg", S_IFLNK) && is_kind("program.out", S_IFREG));
        assert_true(stat("program.out", &info) == 0 && info.st_size > 0);
    }
}

// The program ends as others do: silently, by SIGPIPE, which a shell shows as 141.
TEST(a_reader_that_went_away_ends_the_program)
{
    int ends[2];
    assert_int_equal(pipe(ends), 0);
    close(ends[0]);
    assert_int_equal(dup2(ends[1], 9), 9);
    static const char *const commands[] = {"--help >&9", "run planes -n 9 --repeat 1 --pairs - >&9",
                                           "lua --trust -e 'while true do print(1) end' >&9"};
    for (size_t i = 0; i < sizeof commands / sizeof *commands; ++i) {
        program p = program_run("%s", commands[i]);
        assert_string_equal(p.err, "");
        assert_int_equal(p.exit_code, 128 + SIGPIPE);
    }
    close(9);
    close(ends[1]);
    program_assert_refused(program_run("--help >&-"), 1, "stdout: ");
}
