// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "thread_times.h"

#include <dirent.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

void thread_times_read(thread_times *t)
{
    DIR *tasks = opendir("/proc/self/task");
    t->n = 0;
    for (struct dirent *task; tasks && (task = readdir(tasks)) && t->n < THREAD_TIMES_ROOM;) {
        char path[300];
        snprintf(path, sizeof path, "/proc/self/task/%s/schedstat", task->d_name);
        FILE *file = fopen(path, "r");
        if (file && fscanf(file, "%" SCNu64, &t->threads[t->n].ns) == 1)
            t->threads[t->n++].id = atoi(task->d_name);
        if (file)
            fclose(file);
    }
    if (tasks)
        closedir(tasks);
}

static uint64_t time_of(const thread_times *t, int id)
{
    for (uint32_t i = 0; i < t->n; ++i)
        if (t->threads[i].id == id)
            return t->threads[i].ns;
    return 0;
}

double thread_times_since_ms(const thread_times *before, const thread_times *now)
{
    uint64_t host = 0, busiest = 0;
    for (uint32_t i = 0; i < now->n; ++i) {
        int id = now->threads[i].id;
        uint64_t ns = now->threads[i].ns - time_of(before, id);
        if (id == getpid())
            host = ns;
        else if (ns > busiest)
            busiest = ns;
    }
    return (double)(host + busiest) * 1e-6;
}
