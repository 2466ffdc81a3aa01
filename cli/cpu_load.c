// SPDX-License-Identifier: MIT
#define _GNU_SOURCE // sched_getaffinity
#include "cli/cpu_load.h"

#include <inttypes.h>
#include <sched.h>
#include <stdbool.h>
#include <stdio.h>
#include <sys/resource.h>
#include <unistd.h>

// A line of /proc/stat: "cpu0 user nice system idle iowait irq softirq steal ...";
// what a hypervisor steals is other programs' too.
static bool read_processor(const char *line, unsigned *processor, uint64_t ticks[8])
{
    return sscanf(line,
                  "cpu%u %" SCNu64 " %" SCNu64 " %" SCNu64 " %" SCNu64 " %" SCNu64 " %" SCNu64
                  " %" SCNu64 " %" SCNu64,
                  processor, &ticks[0], &ticks[1], &ticks[2], &ticks[3], &ticks[4], &ticks[5],
                  &ticks[6], &ticks[7]) == 9;
}

static void add_processors(cpu_load *o, FILE *stat, const cpu_set_t *ours)
{
    enum { IDLE = 3, IOWAIT = 4 };
    char line[512];
    unsigned processor;
    uint64_t ticks[8];
    while (fgets(line, sizeof line, stat)) {
        if (!read_processor(line, &processor, ticks) || processor >= CPU_SETSIZE ||
            !CPU_ISSET(processor, ours))
            continue;
        for (int i = 0; i < 8; ++i) {
            o->all_ticks += ticks[i];
            o->busy_ticks += i == IDLE || i == IOWAIT ? 0 : ticks[i];
        }
    }
}

static double seconds(struct timeval t)
{
    return (double)t.tv_sec + (double)t.tv_usec * 1e-6;
}

cpu_load cpu_load_look(void)
{
    cpu_load o = {0};
    cpu_set_t ours;
    struct rusage usage;
    FILE *stat = fopen("/proc/stat", "r");
    if (stat && sched_getaffinity(0, sizeof ours, &ours) == 0)
        add_processors(&o, stat, &ours);
    if (stat)
        fclose(stat);
    if (getrusage(RUSAGE_SELF, &usage) == 0)
        o.own_s = seconds(usage.ru_utime) + seconds(usage.ru_stime);
    return o;
}

double cpu_load_part(const cpu_load *since)
{
    cpu_load now = cpu_load_look();
    double all = (double)(now.all_ticks - since->all_ticks);
    double own = (now.own_s - since->own_s) * (double)sysconf(_SC_CLK_TCK);
    double theirs = (double)(now.busy_ticks - since->busy_ticks) - own;
    return all > 0 && theirs > 0 ? (theirs < all ? theirs / all : 1) : 0;
}
