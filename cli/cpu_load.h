// SPDX-License-Identifier: MIT
// What other programs take of the processors while something is measured.
#ifndef CLI_CPU_LOAD_H
#define CLI_CPU_LOAD_H

#include <stdint.h>

typedef struct cpu_load {
    uint64_t all_ticks;  // of the processors that this program may use
    uint64_t busy_ticks; // of those, whoever used them
    double own_s;        // of all threads of this program
} cpu_load;

cpu_load cpu_load_look(void);

// Their part of the processors' time since then, 0 to 1; 0 where the system
// does not tell. What the program needs takes up to 1 / (1 - part) times as
// long on that account, and more where its threads wait for each other.
double cpu_load_part(const cpu_load *since);

#endif
