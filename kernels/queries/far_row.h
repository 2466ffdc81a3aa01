//@ if ORIGIN > 0 then
// SPDX-License-Identifier: MIT
// A box of a tree in origin cells: as a box of it, then its cell, and how far its bounds reach
// from its centre; the id is last.
#ifndef KERNELS_QUERIES_FAR_ROW_H
#define KERNELS_QUERIES_FAR_ROW_H

#define TREE_FAR_WORDS 24
#define TREE_BOX_CELL 15
#define TREE_BOX_REACH 18

#endif
//@ end
