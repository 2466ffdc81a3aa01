// SPDX-License-Identifier: MIT
// The counters of a device's part in a step, for kernels and host alike: words that the
// step zeroes first and reads last. A 64-bit count is two of them, low then high.
#ifndef KERNELS_COUNTERS_H
#define KERNELS_COUNTERS_H

#define COUNT_CANDIDATES 0 // listed
#define COUNT_PAIRS 2
#define COUNT_UNDECIDED 4
#define COUNT_TESTED 6  // candidates that were tested where they were found
#define COUNT_BAD 8     // objects left out; from here on a search leaves them as the grid set them
#define FIRST_BAD 9     // ~least id among them
#define WIDEST 10       // bits of the largest extent above the coarsest cells
#define COUNT_PLACED 11 // objects in this device's grid
#define COUNT_OTHERS 12 // objects in cells that are not their work-item's own
#define COUNTERS 16

#endif
