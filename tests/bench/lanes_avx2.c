// SPDX-License-Identifier: MIT
#include "lanes_avx2.h"

uint64_t lanes_front[256];

void lanes_prepare(void)
{
    for (unsigned mask = 0; mask < 256; ++mask) {
        uint64_t numbers = 0;
        int n = 0;
        for (uint64_t lane = 0; lane < 8; ++lane)
            if (mask >> lane & 1)
                numbers |= lane << 8 * n++;
        lanes_front[mask] = numbers;
    }
}
