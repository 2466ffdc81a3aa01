// SPDX-License-Identifier: MIT
// Saved states of motions. A file that is taken can be advanced.
#include "support/fuzz.h"
#include "support/motions.h"

#include "base/text.h"

#include <string.h>

static duet_motion *motions[MOTIONS];

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t n, size_t most, unsigned seed);

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
    sum = text_checksum((const char *)data, body);
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
