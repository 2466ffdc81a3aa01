// SPDX-License-Identifier: MIT
// Says why a test program crashes, in any of its threads: the signal, the address, the thread, the
// test and the calls that led there. Every test program has it.
#define _GNU_SOURCE
#include "support/test.h"

#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <signal.h>
#include <stdatomic.h>
#include <sys/wait.h>
#include <unistd.h>

enum { MOST_CALLS = 64, PATIENCE_S = 60 };

static const int signals[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};

enum { SIGNALS = sizeof signals / sizeof *signals };

static struct sigaction before[SIGNALS]; // a sanitizer's, or the default

static int find_signal(int number)
{
    int i = 0;
    while (i < SIGNALS && signals[i] != number)
        ++i;
    return i;
}

// ---------------------------------------------------------------- what is said

// Runs addr2line on the calls that are the program's own: its functions are static or hidden, so
// that only it knows them by name. Says nothing if there is none.
static void name_calls(char addresses[][20], int n)
{
    static const char program[] = "/proc/self/exe";
    char path[512] = "", *words[MOST_CALLS + 4] = {"addr2line", "-Cfipe", path};
    if (n == 0 || readlink(program, path, sizeof path - 1) < 0)
        return;
    for (int i = 0; i < n; ++i)
        words[3 + i] = addresses[i];
    pid_t child = vfork();
    if (child == 0) {
        dup2(STDERR_FILENO, STDOUT_FILENO);
        execvp(*words, words);
        _exit(127);
    }
    waitpid(child, NULL, 0);
}

// The calls as addresses in the program's file, each within the instruction that calls. The first
// call that is not the program's hands the signal to it, and behind that stands what crashed.
static void tell_own_calls(void *const calls[], int n)
{
    char addresses[MOST_CALLS][20];
    Dl_info own, of;
    int n_own = 0, handed = n;
    if (!dladdr(signals, &own))
        return;
    for (int i = 0; i < n; ++i)
        if (!dladdr(calls[i], &of) || of.dli_fbase != own.dli_fbase)
            handed = handed < n ? handed : i;
        else
            snprintf(addresses[n_own++], sizeof *addresses, "%#tx",
                     (char *)calls[i] - (i != handed + 1) - (char *)own.dli_fbase);
    name_calls(addresses, n_own);
}

static void tell(int number, const siginfo_t *info)
{
    char line[256];
    void *calls[MOST_CALLS];
    int n = snprintf(line, sizeof line, "\n%s: SIG%s at %p in thread %d of process %d, test %s\n",
                     program_invocation_short_name, sigabbrev_np(number), info->si_addr, gettid(),
                     getpid(), test_running ? test_running : "not known");
    if (write(STDERR_FILENO, line, (size_t)n) != n)
        return;
    n = backtrace(calls, MOST_CALLS);
    backtrace_symbols_fd(calls, n, STDERR_FILENO);
    tell_own_calls(calls, n);
}

// Hands on to what was there before; what an instruction did, it then does again.
static void hear(int number, siginfo_t *info, void *context)
{
    static atomic_flag is_told = ATOMIC_FLAG_INIT;
    (void)context;
    alarm(PATIENCE_S);
    while (atomic_flag_test_and_set(&is_told))
        pause();
    tell(number, info);
    sigaction(number, &before[find_signal(number)], NULL);
    if (info->si_code <= 0)
        raise(number);
}

// ---------------------------------------------------------------- who hears

typedef int set_action(int, const struct sigaction *, struct sigaction *);

static set_action *real_sigaction(void)
{
    set_action *real;
    *(void **)&real = dlsym(RTLD_NEXT, "sigaction");
    return real;
}

#define FOR_ALL __attribute__((visibility("default")))

// CMocka puts its own handlers around each test, and LLVM when it compiles. CMocka's end the
// program without a word in a thread that is not the test's, and lose the place in the test's;
// LLVM's take no notice of where it was. Handlers that do not ask for it are passed over.
FOR_ALL int sigaction(int number, const struct sigaction *action, struct sigaction *was)
{
    bool is_handler = action && action->sa_handler != SIG_DFL && action->sa_handler != SIG_IGN;
    bool is_deaf = find_signal(number) < SIGNALS && is_handler && !(action->sa_flags & SA_SIGINFO);
    return real_sigaction()(number, is_deaf ? NULL : action, was);
}

FOR_ALL sighandler_t signal(int number, sighandler_t handler)
{
    struct sigaction action = {.sa_handler = handler, .sa_flags = SA_RESTART}, was;
    return sigaction(number, &action, &was) == 0 ? was.sa_handler : SIG_ERR;
}

__attribute__((constructor)) static void begin_to_hear(void)
{
    static char stack[1 << 16]; // for the first thread; a full stack has no space to tell it on
    const stack_t other = {.ss_sp = stack, .ss_size = sizeof stack};
    const struct sigaction action = {.sa_sigaction = hear, .sa_flags = SA_SIGINFO | SA_ONSTACK};
    void *call;
    backtrace(&call, 1); // loads what it needs
    sigaltstack(&other, NULL);
    for (int i = 0; i < SIGNALS; ++i)
        sigaction(signals[i], &action, &before[i]);
}
