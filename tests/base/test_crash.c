// SPDX-License-Identifier: MIT
// A test program that crashes says where, in whichever thread.
#define _GNU_SOURCE
#include "support/test.h"

#include "base/text.h"

#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

// ---------------------------------------------------------------- crashes

static volatile uintptr_t nowhere = 64;

static void *write_nowhere(void *nothing)
{
    *(volatile int *)nowhere = 1;
    return nothing;
}

static void *fail_to_compute(void *nothing)
{
    raise(SIGFPE); // a processor may divide by zero
    return nothing;
}

static void *give_up(void *nothing)
{
    (void)nothing;
    abort();
}

static void *overflow(void *depth)
{
    volatile char much[4096];
    much[0] = (char)(uintptr_t)depth;
    if (nowhere > 0)
        overflow((void *)&much);
    return (void *)(uintptr_t)much[0];
}

// ---------------------------------------------------------------- what a child says

typedef struct ending {
    text said;
    int status;
} ending;

static void crash(void *(*how)(void *), bool in_thread)
{
    pthread_t thread;
    int file = open("said", O_WRONLY | O_CREAT | O_TRUNC, 0600);
    setrlimit(RLIMIT_CORE, &(struct rlimit){0, 0});
    dup2(file, STDERR_FILENO);
    if (!in_thread)
        how(NULL);
    else if (pthread_create(&thread, NULL, how, NULL) == 0)
        pthread_join(thread, NULL);
    _exit(0);
}

// Ends a child by a crash within a test, as CMocka runs one.
static ending end_by(void *(*how)(void *), bool in_thread)
{
    ending e = {.status = 0};
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0)
        crash(how, in_thread);
    assert_int_equal(waitpid(child, &e.status, 0), child);
    e.said = test_read_file("said");
    return e;
}

// A sanitizer may end it another way.
static bool ended_by(int status, int number)
{
    return WIFSIGNALED(status) ? WTERMSIG(status) == number : WEXITSTATUS(status) != 0;
}

static void expect_said(void *(*how)(void *), bool in_thread, int number, const char *const says[])
{
    ending e = end_by(how, in_thread);
    if (!ended_by(e.status, number))
        fail_msg("status %#x: %s", e.status, e.said.chars);
    assert_says_all(e.said.chars, says);
}

#define EXPECT_SAID(how, in_thread, number, ...) \
    expect_said(how, in_thread, number, (const char *const[]){__VA_ARGS__, NULL})

TEST(a_crash_in_a_tests_own_thread_is_told)
{
    EXPECT_SAID(write_nowhere, false, SIGSEGV, "test_crash: SIGSEGV at 0x40 in thread",
                "test a_crash_in_a_tests_own_thread_is_told", "write_nowhere at ", "test_crash.c:");
}

TEST(a_crash_in_another_thread_is_told)
{
    EXPECT_SAID(write_nowhere, true, SIGSEGV, "test_crash: SIGSEGV at 0x40 in thread",
                "test a_crash_in_another_thread_is_told", "write_nowhere at ", "test_crash.c:");
    EXPECT_SAID(fail_to_compute, true, SIGFPE, "SIGFPE", "fail_to_compute");
    EXPECT_SAID(give_up, true, SIGABRT, "SIGABRT", "give_up");
}

TEST(a_full_stack_is_told)
{
    EXPECT_SAID(overflow, false, SIGSEGV, "SIGSEGV", "test a_full_stack_is_told");
}

// CMocka's handlers are gone, those of tests are not.
TEST(a_test_may_ignore_signals)
{
    assert_true(signal(SIGABRT, SIG_IGN) != SIG_ERR);
    assert_true(signal(SIGABRT, SIG_DFL) == SIG_IGN);
    assert_true(signal(SIGUSR1, SIG_IGN) == SIG_DFL);
    assert_true(signal(SIGUSR1, SIG_DFL) == SIG_IGN);
}

TEST_EACH(test_enter_folder, NULL)
