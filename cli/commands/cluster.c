// SPDX-License-Identifier: MIT
// duet cluster: finds all pairs of a scene on the ranks of an MPI job. The program duet itself
// knows nothing of MPI: each rank becomes duet-cluster, which lies beside it.
#define _POSIX_C_SOURCE 200809L
#include "cli/commands/cluster.h"

#include "base/error.h"
#include "base/text.h"
#include "cli/commands.h"
#include "cli/interrupt.h"
#include "cli/say.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

typedef cluster_arguments arguments;

static const option options[] = {
    SCENE_OPTION_ROWS(scene),
    OPTION_COUNT("ranks", ranks, "R", "start R ranks on this machine by mpirun", 1, 65536),
    OPTION_TEXT("hosts", hosts, "H,H", "start the ranks on these machines, by ssh (this one)"),
    OPTION_TEXT("weights", weights, "W,W",
                "part of the objects of each rank, one number each (by its profile)"),
    OPTION_COUNT("parts", parts, "K",
                 "divide each rank's objects into K parts: its devices hold two at a time (1)", 1,
                 1024),
    OPTION_TEXT("pair", pair, "A,B",
                "two devices of each rank (its part of its machine's devices)"),
    OPTION_FLAG("plain", plain, "use no devices but the plain C reference"),
    PLAN_OPTION_ROWS(plan),
    OPTION_TEXT("level", level, "L",
                "level of accuracy: certified, aabb, sphere, sat6, sat15 or double (the scene's)"),
    OPTION_COUNT("repeat", repeat, "K", "steps that are timed, after one to warm up (5)", 1,
                 100000),
    OPTION_COUNT("steps", steps, "K", "advance a moving scene to step K", 1, 1000000000),
    OPTION_FLAG("tune-colours", tune_colours,
                "find how often ghosts come best, and keep it for such ranks"),
    OPTION_FLAG("phases", phases, "tell what the phases of a step take on rank 0"),
    OPTION_LATER("picture", picture, "F.png", "draw the scene after the last step, on rank 0"),
    OPTION_TEXT("frames", frames, "DIR", "write 30 frames a second of the scene"),
    OPTION_TEXT("format", format, "F",
                "what frames are: vtu, which ParaView opens, or png, drawn on rank 0"),
    OPTION_LATER("checkpoint", checkpoint, "F", "save the bodies in file F after the steps"),
    OPTION_COUNT("every", every, "K", "save them after each K steps, too", 1, 1000000000),
    OPTION_TEXT("resume", resume, "F",
                "go on from file F, of any number of ranks, to step --steps"),
    OPTION_INPUT("replay", replay, "F.replay",
                 "replay recorded commands, and compare the hash; rank 0 reads F.replay"),
    OPTION_FLAG("resident", resident, "leave the objects where they are between the steps"),
    OPTION_LATER("pairs", pairs_path, "P.npy", "write the pairs of all ranks into one file"),
    OPTION_FLAG("sorted", sorted, "write them ascending: the same bytes for any number of ranks"),
    OPTION_FLAG("check", check,
                "compare pairs with the plain C reference, or each step with one motion"),
    OPTION_INPUT("simulate", simulate, "P.xml",
                 "simulate the ranks, with the plain C reference, on SimGrid's platform"),
    OPTION_TEXT("profile", profile, "UID",
                "search nothing, and take the time of this profile of the store"),
    OPTION_COUNT("stands-for", stands_for, "K", "count each object as K of a larger scene (1)", 1,
                 1000000),
    OPTION_FLAG("verbose", verbose, "show what mpirun says of a rank that fails, too"),
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

static const option_rule rules[] = {
    {"hosts verbose simulate", OPTION_NEEDS, "ranks"},
    {"sorted", OPTION_NEEDS, "pairs"},
    {"every", OPTION_NEEDS, "checkpoint"},
    {"checkpoint resume picture frames tune-colours replay phases", OPTION_NEEDS, "steps"},
    {"share mode variant variant-a variant-b", OPTION_EXCLUDES, "tune-colours"},
    {"frames", OPTION_NEEDS, "format"},
    {"format", OPTION_NEEDS, "frames"},
    {"frames", OPTION_EXCLUDES, "resume"},
    {"profile", OPTION_NEEDS, "simulate"},
    {"stands-for", OPTION_NEEDS, "profile"},
    {"pair share mode variant variant-a variant-b", OPTION_EXCLUDES, "plain"},
    {"pair share mode variant variant-a variant-b hosts verbose", OPTION_EXCLUDES, "simulate"},
    {"check pairs", OPTION_EXCLUDES, "profile"},
    {"repeat resident pairs level weights plain simulate", OPTION_EXCLUDES, "steps"},
    {0},
};

static const char *refuse(const void *given, char **operands)
{
    const arguments *args = given;
    size_t length = args->pairs_path ? strlen(args->pairs_path) : 0;
    (void)operands;
    if (args->hosts && !*args->hosts)
        return "--hosts: expected names of machines, as one,two";
    if (args->picture && !text_ends_with(args->picture, ".png"))
        return "--picture: the name of a run's picture ends with .png";
    if (args->format && strcmp(args->format, "vtu") != 0 && strcmp(args->format, "png") != 0)
        return "--format: give vtu (bodies for ParaView) or png (pictures)";
    return args->pairs_path && (length < 5 || strcmp(args->pairs_path + length - 4, ".npy") != 0)
               ? "--pairs: expected a file whose name ends in .npy"
               : NULL;
}

const command_line cluster_line = {
    .name = "cluster",
    .operands = "SCENE|FILE",
    .about = "Finds all pairs of boxes that collide, on all ranks of an MPI job: each rank\n"
             "finds those of its part of the world on devices of its own. The pairs, and\n"
             "their hash, are those of 'duet run' at any number of ranks. With --steps\n"
             "bodies move, and their state hash is that of 'duet run --steps'. On several\n"
             "machines, or by another launcher: mpirun -np 4 duet cluster SCENE.",
    .options = options,
    .rules = rules,
    .refuse = refuse,
};

// ---------------------------------------------------------------- the job

static bool read_variable(const char *name, unsigned long *number)
{
    const char *value = getenv(name);
    char *end = NULL;
    if (!value || !*value)
        return false;
    *number = strtoul(value, &end, 10);
    return *end == '\0';
}

// The variables by which Open MPI and MPICH, and with it Slurm, tell their processes.
bool cluster_job(unsigned long *rank, unsigned long *n_ranks)
{
    return (read_variable("OMPI_COMM_WORLD_SIZE", n_ranks) &&
            read_variable("OMPI_COMM_WORLD_RANK", rank)) ||
           (read_variable("PMI_SIZE", n_ranks) && read_variable("PMI_RANK", rank));
}

// ---------------------------------------------------------------- becoming it

typedef struct beside {
    const char *name;
    const char *lacking; // the message if it is not there
} beside;

static const beside rank_program = {
    "duet-cluster",
    "this Duet was built without MPI, or its package duet-cluster is not installed"};
static const beside simulating_program = {"duet-simulate", "this Duet was built without SimGrid"};

static bool find_beside(text *path, const beside *program, duet_error *err)
{
    char own[4096];
    ssize_t n = readlink("/proc/self/exe", own, sizeof own - 1);
    if (n < 0)
        return error_set(err, DUET_STATUS_IO_FAILED, "/proc/self/exe: %s", strerror(errno));
    own[n] = '\0';
    const char *slash = strrchr(own, '/');
    text_add(path, "%.*s/%s", slash ? (int)(slash - own) : 0, own, program->name);
    if (!text_ok(path, err))
        return false;
    return access(path->chars, X_OK) == 0 ||
           error_set(err, DUET_STATUS_NOT_FOUND, "%s: %s; %s", path->chars, strerror(errno),
                     program->lacking);
}

static int count(char *const *words)
{
    int n = 0;
    while (words[n])
        ++n;
    return n;
}

// The words of `begin` and then those of `end`; each ends with NULL.
static char **join(char *const *begin, char *const *end, duet_error *err)
{
    const int n = count(begin), more = count(end);
    char **argv = calloc((size_t)(n + more + 1), sizeof *argv);
    if (!argv)
        return null_no_memory(err, "the command line");
    memcpy(argv, begin, (size_t)n * sizeof *argv);
    memcpy(argv + n, end, (size_t)more * sizeof *argv);
    return argv;
}

typedef struct launch {
    arguments args; // first: the table of options fills it
    const char *scene;
    char **argv;
    int status; // the status of ranks that have told why
} launch;

// Comes back only where it fails.
static bool become(const launch *l, const beside *what, duet_error *err)
{
    text program = {0};
    bool found = find_beside(&program, what, err);
    char *begin[] = {program.chars, NULL};
    char **argv = found ? join(begin, l->argv + 1, err) : NULL;
    if (argv) {
        interrupt_pass(true);
        execv(program.chars, argv);
        error_set(err, DUET_STATUS_IO_FAILED, "%s: %s", program.chars, strerror(errno));
    }
    free(argv);
    text_free(&program);
    return false;
}

// Also as /dev/stdin.
static bool is_stdin(const char *path)
{
    struct stat named, own;
    return strcmp(path, "-") == 0 || (stat(path, &named) == 0 && fstat(STDIN_FILENO, &own) == 0 &&
                                      named.st_dev == own.st_dev && named.st_ino == own.st_ino);
}

static bool run_by_mpirun(mpirun_job *job, uint64_t ranks, char *program, char *const *words,
                          int *status, duet_error *err)
{
    char mpirun[] = "mpirun", flag[] = "-n", number[24];
    char host[] = "--host", map[] = "--map-by", node[] = "node", send[] = "-x";
    char started[] = MPIRUN_STARTED, *hosts = (char *)job->hosts;
    char *here[] = {mpirun, flag, number, program, NULL};
    char *there[] = {mpirun, flag, number, host, hosts, map, node, send, started, program, NULL};
    snprintf(number, sizeof number, "%llu", (unsigned long long)ranks);
    job->argv = join(hosts ? there : here, words, err);
    bool ok = job->argv && mpirun_run(job, status, err);
    free(job->argv);
    job->argv = NULL;
    return ok;
}

bool cluster_run(mpirun_job *job, uint64_t ranks, char *const *words, int *status, duet_error *err)
{
    text program = {0};
    bool ok = find_beside(&program, &rank_program, err) &&
              run_by_mpirun(job, ranks, program.chars, words, status, err);
    text_free(&program);
    return ok;
}

static bool start(launch *l, duet_error *err)
{
    mpirun_job job = {.hosts = l->args.hosts, .verbose = l->args.verbose};
    if (l->args.simulate)
        return become(l, &simulating_program, err);
    if (l->args.ranks == 0)
        return become(l, &rank_program, err);
    job.reads_stdin = is_stdin(l->scene);
    return cluster_run(&job, l->args.ranks, l->argv + 1, &l->status, err);
}

bool cluster_may_start(duet_error *err)
{
    unsigned long rank = 0, n_ranks = 0;
    return !cluster_job(&rank, &n_ranks) ||
           bad_argument(err,
                        "--ranks: this is rank %lu of %lu of an MPI job already; expected one of "
                        "mpirun and --ranks",
                        rank, n_ranks);
}

static bool run(void *given, char **operands, duet_error *err)
{
    launch *l = given;
    duet_plan plan = duet_default_plan(NULL);
    duet_level level;
    l->scene = operands[0];
    return (l->args.ranks == 0 || cluster_may_start(err)) &&
           inputs_change_plan(&l->args.plan, NULL, NULL, &plan, err) &&
           inputs_read_level(l->args.level, &level, err) && start(l, err);
}

// options_run moves the operands together in argv, and the ranks need it as it was. Rank 0
// says what is wrong with it; the others hear of it when that one ends.
int command_cluster(int argc, char **argv)
{
    unsigned long rank = 0, n_ranks = 0;
    duet_error err = {0};
    launch l = {.args = CLUSTER_ARGUMENTS_DEFAULT};
    l.argv = calloc((size_t)argc + 1, sizeof *l.argv);
    if (!l.argv) {
        no_memory(&err, "the command line");
        return say_failed(&err);
    }
    memcpy(l.argv, argv, (size_t)argc * sizeof *argv);
    bool is_later = cluster_job(&rank, &n_ranks) && rank > 0;
    int status = is_later ? EXIT_FAILED : options_run(&cluster_line, argc, argv, &l, run);
    if (is_later && !start(&l, &err))
        status = say_failed(&err);
    free(l.argv);
    return status == EXIT_OK ? l.status : status;
}
