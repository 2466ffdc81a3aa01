// SPDX-License-Identifier: MIT
// Objects as rows of text.
#include "support/fuzz.h"
#include "support/objects.h"

void fuzz_one(const uint8_t *data, size_t n)
{
    fuzz_read_objects("input.csv", data, n);
}
