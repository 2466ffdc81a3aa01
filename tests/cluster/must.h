// SPDX-License-Identifier: MIT
// A fact that does not hold on one rank ends the job with a line.
#ifndef TESTS_MUST_H
#define TESTS_MUST_H

#include "duet_error.h"

#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

// The value of a call that must succeed, in which ERR stands for the error that it fills.
#define must(call)                                         \
    __extension__({                                        \
        rank_error = (duet_error){0};                      \
        __typeof__(call) given_ = (call);                  \
        if (!given_)                                       \
            end_job(#call, __FILE__, __LINE__, ERR->text); \
        given_;                                            \
    })
#define ERR (&rank_error)

// A call that must fail with this status and one line that has `says`, which ERR keeps.
#define must_fail(call, code, says)                                        \
    do {                                                                   \
        rank_error = (duet_error){0};                                      \
        if ((call) || ERR->status != (code) || !strstr(ERR->text, says) || \
            strchr(ERR->text, '\n'))                                       \
            end_job(#call, __FILE__, __LINE__, ERR->text);                 \
    } while (0)

__attribute__((unused)) static duet_error rank_error;

#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#define IGNORE_LEAKS(call) (__lsan_disable(), call, __lsan_enable())
#define FIND_LEAKS() __lsan_do_leak_check()
#else
#define IGNORE_LEAKS(call) call
#define FIND_LEAKS() (void)0
#endif

#endif
