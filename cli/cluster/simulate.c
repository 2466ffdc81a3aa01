// SPDX-License-Identifier: MIT
// The program duet-simulate: `duet cluster --simulate`, all of its ranks in one process.
#include "base/error.h"
#include "cli/cluster/rank.h"
#include "cli/interrupt.h"
#include "cli/say.h"
#include "cluster/cluster.h"
#include "cluster/ghost_traffic.h"
#include "cluster/simulated/smpi.h"

#include <limits.h>
#include <locale.h>
#include <string.h>

typedef struct simulated_job {
    cluster_arguments args; // first: the table of options fills it
    const char *scene;
    simulation simulation;
    duet_profile_list *profiles;
    const duet_stored_profile *profile; // gives the times of ranks; NULL: they find pairs
    bool failed;
    duet_error err; // rank 0's, which is that of all
} simulated_job;

// ---------------------------------------------------------------- times

static const duet_stored_profile *find_profile(const duet_profile_list *list, const char *uid,
                                               duet_error *err)
{
    const duet_stored_profile *found = NULL;
    uint32_t n = 0;
    for (uint32_t i = 0; i < duet_profile_list_get_count(list); ++i) {
        const duet_stored_profile *p = duet_profile_list_get_profile(list, i);
        if (strncmp(p->uid, uid, strlen(uid)) != 0)
            continue;
        found = p;
        ++n;
    }
    if (n != 1)
        bad_argument(err,
                     "--profile '%s': %u profiles begin so; expected the first digits of one, as "
                     "'duet profiles' shows them",
                     uid, n);
    return n == 1 ? found : NULL;
}

// A step over ranks has messages in its time already, and is of more objects than a rank has.
static bool check_steps(const simulated_job *job, const duet_stored_profile *p, duet_error *err)
{
    if (*p->query)
        return bad_argument(err,
                            "--profile '%s': a profile of the query '%s'; expected one of steps",
                            job->args.profile, p->query);
    return strncmp(p->objective, CLUSTER_OVER_RANKS, strlen(CLUSTER_OVER_RANKS)) != 0 ||
           bad_argument(err,
                        "--profile '%s': a profile of %s; expected one of steps on one device pair",
                        job->args.profile, p->objective);
}

// The most that a rank's step can take for each object.
static const double MOST_OBJECT_S = 1;

// Reads the step's time by the objects of the profile. A store may have been written by anybody.
static bool read_times(simulated_job *job, duet_error *err)
{
    simulation *s = &job->simulation;
    *s = (simulation){.pass = smpi_pass, .stands_for = (uint32_t)job->args.stands_for};
    if (!job->args.profile)
        return true;
    job->profiles = duet_profile_list_create(NULL, true, err);
    const duet_stored_profile *p =
        job->profiles ? find_profile(job->profiles, job->args.profile, err) : NULL;
    if (!p || !check_steps(job, p, err))
        return false;
    job->profile = p;
    s->traffic = p->moving ? ghost_traffics : NULL;
    s->object_seconds = p->step_ms * 1e-3 / (double)p->objects;
    return (s->object_seconds > 0 && s->object_seconds <= MOST_OBJECT_S) ||
           bad_input(err,
                     "profile %.8s of the store: its time of a step or its objects cannot be; "
                     "expected what 'duet tune' wrote",
                     p->uid);
}

// ---------------------------------------------------------------- the program

static void run_rank(void *context)
{
    simulated_job *job = context;
    duet_error err = {0};
    int rank = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    if (rank == 0 && job->simulation.stands_for > 1)
        job->simulation.ballast = smpi_ballast(INT_MAX);
    bool ok = rank_run(&job->args, job->scene, &job->simulation, job->profile, &err);
    if (ok || rank > 0)
        return;
    job->failed = true;
    job->err = err;
}

static bool run_ranks(simulated_job *job, duet_error *err)
{
    if (!smpi_run(job->args.simulate, (int)job->args.ranks, run_rank, job, err))
        return false;
    return !job->failed || error_copy(err, &job->err);
}

static bool run(void *given, char **operands, duet_error *err)
{
    simulated_job *job = given;
    job->scene = operands[0];
    bool ok = read_times(job, err) && run_ranks(job, err);
    duet_profile_list_destroy(job->profiles);
    return ok;
}

int main(int argc, char **argv)
{
    simulated_job job = {.args = CLUSTER_ARGUMENTS_DEFAULT};
    setlocale(LC_CTYPE, "");
    interrupt_watch();
    interrupt_react(INTERRUPT_ENDS);
    int status = options_run(&cluster_line, argc, argv, &job, run);
    return status == EXIT_OK && !say_finish() ? EXIT_FAILED : status;
}
