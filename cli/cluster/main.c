// SPDX-License-Identifier: MIT
// The program duet-cluster: one rank of `duet cluster`.
#include "cli/cluster/rank.h"
#include "cli/interrupt.h"
#include "cli/mpirun.h"
#include "cli/say.h"

#include <locale.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct rank_arguments {
    cluster_arguments args; // first: the table of options fills it
    int quiet_status;       // the status of a rank whose failure another process tells
} rank_arguments;

static bool run(void *given, char **operands, duet_error *err)
{
    rank_arguments *own = given;
    int rank = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    bool ok = rank_run(&own->args, operands[0], NULL, NULL, err);
    const bool is_started = getenv(MPIRUN_STARTED);
    const bool starter_tells = is_started && !ok && err->status == DUET_STATUS_INTERRUPTED;
    if (is_started || (!ok && rank > 0)) // another process tells of signals
        interrupt_forget();
    if (is_started) // also of those that come from here on
        interrupt_react(INTERRUPT_ENDS_SILENTLY);
    if (ok || (rank == 0 && !starter_tells))
        return ok;
    if (rank == 0)
        fputc(MPIRUN_STOPPED, stderr);
    own->quiet_status = starter_tells ? EXIT_OK : say_status(err);
    return true;
}

int main(int argc, char **argv)
{
    rank_arguments own = {.args = CLUSTER_ARGUMENTS_DEFAULT};
    int level = 0, rank = 0;
    unsigned long job_rank = 0, job_ranks = 0;
    setlocale(LC_CTYPE, "");
    signal(SIGXFSZ, SIG_IGN);
    interrupt_hear(MPIRUN_STOPS);
    interrupt_tell(mpirun_connect());
    interrupt_watch(); // before MPI's threads, so that the guard alone hears signals
    bool is_alone = !cluster_job(&job_rank, &job_ranks);
    interrupt_react(is_alone ? INTERRUPT_ENDS : INTERRUPT_ENDS_SILENTLY);
    MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &level);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    const char *started = getenv(MPIRUN_STARTED);
    if (rank == 0 && started)
        fputc(MPIRUN_BEGUN, stderr);
    if (rank == 0 && started && strcmp(started, "terminal") == 0)
        say_on_terminal();
    int status = options_run(&cluster_line, argc, argv, &own, run);
    status = status == EXIT_OK ? own.quiet_status : status;
    MPI_Finalize();
    bool written = say_finish();
    status = status == EXIT_OK && !written ? EXIT_FAILED : status;
    if (is_alone && status == EXIT_INTERRUPTED)
        interrupt_end();
    return started && status != EXIT_OK ? MPIRUN_TOLD + status : status;
}
