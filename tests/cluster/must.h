// SPDX-License-Identifier: MIT
// A fact that does not hold on one rank ends the job with a line.
#ifndef TESTS_MUST_H
#define TESTS_MUST_H

#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>

static int rank; // this rank in the whole job

_Noreturn static void end_job(const char *fact, const char *file, int line, const char *why)
{
    fprintf(stderr, "rank %d, %s:%d: %s: %s\n", rank, file, line, fact, why);
    MPI_Abort(MPI_COMM_WORLD, 1);
    abort();
}

#define MUST(fact, why)                                \
    do {                                               \
        if (!(fact))                                   \
            end_job(#fact, __FILE__, __LINE__, (why)); \
    } while (0)
#define MUST_OK(call, err) MUST(call, (err).text)

#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#define IGNORE_LEAKS(call) (__lsan_disable(), call, __lsan_enable())
#define FIND_LEAKS() __lsan_do_leak_check()
#else
#define IGNORE_LEAKS(call) call
#define FIND_LEAKS() (void)0
#endif

#endif
