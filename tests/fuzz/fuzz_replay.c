// SPDX-License-Identifier: MIT
// Recorded commands. A recording that is taken can be given to a motion, which goes on or refuses.
#include "support/fuzz.h"
#include "support/motions.h"

#include "base/text.h"

#include <string.h>

static duet_device_pair *pair;

enum { MOST_STEPS = 4 };

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t n, size_t most, unsigned seed);

// Mostly the sum is right, for anything else is refused before it is looked at.
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t n, size_t most, unsigned seed)
{
    uint64_t sum;
    if (n < sizeof sum || seed % 8 == 0)
        return LLVMFuzzerMutate(data, n, most);
    size_t body = LLVMFuzzerMutate(data, n - sizeof sum, most - sizeof sum);
    sum = text_checksum((const char *)data, body);
    memcpy(data + body, &sum, sizeof sum);
    return body + sizeof sum;
}

void fuzz_begin(void)
{
    duet_error err = {0};
    pair = motions_open_pair(&err);
    fuzz_require_answer(pair != NULL, &err);
}

static void play(const char *path, int which)
{
    duet_error err = {0};
    duet_motion_result result;
    duet_replay *replay = duet_replay_create(path, &err);
    fuzz_require_answer(replay != NULL, &err);
    duet_motion *m = replay ? motions_make(which, pair, &err) : NULL;
    duet_replay_info info = duet_replay_get_info(replay);
    bool ok = m;
    for (uint64_t i = 0; ok && i < info.steps && i < MOST_STEPS; ++i) {
        ok = duet_replay_advance(replay, m, &result, &err);
        fuzz_require_answer(ok, &err);
    }
    duet_motion_destroy(m);
    duet_replay_destroy(replay);
}

void fuzz_one(const uint8_t *data, size_t n)
{
    fuzz_path path = fuzz_file("input.replay", data, n);
    play(path.chars, 0);
}
