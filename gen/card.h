// SPDX-License-Identifier: MIT
// A card (NAME.lua): what a kernel lets vary, which configs are valid, how a
// config is launched.
//
// Each card has a Lua state of its own, so that none can disturb another. A
// card that is wrong is BUILD_FAILED with file:line.
#ifndef GEN_CARD_H
#define GEN_CARD_H

#include "base/text.h"
#include "gen/gen.h"
#include "gen/signature.h"

#define CARD_MAX_PARAMS 32
#define CARD_MAX_NAMES 24
#define CARD_MAX_CONFIGS (UINT64_C(1) << 20)

// Names of files that a card asks for.
typedef struct card_names {
    char at[CARD_MAX_NAMES][64];
    uint32_t n;
} card_names;

typedef struct card {
    struct script *script;
    int table;          // the card's own, in the script's registry
    const char *kernel; // borrowed
    char *about;
    gen_param params[CARD_MAX_PARAMS];
    uint32_t n_params;
    card_names uses;       // headers, "object.clh"
    card_names emit;       // modules of gen/emit, "stencil"
    signature *signatures; // entries by name
    uint32_t n_signatures;
    bool has_struct; // the kernel's text has ARG_FIELDS
} card;

typedef struct card_launch {
    gen_axis axes[3];
    uint32_t n_axes;
} card_launch;

bool card_open(card *c, const char *kernel, const char *path, const text *chars, duet_error *err);
void card_close(card *c);

// Fills in what each parameter is where it is not set; it may depend on limits.
bool card_set_fallbacks(card *c, const gen_limits *limits, duet_error *err);

// Fills in a config: what n offers say, and what the other parameters are where they are not
// set. BAD_ARGUMENT if a parameter that must be there is not, or has no such value.
bool card_fill(card *c, const gen_offer *offers, uint32_t n, const gen_limits *limits,
               gen_setting *config, duet_error *err);

// Tells whether a config is valid, and fails only if the card does.
bool card_judge(card *c, const gen_limits *limits, const gen_setting *config, bool *is_valid,
                duet_error *err);

// BAD_ARGUMENT with the card's reason where the config is not valid.
bool card_check(card *c, const gen_limits *limits, const gen_setting *config, card_launch *launch,
                duet_error *err);

// Checks a config, tells its variant's name, launch and entries, and begins its text.
bool card_resolve(card *c, const gen_limits *limits, const gen_setting *config,
                  gen_variant *variant, text *out, duet_error *err);

// NULL: there is none of that name.
const gen_param *card_param(const card *c, const char *name);
bool card_has_value(const gen_param *param, int64_t value);

// Sets in a config what an offer says, if it is for this kernel.
bool card_take(const card *c, const gen_offer *offer, gen_setting *config, duet_error *err);

// All configs, valid or not, in mixed radix: the last parameter fastest.
uint64_t card_size(const card *c);
void card_config(const card *c, uint64_t index, gen_setting *config);

#endif
