// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L // pthread_condattr_setclock
#include "cluster/rank_watch.h"

#include <errno.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

enum { BEATS = 10 }; // beats of silence: each is a tenth of the seconds

struct rank_heartbeat {
    _Atomic uint64_t beats; // GONE: is not watched
    int rank;
    int pid;
};

#define GONE UINT64_MAX

typedef struct last_heard {
    uint64_t beats;
    uint32_t silent; // own beats since the rank's beats moved
    bool reported;
} last_heard;

// Own beats are counted and no time, so that ranks that were all stopped together, and go on, do
// not report each other.
static void note_beats(last_heard *s, uint64_t beats, bool counts)
{
    s->silent = beats == s->beats && counts ? s->silent + 1 : 0;
    s->beats = beats;
}

static bool is_silent(const last_heard *s)
{
    return s->silent >= BEATS;
}

static void report(const rank_watch *w, last_heard *s, int rank, const char *host_name, int pid)
{
    char line[512];
    int n = snprintf(line, sizeof line, "rank %d of %d (host %s, pid %d) ", rank, w->all.n,
                     host_name, pid);
    s->reported = is_silent(s);
    if (s->reported)
        snprintf(line + n, sizeof line - (size_t)n, "has not answered for %g s", w->seconds);
    else
        snprintf(line + n, sizeof line - (size_t)n, "answers again");
    w->say(line);
}

// The first rank of this host that is not silent reports the silent ones.
static void check_host(rank_watch *w)
{
    int first = -1;
    atomic_fetch_add(&w->heartbeats[w->all.self_on_host].beats, 1);
    for (int i = 0; i < w->all.n_on_host; ++i) {
        uint64_t beats = atomic_load(&w->heartbeats[i].beats);
        note_beats(&w->last[i], beats, beats != GONE && i != w->all.self_on_host);
        first = first < 0 && !is_silent(&w->last[i]) ? i : first;
    }
    for (int i = 0; i < w->all.n_on_host; ++i) {
        last_heard *s = &w->last[i];
        const rank_heartbeat *heartbeat = &w->heartbeats[i];
        if (is_silent(s) != s->reported && (!is_silent(s) || first == w->all.self_on_host))
            report(w, s, heartbeat->rank, w->all.host_name, heartbeat->pid);
    }
}

static void check_other_hosts(rank_watch *w)
{
    beacon_send(&w->beacon);
    beacon_hear(&w->beacon);
    for (int i = 0; i < w->beacon.n_heard; ++i) {
        last_heard *s = &w->last[w->all.n_on_host + i];
        const beacon_rank *far = &w->beacon.heard[i];
        note_beats(s, far->beats, far->beats > 0);
        if (is_silent(s) != s->reported)
            report(w, s, far->rank, far->host_name, far->pid);
    }
}

static struct timespec next_beat(const rank_watch *w)
{
    struct timespec at;
    double seconds = w->seconds / BEATS;
    clock_gettime(CLOCK_MONOTONIC, &at);
    at.tv_sec += (time_t)seconds;
    at.tv_nsec += (long)((seconds - (double)(time_t)seconds) * 1e9);
    at.tv_sec += at.tv_nsec / 1000000000;
    at.tv_nsec %= 1000000000;
    return at;
}

static void *watch(void *of)
{
    rank_watch *w = of;
    struct timespec at = next_beat(w);
    pthread_mutex_lock(&w->lock);
    while (!w->ends) {
        if (pthread_cond_timedwait(&w->ended, &w->lock, &at) != ETIMEDOUT)
            continue;
        check_host(w);
        check_other_hosts(w);
        at = next_beat(w);
    }
    pthread_mutex_unlock(&w->lock);
    return NULL;
}

static bool begin_thread(rank_watch *w)
{
    pthread_condattr_t steady;
    pthread_condattr_init(&steady);
    pthread_condattr_setclock(&steady, CLOCK_MONOTONIC);
    pthread_mutex_init(&w->lock, NULL);
    pthread_cond_init(&w->ended, &steady);
    pthread_condattr_destroy(&steady);
    return pthread_create(&w->thread, NULL, watch, w) == 0;
}

// Without memory, or a thread, a rank is neither watched nor does it watch.
bool rank_watch_begin(rank_watch *w, double seconds, void (*say)(const char *line), duet_error *err)
{
    *w = (rank_watch){.seconds = seconds, .say = say};
    if (!ranks_begin(&w->all, NULL, NULL, err))
        return false;
    w->heartbeats =
        ranks_share(&w->all, (size_t)w->all.n_on_host * sizeof *w->heartbeats, &w->window);
    if (!w->heartbeats)
        return true;
    rank_heartbeat *own = &w->heartbeats[w->all.self_on_host];
    own->rank = w->all.self;
    own->pid = (int)getpid();
    beacon_begin(&w->beacon, &w->all);
    w->last = calloc((size_t)w->all.n_on_host + (size_t)w->beacon.n_heard, sizeof *w->last);
    w->watches = seconds > 0 && w->all.n > 1 && w->last && begin_thread(w);
    if (!w->watches)
        atomic_store(&own->beats, GONE);
    ranks_wait(&w->all);
    return true;
}

void rank_watch_end(rank_watch *w)
{
    ranks_wait(&w->all); // a rank that is stopped on its way here is reported
    if (w->watches) {
        pthread_mutex_lock(&w->lock);
        w->ends = true;
        pthread_cond_signal(&w->ended);
        pthread_mutex_unlock(&w->lock);
        pthread_join(w->thread, NULL);
        pthread_cond_destroy(&w->ended);
        pthread_mutex_destroy(&w->lock);
    }
    free(w->last);
    if (w->heartbeats) {
        beacon_end(&w->beacon);
        ranks_unshare(&w->window);
    }
    ranks_end(&w->all);
}
