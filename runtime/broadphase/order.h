// SPDX-License-Identifier: MIT
// The order of a world's objects by cell, in memory and by threads of whoever asks for it.
#ifndef RUNTIME_ORDER_H
#define RUNTIME_ORDER_H

#include "runtime/broadphase/world.h"

enum { ORDER_SCRATCH = 16 }; // bytes for each object

// order[i] becomes the object that comes i-th, as duet_world_order has it, for as many objects as
// the world has. The content of scratch is lost. The caller's is one of the threads; fewer are used
// if there are few objects, or the system gives no more.
bool world_order(duet_world *world, uint32_t n_threads, uint32_t *order, void *scratch,
                 duet_error *err);

#endif
