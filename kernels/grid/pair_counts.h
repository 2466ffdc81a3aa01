// SPDX-License-Identifier: MIT
// What is counted of the pairs that a search found, for kernels and host alike: 64 bits in two
// words each, low then high.
#ifndef KERNELS_PAIR_COUNTS_H
#define KERNELS_PAIR_COUNTS_H

#define COUNT_COUNTED 0
#define COUNTED_HASH 2
#define COUNT_LEFT 4 // to the host
#define PAIR_COUNTS 6

#define NO_GLOBAL_ID 0xffffffffu // in both words of an id

#endif
