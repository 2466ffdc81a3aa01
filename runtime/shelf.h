// SPDX-License-Identifier: MIT
// The programs that were built last on a device. A world or a motion more on it
// then builds nothing: even where a driver keeps what it built, it reads the
// whole text again to find it.
#ifndef RUNTIME_SHELF_H
#define RUNTIME_SHELF_H

#include <CL/cl.h>

typedef struct shelf shelf;

shelf *shelf_open(void); // NULL without memory; the others take NULL
void shelf_close(shelf *s);

// The program of the text with this hash, which the caller releases; NULL where
// it is not there (any more). Threads may ask at once.
cl_program shelf_take(shelf *s, const char sha256[65]);
void shelf_put(shelf *s, const char sha256[65], cl_program program);

#endif
