// SPDX-License-Identifier: MIT
// What comes out of mpirun's stderr: lines of ranks, which are for the person who started them, and
// between them lines of MPI's own. These are kept back, and what they tell of a failure is kept.
#ifndef CLI_MPIRUN_SAYS_H
#define CLI_MPIRUN_SAYS_H

#include "base/text.h"

// Rank 0 writes this byte once all ranks are there. What comes before it is of those that start
// them.
#define MPIRUN_BEGUN "\x06"
// And this one where all ranks have stopped because one was asked to. They then end as if all were
// well: mpirun is slow to end a job that failed.
#define MPIRUN_STOPPED "\x18"

enum { MPIRUN_LINE = 512 };

// All 0: nothing was said yet.
typedef struct mpirun_says {
    bool passes_all; // MPI's lines, too
    bool begun;
    bool stopped;
    bool names_rank;       // that a signal has ended
    unsigned long rank;    // this one
    char host[256];        // where it was, or the machine that was lost; "": neither was said
    char peer[256];        // where a rank was that others no longer reach; "": was not said
    char why[MPIRUN_LINE]; // the first line before ranks began, fit to be shown
    // ---------------- of its own
    int state;
    bool in_block;
    bool why_is_of_block;
    char line[MPIRUN_LINE]; // what is held of this line
    size_t n;               // of it; more where there was no space
} mpirun_says;

// Adds those of the bytes to `out` that are to be seen; some are held until their line goes on.
void mpirun_hear(mpirun_says *s, const char *bytes, size_t n, text *out);
// No more bytes come.
void mpirun_hear_end(mpirun_says *s, text *out);

#endif
