// SPDX-License-Identifier: MIT
// How a program gets from its text to the device: from those that were built last there, from the
// folder of built programs, or by the driver's compiler.
#ifndef RUNTIME_PROGRAM_BUILD_H
#define RUNTIME_PROGRAM_BUILD_H

#include "runtime/opencl/program.h"

enum { PROGRAM_MOST_ENTRIES = 5 };

typedef struct program {
    struct program *next;
    char sha256[65]; // of the variant's text
    char key[65];    // in the folder of built programs
    char name[160];
    char *text;    // NULL once everything that was asked for is there
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
    const char *built_ins; // what stands in the place of the driver's header, or NULL
    program *first;
};

// Compiles the program's text.
bool program_compile(const program_set *set, program *p, duet_error *err);

void program_close(program *p);

// The programs that were built last on a device. A world or a motion more on it then builds
// nothing: even where a driver keeps what it built, it reads the whole text again to find it.
program_pool *program_pool_open(void); // NULL without memory, which is a pool that keeps nothing
void program_pool_close(program_pool *pool);

#endif
