// SPDX-License-Identifier: MIT
#define _GNU_SOURCE
#include "base/core_watch.h"

#include "base/clock.h"
#include "base/list.h"

#include <dirent.h>
#include <fcntl.h>
#include <inttypes.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

// The system counts a core's time in hundredths of a second: a shorter window says too little.
#define WINDOW_NS UINT64_C(300000000)

static const double LOST = 0.05;      // part of a launch that may be lost
static const double WANTS = 0.2;      // part for which a thread that matters wants a core
static const double FEW_CORES = 0.15; // share that a system's own programs take at rest
static const double ALL_CORES = 0.9;  // part of the cores that is as good as all

typedef struct thread_row {
    int id;
    uint64_t ran_ns;
    uint64_t waited_ns;
} thread_row;

typedef struct thread_table {
    thread_row *rows; // by id
    uint32_t n;
} thread_table;

// Readings of the clocks at a moment.
typedef struct look {
    uint64_t at_ns;
    double busy_s; // time of the cores of this process, by all programs
    double own_s;  // processor time of this process
} look;

struct core_watch {
    thread_table before;
    thread_table after;
    uint32_t spread;
    uint64_t begun_ns;
    uint64_t caller_ns; // processor time of the calling thread when the launch began
    cpu_set_t cores;    // that this process may use
    core_others others;
    look first; // when the watch was opened
    look last;
    core_tally tally;
};

// ---------------------------------------------------------------- threads

static bool read_row(int folder, const char *id, thread_row *row)
{
    char path[300], line[64] = {0};
    snprintf(path, sizeof path, "%s/schedstat", id);
    int file = openat(folder, path, O_RDONLY | O_CLOEXEC);
    if (file < 0)
        return false;
    ssize_t n = read(file, line, sizeof line - 1);
    close(file);
    row->id = atoi(id);
    return n > 0 && sscanf(line, "%" SCNu64 " %" SCNu64, &row->ran_ns, &row->waited_ns) == 2;
}

static bool add_row(thread_table *t, const thread_row *row)
{
    thread_row *rows = list_room(t->rows, t->n, sizeof *rows, NULL);
    if (!rows)
        return false;
    t->rows = rows;
    t->rows[t->n++] = *row;
    return true;
}

static int by_id(const void *a, const void *b)
{
    return ((const thread_row *)a)->id - ((const thread_row *)b)->id;
}

// A thread that ends meanwhile is left out.
static bool read_threads(thread_table *t)
{
    t->n = 0;
    DIR *folder = opendir("/proc/self/task");
    struct dirent *entry;
    bool ok = folder;
    while (ok && (entry = readdir(folder))) {
        thread_row row;
        if (*entry->d_name != '.' && read_row(dirfd(folder), entry->d_name, &row))
            ok = add_row(t, &row);
    }
    if (folder)
        closedir(folder);
    if (ok && t->n > 1)
        qsort(t->rows, t->n, sizeof *t->rows, by_id);
    return ok && t->n > 0;
}

// The time of a thread since the launch began; a thread that is new did all of it.
static thread_row difference(const thread_table *before, const thread_row *after)
{
    thread_row row = *after;
    const thread_row *old =
        before->n ? bsearch(after, before->rows, before->n, sizeof *before->rows, by_id) : NULL;
    if (old) {
        row.ran_ns -= old->ran_ns;
        row.waited_ns -= old->waited_ns;
    }
    return row;
}

// ---------------------------------------------------------------- other programs

// Seconds that the cores of this process were busy, since the system began.
static double read_busy_s(const cpu_set_t *cores)
{
    FILE *file = fopen("/proc/stat", "re");
    char line[512];
    double ticks = 0;
    while (file && fgets(line, sizeof line, file)) {
        int core;
        uint64_t user, nice, kernel, irq, softirq, steal;
        if (sscanf(line,
                   "cpu%d %" SCNu64 " %" SCNu64 " %" SCNu64 " %*u %*u %" SCNu64 " %" SCNu64
                   " %" SCNu64,
                   &core, &user, &nice, &kernel, &irq, &softirq, &steal) == 7 &&
            core >= 0 && core < CPU_SETSIZE && CPU_ISSET(core, cores))
            ticks += (double)(user + nice + kernel + irq + softirq + steal);
    }
    if (file)
        fclose(file);
    return ticks / (double)sysconf(_SC_CLK_TCK);
}

static look look_now(const core_watch *w)
{
    return (look){.at_ns = clock_steady_ns(),
                  .busy_s = read_busy_s(&w->cores),
                  .own_s = (double)clock_process_ns() * 1e-9};
}

static double cores_between(const look *from, const look *to)
{
    double seconds = (double)(to->at_ns - from->at_ns) * 1e-9;
    double others_s = to->busy_s - from->busy_s - (to->own_s - from->own_s);
    return others_s > 0 && seconds > 0 ? others_s / seconds : 0;
}

static void look_at_others(core_watch *w)
{
    if (clock_steady_ns() - w->last.at_ns < WINDOW_NS)
        return;
    look now = look_now(w);
    w->others.cores = cores_between(&w->last, &now);
    w->others.is_crowded = w->others.cores > FEW_CORES;
    w->last = now;
}

// ---------------------------------------------------------------- watching

core_watch *core_watch_open(void)
{
    core_watch *w = calloc(1, sizeof *w);
    if (!w || !read_threads(&w->before) || sched_getaffinity(0, sizeof w->cores, &w->cores) != 0) {
        core_watch_close(w);
        return NULL;
    }
    w->others.of = w->tally.of = (uint32_t)CPU_COUNT(&w->cores);
    w->first = w->last = look_now(w);
    return w;
}

void core_watch_close(core_watch *w)
{
    if (!w)
        return;
    free(w->before.rows);
    free(w->after.rows);
    free(w);
}

void core_watch_start(core_watch *w, uint32_t spread)
{
    if (!w)
        return;
    w->spread = spread < w->others.of ? spread : w->others.of;
    look_at_others(w);
    if (!read_threads(&w->before))
        w->before.n = 0;
    w->caller_ns = clock_thread_ns();
    w->begun_ns = clock_steady_ns();
}

static uint64_t least(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

static uint64_t most(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

// The threads' work and waits during a launch.
typedef struct thread_sums {
    uint64_t longest_wait_ns;
    uint64_t ran_ns;     // all threads'
    uint64_t busiest_ns; // other threads than the caller
    uint64_t others_ns;
    uint32_t wanting; // threads that wanted a core for long
} thread_sums;

static thread_sums sum_threads(const core_watch *w, uint64_t ns)
{
    thread_sums s = {0};
    int caller = gettid();
    for (uint32_t i = 0; i < w->after.n; ++i) {
        thread_row row = difference(&w->before, &w->after.rows[i]);
        s.longest_wait_ns = most(s.longest_wait_ns, row.waited_ns);
        s.ran_ns += row.ran_ns;
        s.wanting += (double)(row.ran_ns + row.waited_ns) > WANTS * (double)ns;
        s.busiest_ns = row.id != caller ? most(s.busiest_ns, row.ran_ns) : s.busiest_ns;
        s.others_ns += row.id != caller ? row.ran_ns : 0;
    }
    return s;
}

// Whether more threads of this process wanted a core than there are, so that they waited for each
// other. Until other programs were looked at, that is believed of a launch that had the cores.
static bool waits_for_itself(const core_watch *w, const thread_sums *s, uint64_t ns)
{
    bool looked = w->last.at_ns > w->first.at_ns;
    bool crowded =
        looked ? w->others.is_crowded : (double)s->ran_ns < ALL_CORES * w->others.of * (double)ns;
    return !crowded && s->wanting > w->others.of;
}

core_use core_watch_stop(core_watch *w)
{
    core_use use = {0};
    if (!w)
        return use;
    uint64_t ns = clock_steady_ns() - w->begun_ns;
    // The system's table is behind for a thread that runs, as this one does.
    uint64_t caller_ns = clock_thread_ns() - w->caller_ns;
    if (w->before.n == 0 || !read_threads(&w->after))
        return use;
    thread_sums s = sum_threads(w, ns);
    uint64_t slowest_ns = w->spread > 1 ? s.others_ns / w->spread : s.busiest_ns;
    use.cpu_ns = caller_ns + s.busiest_ns;
    use.wait_ns = s.longest_wait_ns;
    use.lost_ns = least(use.wait_ns, ns - least(caller_ns + slowest_ns, ns));
    look_at_others(w);
    use.disturbed = (double)use.lost_ns > LOST * (double)ns && !waits_for_itself(w, &s, ns);
    ++w->tally.launches;
    w->tally.disturbed += use.disturbed;
    return use;
}

core_others core_watch_others(core_watch *w)
{
    if (!w)
        return (core_others){0};
    look_at_others(w);
    return w->others;
}

core_tally core_watch_tally(core_watch *w)
{
    if (!w)
        return (core_tally){0};
    look now = look_now(w);
    w->tally.others = cores_between(&w->first, &now);
    return w->tally;
}
