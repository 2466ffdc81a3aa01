// SPDX-License-Identifier: MIT
// A kernel's files, its card, the headers that it uses, and its text or template, carried or from
// one folder; and the variants made from them.
#ifndef GEN_KERNEL_H
#define GEN_KERNEL_H

#include "gen/card.h"
#include "gen/template.h"

// The number of valid configs, for some limits.
typedef struct valid_configs {
    gen_limits limits;
    uint64_t *before; // [n_blocks + 1] before each block of the numbering; NULL: not counted
    uint64_t n_blocks;
} valid_configs;

// The text of a variant that was made before, and its hash. It begins with the config as #defines,
// `prelude` bytes of it, from which all the rest follows.
typedef struct made_text {
    text whole;
    size_t prelude;
    char sha256[65];
} made_text;

enum { KERNEL_MADE = 2 }; // a world that changes between two plans makes each text once

typedef struct kernel {
    char name[48];
    char folder[32];               // within the kernels' folder, "grid/", or ""
    char *given_card, *given_text; // in the place of files; NULL: files
    bool is_read;
    card card;
    valid_configs valid;
    text plain;         // common.clh, what the card uses, and a .cl, with #lines
    template *choices;  // template of plain, if some line is Lua, else NULL
    template *template; // template of a .cl.in, else NULL
    made_text made[KERNEL_MADE];
    uint32_t n_made; // so far; the latest replaces the oldest
} kernel;

struct gen {
    char *dir; // NULL: what is carried
    kernel *kernels;
    uint32_t n_kernels;
};

// Ends a message about a folder of kernels: who set the variable that names it may have forgotten
// that.
const char *gen_without(const gen *g);

// The kernel of that name. At first its files are read, NAME.lua, common.clh, NAME.cl or
// NAME.cl.in; every one that is missing is NOT_FOUND with its path.
kernel *kernel_find(gen *g, const char *name, duet_error *err);
void kernel_close(kernel *k); // also what was given

#endif
