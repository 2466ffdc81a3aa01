// SPDX-License-Identifier: MIT
// A test that all ranks of a job run. A fact that does not hold on one rank ends the job with a
// line.
#ifndef TESTS_JOB_H
#define TESTS_JOB_H

#include "runtime/duet.h"

#include "cluster/duet_cluster.h"

#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

extern int rank; // this rank in the whole job

// A fact, which the function of that name shows on all ranks, or on rank 0 alone while the others
// wait: FACT(name) { ... } is all that it needs. A fact that fails is named.
#define FACT(name) JOB_FACT(name, false)
#define FACT_OF_ONE(name) JOB_FACT(name, true)
#define JOB_FACT(name, of_one)                                \
    static void name(void);                                   \
    __attribute__((constructor)) static void add_##name(void) \
    {                                                         \
        job_add(#name, name, of_one);                         \
    }                                                         \
    static void name(void)

void job_add(const char *name, void (*show)(void), bool of_one);

// Shows a program's facts in a job of so many ranks, those of rank 0 alone first.
#define JOB_MAIN(n_ranks, seed, says)                      \
    int main(int argc, char **argv)                        \
    {                                                      \
        return job_run(&argc, &argv, n_ranks, seed, says); \
    }
int job_run(int *argc, char ***argv, int n_ranks, uint64_t seed, const char *says);

extern uint64_t job_seed; // which job_begin returned

// Begins a job of so many ranks. Returns DUET_TEST_SEED if that is set, else the seed; rank 0
// prints it.
uint64_t job_begin(int *argc, char ***argv, int n_ranks, uint64_t seed);

// Ends it, after rank 0 has said what holds. Returns 0.
int job_end(const char *says);

_Noreturn void end_job(const char *fact, const char *file, int line, const char *why);

// A cluster of the first n ranks, NULL on the others; or of this rank alone, which then needs no
// others for the call. The def needs no comm.
enum { ALONE = 0 };
duet_cluster *cluster_of(int n, duet_cluster_def def);

// Writes a file that all ranks find; and removes it once all have it no more.
void job_write(const char *path, const char *content);
void job_remove(const char *path);

#define MUST(fact, why)                                \
    do {                                               \
        if (!(fact))                                   \
            end_job(#fact, __FILE__, __LINE__, (why)); \
    } while (0)

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

extern duet_error rank_error;

#endif
