// SPDX-License-Identifier: MIT
#include "gen/space.h"

#include <inttypes.h>
#include <stdlib.h>

#define BLOCK 256

void space_free(space *s)
{
    free(s->before);
    *s = (space){0};
}

static bool same_limits(const gen_limits *a, const gen_limits *b)
{
    return a->max_group == b->max_group && a->local_bytes == b->local_bytes && a->fp64 == b->fp64 &&
           a->cpu == b->cpu;
}

static bool check_one(card *c, const gen_limits *limits, uint64_t number, gen_setting *config,
                      bool *valid, duet_error *err)
{
    card_launch launch;
    duet_error why = {0};
    card_config(c, number, config);
    *valid = card_check(c, limits, config, &launch, &why);
    bool broken = !*valid && why.status != DUET_STATUS_BAD_ARGUMENT;
    return !broken || error_copy(err, &why);
}

// Walks through the block from its first config on and ends after the valid
// one that makes n `enough`, which is then in config.
static bool walk_block(card *c, const gen_limits *limits, uint64_t block, uint64_t enough,
                       gen_setting *config, uint64_t *n, duet_error *err)
{
    uint64_t size = card_size(c);
    bool ok = true;
    *n = 0;
    for (uint64_t i = block * BLOCK; ok && i < size && i < (block + 1) * BLOCK && *n < enough;
         ++i) {
        bool valid = false;
        ok = check_one(c, limits, i, config, &valid, err);
        *n += valid;
    }
    return ok;
}

static bool fill_blocks(space *s, card *c, const gen_limits *limits, duet_error *err)
{
    gen_setting config[CARD_MAX_PARAMS];
    bool ok = true;
    for (uint64_t i = 0; ok && i < s->n_blocks; ++i) {
        uint64_t n = 0;
        ok = walk_block(c, limits, i, BLOCK, config, &n, err);
        s->before[i + 1] = s->before[i] + n;
    }
    return ok;
}

static bool count_blocks(space *s, card *c, const gen_limits *limits, duet_error *err)
{
    space_free(s);
    if (!card_set_fallbacks(c, limits, err))
        return false;
    s->limits = *limits;
    s->n_blocks = (card_size(c) + BLOCK - 1) / BLOCK;
    s->before = calloc(s->n_blocks + 1, sizeof *s->before);
    bool ok = s->before ||
              error_set(err, DUET_STATUS_NO_MEMORY, "%s: no memory to count configs", c->kernel);
    ok = ok && fill_blocks(s, c, limits, err);
    if (!ok)
        space_free(s);
    return ok;
}

bool space_count(space *s, card *c, const gen_limits *limits, uint64_t *count, duet_error *err)
{
    bool counted = s->before && same_limits(&s->limits, limits);
    if (!counted && !count_blocks(s, c, limits, err))
        return false;
    *count = s->before[s->n_blocks];
    return true;
}

// The block that holds valid config number index.
static uint64_t block_of(const space *s, uint64_t index)
{
    uint64_t low = 0, high = s->n_blocks;
    while (high - low > 1) {
        uint64_t middle = low + (high - low) / 2;
        if (s->before[middle] <= index)
            low = middle;
        else
            high = middle;
    }
    return low;
}

bool space_config(space *s, card *c, const gen_limits *limits, uint64_t index, gen_setting *config,
                  duet_error *err)
{
    uint64_t count = 0;
    if (!space_count(s, c, limits, &count, err) || !card_set_fallbacks(c, limits, err))
        return false;
    if (index >= count)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "%s: config %" PRIu64 " of %" PRIu64,
                         c->kernel, index, count);
    uint64_t block = block_of(s, index);
    uint64_t n = 0;
    return walk_block(c, limits, block, index - s->before[block] + 1, config, &n, err);
}
