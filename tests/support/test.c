// SPDX-License-Identifier: MIT
#include "support/test.h"

#include <inttypes.h>
#include <stdlib.h>

uint64_t test_seed(void)
{
    const char *given = getenv("DUET_TEST_SEED");
    uint64_t seed = given ? strtoull(given, NULL, 0) : 20261121;
    print_message("DUET_TEST_SEED=%" PRIu64 "\n", seed);
    return seed;
}
