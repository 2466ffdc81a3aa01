// SPDX-License-Identifier: MIT
// The program duet-simulate: `duet cluster --simulate`, all of its ranks in one process.
#include "base/error.h"
#include "cli/cluster/rank.h"
#include "cli/interrupt.h"
#include "cli/say.h"
#include "cluster/simulated/platform.h"
#include "cluster/simulated/smpi.h"
#include "profiles/duet_profiles.h"

#include <limits.h>
#include <locale.h>
#include <string.h>
#include <unistd.h>

typedef struct simulated_job {
    cluster_arguments args; // first: the table of options fills it
    const char *scene;
    simulation simulation;
    stored_run run;        // whose times ranks take; no ranks: none's
    double object_seconds; // of a profile, whose times they take else
    stored_steps like;     // those; without a name where ranks find pairs
    bool failed;
    duet_error err; // of rank 0, which is that of all
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
        error_set(err, DUET_STATUS_BAD_ARGUMENT,
                  "--profile '%s': %u profiles begin so; expected the first digits of one, or of "
                  "a kept run, as 'duet profiles' shows them",
                  uid, n);
    return n == 1 ? found : NULL;
}

static bool check_steps(const simulated_job *job, const duet_stored_profile *p, duet_error *err)
{
    return !*p->query ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT,
                     "--profile '%s': a profile of the query '%s'; expected one of steps",
                     job->args.profile, p->query);
}

// A step's time by the objects of the profile, on devices of each rank's own.
static bool take_profile(simulated_job *job, duet_error *err)
{
    duet_profile_list *list = duet_profile_list_create(NULL, true, err);
    const duet_stored_profile *p = list ? find_profile(list, job->args.profile, err) : NULL;
    if (p) {
        job->object_seconds = p->step_ms * 1e-3 / (double)p->objects;
        job->like = (stored_steps){.of = "profile", .dims = p->dims};
        memcpy(job->like.level, p->level, sizeof p->level);
    }
    bool ok = p && check_steps(job, p, err) &&
              (stored_time_can_be(job->object_seconds) ||
               error_set(err, DUET_STATUS_BAD_INPUT,
                         "profile %.8s of the store: its time of a step or its objects cannot "
                         "be; expected what 'duet tune' wrote",
                         p->uid));
    job->simulation.object_seconds = &job->object_seconds;
    job->simulation.n_seconds = 1;
    duet_profile_list_destroy(list);
    return ok;
}

static bool read_times(simulated_job *job, duet_error *err)
{
    bool found = false;
    simulation *s = &job->simulation;
    *s = (simulation){
        .pass = smpi_pass, .stands_for = (uint32_t)job->args.stands_for, .ghost_objects = 1};
    if (!job->args.profile)
        return true;
    if (!stored_run_read(&job->run, job->args.profile, &found, err))
        return false;
    if (!found)
        return take_profile(job, err);
    s->object_seconds = job->run.object_seconds;
    s->n_seconds = job->run.n_seconds;
    s->ranks_a_host = (double)job->run.ranks / job->run.hosts;
    s->ghost_objects = STORED_RUN_GHOST;
    s->company = job->run.company;
    s->n_company = job->run.n_seconds;
    job->like = (stored_steps){.of = "run", .dims = job->run.dims, .run = &job->run};
    memcpy(job->like.level, job->run.level, sizeof job->run.level);
    return true;
}

// ---------------------------------------------------------------- the network

// Digits of a uid, where no file has that name.
static bool names_run(const char *name)
{
    return *name && name[strspn(name, "0123456789abcdef")] == '\0' && access(name, F_OK) != 0;
}

// Ranks stay on the one host whose inside was measured; else hosts have as many as in that run.
static bool write_platform(const simulated_job *job, const stored_run *run, platform_file *file,
                           duet_error *err)
{
    uint32_t a_host = (run->ranks + run->hosts - 1) / run->hosts, n = (uint32_t)job->args.ranks;
    platform p = {.hosts = run->hosts == 1 ? 1 : (n + a_host - 1) / a_host,
                  .latency_s = run->latency_ns * 1e-9};
    if (run->latency_ns == 0)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "--simulate '%s': that run had one rank and no network; expected a run of "
                         "several",
                         job->args.simulate);
    p.bytes_a_second = 1e9 / run->byte_ns;
    return platform_write(file, &p, err);
}

static bool make_platform(const simulated_job *job, platform_file *file, duet_error *err)
{
    bool found = false;
    stored_run run;
    bool ok = stored_run_read(&run, job->args.simulate, &found, err);
    if (ok && !found)
        ok = error_set(err, DUET_STATUS_BAD_ARGUMENT,
                       "--simulate '%s': no such file, and no kept run begins so; 'duet profiles "
                       "list' shows them",
                       job->args.simulate);
    ok = ok && write_platform(job, &run, file, err);
    stored_run_end(&run);
    return ok;
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
    bool ok =
        rank_run(&job->args, job->scene, &job->simulation, job->like.of ? &job->like : NULL, &err);
    if (ok || rank > 0)
        return;
    job->failed = true;
    job->err = err;
}

static bool run_ranks(simulated_job *job, const char *path, duet_error *err)
{
    if (!smpi_run(path, (int)job->args.ranks, run_rank, job, err))
        return false;
    if (job->failed)
        *err = job->err;
    return !job->failed;
}

static bool run(void *given, char **operands, duet_error *err)
{
    simulated_job *job = given;
    platform_file made = {.file = -1};
    bool is_run = names_run(job->args.simulate);
    job->scene = operands[0];
    bool ok = read_times(job, err) && (!is_run || make_platform(job, &made, err)) &&
              run_ranks(job, is_run ? made.path : job->args.simulate, err);
    platform_close(&made);
    stored_run_end(&job->run);
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
