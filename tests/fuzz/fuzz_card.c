// SPDX-License-Identifier: MIT
// Cards of kernels, and what they answer of each of their first configs.
#include "support/fuzz.h"

#include "gen/card.h"

enum { CONFIGS = 8 };

static void ask(card *c, const gen_limits *limits)
{
    duet_error err = {0};
    if (!card_set_fallbacks(c, limits, &err)) {
        fuzz_require_answer(false, &err);
        return;
    }
    for (uint64_t i = 0; i < card_size(c) && i < CONFIGS; ++i) {
        gen_setting config[CARD_MAX_PARAMS];
        card_launch launch = {0};
        err = (duet_error){0};
        card_config(c, i, config);
        bool ok = card_check(c, limits, config, &launch, &err);
        fuzz_require_answer(ok, &err);
        double group = 1;
        for (uint32_t axis = 0; ok && axis < 3; ++axis)
            group *= launch.axes[axis].group;
        fuzz_require(!ok || (group <= limits->max_group && group > 0 && launch.n_axes >= 1 &&
                             launch.n_axes <= 3));
    }
}

void fuzz_one(const uint8_t *data, size_t n)
{
    static const gen_limits limits = {.max_group = 256, .local_bytes = 32768, .fp64 = true};
    text chars = {0};
    duet_error err = {0};
    card c;
    text_add_bytes(&chars, (const char *)data, n);
    bool ok = card_open(&c, "kernel", "kernels/kernel.lua", &chars, &err);
    fuzz_require_answer(ok, &err);
    if (ok) {
        ask(&c, &limits);
        card_close(&c);
    }
    text_free(&chars);
}
