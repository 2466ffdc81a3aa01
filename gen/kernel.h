// SPDX-License-Identifier: MIT
// What is read of a kernel: its card, the headers that it uses, and its text
// or template. From the carried files, or from a folder and nowhere else.
#ifndef GEN_KERNEL_H
#define GEN_KERNEL_H

#include "gen/card.h"
#include "gen/space.h"
#include "gen/template.h"

typedef struct kernel {
    char name[48];
    char folder[32]; // within the kernels' folder, "grid/", or ""
    bool is_read;
    card card;
    space space;
    text plain;         // common.clh, what the card uses, and a .cl, with #lines
    template *choices;  // of these, where some line is Lua, else NULL
    template *template; // of a .cl.in, else NULL
} kernel;

// Reads the folder's NAME.lua, common.clh, NAME.cl or NAME.cl.in; dir NULL: carried ones.
// Every file that is missing is NOT_FOUND with its path.
bool kernel_read(kernel *k, const char *dir, duet_error *err);
void kernel_forget(kernel *k);

#endif
