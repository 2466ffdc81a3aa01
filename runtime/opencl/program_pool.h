// SPDX-License-Identifier: MIT
// The programs that were built last on a device. A world or a motion more on it
// then builds nothing: even where a driver keeps what it built, it reads the
// whole text again to find it.
#ifndef RUNTIME_PROGRAM_POOL_H
#define RUNTIME_PROGRAM_POOL_H

#include <CL/cl.h>

typedef struct program_pool program_pool;

program_pool *program_pool_open(void); // NULL without memory; the others take NULL
void program_pool_close(program_pool *s);

// The program of the text with this hash, which the caller releases; NULL where
// it is not there (any more). Threads may ask at once.
cl_program program_pool_take(program_pool *s, const char sha256[65]);
void program_pool_put(program_pool *s, const char sha256[65], cl_program program);

#endif
