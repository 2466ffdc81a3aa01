// SPDX-License-Identifier: MIT
// Tune files: what to tune, and how.
#include "support/fuzz.h"

#include "cli/tune_config.h"

static void require_config(const tune_config *c)
{
    fuzz_require(c->n_workloads >= 1 && c->n_workloads <= CONFIG_WORKLOADS);
    fuzz_require(c->def.n_variants <= FIELD_NAMES && c->def.n_modes <= FIELD_NAMES);
    for (uint32_t i = 0; i < c->n_workloads; ++i)
        fuzz_require(!c->workloads[i].scene == !!c->workloads[i].task &&
                     c->workloads[i].n_settings <= CONFIG_SETTINGS);
}

void fuzz_one(const uint8_t *data, size_t n)
{
    fuzz_path path = fuzz_file("tune.lua", data, n);
    duet_error err = {0};
    tune_config config;
    bool ok = tune_config_load(&config, path.chars, &err);
    fuzz_require_answer(ok, &err);
    if (ok)
        require_config(&config);
    if (ok)
        tune_config_free(&config);
}
