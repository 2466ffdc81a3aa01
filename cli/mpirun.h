// SPDX-License-Identifier: MIT
// Ranks of a job that the program mpirun starts. The stderr of mpirun and of the ranks passes
// through, and one line follows if the job fails and no rank has said why.
#ifndef CLI_MPIRUN_H
#define CLI_MPIRUN_H

#include "duet_error.h"

#include <signal.h>
#include <stdbool.h>

// Set for these ranks: they end with MPIRUN_TOLD more than their exit status, unless that is 0, so
// that it is known that a line was told. "terminal": lines go to one, through a pipe.
#define MPIRUN_STARTED "DUET_CLUSTER_STARTED"
enum { MPIRUN_TOLD = 64 };

// Bytes that rank 0 writes to stderr, which nobody sees: all ranks are there; and all have stopped,
// because one was asked to. They then end as if all were well: mpirun is slow to end a job that
// failed.
enum { MPIRUN_BEGUN = 0x06, MPIRUN_STOPPED = 0x18 };

// Asks a rank to stop where it is best. Open MPI's mpirun passes it on, and MPICH's does not: its
// ranks then end with it, unless a terminal tells them, too.
#define MPIRUN_STOPS SIGUSR2

// The name of a socket of this host that a rank tells once a signal asks it to stop: mpirun, when
// it is asked itself, ends its ranks by one and no longer passes on what they write.
#define MPIRUN_ASKED "DUET_CLUSTER_ASKED"

// For a rank: connects to that socket, to which a byte 0 is written then; -1: there is none.
int mpirun_connect(void);

// Tells it that this rank is done, so that no signal is told any more.
void mpirun_tell_done(int file);

typedef struct mpirun_job {
    char **argv;        // mpirun's, itself first, and NULL last
    const char *hosts;  // machines that it is to reach; NULL: this one
    const char *output; // a file that takes what the ranks print; NULL: stdout
    bool reads_stdin;   // which is else left to who called
    bool verbose;       // mpirun tells of ranks that fail, too
} mpirun_job;

// *status becomes the ranks' exit status; if it is not 0, a rank has printed why. False, with a
// line that says why, if the ranks failed and none of them has.
bool mpirun_run(const mpirun_job *job, int *status, duet_error *err);

#endif
