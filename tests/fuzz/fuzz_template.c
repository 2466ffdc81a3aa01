// SPDX-License-Identifier: MIT
// Templates of kernels, expanded by one config.
#include "support/fuzz.h"

#include "gen/template.h"

void fuzz_one(const uint8_t *data, size_t n)
{
    static const gen_setting config[] = {{"DIMS", 2}, {"WG", 64}};
    static const card_names emit = {.at = {"stencil"}, .n = 1};
    text chars = {0}, out = {0};
    duet_error err = {0};
    text_add_bytes(&chars, (const char *)data, n);
    template *t = template_open(&chars, "kernels/kernel.cl.in", "kernel.cl.in", &emit, &err);
    fuzz_require_answer(t != NULL, &err);
    if (t) {
        bool ok = template_expand(t, config, 2, &out, &err);
        fuzz_require_answer(ok, &err);
        template_close(t);
    }
    text_free(&chars);
    text_free(&out);
}
