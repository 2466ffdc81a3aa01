// SPDX-License-Identifier: MIT
// Saved states of motions. What is taken can be advanced.
#include "support/fuzz.h"
#include "support/motions.h"

#include <string.h>

static duet_motion *motions[MOTIONS];

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t n, size_t most, unsigned seed);

// The sum at a state's end, as docs/formats.md has it.
static uint64_t sum_of(const uint8_t *bytes, size_t n)
{
    uint64_t sum = UINT64_C(0xcbf29ce484222325);
    for (size_t i = 0; i < n; ++i)
        sum = (sum ^ bytes[i]) * UINT64_C(0x100000001b3);
    return sum;
}

// Most changes stay within the state's length and are summed again; anything else
// is refused before it is looked at.
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t n, size_t most, unsigned seed)
{
    uint64_t sum = 0;
    if (n < sizeof sum || seed % 8 == 0)
        return LLVMFuzzerMutate(data, n, most);
    size_t body = n - sizeof sum;
    size_t at = seed / 8 % (body + 1), span = body - at < 16 ? body - at : 16;
    LLVMFuzzerMutate(data + at, span, span);
    sum = sum_of(data, body);
    memcpy(data + body, &sum, sizeof sum);
    return n;
}

static bool advance(duet_motion *m)
{
    duet_error err = {0};
    duet_motion_result result;
    bool ok = duet_motion_advance(m, &result, &err);
    fuzz_require_answer(ok, &err);
    return ok;
}

// Drivers compile on when a kernel is launched first, so every one is.
void fuzz_begin(void)
{
    duet_error err = {0};
    duet_device_pair *pair = motions_open_pair(&err);
    fuzz_require_answer(pair != NULL, &err);
    for (int i = 0; i < MOTIONS; ++i) {
        motions[i] = motions_make(i, pair, &err);
        fuzz_require_answer(motions[i] != NULL, &err);
        for (int step = 0; step < 30; ++step)
            fuzz_require(advance(motions[i]));
    }
}

void fuzz_one(const uint8_t *data, size_t n)
{
    fuzz_path path = fuzz_file("state.motion", data, n);
    for (int i = 0; i < MOTIONS; ++i) {
        duet_error err = {0};
        bool ok = duet_motion_load(motions[i], path.chars, &err);
        fuzz_require_answer(ok, &err);
        if (ok)
            advance(motions[i]);
    }
}
