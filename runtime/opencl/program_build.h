// SPDX-License-Identifier: MIT
// How a program gets to the device: from what the folder of built programs had, or by the driver's
// compiler.
#ifndef RUNTIME_PROGRAM_BUILD_H
#define RUNTIME_PROGRAM_BUILD_H

#include "runtime/opencl/program.h"

enum { PROGRAM_MOST_ENTRIES = 8 };

// Contraction is off in the kernels' text; nothing here may loosen it.
#define PROGRAM_OPTIONS "-cl-std=CL1.2 -w"

typedef struct program {
    struct program *next;
    char sha256[65]; // hash of the variant's text
    char key[65];    // in the folder of built programs
    char name[160];
    char *text;   // NULL once it is built and its kernels are there
    char *binary; // the folder's binary, until it is built; or NULL
    size_t binary_bytes;
    cl_program cl; // NULL: asked for, and not yet built
    struct {
        char entry[48];
        kernel k;
    } entries[PROGRAM_MOST_ENTRIES];
    int n_entries;
} program;

struct program_set {
    const device *device;
    gen *gen;
    gen_limits limits;
    program_builder builder;
    const char *cache_dir; // NULL: this device's programs are not kept there
    program *first;
};

enum { PROGRAM_PLACE = 128 };

// The line of a compiler's log with its first error, or else its first line.
const char *program_first_error(const char *log);

// Writes the file and line of a compiler's message, where that names but a line of the text, and
// returns the rest of the message; else place is empty and the message is returned.
const char *program_place_message(const char *source, const char *message,
                                  char place[PROGRAM_PLACE]);

// Compiles the program's text.
bool program_compile(const program_set *set, program *p, duet_error *err);

// The programs that were built last on a device. A world or a motion more on it then builds
// nothing: even where a driver keeps what it built, it reads the whole text again to find it.
program_pool *program_pool_open(void); // NULL without memory, which is a pool that keeps nothing
void program_pool_close(program_pool *pool);

// Takes the program from the pool, if it is there; false if not, or if pool is NULL.
bool program_pool_take(program_pool *pool, program *p);
void program_pool_put(program_pool *pool, const program *p); // the pool may be NULL

void program_close(program *p); // with its kernels

#endif
