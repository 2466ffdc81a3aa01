// SPDX-License-Identifier: MIT
#define _GNU_SOURCE
#include "tuner/device_lock.h"

#include "base/budget.h"
#include "base/clock.h"
#include "base/error.h"

#include <errno.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#define LOOK_NS UINT64_C(100000000)

typedef struct lock_name {
    struct sockaddr_un address;
    socklen_t length;
} lock_name;

// Parts of a CPU share its lock: they share its memory and caches.
static lock_name name_of(const char *selector)
{
    lock_name name = {.address.sun_family = AF_UNIX};
    int n = snprintf(name.address.sun_path + 1, sizeof name.address.sun_path - 1, "duet/tune/%.*s",
                     (int)strcspn(selector, "["), selector);
    name.length = (socklen_t)(offsetof(struct sockaddr_un, sun_path) + 1 + (size_t)n);
    return name;
}

// The socket, or -1 while another process has the name. 0: the system has no such sockets, and
// nothing is locked.
static int try_name(const lock_name *name)
{
    int holder = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (holder < 0)
        return 0;
    if (bind(holder, (const struct sockaddr *)&name->address, name->length) == 0 &&
        listen(holder, 1) == 0)
        return holder;
    bool held = errno == EADDRINUSE;
    close(holder);
    return held ? -1 : 0;
}

// 0: nobody answers.
static long owner_of(const lock_name *name)
{
    struct ucred owner = {0};
    socklen_t length = sizeof owner;
    int caller = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    bool known = caller >= 0 &&
                 connect(caller, (const struct sockaddr *)&name->address, name->length) == 0 &&
                 getsockopt(caller, SOL_SOCKET, SO_PEERCRED, &owner, &length) == 0;
    if (caller >= 0)
        close(caller);
    return known ? owner.pid : 0;
}

static bool tell_waiting(const duet_tune_def *def, const lock_name *name, double seconds)
{
    static const duet_plan none = {.mode = DUET_MODE_OWN};
    char waiting[160], owner[32] = "another process";
    long pid = owner_of(name);
    if (pid > 0)
        snprintf(owner, sizeof owner, "process %ld", pid);
    snprintf(waiting, sizeof waiting, "%s is tuning on %.80s", owner,
             name->address.sun_path + 1 + strlen("duet/tune/"));
    duet_tune_progress progress = {
        .stage = "wait", .plan = &none, .seconds = seconds, .waiting = waiting};
    return budget_check_stop(NULL) && (!def->watch || def->watch(def->watch_context, &progress));
}

static bool wait_for(int *holder, const lock_name *name, const duet_tune_def *def, duet_error *err)
{
    uint64_t begun = clock_steady_ns();
    while ((*holder = try_name(name)) < 0) {
        *holder = 0;
        if (def->wait_seconds == 0)
            return true;
        if (!tell_waiting(def, name, clock_ms_since(begun) * 1e-3))
            return error_set(err, DUET_STATUS_INTERRUPTED,
                             "stopped while another process was tuning");
        clock_sleep_ns(LOOK_NS);
    }
    return true;
}

bool device_lock_take(device_lock *lock, const duet_tune_def *def, duet_error *err)
{
    lock_name a = name_of(duet_device_pair_get_info(def->pair, 0)->selector);
    lock_name b = name_of(duet_device_pair_get_info(def->pair, 1)->selector);
    int order = memcmp(&a.address, &b.address, sizeof a.address);
    *lock = (device_lock){0};
    // All processes take them in this order, so that no two wait for each other.
    return wait_for(&lock->sockets[0], order <= 0 ? &a : &b, def, err) &&
           (order == 0 || wait_for(&lock->sockets[1], order <= 0 ? &b : &a, def, err));
}

void device_lock_release(device_lock *lock)
{
    for (int i = 0; i < 2; ++i)
        if (lock->sockets[i] > 0)
            close(lock->sockets[i]);
    *lock = (device_lock){0};
}
