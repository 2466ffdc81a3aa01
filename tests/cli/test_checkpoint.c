// SPDX-License-Identifier: MIT
// duet run --checkpoint and --resume: a run that is killed, at any moment, goes on bit for bit.
#define _POSIX_C_SOURCE 200809L
#include "support/json.h"
#include "support/test.h"

#include "base/clock.h"
#include "base/text_file.h"

#include <signal.h>
#include <sys/wait.h>
#include <time.h>

#define SCENE "falling -n 300"
#define RUN "run " SCENE " --steps 60 --json"
#define SAVED "run.motion"
#define KEPT " --every 2 --checkpoint " SAVED " --resume " SAVED

enum { KILLS = 8 };

// Starts the command and kills it after a while, unless it is done before. Returns whether it was
// killed.
static bool run_and_kill(const char *arguments, uint64_t ns)
{
    pid_t child = program_start("/dev/null", arguments);
    const struct timespec delay = {(time_t)(ns / 1000000000), (long)(ns % 1000000000)};
    nanosleep(&delay, NULL);
    kill(child, SIGKILL);
    int status = 0;
    assert_true(waitpid(child, &status, 0) == child);
    return WIFSIGNALED(status);
}

TEST(a_run_that_is_killed_at_any_moment_goes_on_bit_for_bit)
{
    char right[32], hash[32];
    double steps;
    rng r = rng_seed(test_seed());
    get_hash(RUN, right, &steps);
    uint64_t begun = clock_steady_ns();
    get_hash(RUN KEPT, hash, &steps);
    uint64_t took = clock_steady_ns() - begun;
    assert_string_equal(hash, right);
    assert_true(steps == 60);
    remove(SAVED);
    for (int i = 0; i < KILLS; ++i) {
        if (!run_and_kill(RUN KEPT, (uint64_t)((double)took * rng_unit(&r))))
            remove(SAVED); // it was done, and begins again
    }
    get_hash(RUN KEPT, hash, &steps);
    print_message("%.0f steps after the last kill\n", steps);
    assert_string_equal(hash, right);
}

TEST(a_checkpoint_goes_on_from_its_step_on_other_devices)
{
    char right[32], hash[32];
    double steps;
    get_hash(RUN, right, &steps);
    get_hash("run " SCENE " --steps 33 --json --every 10 --checkpoint " SAVED, hash, &steps);
    assert_true(steps == 33);
    get_hash(RUN " --pair halves --share 0.5 --mode slab --resume " SAVED, hash, &steps);
    assert_true(steps == 30);
    assert_string_equal(hash, right);
    get_hash("run " SCENE " --steps 30 --json --resume " SAVED, hash, &steps);
    assert_true(steps == 0);
}

TEST(checkpoints_that_cannot_be_used_are_refused)
{
    static const program_refusal lines[] = {
        {"run " SCENE " --steps 9 --every 2", 2, "--checkpoint"},
        {"run " SCENE " --steps 9 --checkpoint x", 2, "--every"},
        {"run " SCENE " --resume x", 2, "--steps"},
        {"run " SCENE " --steps 9 --resume no.motion", 1, "no.motion: No such file"},
        {"run " SCENE " --steps 9 --every 2 --checkpoint y --resume no.motion", 1, "no.motion"},
        {"run " SCENE " --steps 9 --resume " SAVED, 2, "was saved at step 10"},
        {"run marbles -n 20 --steps 30 --resume " SAVED, 1, SAVED},
    };
    char hash[32];
    double steps;
    get_hash("run " SCENE " --steps 10 --json --every 10 --checkpoint " SAVED, hash, &steps);
    program_assert_refusals("", " --json", lines);
}

TEST(a_checkpoint_that_is_cut_short_is_refused)
{
    char hash[32];
    double steps;
    rng r = rng_seed(test_seed());
    get_hash("run " SCENE " --steps 10 --json --every 10 --checkpoint " SAVED, hash, &steps);
    const text file = test_read_file(SAVED);
    for (int i = 0; i < 3; ++i) {
        size_t length = 16 + rng_below(&r, (uint32_t)file.length - 16);
        must(text_write_file("cut.motion", file.chars, length, ERR));
        program_assert_refused(program_run(RUN " --resume cut.motion"), 1, "cut short or damaged");
    }
}
