//@ if SHAPE >= 2 then
// SPDX-License-Identifier: MIT
// A rounded box of a tree: as a box of it, then its radius; the id is last. Spheres come as
// rounded boxes without a core.
#ifndef KERNELS_QUERIES_ROUNDED_ROW_H
#define KERNELS_QUERIES_ROUNDED_ROW_H

#define TREE_ROUNDED_WORDS 24
#define TREE_BOX_RADIUS 15

#endif
//@ end
