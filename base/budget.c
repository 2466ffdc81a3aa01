// SPDX-License-Identifier: MIT
#include "base/budget.h"

#include "base/clock.h"

#include <stdio.h>

static _Atomic size_t held_bytes;
static _Thread_local budget *current;
static _Thread_local budget_watch *watcher;

budget_watch *budget_set_watch(budget_watch *watch)
{
    budget_watch *before = watcher;
    watcher = watch;
    return before;
}

static void tell(uint64_t deadline_ns)
{
    if (watcher)
        atomic_store(&watcher->deadline_ns, deadline_ns);
}

void budget_enter(budget *b)
{
    b->outer = current;
    if (current && current->deadline_ns < b->deadline_ns) {
        b->deadline_ns = current->deadline_ns;
        b->seconds = current->seconds;
    }
    current = b;
    tell(b->deadline_ns);
}

void budget_leave(budget *b)
{
    current = (budget *)b->outer;
    tell(current ? current->deadline_ns : 0);
}

bool budget_check_stop(duet_error *err)
{
    return !(watcher && watcher->stopped && watcher->stopped()) ||
           error_set(err, DUET_STATUS_INTERRUPTED, "stopped");
}

void budget_listen(void (*told)(void *listener, uint64_t done, uint64_t total), void *listener)
{
    if (!watcher)
        return;
    watcher->told = told;
    watcher->listener = listener;
}

void budget_tell(uint64_t done, uint64_t total)
{
    if (watcher && watcher->told)
        watcher->told(watcher->listener, done, total);
}

bool budget_check(duet_error *err)
{
    bool listens = watcher && watcher->told;
    if (!current && !listens)
        return true;
    if (!budget_check_stop(err))
        return false;
    if (!current || current->deadline_ns == UINT64_MAX || clock_steady_ns() <= current->deadline_ns)
        return true;
    return bad_input(err, "runs for more than the %g s it may take", current->seconds);
}

static bool has_space(const budget *b, size_t bytes)
{
    size_t held = atomic_load(&held_bytes);
    return held <= b->host_bytes && bytes <= b->host_bytes - held;
}

bool budget_space(size_t bytes, duet_error *err)
{
    for (const budget *b = current; b; b = b->outer) {
        if (!has_space(b, bytes) && b->reclaim)
            b->reclaim(b->owner);
        if (!has_space(b, bytes))
            return error_set(err, DUET_STATUS_NO_MEMORY,
                             "needs more than the %s of the host's memory it may take",
                             budget_memory(b->host_bytes).chars);
    }
    return true;
}

budget_words budget_memory(size_t bytes)
{
    budget_words words;
    bool whole = bytes % ((size_t)1 << 20) == 0;
    snprintf(words.chars, sizeof words.chars, "%zu %s", bytes >> (whole ? 20 : 10),
             whole ? "MiB" : "KiB");
    return words;
}

void budget_hold(size_t bytes)
{
    atomic_fetch_add(&held_bytes, bytes);
}

void budget_release(size_t bytes)
{
    atomic_fetch_sub(&held_bytes, bytes);
}
