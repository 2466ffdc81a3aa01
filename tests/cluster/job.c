// SPDX-License-Identifier: MIT
#include "cluster/job.h"

#include "base/text_file.h"

#include <inttypes.h>

#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#define IGNORE_LEAKS(call) (__lsan_disable(), call, __lsan_enable())
#define FIND_LEAKS() __lsan_do_leak_check()
#else
#define IGNORE_LEAKS(call) call
#define FIND_LEAKS() (void)0
#endif

int rank;
uint64_t job_seed;
duet_error rank_error;

enum { MOST_FACTS = 60 };

static struct {
    const char *name;
    void (*show)(void);
    bool of_one;
} facts[MOST_FACTS];
static int n_facts;
static const char *showing = "";

void end_job(const char *fact, const char *file, int line, const char *why)
{
    fprintf(stderr, "rank %d, %s:%d: %s %s: %s\n", rank, file, line, showing, fact, why);
    MPI_Abort(MPI_COMM_WORLD, 1);
    abort();
}

uint64_t job_begin(int *argc, char ***argv, int n_ranks, uint64_t seed)
{
    const char *given = getenv("DUET_TEST_SEED");
    int n = 0;
    IGNORE_LEAKS(MPI_Init(argc, argv));
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &n);
    MUST(n == n_ranks, "another number of ranks is expected");
    job_seed = given ? strtoull(given, NULL, 10) : seed;
    if (rank == 0)
        printf("DUET_TEST_SEED=%" PRIu64 "\n", job_seed);
    return job_seed;
}

int job_end(const char *says)
{
    if (rank == 0)
        printf("%s\n", says);
    FIND_LEAKS(); // before MPI ends, which forgets some memory of its own
    MPI_Finalize();
    return 0;
}

void job_add(const char *name, void (*show)(void), bool of_one)
{
    if (n_facts == MOST_FACTS)
        abort();
    facts[n_facts].name = name;
    facts[n_facts].show = show;
    facts[n_facts++].of_one = of_one;
}

static void show_facts(bool of_one)
{
    for (int i = 0; i < n_facts; ++i)
        if (facts[i].of_one == of_one && (rank == 0 || !of_one)) {
            showing = facts[i].name;
            facts[i].show();
        }
}

int job_run(int *argc, char ***argv, int n_ranks, uint64_t seed, const char *says)
{
    job_begin(argc, argv, n_ranks, seed);
    show_facts(true);
    show_facts(false);
    return job_end(says);
}

duet_cluster *cluster_of(int n, duet_cluster_def def)
{
    MPI_Comm comm = MPI_COMM_SELF;
    if (n != ALONE)
        MPI_Comm_split(MPI_COMM_WORLD, rank < n ? 0 : MPI_UNDEFINED, rank, &comm);
    if (comm == MPI_COMM_NULL)
        return NULL;
    def.comm = &comm;
    duet_cluster *c = must(duet_cluster_create(&def, ERR));
    if (n != ALONE)
        MPI_Comm_free(&comm); // the cluster has a copy
    return c;
}

void job_write(const char *path, const char *content)
{
    if (rank == 0)
        must(text_write_file(path, content, strlen(content), ERR));
    MPI_Barrier(MPI_COMM_WORLD);
}

void job_remove(const char *path)
{
    MPI_Barrier(MPI_COMM_WORLD);
    if (rank == 0)
        remove(path);
}
