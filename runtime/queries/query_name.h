// SPDX-License-Identifier: MIT
// What a tree is asked, in words: "rays closest", "sweeps any", "boxes", "points nearest 8". The
// profile store, options and Lua have the same ones.
#ifndef RUNTIME_QUERY_NAME_H
#define RUNTIME_QUERY_NAME_H

#include "runtime/duet_tree.h"

#define QUERY_NAME 32 // bytes, its end counted

typedef enum query_item { QUERY_RAYS, QUERY_SWEEPS, QUERY_BOXES, QUERY_POINTS } query_item;

typedef struct query_name {
    query_item item;
    duet_query_wants wants; // rays and sweeps only
    bool itself;            // boxes only: the tree's own
    uint32_t nearest;       // points only; 0: boxes that contain them
} query_name;

void query_name_write(const query_name *name, char text[QUERY_NAME]);

// "rays" and "sweeps" want the closest. BAD_ARGUMENT for other words.
bool query_name_read(const char *text, query_name *name, duet_error *err);

#endif
