// SPDX-License-Identifier: MIT
#ifndef TESTS_WRONG_MEMORY_H
#define TESTS_WRONG_MEMORY_H

#include <stdint.h>

// From here on Duet's own calls for memory are counted from 0, and those from first to last fail.
void memory_refuse(uint64_t first, uint64_t last);
uint64_t memory_asked(void); // calls since then

#endif
