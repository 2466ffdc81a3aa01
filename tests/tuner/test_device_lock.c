// SPDX-License-Identifier: MIT
// One tuning at a time on a device.
#define _GNU_SOURCE
#include "support/test.h"

#include "tuner/device_lock.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

// A process that holds the pair's devices until it is killed, and has them when this returns.
static pid_t hold(const duet_tune_def *def)
{
    int ready[2];
    char byte;
    assert_int_equal(pipe(ready), 0);
    pid_t holder = fork();
    if (holder == 0) {
        device_lock lock;
        duet_tune_def own = *def;
        own.watch = NULL; // it knows no holder to end
        bool ok = device_lock_take(&lock, &own, NULL) && write(ready[1], "x", 1) == 1;
        while (ok)
            pause();
        _exit(1);
    }
    assert_int_equal(read(ready[0], &byte, 1), 1);
    close(ready[0]);
    close(ready[1]);
    return holder;
}

typedef struct waiting {
    pid_t holder;
    uint32_t told;
    bool names_holder;
    bool stops;
} waiting;

// Ends the holder, or stops the wait, once it was told of.
static bool watch(void *context, const duet_tune_progress *progress)
{
    waiting *w = context;
    char process[64];
    snprintf(process, sizeof process, "process %d is tuning on ", (int)w->holder);
    w->names_holder = strncmp(progress->waiting, process, strlen(process)) == 0;
    if (w->told++ == 0 && !w->stops) {
        kill(w->holder, SIGKILL);
        waitpid(w->holder, NULL, 0);
    }
    return !w->stops;
}

static duet_tune_def def_of(waiting *w)
{
    duet_tune_def def = duet_default_tune_def();
    def.pair = kept(duet_device_pair_open(NULL, ERR));
    def.wait_seconds = 60;
    def.watch = watch;
    def.watch_context = w;
    w->holder = hold(&def);
    return def;
}

static void end_holder(const waiting *w)
{
    kill(w->holder, SIGKILL);
    waitpid(w->holder, NULL, 0);
}

TEST(a_second_tuning_waits_for_the_end_of_the_first)
{
    waiting w = {0};
    duet_tune_def def = def_of(&w);
    device_lock lock;
    must(device_lock_take(&lock, &def, ERR));
    assert_int_equal(w.told, 1);
    assert_true(w.names_holder);
    device_lock_release(&lock);
    w.told = 0;
    must(device_lock_take(&lock, &def, ERR)); // it was given back
    assert_int_equal(w.told, 0);
    device_lock_release(&lock);
}

TEST(a_wait_is_stopped_by_the_watch)
{
    waiting w = {.stops = true};
    duet_tune_def def = def_of(&w);
    device_lock lock;
    must_fail(device_lock_take(&lock, &def, ERR), DUET_STATUS_INTERRUPTED, "");
    device_lock_release(&lock);
    end_holder(&w);
}

TEST(a_tuning_that_does_not_wait_runs_beside_others)
{
    waiting w = {0};
    duet_tune_def def = def_of(&w);
    def.wait_seconds = 0;
    device_lock lock;
    must(device_lock_take(&lock, &def, ERR));
    device_lock_release(&lock);
    end_holder(&w);
}
