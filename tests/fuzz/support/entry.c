// SPDX-License-Identifier: MIT
// Hands each input to the target and says at the end how long the slowest took:
// libFuzzer itself counts whole seconds.
#include "support/fuzz.h"

#include "base/clock.h"

#include <stdio.h>
#include <stdlib.h>

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n);

static uint64_t slowest_ns;

static void tell_slowest(void)
{
    printf("slowest_ms: %.1f\n", (double)slowest_ns * 1e-6);
}

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    (void)argc;
    (void)argv;
    atexit(tell_slowest);
    if (fuzz_begin)
        fuzz_begin();
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n)
{
    uint64_t start = clock_steady_ns();
    fuzz_one(data, n);
    uint64_t took = clock_steady_ns() - start;
    slowest_ns = took > slowest_ns ? took : slowest_ns;
    return 0;
}
