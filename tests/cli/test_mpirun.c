// SPDX-License-Identifier: MIT
// What mpirun and ranks write passes through, and one line follows if the job fails. A script
// stands for mpirun.
#define _POSIX_C_SOURCE 200809L
#include "support/program.h"
#include "support/test.h"

#include "base/text_file.h"

#include <signal.h>
#include <sys/stat.h>

// Bytes of rank 0: all ranks are there, and all have stopped.
#define BEGUN "\x06"
#define STOPPED "\x18"

// `duet cluster` finds this in the place of mpirun.
static void be_mpirun(const char *says, const char *then)
{
    char script[256];
    snprintf(script, sizeof script, "#!/bin/sh\ncat mpirun_of_test/says >&2\n%s\n", then);
    test_write_file("mpirun_of_test/says", says);
    test_write_file("mpirun_of_test/mpirun", script);
    assert_int_equal(chmod("mpirun_of_test/mpirun", 0755), 0);
}

TEST(a_job_that_fails_is_one_line)
{
    static const struct {
        const char *says, *then, *arguments, *told;
    } jobs[] = {
        {BEGUN, "exit 139", "--ranks 4",
         "a rank was ended by signal 11 (Segmentation fault), and with it the job; with --verbose"},
        {BEGUN, "exit 205", "--ranks 4 --hosts a,b",
         "mpirun ended with status 205, a machine may be out of reach; with --verbose it says why"},
        {BEGUN, "exit 3", "--ranks 4", "mpirun ended with status 3; with --verbose it says"},
        {"", "exit 1", "--ranks 2", "before all ranks had begun; with --verbose it says why"},
        {"", "kill -9 $$", "--ranks 2", "mpirun was ended by signal 9 (Killed)"},
        {"", "sleep 100 & sleep 100", "--ranks 2 --hosts a,b",
         "the ranks on a,b have not begun within 1 s; expected machines that ssh reaches"},
        {BEGUN, "sleep 0.1 & exec sleep 100", "--ranks 2",
         "the ranks have ended, and mpirun did not: it was ended after 3 s"},
        {BEGUN "duet: rank 1 on two: no\n", "sleep 0.1 & exec sleep 100", "--ranks 2",
         "duet: rank 1 on two: no"},
        {BEGUN "duet: rank 1 on two: no\n", "exit 65", "--ranks 2", "duet: rank 1 on two: no"},
    };
    static const char variables[] =
        "PATH=\"$PWD/mpirun_of_test:$PATH\" OMPI_MCA_orte_startup_timeout=1";
    skip_without_mpi();
    mkdir("mpirun_of_test", 0755);
    for (size_t i = 0; i < sizeof jobs / sizeof *jobs; ++i) {
        be_mpirun(jobs[i].says, jobs[i].then);
        program p = program_run_with(variables, "cluster %s still -n 3", jobs[i].arguments);
        program_assert_refused(p, 1, jobs[i].told);
    }
    be_mpirun(BEGUN STOPPED, "exit 0");
    program_assert_refused(program_run_with(variables, "cluster --ranks 2 still"), 130,
                           "duet: stopped");
    be_mpirun("ssh: no\n" BEGUN "driver: a warning\n\r\033[Kstep 3", "echo found");
    program p = program_done(program_run_with(variables, "cluster --ranks 2 still"));
    assert_string_equal(p.out, "found\n");
    assert_string_equal(p.err, "ssh: no\ndriver: a warning\n\r\033[Kstep 3");
}

TEST(a_job_that_fails_under_verify_is_one_line)
{
    static const char *const jobs[][2] = {
        {"exit 137", "a rank was ended by signal 9 (Killed), and with it the job"},
        {"exit 3", "mpirun ended with status 3; with --verbose it says"},
    };
    skip_without_mpi();
    mkdir("mpirun_of_test", 0755);
    for (size_t i = 0; i < sizeof jobs / sizeof *jobs; ++i) {
        be_mpirun(BEGUN, jobs[i][0]);
        program_assert_refused(program_run_with("PATH=\"$PWD/mpirun_of_test:$PATH\"",
                                                "verify falling -n 9 --steps 2 --ranks 2"),
                               1, jobs[i][1]);
    }
}

// It is killed before duet ends, and no rank is left.
TEST(mpirun_that_hears_no_signal_does_not_stay)
{
    skip_without_mpi();
    mkdir("mpirun_of_test", 0755);
    be_mpirun(BEGUN, "trap '' INT TERM USR1 USR2; echo $$ >mpirun_of_test/pid; "
                     "while :; do sleep 0.1; done");
    program p = program_run_with("timeout -s INT 1 env PATH=\"$PWD/mpirun_of_test:$PATH\"",
                                 "cluster --ranks 2 still");
    text pid = test_read_file("mpirun_of_test/pid");
    assert_string_equal(p.err, "duet: stopped\n");
    assert_true(atol(pid.chars) > 0);
    assert_int_equal(kill((pid_t)atol(pid.chars), 0), -1);
}

// mpirun says less unless a person asks for it.
TEST(mpirun_is_quiet_unless_verbose)
{
    skip_without_mpi();
    mkdir("mpirun_of_test", 0755);
    be_mpirun(BEGUN, "echo $OMPI_MCA_orte_execute_quiet $PRTE_MCA_prte_execute_quiet");
    for (int verbose = 0; verbose < 2; ++verbose) {
        program p = program_run_with("PATH=\"$PWD/mpirun_of_test:$PATH\"",
                                     "cluster --ranks 2 %s still", verbose ? "--verbose" : "");
        assert_string_equal(p.out, verbose ? "\n" : "1 1\n");
    }
}

// Input that a shell's loop reads stays there. A scene may come from there, by any of its names.
TEST(ranks_get_stdin_only_where_they_read_the_scene_from_it)
{
    skip_without_mpi();
    mkdir("mpirun_of_test", 0755);
    be_mpirun(BEGUN, "cat");
    static const char *const jobs[][2] = {{"still", ""}, {"-", "next\n"}, {"/dev/stdin", "next\n"}};
    for (size_t i = 0; i < sizeof jobs / sizeof *jobs; ++i) {
        program p = program_done(program_run_with("echo next | PATH=\"$PWD/mpirun_of_test:$PATH\"",
                                                  "cluster --ranks 2 %s", jobs[i][0]));
        assert_string_equal(p.out, jobs[i][1]);
    }
}

#define OLD_BINDING "OMPI_MCA_hwloc_base_binding_policy"
#define OLD_SHARING "OMPI_MCA_rmaps_base_oversubscribe"
#define NEW_BINDING "PRTE_MCA_hwloc_default_binding_policy"
#define NEW_SHARING "PRTE_MCA_rmaps_default_mapping_policy"

// Open MPI 4 and 5 have names of their own for it. The user's word goes first.
TEST(ranks_share_the_machine_with_any_open_mpi)
{
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
        program p = program_done(program_run_with(variables, "cluster --ranks 9 still -n 3"));
        assert_string_equal(p.out, given[i][1]);
    }
}
