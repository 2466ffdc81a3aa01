// SPDX-License-Identifier: MIT
// The program duet-cluster: one rank of `duet cluster`.
#include "cli/cluster/rank.h"

#include "base/error.h"
#include "base/text.h"
#include "cli/interrupt.h"
#include "cli/mpirun.h"
#include "cli/say.h"

#include <locale.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- the same words

// The word that begins there; a line break is behind each.
static said show_word(const char *at)
{
    said word = {"nothing"};
    if (*at)
        snprintf(word.chars, sizeof word.chars, "'%.*s'", (int)strcspn(at, "\n"), at);
    return word;
}

static bool are_same(const char *own, const char *of_rank_0, duet_error *err)
{
    size_t at = 0, word = 0;
    for (; own[at] && own[at] == of_rank_0[at]; ++at)
        word = own[at] == '\n' ? at + 1 : word;
    return own[at] == of_rank_0[at] ||
           bad_argument(err, "%s, where rank 0 has %s; expected the same words on all ranks",
                        show_word(own + word).chars, show_word(of_rank_0 + word).chars);
}

// A launcher may start each rank by a command line of its own, and ranks that do not do the same
// would wait for each other.
static bool words_agree(char *const *argv, duet_error *err)
{
    ranks all;
    text words = {0};
    for (; *argv; ++argv)
        text_add(&words, "%s\n", *argv);
    char *of_rank_0 = NULL;
    bool ok = ranks_begin(&all, NULL, NULL, err) && ranks_agree(&all, text_ok(&words, err), err);
    ok = ok && (of_rank_0 = ranks_broadcast_text(&all, text_chars(&words), err));
    ok = ok && ranks_agree(&all, are_same(text_chars(&words), of_rank_0, err), err);
    free(of_rank_0);
    text_free(&words);
    ranks_end(&all);
    return ok;
}

// ---------------------------------------------------------------- the program

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
    const int starter = mpirun_connect();
    interrupt_tell(starter);
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
    duet_error err = {0};
    int status = words_agree(argv + 1, &err) ? options_run(&cluster_line, argc, argv, &own, run)
                 : rank == 0                 ? say_failed(&err)
                                             : say_status(&err);
    status = status == EXIT_OK ? own.quiet_status : status;
    MPI_Finalize();
    bool written = say_finish();
    status = status == EXIT_OK && !written ? EXIT_FAILED : status;
    if (status == EXIT_OK)
        mpirun_tell_done(starter);
    if (is_alone && status == EXIT_INTERRUPTED)
        interrupt_end();
    return started && status != EXIT_OK ? MPIRUN_TOLD + status : status;
}
