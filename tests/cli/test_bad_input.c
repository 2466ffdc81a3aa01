// SPDX-License-Identifier: MIT
// What a person can get wrong with `duet run`: each is refused with one line,
// and leaves nothing behind. Under ASan the program's leaks fail these too.
#define _POSIX_C_SOURCE 200809L
#include "support/json.h"
#include "support/test.h"

#include "base/text_file.h"
#include "support/kernels.h"

#include <sys/stat.h>
#include <unistd.h>

#define OUT "test_bad_input.out"

static void assert_file_holds(const char *path, const char *chars)
{
    const text t = test_read_file(path);
    assert_string_equal(text_chars(&t), chars);
}

// The refusal leaves stdout empty and the file for the pairs as it was.
static void assert_run_refused(int exit_code, const char *arguments, const char *says)
{
    test_write_file(OUT, "before");
    program_assert_refused(program_run("run %s --pairs " OUT, arguments), exit_code, says);
    assert_file_holds(OUT, "before");
    remove(OUT);
    program_assert_refused(program_run("run %s --json --pairs " OUT, arguments), exit_code, says);
    assert_null(fopen(OUT, "rb"));
}

TEST(a_missing_file_is_named)
{
    assert_run_refused(1, "no/such/boxes.csv", "no/such/boxes.csv: No such file or directory");
    assert_run_refused(1, "no/such/boxes.npy", "no/such/boxes.npy: No such file or directory");
    assert_run_refused(1, "no/such/scene.lua", "no/such/scene.lua: No such file or directory");
    assert_run_refused(1, ".", ".: is a folder, not a file");
}

// Their other lines are facts of test_scene_text, test_npy and test_scene_lua.
TEST(what_a_reader_refuses_is_one_line)
{
    static const char *const wrong[][3] = {
        {"bad.csv", "0,0,1,1\n0,nan,1,1\n", "bad.csv:2: object 1: min y is nan"},
        {"bad.npy", "NUMPY", "bad.npy: does not begin as a .npy file does"},
        {"bad.lua", "return {\n  wrld = {},\n}\n", "bad.lua:2: a scene has no field 'wrld'"},
        {"bad.lua", "\nerror('no boxes today')\n", "bad.lua:2: no boxes today"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        test_write_file(wrong[i][0], wrong[i][1]);
        assert_run_refused(1, wrong[i][0], wrong[i][2]);
    }
}

// Files that a person brings along for a scene or a task, and that belong into one.
TEST(a_mesh_and_a_kernel_are_told_where_they_belong)
{
    static const char *const wrong[][2] = {
        {"run bad.stl", "bad.stl: a mesh, which is the ground of a scene; expected boxes as text, "
                        ".npy or a .lua scene with mesh = { file = \"bad.stl\" }"},
        {"picture sub/bad.obj -o bad.svg", "a .lua scene with mesh = { file = \"bad.obj\" }"},
        {"run bad.cl", "bad.cl: the text of a kernel, which a task file names; expected"},
        {"run --task bad.cl", "bad.cl: the text of a kernel; expected a task file, which names it"},
        {"run no.stl", "no.stl: No such file or directory"},
    };
    test_write_file("bad.stl", "solid t\nfacet normal 0 0 1\n");
    mkdir("sub", 0777);
    test_write_file("sub/bad.obj", "v 0 0 0\n");
    test_write_file("bad.cl", "__kernel void add(__global float *a) {}\n");
    program_assert_refused_by(1, wrong);
}

// An endless file is left at the first byte or line that no text has.
TEST(what_is_no_text_is_refused_at_once)
{
    static const char *const wrong[][2] = {
        {"run /dev/zero", "/dev/zero: byte 0 is NUL"},
        {"run - </dev/zero", "stdin: byte 0 is NUL"},
        {"query /dev/zero", "/dev/zero: byte 0 is NUL"},
        {"lua /dev/zero", "/dev/zero: byte 0 is NUL"},
        {"tune --config /dev/zero", "/dev/zero: byte 0 is NUL"},
        {"tune paper --strategy-lua /dev/zero", "/dev/zero: byte 0 is NUL"},
        {"bench --against /dev/zero", "/dev/zero: byte 0 is NUL"},
        {"report /dev/zero -o test_bad_input.html", "/dev/zero: byte 0 is NUL"},
        {"profiles import /dev/zero", "/dev/zero"},
        {"run falling -n 9 --steps 1 --replay /dev/zero",
         "/dev/zero: a device with more than 256 MiB; expected a file"},
    };
    skip_without_device("/dev/zero");
    program_assert_refused_by(1, wrong);
}

TEST(a_line_that_is_too_long_is_refused)
{
    text line = {0};
    for (size_t i = 0; i < TEXT_LINE_MOST / 8 + 1; ++i)
        text_add(&line, "0,0,0,1,");
    test_write_file("test_bad_input.csv", line.chars);
    text_free(&line);
    assert_run_refused(1, "test_bad_input.csv",
                       "test_bad_input.csv: has a line of more than 16 MiB");
}

TEST(a_wrong_option_is_wrong_usage)
{
    test_write_file("test_bad_input.csv", "0,0,1,1\n");
    assert_run_refused(2, "test_bad_input.csv --share half", "--share 'half'");
    assert_run_refused(2, "paper -n 4294967294",
                       "--objects '4294967294': give a whole number from 0 to 4294967293");
    assert_run_refused(2, "test_bad_input.csv -n 1",
                       "'n' cannot be chosen, since this is data and no .lua scene");
}

TEST(a_long_value_is_cut_and_not_the_sentence)
{
    char value[1501] = {0};
    memset(value, 'x', sizeof value - 1);
    program_assert_refused(program_run("run paper --repeat %s", value), 2,
                           "x': give a whole number from ");
    program_assert_refused(program_run("run paper --pairs %s", value), 1,
                           "x: cannot be written: File name too long");
    program_assert_refused(program_run("lua -e 'error(\"%s expected\")'", value), 1, "x expected");
}

TEST(an_empty_name_is_wrong_usage)
{
    static const refusal wrong[] = {
        {"run ''", "duet run: SCENE|FILE is ''; 'duet run --help' says what it is"},
        {"run paper --pairs ''",
         "duet run: --pairs '': the value is empty; expected --pairs OUT.csv"},
        {"run falling --steps 1 --record ''", "--record '': the value is empty"},
        {"run falling --steps 1 --replay ''", "--replay '': the value is empty"},
        {"run falling --steps 1 --every 1 --checkpoint ''", "--checkpoint '': the value is empty"},
        {"run falling --steps 1 --frames ''", "--frames '': the value is empty"},
        {"tune --config ''", "--config '': the value is empty"},
        {"picture paper -o ''", "--output '': the value is empty"},
        {"run falling --steps 1 --resume ''", "--resume '': the value is empty"},
        {"run paper --pair ''", "--pair '': the value is empty; expected --pair A,B"},
        {"lua ''", "is ''"},
        {"report ''", "is ''"},
        {"profiles import ''", "is ''"},
        {"profiles export ''", "is ''"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i)
        program_assert_refused(program_run("%s", wrong[i].given), 2, wrong[i].says);
}

// By whatever name it is called, and before it is read: it is no scene.
TEST(an_output_that_would_replace_what_is_read_is_refused)
{
    static const refusal wrong[] = {
        {"run in.csv --pairs in.csv", "duet run: --pairs in.csv would overwrite what is read"},
        {"run in.csv --pairs ./in.csv", "--pairs ./in.csv would overwrite what is read"},
        {"run link.csv --pairs in.csv", "--pairs in.csv would overwrite what is read"},
        {"run in.csv --pairs link.csv", "--pairs link.csv would overwrite what is read"},
        {"run - --pairs in.csv <in.csv", "--pairs in.csv would overwrite what is read"},
        {"query in.csv -o in.csv", "duet query: --output in.csv would overwrite"},
        {"accuracy in.csv --csv in.csv", "duet accuracy: --csv in.csv would overwrite"},
        {"picture in.csv -o in.csv", "duet picture: --output in.csv would overwrite"},
        {"run falling --steps 1 --replay in.csv --record in.csv",
         "duet run: --record in.csv would overwrite what is read"},
        {"bench --against in.csv -o in.csv", "duet bench: --output in.csv would overwrite"},
        {"report in.csv -o in.csv", "duet report: --output in.csv would overwrite"},
        {"report --profile in.csv -o in.csv", "duet report: --output in.csv would overwrite"},
        {"run in.npy --pairs ./in.npy", "--pairs ./in.npy would overwrite what is read"},
        {"accuracy in.csv --csv out --plot ./out", "--csv and --plot would both write ./out"},
    };
    test_write_file("in.csv", "no scene");
    assert_int_equal(symlink("in.csv", "link.csv"), 0);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        program_assert_refused(program_run("%s", wrong[i].given), 2, wrong[i].says);
        assert_file_holds("in.csv", "no scene");
        assert_int_not_equal(access("out", F_OK), 0);
    }
}

TEST(none_and_one_and_two_objects_are_no_error)
{
    static const char *const rows[] = {"", "0,0,0,1,1,1\n", "0,0,0,1,1,1\n1,1,1,2,2,2\n"};
    for (int n = 0; n <= 2; ++n) {
        test_write_file("test_bad_input.csv", rows[n]);
        program p =
            program_done(program_run("run test_bad_input.csv --repeat 1 --json --pairs " OUT));
        assert_string_equal(p.err,
                            n == 0 ? "duet: note: test_bad_input: there are no objects\n" : "");
        cJSON *report = json_of(p.out);
        assert_int_equal(json_number(report, "objects"), n);
        assert_int_equal(json_number(report, "pairs"), n == 2);
        assert_file_holds(OUT, n == 2 ? "0,1\n" : "");
        remove(OUT);
    }
}

// ------------------------------------------------------------------ kernels

// Clang, inside PoCL, counts its errors on stderr by itself and cannot be told
// not to. That line is not the program's.
static void drop_compiler_count(program *p)
{
    char *count = strstr(p->err, "generated.\n");
    if (!count)
        return;
    char *start = count;
    while (start > p->err && start[-1] != '\n')
        --start;
    char *rest = count + strlen("generated.\n");
    memmove(start, rest, strlen(rest) + 1);
}

TEST(a_kernel_that_does_not_compile_is_named)
{
    static const struct {
        const char *file;
        const char *more;
        const char *says;
    } wrong[] = {
        {"grid/hash.cl", "this is no OpenCL C;\n", "kernels/grid/hash.cl:"},
        {"grid/hash.lua", "this is no Lua\n", "hash.lua:"},
    };
    test_write_file("test_bad_input.csv", "0,0,1,1\n1,1,2,2\n");
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        test_kernels_write("test_bad_input.kernels", wrong[i].file, "", wrong[i].more);
        test_write_file(OUT, "before");
        program p = program_run_with("DUET_KERNEL_DIR=test_bad_input.kernels",
                                     "run test_bad_input.csv --pairs " OUT);
        drop_compiler_count(&p);
        program_assert_refused(p, 1, wrong[i].says);
        assert_file_holds(OUT, "before");
        remove(OUT);
    }
}

TEST(a_missing_folder_of_kernels_is_named)
{
    test_write_file("test_bad_input.csv", "0,0,1,1\n");
    program_assert_refused(
        program_run_with("DUET_KERNEL_DIR=no/such/folder", "run test_bad_input.csv"), 1,
        "no/such/folder: No such file or directory");
}
