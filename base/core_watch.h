// SPDX-License-Identifier: MIT
// Watches whether other programs take the processor cores that a launch needs.
//
// A clock cannot tell: where the system's scheduler puts two threads on one core for minutes, all
// launches take twice their time and none stands out. The system counts for each thread how long
// it ran and how long it waited for a core (/proc/self/task/*/schedstat), and for each core how
// long it was busy (/proc/stat).
#ifndef BASE_CORE_WATCH_H
#define BASE_CORE_WATCH_H

#include <stdbool.h>
#include <stdint.h>

// The threads of this process, as one launch after another uses them.
typedef struct core_watch core_watch;

// The threads' use of the cores during a launch.
//
// A launch ends when its slowest thread does. So it lost no more than the longest that one thread
// waited for a core, and no more than the time in which neither the caller nor the busiest other
// thread ran. A thread that waits beside the slowest one costs nothing and shows in the first
// alone; threads that work one after another show in the second alone. If threads share the work as
// they come, one does what another that waits leaves: then it is the time in which the caller did
// not run, less an equal part of what all the others ran.
typedef struct core_use {
    uint64_t
        cpu_ns; // processor time of the calling thread and of the busiest other one; 0: unknown
    uint64_t wait_ns; // the longest that one thread waited for a core
    uint64_t lost_ns; // the lesser of both bounds
    bool disturbed;   // that is more than a twentieth of the launch: another program had a core, or
                      // two of its own threads were put on one although there were enough
} core_use;

// Cores that other programs have.
typedef struct core_others {
    double cores;    // that they had lately, on average; what a hypervisor took counts
    uint32_t of;     // cores that this process may use
    bool is_crowded; // they have so much that a launch may be disturbed
} core_others;

// All launches since the watch was opened.
typedef struct core_tally {
    uint64_t launches;
    uint64_t disturbed; // part of the launches
    double others;      // cores that other programs had on average
    uint32_t of;        // cores that this process may use; 0: nothing is known
} core_tally;

// NULL if the system counts nothing of this, or memory is lacking.
core_watch *core_watch_open(void);
void core_watch_close(core_watch *w); // NULL: does nothing

// Encloses a launch by the calling thread, whose work is spread over so many threads as they come;
// 1: each does its own. A NULL watch sees nothing.
void core_watch_start(core_watch *w, uint32_t spread);
core_use core_watch_stop(core_watch *w);

// The last third of a second or so; of == 0 for a NULL watch.
core_others core_watch_others(core_watch *w);
core_tally core_watch_tally(core_watch *w);

#endif
