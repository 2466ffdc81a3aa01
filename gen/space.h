// SPDX-License-Identifier: MIT
// The valid configs of a card, counted and found by number without a list of
// them: only how many there are in each block of the numbering is kept.
#ifndef GEN_SPACE_H
#define GEN_SPACE_H

#include "gen/card.h"

typedef struct space {
    gen_limits limits; // that before[] was counted for
    uint64_t *before;  // [n_blocks + 1] valid ones before each block; NULL: not counted
    uint64_t n_blocks;
} space;

void space_free(space *s);

bool space_count(space *s, card *c, const gen_limits *limits, uint64_t *count, duet_error *err);

// BAD_ARGUMENT where index is not below the count.
bool space_config(space *s, card *c, const gen_limits *limits, uint64_t index, gen_setting *config,
                  duet_error *err);

#endif
