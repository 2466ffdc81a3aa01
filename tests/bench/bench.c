// SPDX-License-Identifier: MIT
// duet_bench NAME [--n N] [--runs K] [--seed S] [--device D] [--pair A,B] [--task T]
// [--strategy S] [--seconds S] [--verify]
#include "bench.h"

#include "base/error.h"
#include "runtime/scene/reference.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct {
    const char *name;
    bench_run *run;
    const char *about;
} benches[] = {
    {"candidates", bench_candidates, "merged rows against the paper's search, on one device"},
    {"share", bench_share, "two devices against the better one, each way to split"},
    {"step", bench_step, "a whole step against the AVX2 program and the paper's kernels"},
    {"still", bench_still, "what effects cost a scene that calls for none"},
    {"growth", bench_growth, "time an object, up to --n objects"},
#ifdef BENCH_AVX2
    {"limit", bench_limit, "the AVX2 program alone, stage by stage"},
#endif
    {"commands", bench_commands,
     "bodies that come and go before each step, and the same only woken"},
    {"cost", bench_cost, "processor time and instructions of a step of six scenes, for .ci/cost"},
    {"generate", bench_generate, "the text of each kernel, and its number of configs"},
    {"lookup", bench_lookup, "opening the profile store and looking up, with --n profiles in it"},
    {"loss", bench_loss,
     "plans that are looked up beside fresh tunings, at --runs sizes around --n"},
    {"join", bench_join, "a hundredth of the paper's scene against all of it, and a step of both"},
    {"cells", bench_cells, "the order of the paper's scene by cell alone"},
    {"order", bench_order, "objects at random and in order, on one device and two"},
    {"rays", bench_rays, "a tree over the paper's scene, and as many rays through it"},
    {"spheres", bench_spheres,
     "a million equal spheres, and as many unrotated cubes in their places"},
    {"tune", bench_tune, "searches for the share on this machine, one device slowed down"},
    {"tasks", bench_tasks,
     "kernels and share of the example tasks, by each strategy and by all plans"},
    {"strategies", bench_strategies, "searches for the share on invented device pairs"},
};

enum { N_BENCHES = sizeof benches / sizeof benches[0] };

duet_device_pair *bench_pair(const bench_options *options, duet_error *err)
{
    duet_device_pair_def def = duet_default_device_pair_def();
    if (options->device_a) {
        def.a = options->device_a;
        def.b = options->device_b;
    }
    return duet_device_pair_create(&def, err);
}

duet_pose *bench_poses(uint32_t n, const bench_options *options, duet_error *err)
{
    duet_pose *poses = paper_poses(n, options->seed);
    if (!poses)
        error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u objects", n);
    return poses;
}

static uint64_t spans_hash(const duet_span *spans, uint32_t n_spans, uint64_t *n_pairs)
{
    uint64_t hash = 0;
    *n_pairs = 0;
    for (uint32_t i = 0; i < n_spans; ++i) {
        hash += duet_pairs_hash(spans[i].pairs, spans[i].n);
        *n_pairs += spans[i].n;
    }
    return hash;
}

bool bench_verify(const duet_pose *poses, uint32_t n, const duet_span *spans, uint32_t n_spans,
                  duet_error *err)
{
    reference_objects objects = {.dims = 3, .shape = DUET_SHAPE_POSES, .n = n, .poses = poses};
    reference_found found = {0};
    if (!reference_find(&objects, REFERENCE_COLUMNS, &found, err))
        return false;
    uint64_t n_pairs;
    uint64_t hash = spans_hash(spans, n_spans, &n_pairs);
    uint64_t expected = duet_pairs_hash(found.pairs, found.n);
    duet_free(found.pairs);
    if (n_pairs != found.n || hash != expected)
        return error_set(err, DUET_STATUS_WRONG_RESULT,
                         "%" PRIu64 " pairs with hash %016" PRIx64 ", the reference finds %" PRIu64
                         " with %016" PRIx64,
                         n_pairs, hash, found.n, expected);
    printf("verified: %" PRIu64 " pairs, hash %016" PRIx64 "\n", n_pairs, hash);
    return true;
}

static int usage(void)
{
    fprintf(stderr, "usage: duet_bench NAME [--n N] [--runs K] [--seed S] [--device D] "
                    "[--pair A,B] [--task T] [--strategy S] [--seconds S] [--verify]\n");
    for (int i = 0; i < N_BENCHES; ++i)
        fprintf(stderr, "  %-10s %s\n", benches[i].name, benches[i].about);
    return 2;
}

// A whole number of at least `least`; false for anything else.
static bool read_number(const char *text, uint64_t least, uint64_t most, uint64_t *number)
{
    char *end = NULL;
    *number = text ? strtoull(text, &end, 10) : 0;
    return text && *text >= '0' && *text <= '9' && !*end && *number >= least && *number <= most;
}

static bool read_pair(char *text, bench_options *options)
{
    char *comma = text ? strchr(text, ',') : NULL;
    if (!comma)
        return false;
    *comma = '\0';
    options->device_a = text;
    options->device_b = comma + 1;
    return true;
}

// --name and its value; false where either is wrong.
static bool read_option(const char *name, char *value, bench_options *options)
{
    uint64_t number = 0;
    if (strcmp(name, "--pair") == 0)
        return read_pair(value, options);
    if (strcmp(name, "--device") == 0) {
        options->device = value;
        return value != NULL;
    }
    if (strcmp(name, "--task") == 0) {
        options->task = value;
        return value != NULL;
    }
    if (strcmp(name, "--strategy") == 0) {
        options->strategy = value;
        return value != NULL;
    }
    if (strcmp(name, "--seed") == 0)
        return read_number(value, 0, UINT64_MAX, &options->seed);
    if (strcmp(name, "--n") == 0 && read_number(value, 1, 1u << 26, &number)) {
        options->n = (uint32_t)number;
        return true;
    }
    if (strcmp(name, "--seconds") == 0 && read_number(value, 1, 1u << 20, &number)) {
        options->seconds = (double)number;
        return true;
    }
    if (strcmp(name, "--runs") == 0 && read_number(value, 1, SERIES_ROOM, &number)) {
        options->runs = (uint32_t)number;
        return true;
    }
    return false;
}

static bool read_options(char **words, bench_options *options)
{
    for (; *words; ++words) {
        if (strcmp(*words, "--verify") == 0)
            options->verify = true;
        else if (read_option(words[0], words[1], options))
            ++words;
        else
            return false;
    }
    return true;
}

int main(int argc, char **argv)
{
    bench_options options = {.device = "pocl:0", .runs = 21, .seed = 1};
    if (argc < 2 || !read_options(argv + 2, &options))
        return usage();
    for (int i = 0; i < N_BENCHES; ++i) {
        if (strcmp(argv[1], benches[i].name) != 0)
            continue;
        duet_error err = {0};
        if (benches[i].run(&options, &err))
            return 0;
        fprintf(stderr, "duet_bench %s: %s\n", argv[1], err.text);
        return 1;
    }
    return usage();
}
