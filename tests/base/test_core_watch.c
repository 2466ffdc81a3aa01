// SPDX-License-Identifier: MIT
// What a launch loses to another program, told from what its own threads do.
#define _GNU_SOURCE
#include "support/test.h"

#include "base/clock.h"
#include "base/core_watch.h"

#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdatomic.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static uint64_t own_cpu_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (uint64_t)t.tv_sec * 1000000000 + (uint64_t)t.tv_nsec;
}

// Works until the thread has had so much processor time.
static void *work(void *ns)
{
    uint64_t end = own_cpu_ns() + *(const uint64_t *)ns;
    while (own_cpu_ns() < end) {
    }
    return NULL;
}

// This process and what it starts from here on share one core.
static cpu_set_t keep_one_core(void)
{
    cpu_set_t all, one;
    assert_int_equal(sched_getaffinity(0, sizeof all, &all), 0);
    CPU_ZERO(&one);
    CPU_SET((unsigned)sched_getcpu(), &one);
    assert_int_equal(sched_setaffinity(0, sizeof one, &one), 0);
    return all;
}

static pid_t burn(void)
{
    pid_t burner = fork();
    if (burner == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        for (;;) {
        }
    }
    assert_true(burner > 0);
    return burner;
}

TEST(a_program_on_the_same_core_disturbs_a_launch)
{
    cpu_set_t all = keep_one_core();
    core_watch *w = core_watch_open();
    if (!w)
        skip();
    pid_t burner = burn();
    uint64_t ns = 400000000;
    work(&ns); // others are looked at over a while
    core_watch_start(w, 1);
    uint64_t begun = clock_steady_ns(), worked = 200000000;
    work(&worked);
    uint64_t took = clock_steady_ns() - begun;
    core_use use = core_watch_stop(w);
    kill(burner, SIGKILL);
    waitpid(burner, NULL, 0);
    core_others others = core_watch_others(w);
    assert_true(use.disturbed);
    assert_int_equal(others.of, 1);
    assert_true(others.is_crowded && others.cores > 0.15 && others.cores < 1.1);
    // The rest is the thread's own work, whatever else the core did.
    assert_true(use.cpu_ns >= worked && use.cpu_ns < worked + worked / 10);
    assert_true(use.lost_ns <= took - worked && use.lost_ns >= (took - worked) / 2);
    core_watch_close(w);
    sched_setaffinity(0, sizeof all, &all);
}

// Pieces of work that threads take as they come.
typedef struct pieces {
    atomic_int left;
    unsigned core[2]; // of each thread
    atomic_int begun;
    atomic_bool seen; // a thread that ended is in no table
} pieces;

static void *take_pieces(void *of)
{
    static const uint64_t piece = 100000;
    pieces *p = of;
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(p->core[atomic_fetch_add(&p->begun, 1)], &one);
    sched_setaffinity(0, sizeof one, &one);
    while (atomic_fetch_sub(&p->left, 1) > 0)
        work(&(uint64_t){piece});
    while (!atomic_load(&p->seen))
        clock_sleep_ns(1000000);
    return NULL;
}

// The other one does its work, and runs all the time.
TEST(a_thread_that_waits_for_work_that_comes_loses_it)
{
    cpu_set_t all;
    unsigned n = 0;
    pieces p = {.left = 3000};
    assert_int_equal(sched_getaffinity(0, sizeof all, &all), 0);
    for (unsigned core = 0; core < CPU_SETSIZE && n < 2; ++core)
        if (CPU_ISSET(core, &all))
            p.core[n++] = core;
    core_watch *w = core_watch_open();
    if (!w || n < 2)
        skip();
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(p.core[0], &one);
    pid_t burner = burn();
    must(sched_setaffinity(burner, sizeof one, &one) == 0);
    pthread_t threads[2];
    core_watch_start(w, 2);
    for (int i = 0; i < 2; ++i)
        assert_int_equal(pthread_create(&threads[i], NULL, take_pieces, &p), 0);
    while (atomic_load(&p.left) > 0)
        clock_sleep_ns(1000000);
    core_use use = core_watch_stop(w);
    atomic_store(&p.seen, true);
    for (int i = 0; i < 2; ++i)
        pthread_join(threads[i], NULL);
    kill(burner, SIGKILL);
    waitpid(burner, NULL, 0);
    core_watch_close(w);
    assert_true(use.disturbed);
}

// The share of other programs is known only after a while, and the launch has more threads than
// cores.
TEST(a_program_disturbs_the_first_launch_too)
{
    cpu_set_t all = keep_one_core();
    pid_t burner = burn();
    core_watch *w = core_watch_open();
    pthread_t other;
    uint64_t ns = 10000000, longer = 100000000;
    core_watch_start(w, 1);
    assert_int_equal(pthread_create(&other, NULL, work, &longer), 0);
    work(&ns);
    core_use use = core_watch_stop(w);
    pthread_join(other, NULL);
    kill(burner, SIGKILL);
    waitpid(burner, NULL, 0);
    sched_setaffinity(0, sizeof all, &all);
    core_watch_close(w);
    if (!w)
        skip();
    assert_true(use.disturbed);
}

// It is not on the way of the launch.
TEST(a_thread_that_waits_while_another_works_loses_nothing)
{
    core_watch *w = core_watch_open();
    if (!w)
        skip();
    cpu_set_t all = keep_one_core();
    pthread_t other;
    uint64_t little = 1000, much = 100000000;
    core_watch_start(w, 1);
    assert_int_equal(pthread_create(&other, NULL, work, &little), 0);
    uint64_t begun = clock_steady_ns();
    work(&much);
    uint64_t took = clock_steady_ns() - begun;
    core_use use = core_watch_stop(w);
    pthread_join(other, NULL);
    assert_true(use.lost_ns <= took - much + 1000000);
    core_watch_close(w);
    sched_setaffinity(0, sizeof all, &all);
}

TEST(nobody_watching_sees_nothing)
{
    core_watch_start(NULL, 1);
    core_use use = core_watch_stop(NULL);
    assert_false(use.disturbed);
    assert_int_equal(use.cpu_ns, 0);
    assert_int_equal(core_watch_others(NULL).of, 0);
    core_watch_close(NULL);
}
