// SPDX-License-Identifier: MIT
// Of what comes out of mpirun a person sees the ranks' lines and one line where the job fails. A
// script stands for mpirun, and says what Open MPI 4.1 was seen to say.
#include "cli/mpirun_says.h"

#include "support/program.h"
#include "support/test.h"

#include "base/rng.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define RULE "--------------------------------------------------------------------------\n"
#define RESET                                                                                  \
    "[four][[34703,1],3][../../opal/mca/btl/tcp/btl_tcp.c:559:mca_btl_tcp_recv_blocking] recv" \
    "(17) failed: Connection reset by peer (104)\n"
#define HUNG_UP                                                                           \
    RULE "An MPI communication peer process has unexpectedly disconnected.\n\n  duetted " \
         "Local host: one\n" RULE
#define NOTICED                                                                             \
    RULE "mpirun noticed that process rank 2 with PID 1168 on node three exited on signal " \
         "9 (Killed).\n" RULE
#define LOST                                                                      \
    RULE "ORTE has lost communication with a remote daemon.\n\n  HNP daemon   : " \
         "[[36590,0],0] on node one\n  Remote daemon: [[36590,0],2] on node three\n\n" RULE
#define AGGREGATE "[one:01043] 1 more process has sent help message help-mpi-btl-tcp.txt\n"
#define BEGUN MPIRUN_BEGUN

// ---------------------------------------------------------------- what goes through

static const struct {
    const char *says, *shown;
} streams[] = {
    {"", ""},
    {BEGUN "duet: kept\n", "duet: kept\n"},
    {BEGUN "one\n\ntwo", "one\n\ntwo"},
    {BEGUN RESET "duet: a line\n" AGGREGATE "another\n", "duet: a line\nanother\n"},
    {BEGUN HUNG_UP NOTICED LOST AGGREGATE "after\n", "after\n"},
    {BEGUN RULE "duet: within\n" RULE "after\n", "duet: within\nafter\n"},
    {BEGUN RULE "never ends\nduet: seen\r\033[Kstep 4\r\033[Kduet: too\n",
     "duet: seen\r\033[K\r\033[Kduet: too\n"},
    {BEGUN "\r\033[Kstep 3 of 9" RESET "\r\033[Kstep 4 of 9\r\033[K",
     "\r\033[Kstep 3 of 9\r\033[Kstep 4 of 9\r\033[K"},
    {BEGUN "\r\033[Kstep 3 of 9[one:12] noise\nnext\n", "\r\033[Kstep 3 of 9next\n"},
    {BEGUN "pocl:0[0-1] a[1] [x:y] [] [:1] [a:] [a:1]! [[b:2]. [c] [d][ [e][f\n",
     "pocl:0[0-1] a[1] [x:y] [] [:1] [a:] [a:1]! [[b:2]. [c] [d][ [e][f\n"},
    {BEGUN "mpirun: Forwarding signal 12 to job\nmpirun no\nmm\n", "mpirun no\nmm\n"},
    {BEGUN "\r\033[Kstep 3 of 9mpirun: Forwarding signal 12 to job\n\r\033[Kmpi\nm",
     "\r\033[Kstep 3 of 9\r\033[Kmpi\nm"},
    {BEGUN "duet: [one:12] is a name\n", "duet: [one:12] is a name\n"},
    {BEGUN "--- a few dashes ---\n-\nd\ndu\ndue\nduel\n[",
     "--- a few dashes ---\n-\nd\ndu\ndue\nduel\n["},
    {"ssh: no\r\n\nduet: yes\nother\n" BEGUN "then\n", "duet: yes\nthen\n"},
};

// However the bytes come: all at once, one by one, and in random pieces.
static void lines_of_mpi_are_kept_back(void **state)
{
    (void)state;
    rng r = rng_seed(test_seed());
    for (size_t i = 0; i < sizeof streams / sizeof *streams; ++i)
        for (uint32_t most = 1; most < 200; most += 1 + most / 2) {
            mpirun_says says = {0}, all = {.passes_all = true};
            text shown = {0}, passed = {0}, without = {0};
            for (const char *at = streams[i].says; *at;) {
                size_t n = 1 + rng_below(&r, most), left = strlen(at);
                n = n < left ? n : left;
                mpirun_hear(&says, at, n, &shown);
                mpirun_hear(&all, at, n, &passed);
                at += n;
            }
            mpirun_hear_end(&says, &shown);
            mpirun_hear_end(&all, &passed);
            for (const char *at = streams[i].says; *at; ++at)
                if (*at != *BEGUN)
                    text_add_bytes(&without, at, 1);
            assert_string_equal(text_chars(&shown), streams[i].shown);
            assert_string_equal(text_chars(&passed), text_chars(&without));
            assert_int_equal(says.begun, strstr(streams[i].says, BEGUN) != NULL);
            text_free(&shown);
            text_free(&passed);
            text_free(&without);
        }
}

static mpirun_says heard(const char *stream)
{
    mpirun_says says = {0};
    text shown = {0};
    mpirun_hear(&says, stream, strlen(stream), &shown);
    mpirun_hear_end(&says, &shown);
    text_free(&shown);
    return says;
}

static void what_mpi_tells_is_known(void **state)
{
    (void)state;
    mpirun_says says = heard(BEGUN RESET HUNG_UP NOTICED AGGREGATE);
    assert_true(says.names_rank && says.rank == 2);
    assert_string_equal(says.host, "three");
    assert_string_equal(says.why, "");
    says = heard(BEGUN LOST);
    assert_false(says.names_rank);
    assert_string_equal(says.host, "three");
    says = heard("[vm:1] plm:rsh: Warning: setpgid\n\nssh: \033[1mno\nand more\n" HUNG_UP);
    assert_string_equal(says.why, "ssh: \\x1b[1mno");
    says = heard(RULE "mpirun has detected an attempt to run as root.\nOther\n" RULE);
    assert_string_equal(says.why, "mpirun has detected an attempt to run as root.");
    says = heard(HUNG_UP "orted: command not found\n" HUNG_UP);
    assert_string_equal(says.why, "orted: command not found");
    says = heard("no end");
    assert_string_equal(says.why, "no end");
}

// Nothing is read or written past a line's memory, however long it is.
static void long_lines_are_lines(void **state)
{
    (void)state;
    enum { LONG = 3 * MPIRUN_LINE };
    static const char *const begins[] = {"[",
                                         "-",
                                         "[x:1",
                                         "d",
                                         "x",
                                         "[x:1] ",
                                         "mpirun noticed that process rank 1 with PID 1 on node "};
    for (size_t i = 0; i < sizeof begins / sizeof *begins; ++i)
        for (int begun = 0; begun < 2; ++begun) {
            mpirun_says says = {.begun = begun};
            text line = {0}, shown = {0};
            text_add(&line, "%s", begins[i]);
            for (int k = 0; k < LONG; ++k)
                text_add_bytes(&line, "1", 1);
            text_add(&line, "\nduet\n");
            mpirun_hear(&says, line.chars, line.length, &shown);
            mpirun_hear_end(&says, &shown);
            bool passes = begun && strcmp(begins[i], "[x:1] ") != 0;
            assert_string_equal(text_chars(&shown), passes ? line.chars : "duet\n");
            text_free(&line);
            text_free(&shown);
        }
}

// A byte of zero follows each of its blocks.
static void blocks_of_open_mpi_5_are_kept_back(void **state)
{
    (void)state;
    static const char bytes[] = BEGUN HUNG_UP
        "\0" RULE "prterun noticed that process rank 2 with PID 16503 on node three exited on\n"
        "signal 9 (Killed).\n" RULE "\0duet: a line\n\0" HUNG_UP "\0another\n";
    for (size_t most = 1; most < sizeof bytes; most = 2 * most + 1) {
        mpirun_says says = {0};
        text shown = {0};
        for (size_t i = 0; i < sizeof bytes - 1; i += most)
            mpirun_hear(&says, bytes + i, sizeof bytes - 1 - i < most ? sizeof bytes - 1 - i : most,
                        &shown);
        mpirun_hear_end(&says, &shown);
        assert_string_equal(text_chars(&shown), "duet: a line\nanother\n");
        assert_true(says.names_rank && says.rank == 2);
        assert_string_equal(says.host, "three");
        text_free(&shown);
    }
}

// ---------------------------------------------------------------- the program

// `duet cluster` finds this in the place of mpirun.
static void be_mpirun(const char *says, const char *then)
{
    char script[256];
    snprintf(script, sizeof script, "#!/bin/sh\ncat mpirun_of_test/says >&2\n%s\n", then);
    test_write_file("mpirun_of_test/says", says);
    test_write_file("mpirun_of_test/mpirun", script);
    assert_int_equal(chmod("mpirun_of_test/mpirun", 0755), 0);
}

static void skip_without_mpi(void)
{
    char path[4096];
    snprintf(path, sizeof path, "%s-cluster", getenv("DUET_PROGRAM"));
    if (access(path, X_OK) != 0) {
        print_message("%s: Duet was built without MPI\n", path);
        skip();
    }
}

static void a_job_that_fails_is_one_line(void **state)
{
    (void)state;
    static const struct {
        const char *says, *then, *arguments, *told;
    } jobs[] = {
        {BEGUN RESET HUNG_UP NOTICED AGGREGATE, "exit 137", "--ranks 4",
         "rank 2 on three was ended by signal 9 (Killed), and with it the job"},
        {BEGUN RESET, "exit 139", "--ranks 4",
         "a rank was ended by signal 11 (Segmentation fault), and with it the job"},
        {BEGUN LOST, "exit 205", "--ranks 4", "three is out of reach, and with it the job has"},
        {BEGUN RULE "  Local host: one\n  Peer host:  three\n" RULE, "exit 14", "--ranks 4",
         "a rank on three was lost, and with it the job has ended"},
        {BEGUN RESET, "exit 3", "--ranks 4", "mpirun ended with status 3; with --verbose it says"},
        {"ssh: no route\n" HUNG_UP, "exit 255", "--ranks 4 --hosts a,b",
         "mpirun ended with status 255 before all ranks had begun: ssh: no route\n"},
        {"", "exit 1", "--ranks 2", "before all ranks had begun; with --verbose it says why"},
        {"", "kill -9 $$", "--ranks 2", "mpirun was ended by signal 9 (Killed)"},
        {"", "sleep 100 & sleep 100", "--ranks 2 --hosts a,b",
         "the ranks on a,b have not begun within 1 s; expected machines that ssh reaches"},
        {BEGUN RESET "duet: rank 1 on two: no\n" NOTICED, "exit 65", "--ranks 2",
         "duet: rank 1 on two: no"},
    };
    static const char variables[] =
        "PATH=\"$PWD/mpirun_of_test:$PATH\" OMPI_MCA_orte_startup_timeout=1";
    skip_without_mpi();
    mkdir("mpirun_of_test", 0755);
    for (size_t i = 0; i < sizeof jobs / sizeof *jobs; ++i) {
        be_mpirun(jobs[i].says, jobs[i].then);
        program p = program_run_with(variables, "cluster %s still -n 3", jobs[i].arguments);
        program_assert_refused(&p, 1, jobs[i].told);
    }
    be_mpirun(BEGUN MPIRUN_STOPPED, "exit 0");
    program stopped = program_run_with(variables, "cluster --ranks 2 still");
    program_assert_refused(&stopped, 130, "duet: stopped");
    be_mpirun(BEGUN RESET "driver: a warning\n", "echo found");
    for (int verbose = 0; verbose < 2; ++verbose) {
        program p =
            program_run_with(variables, "cluster --ranks 2 %s still", verbose ? "--verbose" : "");
        assert_int_equal(p.exit_code, 0);
        assert_string_equal(p.out, "found\n");
        assert_string_equal(p.err, verbose ? RESET "driver: a warning\n" : "driver: a warning\n");
        program_free(&p);
    }
    unlink("mpirun_of_test/mpirun");
    unlink("mpirun_of_test/says");
    rmdir("mpirun_of_test");
}

// What a shell's loop reads stays there. A scene may come from there, by any of its names.
static void ranks_get_stdin_only_where_they_read_the_scene_from_it(void **state)
{
    (void)state;
    skip_without_mpi();
    mkdir("mpirun_of_test", 0755);
    be_mpirun(BEGUN, "cat");
    static const char *const jobs[][2] = {{"still", ""}, {"-", "next\n"}, {"/dev/stdin", "next\n"}};
    for (size_t i = 0; i < sizeof jobs / sizeof *jobs; ++i) {
        program p = program_run_with("echo next | PATH=\"$PWD/mpirun_of_test:$PATH\"",
                                     "cluster --ranks 2 %s", jobs[i][0]);
        assert_int_equal(p.exit_code, 0);
        assert_string_equal(p.out, jobs[i][1]);
        program_free(&p);
    }
    unlink("mpirun_of_test/mpirun");
    unlink("mpirun_of_test/says");
    rmdir("mpirun_of_test");
}

#define OLD_BINDING "OMPI_MCA_hwloc_base_binding_policy"
#define OLD_SHARING "OMPI_MCA_rmaps_base_oversubscribe"
#define NEW_BINDING "PRTE_MCA_hwloc_default_binding_policy"
#define NEW_SHARING "PRTE_MCA_rmaps_default_mapping_policy"

// Open MPI 4 and 5 have names of their own for it. What the user says goes before.
static void ranks_share_the_machine_with_any_open_mpi(void **state)
{
    (void)state;
    skip_without_mpi();
    mkdir("mpirun_of_test", 0755);
    be_mpirun(BEGUN, "echo $" OLD_BINDING " $" OLD_SHARING " $" NEW_BINDING " $" NEW_SHARING);
    static const char *const given[][2] = {
        {"-u " NEW_BINDING, "none 1 none :oversubscribe\n"},
        {NEW_BINDING "=core", "none 1 core :oversubscribe\n"},
    };
    for (size_t i = 0; i < sizeof given / sizeof *given; ++i) {
        char variables[400];
        snprintf(variables, sizeof variables,
                 "env -u " OLD_BINDING " -u " OLD_SHARING " -u " NEW_SHARING
                 " %s PATH=\"$PWD/mpirun_of_test:$PATH\"",
                 given[i][0]);
        program p = program_run_with(variables, "cluster --ranks 9 still -n 3");
        assert_int_equal(p.exit_code, 0);
        assert_string_equal(p.out, given[i][1]);
        program_free(&p);
    }
    unlink("mpirun_of_test/mpirun");
    unlink("mpirun_of_test/says");
    rmdir("mpirun_of_test");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lines_of_mpi_are_kept_back),
        cmocka_unit_test(what_mpi_tells_is_known),
        cmocka_unit_test(long_lines_are_lines),
        cmocka_unit_test(blocks_of_open_mpi_5_are_kept_back),
        cmocka_unit_test(a_job_that_fails_is_one_line),
        cmocka_unit_test(ranks_get_stdin_only_where_they_read_the_scene_from_it),
        cmocka_unit_test(ranks_share_the_machine_with_any_open_mpi),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
