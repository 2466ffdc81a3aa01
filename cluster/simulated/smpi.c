// SPDX-License-Identifier: MIT
#define _GNU_SOURCE // memfd_create, strverscmp
#include "cluster/simulated/smpi.h"

#include "base/error.h"

#include <errno.h>
#include <mpi.h>
#include <simgrid/actor.h>
#include <simgrid/engine.h>
#include <simgrid/host.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>
#include <xbt/config.h>
#include <xbt/log.h>

static void (*rank_body)(void *context);
static void *rank_context;

static void run_rank(int argc, char **argv)
{
    MPI_Init(&argc, &argv);
    rank_body(rank_context);
    MPI_Finalize();
}

// The times of messages are the platform's; no processor time of this machine is added. SimGrid
// does as Open MPI does, except for a broadcast, which is a binomial tree: SimGrid's own choice has
// each rank tell all others first where it is, and at a thousand ranks that is most of the work.
static void begin_simgrid(const char *platform)
{
    char name[] = "duet", *argv[] = {name, NULL};
    int argc = 1;
    xbt_log_control_set("root.thres:error");
    xbt_log_control_set("root.fmt:%m%n");
    simgrid_init(&argc, argv);
    smpi_init_options();
    sg_cfg_set_string("smpi/privatization", "no");
    sg_cfg_set_boolean("smpi/simulate-computation", "no");
    sg_cfg_set_string("smpi/host-speed", "1Gf");
    sg_cfg_set_string("smpi/coll-selector", "ompi");
    sg_cfg_set_string("smpi/bcast", "binomial_tree");
    sg_cfg_set_string("smpi/shared-malloc", "global");
    SMPI_init();
    simgrid_load_platform(platform);
}

static int by_name(const void *left, const void *right)
{
    return strverscmp(sg_host_get_name(*(const sg_host_t *)left),
                      sg_host_get_name(*(const sg_host_t *)right));
}

// The platform's, to be freed; ranks are dealt out to them in turn.
static sg_host_t *list_hosts(size_t *n)
{
    sg_host_t *hosts = sg_host_list();
    *n = sg_host_count();
    qsort(hosts, *n, sizeof(sg_host_t), by_name);
    return hosts;
}

// ---------------------------------------------------------------- whether it is sound

// Returns whether the route has links: its least bandwidth is below 0 if it has none.
static bool has_route(sg_host_t from, sg_host_t to)
{
    return sg_host_get_route_bandwidth(from, to) > 0;
}

// Routes are tried to this many others, and so between every pair of hosts if there are few hosts.
// Many hosts try fewer routes each, because some platforms search all of their links for each
// route.
enum { ROUTES_A_HOST = 16, ROUTES_IN_ALL = 4096 };

static size_t n_tried; // ranks whose hosts' routes are tried

static size_t routes_a_host(size_t n)
{
    size_t most = ROUTES_IN_ALL / (n + 1) + 1;
    return most < ROUTES_A_HOST ? most : ROUTES_A_HOST;
}

// An actor's, for a platform is complete only once it runs.
static void try_routes(int argc, char **argv)
{
    size_t n = 0;
    sg_host_t *hosts = list_hosts(&n);
    (void)argc, (void)argv;
    n = n < n_tried ? n : n_tried;
    for (size_t i = 0; i < n; ++i)
        for (size_t k = 0; k < i && k < routes_a_host(n); ++k)
            if (!has_route(hosts[i], hosts[k]) || !has_route(hosts[k], hosts[i])) {
                fprintf(stderr, "no route leads from %s to %s and back\n",
                        sg_host_get_name(hosts[k]), sg_host_get_name(hosts[i]));
                _exit(1);
            }
    free(hosts);
}

// SimGrid ends a process that reads a wrong platform, and says why on stderr.
_Noreturn static void try_platform(const char *platform, int n_ranks, int told)
{
    dup2(told, STDERR_FILENO);
    begin_simgrid(platform);
    size_t n = 0;
    sg_host_t *hosts = list_hosts(&n);
    if (n == 0) {
        fputs("it has no hosts\n", stderr);
        _exit(1);
    }
    n_tried = (size_t)n_ranks;
    sg_actor_create("routes", hosts[0], try_routes, 0, NULL);
    simgrid_run();
    _exit(0);
}

static void read_reason(int from, char *reason, size_t size)
{
    FILE *lines = fdopen(from, "r");
    if (!lines || !fgets(reason, (int)size, lines))
        snprintf(reason, size, "it ends SimGrid without a word");
    reason[strcspn(reason, "\n")] = '\0';
    if (lines)
        fclose(lines);
}

static bool check_platform(const char *platform, int n_ranks, duet_error *err)
{
    int told[2], status = 0;
    char reason[256] = "";
    if (access(platform, R_OK) != 0)
        return error_set(err, DUET_STATUS_NOT_FOUND, "%s: %s", platform, strerror(errno));
    if (pipe(told) != 0)
        return error_set(err, DUET_STATUS_IO_FAILED, "a pipe: %s", strerror(errno));
    pid_t child = fork();
    if (child == 0)
        try_platform(platform, n_ranks, told[1]);
    close(told[1]);
    bool ran = child > 0 && waitpid(child, &status, 0) == child;
    read_reason(told[0], reason, sizeof reason);
    return (ran && status == 0) ||
           bad_input(err, "%s: no platform of SimGrid: %s", platform, reason);
}

// ---------------------------------------------------------------- ranks

// SimGrid takes ranks from a file alone.
static bool deploy(int n, duet_error *err)
{
    char path[64];
    int file = memfd_create("ranks", MFD_CLOEXEC);
    FILE *lines = file >= 0 ? fdopen(file, "w") : NULL;
    if (!lines)
        return error_set(err, DUET_STATUS_IO_FAILED, "the list of %d ranks: %s", n,
                         strerror(errno));
    size_t n_hosts = 0;
    sg_host_t *hosts = list_hosts(&n_hosts);
    fputs("<!DOCTYPE platform SYSTEM \"https://simgrid.org/simgrid.dtd\">\n"
          "<platform version=\"4.1\">\n",
          lines);
    for (int i = 0; i < n; ++i)
        fprintf(lines,
                "<actor host=\"%s\" function=\"duet\"><prop id=\"instance_id\" value=\"duet\"/>"
                "<prop id=\"rank\" value=\"%d\"/></actor>\n",
                sg_host_get_name(hosts[(size_t)i % n_hosts]), i);
    fputs("</platform>\n", lines);
    fflush(lines);
    snprintf(path, sizeof path, "/proc/self/fd/%d", file);
    simgrid_load_deployment(path);
    fclose(lines);
    free(hosts);
    return true;
}

bool smpi_run(const char *platform, int n, void (*body)(void *context), void *context,
              duet_error *err)
{
    if (!check_platform(platform, n, err))
        return false;
    rank_body = body;
    rank_context = context;
    begin_simgrid(platform);
    SMPI_app_instance_register("duet", run_rank, n);
    if (!deploy(n, err))
        return false;
    simgrid_run();
    SMPI_finalize();
    return true;
}

void smpi_pass(double seconds)
{
    sg_actor_sleep_for(seconds);
}

void *smpi_ballast(uint64_t bytes)
{
    return SMPI_SHARED_MALLOC(bytes);
}
