// SPDX-License-Identifier: MIT
// What a profile is of, and what it brings: a tree without what is in it.
#ifndef RUNTIME_TREE_SHARE_H
#define RUNTIME_TREE_SHARE_H

#include "runtime/queries/query_name.h"

const duet_tree_def *tree_def(const duet_tree *tree);
uint32_t tree_count(const duet_tree *tree);

// Returns the share of queries of that name: their own, or else the tree's.
uint32_t tree_share_of(const duet_tree *tree, const char *query);

// Sets the share like duet_tree_set_share, for queries of that name alone.
bool tree_tune(duet_tree *tree, const query_name *query, uint32_t share, duet_error *err);

#endif
