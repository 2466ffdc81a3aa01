// SPDX-License-Identifier: MIT
// An array that grows: it has space for as many items as the next power of two, so that the number
// of its items says when it is full.
#ifndef BASE_LIST_H
#define BASE_LIST_H

#include "duet_error.h"

#include <stddef.h>
#include <stdint.h>

// Returns the array of n items with space for one more, which may lie elsewhere; NULL if there is
// no memory: the array stays as it was. items is NULL before the first call, and freed by the
// caller; it may lose items at its end between calls.
void *list_room(void *items, uint64_t n, size_t size, duet_error *err);

#endif
