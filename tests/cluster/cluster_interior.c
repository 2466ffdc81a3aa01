// SPDX-License-Identifier: MIT
// A device finds what lies inside a box for a rank: it passes over nothing that the host must look
// at, and ranks whose devices do so find the pairs of ranks whose devices do not. The CPU's parts
// here are told that they have memory of their own.
#include "cluster/cluster.h"
#include "cluster/job.h"
#include "cluster/worker_pair.h"

#include "base/error.h"
#include "base/rng.h"
#include "runtime/broadphase/world.h"
#include "runtime/opencl/device_pair.h"

#include <float.h>
#include <inttypes.h>
#include <math.h>

enum { N = 9000, MANY = 40000 };

static duet_device_pair *devices;

static void open_devices(void)
{
    devices = must(duet_device_pair_open(NULL, ERR));
    devices->devices[0].info.host_memory = devices->devices[1].info.host_memory = false;
}

// ---------------------------------------------------------------- one device

static const extent inside = {{-2.5, -2.25, -3}, {2.5, 3.1, 2.7}};

// Few of them are any number that there is.
static float some_number(rng *r, double likely)
{
    const float odd[] = {NAN,      INFINITY, -INFINITY, -0.0f,  1e-40f, -1e-40f, FLT_MAX,
                         -FLT_MAX, 1e-25f,   1e25f,     2.5f,   2.7f,   -2.25f,  0.0f,
                         -3.0f,    -FLT_MIN, 3.1f,      1e-16f, 1e16f,  -1.0f};
    return rng_below(r, 150) > 0 ? (float)likely : odd[rng_below(r, sizeof odd / sizeof *odd)];
}

// A coordinate promised not to count in 2D is any number too. Some are all so small that float
// squares of them vanish.
static void make_row(rng *r, const object_form *form, bool is_small, float *row)
{
    float from[3], half[3];
    for (int k = 0; k < 3; ++k) {
        from[k] = some_number(r, rng_between(r, -4, 4));
        half[k] = some_number(r, rng_below(r, 9) ? rng_between(r, 0, 1) : 0);
    }
    for (int k = 0; k < 3; ++k) {
        row[k] = from[k];
        row[3 + k] = form->shape == DUET_SHAPE_POSES ? half[k] : some_number(r, from[k] + half[k]);
    }
    for (int k = 6; form->shape == DUET_SHAPE_POSES && k < 10; ++k)
        row[k] = rng_below(r, 200) ? some_number(r, rng_normal(r)) : 0.0f;
    for (int k = 0; is_small && k < 6; ++k)
        row[k] *= 1e-24f;
}

static bool is_between(double lower, double x, double upper)
{
    return lower < x && x < upper;
}

// Each object passed over is sound, lies inside, and is in what is known of its block.
static void must_be_deep(const object_form *form, const float *row, const interior_block *block)
{
    double at[3];
    interior all = interior_none;
    interior_add_block(&all, block);
    object_centre(form, row, at);
    extent e = extent_of(form, row);
    MUST(object_is_sound(form, row), "sound");
    for (uint32_t k = 0; k < form->dims; ++k)
        MUST(is_between(inside.lower[k], at[k], inside.upper[k]) && at[k] >= all.centres.lower[k] &&
                 at[k] <= all.centres.upper[k],
             "inside");
    MUST(extent_widest(&e) <= interior_widest(&all, form), "no wider than is said");
}

// Whether float must see that it is deep inside: the host does, bounds are inside as a whole, and
// the numbers are neither very small nor very large.
static bool is_plainly_deep(const object_form *form, const float *row)
{
    const object_rows one = {.objects = (void *)(uintptr_t)row, .n = 1};
    interior s = interior_none;
    float lower[3], upper[3];
    interior_box(&inside, lower, upper);
    if (object_rows_add_interior(&one, form, 0, 1, &inside, &s) != 1)
        return false;
    for (uint32_t k = 0; k < form->dims; ++k)
        if (form->shape == DUET_SHAPE_BOUNDS && !(row[k] > lower[k] && row[3 + k] < upper[k]))
            return false;
    return is_between(0x1p-99, s.square, 0x1p99);
}

static void a_device_passes_over_what_the_host_would(rng *r, uint32_t dims, duet_shape shape,
                                                     const char *plan)
{
    duet_world_def def = duet_default_world_def();
    def.pair = devices;
    def.dims = dims;
    def.shape = shape;
    def.rotated = shape == DUET_SHAPE_POSES;
    def.plan = (duet_plan){.mode = DUET_MODE_OWN};
    strcpy(def.plan.variant_a, plan);
    strcpy(def.plan.variant_b, plan);
    duet_world *world = must(duet_world_create(&def, ERR));
    world->parts[1].least_chunk = 1;

    object_form form = object_form_of(&def);
    uint32_t words = form.bytes / (uint32_t)sizeof(float), deep = 0, plain = 0, n_odd = 0,
             chunks = 0;
    duet_result result;
    float lower[3], upper[3],
        *rows = must(duet_world_map_objects(world, object_form_kind(&form), 1, ERR));
    for (uint32_t k = 0; k < words; ++k)
        rows[k] = k > 2; // whatever it is, so that kernels are there
    must(duet_world_step(world, &result, ERR));
    rows = must(duet_world_map_objects(world, object_form_kind(&form), N, ERR));
    for (uint32_t i = 0; i < N; ++i)
        make_row(r, &form, i / INTERIOR_ROWS == 1, rows + (size_t)i * words);
    interior_box(&inside, lower, upper);
    MUST(!world_find_interior(world, lower, upper), "nothing was sent ahead");
    world_prefetch(world, N);
    for (int again = 0; again < 2; ++again) { // any number of times
        const interior_block *blocks = NULL;
        MUST(world_find_interior(world, lower, upper), "it looks");
        for (uint32_t from = 0; from < N; ++chunks)
            from = world_await_interior(world, from, &blocks);
        deep = plain = n_odd = 0;
        for (uint32_t i = 0; i < N; ++i) {
            const float *row = rows + (size_t)i * words;
            bool is_odd = blocks[i / INTERIOR_ROWS].odd[i % INTERIOR_ROWS / 32] >> i % 32 & 1;
            bool is_plain = is_plainly_deep(&form, row);
            if (!is_odd)
                must_be_deep(&form, row, &blocks[i / INTERIOR_ROWS]);
            MUST(!is_odd || !is_plain, "what is plainly deep is passed over");
            deep += !is_odd;
            plain += is_plain;
        }
        for (uint32_t b = 0; b <= (N - 1) / INTERIOR_ROWS; ++b)
            n_odd += blocks[b].n_odd;
    }
    MUST(chunks == 2 * world->parts[1].objects.n_chunks && chunks > 4, "they come in chunks");
    MUST(n_odd == N - deep, "odd ones are counted");
    MUST(plain > 500 && deep < N - 2000, "some are, and some are not");
    world_cancel_prefetch(world);
    MUST(!world_find_interior(world, lower, upper), "nothing is sent ahead any more");
    duet_world_destroy(world);
}

// ---------------------------------------------------------------- memory

static bool lacks_memory;

bool __real_host_block_reserve(host_block *h, const device of[], int n, size_t size,
                               duet_error *err);
bool __wrap_host_block_reserve(host_block *h, const device of[], int n, size_t size,
                               duet_error *err);

// Does as a list with no more memory: the old block is gone.
bool __wrap_host_block_reserve(host_block *h, const device of[], int n, size_t size,
                               duet_error *err)
{
    if (!lacks_memory || (h->bytes && h->size >= size))
        return __real_host_block_reserve(h, of, n, size, err);
    host_block_release(h);
    return error_set(err, DUET_STATUS_NO_MEMORY, "none for now");
}

static void must_count_up(const void *rows, uint32_t n)
{
    for (uint32_t i = 0; i < n; ++i)
        MUST(((const duet_pose *)rows)[i].centre[0] == (float)i, "each is there");
}

// Kept objects stay, whether there is memory for more or not.
static void a_worker_keeps_its_objects(void)
{
    duet_world_def def = duet_default_world_def();
    def.pair = devices;
    worker *w = must(worker_open_pair(&def, ERR));
    duet_pose *rows = must(w->extend(w, N, 0, ERR));
    for (uint32_t i = 0; i < N; ++i)
        rows[i] = (duet_pose){.centre = {(float)i}};
    for (int again = 0; again < 2; ++again) {
        lacks_memory = true;
        must_fail(w->extend(w, MANY, N, ERR), DUET_STATUS_NO_MEMORY, "none for now");
        MUST(strcmp(ERR->text, "none for now") == 0, ERR->text);
        must_count_up(rows, N);
        MUST(w->map(w, N, NULL) == rows, "where they were");
        lacks_memory = false;
    }
    rows = must(w->extend(w, MANY, N, ERR));
    must_count_up(rows, N);
    w->close(w);
}

// ---------------------------------------------------------------- ranks

static duet_cluster *open_cluster(int n_ranks, bool looks, uint32_t n_parts)
{
    duet_cluster_def def = duet_default_cluster_def();
    def.plain = !looks;
    def.weight = 1;
    def.parts = n_parts;
    def.imbalance = 1.5;
    def.world.pair = looks ? devices : NULL;
    def.world.plan.share = 0;
    def.world.plan.mode = DUET_MODE_OWN;
    return cluster_of(n_ranks, def);
}

static worker_pair *worker_of(duet_cluster *c)
{
    return (worker_pair *)c->workers[0];
}

static float size = 1; // size of the objects that are handed over

// Rank 0 brings all.
static void hand_over(duet_cluster *c, uint32_t n, uint64_t seed)
{
    static duet_pose poses[MANY];
    static uint64_t ids[MANY];
    rng r = rng_seed(seed);
    for (uint32_t i = 0; i < n; ++i) {
        ids[i] = i;
        poses[i] = (duet_pose){.half_extents = {0.5f * size, 0.3f * size, 0.4f * size}};
        for (int k = 0; k < 3; ++k)
            poses[i].centre[k] = (float)rng_between(&r, -12, 12);
        for (int k = 0; k < 4; ++k)
            poses[i].rotation[k] = (float)rng_normal(&r);
    }
    n = duet_cluster_get_rank(c) == 0 ? n : 0;
    must(duet_cluster_set_objects(c, DUET_OBJECT_POSES, ids, poses, n, ERR));
}

enum { DRIFTS = 12, LEAPS = 4, SWELLS = 6, SPOILS = 8 };
enum { STEPS = 14, AGAIN = 3, GROWS = 4, CUTS = 6, SHRINKS = 7, FAILS = 9, CROWDS = 11 };

// An object's place at a step is known by its id alone: some leap far, once one becomes wide, and
// later narrow, two are bad for a moment, and most come to one side.
static void move(duet_pose *p, uint64_t id, uint32_t at)
{
    rng r = rng_seed(id * 1000 + at);
    for (int k = 0; k < 3; ++k)
        p->centre[k] += (float)rng_between(&r, -0.3, 0.3);
    if (id % 97 == at)
        p->centre[id % 3] = (float)rng_between(&r, -16, 16);
    if (at == CROWDS && id % 4 > 0)
        p->centre[0] = fabsf(p->centre[0]);
    if (id == 77)
        p->half_extents[1] = at < GROWS || at >= SHRINKS ? 0.3f : 3.0f;
    if (id == 4321 || id == 8765)
        p->half_extents[2] = at == FAILS ? -1.0f : 0.4f;
}

typedef void mover(duet_pose *p, uint64_t id, uint32_t at);

static void move_owned(duet_cluster *c, mover *how, uint32_t at)
{
    const uint64_t *ids;
    uint32_t n;
    duet_pose *own = must(duet_cluster_map_owned(c, DUET_OBJECT_POSES, &ids, &n, ERR));
    for (uint32_t i = 0; i < n; ++i)
        how(&own[i], ids[i], at);
}

// The next step partitions the world anew, while objects that moved are on their way to devices.
static void make_uneven(duet_cluster *c)
{
    c->migration.unevenness = 0;
}

static void must_name_the_bad(duet_cluster *c)
{
    duet_cluster_result result;
    must_fail(duet_cluster_step(c, &result, ERR), DUET_STATUS_BAD_OBJECT,
              "object 4321 of 9000 is not a number");
    MUST(strstr(ERR->text, "(2 such"), ERR->text);
}

static bool (*find_in_truth)(worker *, const float[3], const float[3]);
static int n_finds;

static bool count_find(worker *w, const float lower[3], const float upper[3])
{
    bool finds = find_in_truth(w, lower, upper);
    n_finds += finds;
    return finds;
}

// Happens once a step, except where nothing was sent ahead or levels change.
static bool is_quiet(uint32_t at)
{
    return at > 2 && at != GROWS && at != CUTS && at != SHRINKS && at != CROWDS && at != FAILS &&
           at != FAILS + 1;
}

static uint64_t sum_of(duet_cluster *c, uint64_t own)
{
    ranks_sum(&c->ranks, &own, 1);
    return own;
}

static void must_be_listed(duet_cluster *c, uint64_t hash)
{
    const duet_pair64 *pairs;
    uint64_t n, own = 0;
    must(duet_cluster_get_own_pairs(c, &pairs, &n, ERR));
    for (uint64_t k = 0; k < n; ++k)
        own += pair64_hash(pairs[k]);
    MUST(sum_of(c, own) == hash, "they are listed");
}

// A second step finds the same, and so does one whose kernels may be others.
static void must_find_again(duet_cluster *c, const duet_cluster_result *first)
{
    for (int i = 0; i < 2; ++i) {
        duet_cluster_result again;
        bool was_apart = (c->search == SEARCH_OVERLAPPED);
        if (i == 1)
            must(duet_cluster_set_plan(c, &c->def.world.plan, ERR));
        must(duet_cluster_step(c, &again, ERR));
        MUST(again.hash == first->hash && again.pairs == first->pairs, "they are found again");
        MUST((c->search == SEARCH_OVERLAPPED) == (was_apart && i == 0),
             "by two searches where that holds");
    }
}

static void ranks_with_and_without_find_the_same_pairs(int n_ranks, uint64_t seed)
{
    duet_cluster *clusters[] = {open_cluster(n_ranks, true, 1), open_cluster(n_ranks, false, 1)};
    uint64_t left = 0, apart = 0, left_apart = 0, timed = 0;
    part *b = &worker_of(clusters[0])->world->parts[1];
    find_in_truth = clusters[0]->workers[0]->find_interior;
    clusters[0]->workers[0]->find_interior = count_find;
    for (int i = 0; i < 2; ++i)
        hand_over(clusters[i], N, seed);
    for (uint32_t at = 0; at < STEPS; ++at) {
        duet_cluster_result results[2];
        n_finds = 0;
        for (int i = 0; i < 2; ++i) {
            if (at > 0)
                move_owned(clusters[i], move, at);
            if (at == CUTS)
                make_uneven(clusters[i]);
            if (at == FAILS)
                must_name_the_bad(clusters[i]);
            else
                must(duet_cluster_step(clusters[i], &results[i], ERR));
        }
        MUST(!is_quiet(at) || (n_finds == 1 && b->objects.n_chunks > 1),
             "a look is enough, in chunks");
        left += clusters[0]->owned.leavers.n;
        b->least_chunk = 1;
        timed += !b->times.untimed;
        if (at == FAILS)
            continue;
        MUST(results[0].hash == results[1].hash && results[0].pairs == results[1].pairs &&
                 results[0].pairs > 1000,
             "the pairs are the reference's");
        apart += (clusters[0]->search == SEARCH_OVERLAPPED);
        left_apart += (clusters[0]->search == SEARCH_OVERLAPPED) ? clusters[0]->owned.leavers.n : 0;
        must_be_listed(clusters[0], results[0].hash);
        if (at == AGAIN)
            must_find_again(clusters[0], &results[0]);
    }
    MUST(timed > 0 && timed < STEPS / 2,
         "few steps are timed, as on any device with its own memory");
    MUST(clusters[0]->ranks.n == 1 || sum_of(clusters[0], left) > 100, "objects changed ranks");
    MUST(clusters[0]->ranks.n == 1 ||
             (sum_of(clusters[0], apart) > 6 && sum_of(clusters[0], left_apart) > 50),
         "owned objects were searched while ghosts travelled, where objects changed ranks, too");
    for (int i = 0; i < 2; ++i)
        duet_cluster_destroy(clusters[i]);
}

static void take_all_threads(duet_cluster *c)
{
    parallel_end(&c->threads);
    must(parallel_begin(&c->threads, c->ranks.processors * c->ranks.n_on_host, 1, ERR));
}

// Several threads look at each chunk, and then at the next.
static void objects_leave_in_the_order_of_their_rows(int n_ranks, uint64_t seed)
{
    duet_cluster_result result;
    duet_cluster *c = open_cluster(n_ranks, true, 1);
    const row_list *l = &c->owned.leavers;
    take_all_threads(c);
    hand_over(c, MANY, seed);
    for (uint32_t at = 1; at < 4; ++at) {
        must(duet_cluster_step(c, &result, ERR));
        worker_of(c)->world->parts[1].least_chunk = 1;
        for (uint32_t i = 1; i < l->n; ++i)
            MUST(l->rows[i - 1] < l->rows[i], "ascending");
        MUST(at < 3 || (l->n > 100 && worker_of(c)->world->parts[1].interior.done[1]), "some left");
        move_owned(c, move, at);
    }
    duet_cluster_destroy(c);
}

static void *(*extend_in_truth)(worker *, uint32_t, uint32_t, duet_error *);

// Once.
static void *fail_to_extend(worker *w, uint32_t n, uint32_t kept, duet_error *err)
{
    (void)n, (void)kept;
    w->extend = extend_in_truth;
    error_set(err, DUET_STATUS_NO_MEMORY, "none for now");
    return NULL;
}

static void *(*map_in_truth)(worker *, uint32_t, duet_error *);

static void *fail_to_map(worker *w, uint32_t n, duet_error *err)
{
    (void)n;
    w->map = map_in_truth;
    error_set(err, DUET_STATUS_NO_MEMORY, "none for now");
    return NULL;
}

#define MUST_LACK_MEMORY(call)                                \
    do {                                                      \
        must_fail(call, DUET_STATUS_NO_MEMORY, "rank 1 on "); \
        MUST(strstr(ERR->text, "none for now"), ERR->text);   \
    } while (0)

// A rank that has no memory for newcomers: none comes to any, and all do in the next step.
static void newcomers_come_to_all_ranks_or_to_none(int n_ranks, uint64_t seed)
{
    enum { MISSES = 3, ENDS = 6 };
    duet_cluster *clusters[] = {open_cluster(n_ranks, true, 1), open_cluster(n_ranks, false, 1)};
    worker *w = clusters[0]->workers[0];
    duet_cluster_result results[2];
    uint64_t left = 0;
    extend_in_truth = w->extend;
    for (int i = 0; i < 2; ++i)
        hand_over(clusters[i], N, seed);
    for (uint32_t at = 0; at < ENDS; ++at) {
        for (int i = 0; at > 0 && i < 2; ++i)
            move_owned(clusters[i], move, at);
        if (at == MISSES) {
            w->extend = rank == 1 ? fail_to_extend : extend_in_truth;
            MUST_LACK_MEMORY(duet_cluster_step(clusters[0], &results[0], ERR));
            MUST(w->extend == extend_in_truth && clusters[0]->owned.leavers.n == 0, "none left");
        }
        for (int i = 0; i < 2; ++i)
            must(duet_cluster_step(clusters[i], &results[i], ERR));
        left += at == MISSES ? clusters[0]->owned.leavers.n : 0;
        MUST(results[0].objects == N && results[0].hash == results[1].hash, "all are there, once");
    }
    MUST(sum_of(clusters[0], left) > 10, "some left");
    for (int i = 0; i < 2; ++i)
        duet_cluster_destroy(clusters[i]);
}

// A rank that has no memory for its owned objects: none has them, and all do at the next call.
static void objects_are_mapped_by_all_ranks_or_by_none(int n_ranks, uint64_t seed)
{
    duet_cluster *c = open_cluster(n_ranks, true, 1);
    worker *w = c->workers[0];
    const uint64_t *ids = NULL;
    uint32_t n = 0;
    duet_cluster_result first, again;
    map_in_truth = w->map;
    hand_over(c, N, seed);
    must(duet_cluster_step(c, &first, ERR));
    for (int moves = 0; moves < 2; ++moves) { // objects as they are found, and as they were written
        for (int i = 0; i < 2; ++i) {
            w->map = rank == 1 ? fail_to_map : map_in_truth;
            MUST_LACK_MEMORY(duet_cluster_map_owned(c, DUET_OBJECT_POSES, &ids, &n, ERR));
            MUST(w->map == map_in_truth && c->owned.rows.objects, "they are there");
        }
        if (moves)
            move_owned(c, move, 1);
    }
    must(duet_cluster_step(c, &again, ERR));
    MUST(again.objects == N && again.hash != first.hash, "they moved");
    duet_cluster_destroy(c);
}

// A little; some come through a border of parts or ranks, and one leaps at one step.
static void drift(duet_pose *p, uint64_t id, uint32_t at)
{
    rng r = rng_seed(id * 1000 + at);
    for (int k = 0; k < 3; ++k)
        p->centre[k] += (float)rng_between(&r, -0.3, 0.3);
    for (int k = 0; k < 3 && at == LEAPS && id == 4321; ++k)
        p->centre[k] = p->centre[k] < 0 ? 11 : -11;
    if (at == SWELLS && id == 77)
        p->half_extents[1] = 0.55f;
    if (id == 1234 && at >= SPOILS)
        p->half_extents[2] = at == SPOILS ? NAN : 0.4f;
}

// Few objects lie at boundaries, or so many that several threads look at them.
static void large_parts_find_the_same_pairs(int n_ranks, uint64_t seed, uint32_t n_parts, bool thin)
{
    duet_cluster *clusters[] = {open_cluster(n_ranks, true, n_parts),
                                open_cluster(n_ranks, true, 1)};
    duet_cluster *c = clusters[0];
    size = thin ? 0.3f : 1;
    for (int i = 0; i < 2; ++i) {
        take_all_threads(clusters[i]);
        hand_over(clusters[i], MANY, seed);
    }
    size = 1;
    for (uint32_t at = 0; at < SWELLS; ++at) {
        duet_cluster_result results[2];
        for (int i = 0; i < 2; ++i) {
            if (at > 0)
                move_owned(clusters[i], thin ? drift : move, at);
            must(duet_cluster_step(clusters[i], &results[i], ERR));
        }
        MUST(results[0].hash == results[1].hash && results[0].pairs == results[1].pairs &&
                 results[0].pairs > 1000,
             "the pairs are those of one part");
        MUST(thin ? c->owned.boundary.n < c->owned.rows.n / 8 : c->owned.boundary.n > 1 << 12,
             "few are at boundaries, or many");
        MUST(at == 0 || c->owned.runs.n > 10 * n_parts, "objects changed domains");
        must_be_listed(c, results[0].hash);
    }
    for (int i = 0; i < 2; ++i)
        duet_cluster_destroy(clusters[i]);
}

static void spoil(duet_cluster *clusters[2])
{
    duet_cluster_result result;
    for (int i = 0; i < 2; ++i)
        must_fail(duet_cluster_step(clusters[i], &result, ERR), DUET_STATUS_BAD_OBJECT,
                  "object 1234 of");
}

// Whether pairs are listed or only counted, and also if objects leap, swell or are bad for a
// moment.
static void parts_find_the_same_pairs(int n_ranks, uint64_t seed, bool drops)
{
    enum { PARTS = 5 };
    duet_cluster *clusters[] = {open_cluster(n_ranks, true, PARTS),
                                open_cluster(n_ranks, false, 1)};
    duet_cluster *c = clusters[0];
    c->def.drops_pairs = drops;
    take_all_threads(c);
    for (int i = 0; i < 2; ++i)
        hand_over(clusters[i], N, seed);
    for (uint32_t at = 0; at < DRIFTS; ++at) {
        duet_cluster_result results[2];
        for (int i = 0; at > 0 && i < 2; ++i)
            move_owned(clusters[i], drift, at);
        if (at == SPOILS) {
            spoil(clusters);
            continue;
        }
        for (int i = 0; i < 2; ++i)
            must(duet_cluster_step(clusters[i], &results[i], ERR));
        MUST(results[0].hash == results[1].hash && results[0].pairs == results[1].pairs &&
                 results[0].pairs > 1000,
             "the pairs are the reference's");
        if (at % 3 == 0) { // and again, as they are
            must(duet_cluster_step(c, &results[0], ERR));
            MUST(results[0].hash == results[1].hash, "the same");
        }
        MUST(at == 0 || c->owned.runs.n > 2 * PARTS, "objects changed domains");
        if (!drops)
            must_be_listed(c, results[1].hash);
    }
    for (int i = 0; i < 2; ++i)
        duet_cluster_destroy(clusters[i]);
}

static void change(duet_cluster *c, uint32_t what)
{
    if (what == 0)
        must(duet_cluster_set_plan(c, &c->def.world.plan, ERR));
    if (what == 1)
        must(duet_cluster_set_level(c, DUET_LEVEL_AABB, ERR));
    if (what == 2)
        must(duet_cluster_set_level(c, DUET_LEVEL_CERTIFIED, ERR));
    if (what == 3) // and back
        must(duet_cluster_set_level(c, DUET_LEVEL_SPHERE, ERR) &&
             duet_cluster_set_level(c, DUET_LEVEL_CERTIFIED, ERR));
}

// Whatever was called between two steps.
static void any_order_of_calls_finds_the_same_pairs(int n_ranks, uint64_t seed)
{
    enum { CALLS = 60, CHANGES = 4, MOVES = 5, FEW = 3000 };
    duet_cluster *clusters[] = {open_cluster(n_ranks, true, 1), open_cluster(n_ranks, false, 1)};
    rng r = rng_seed(seed + 1);
    uint64_t apart = 0, steps = 0;
    duet_cluster_result results[2] = {{0}};
    for (int i = 0; i < 2; ++i)
        hand_over(clusters[i], FEW, seed);
    for (uint32_t at = 0; at < CALLS; ++at) {
        uint32_t what = rng_below(&r, 16);
        bool steps_now = what > MOVES + 2;
        for (int i = 0; i < 2; ++i) {
            if (what > MOVES && what <= MOVES + 5)
                move_owned(clusters[i], drift, DRIFTS + at);
            else if (what < CHANGES)
                change(clusters[i], what);
            if (what % 5 == 4)
                make_uneven(clusters[i]);
            if (steps_now)
                must(duet_cluster_step(clusters[i], &results[i], ERR));
        }
        steps += steps_now;
        apart += steps_now && (clusters[0]->search == SEARCH_OVERLAPPED);
        MUST(results[0].hash == results[1].hash && results[0].pairs == results[1].pairs,
             "the pairs are the reference's");
        if (steps_now && what % 2)
            must_be_listed(clusters[0], results[0].hash);
    }
    MUST(steps > 20 && (clusters[0]->ranks.n == 1 || sum_of(clusters[0], apart) > 10),
         "owned objects were searched while ghosts travelled");
    for (int i = 0; i < 2; ++i)
        duet_cluster_destroy(clusters[i]);
}

int main(int argc, char **argv)
{
    uint64_t seed = job_begin(&argc, &argv, 2, 20261123);
    rng r = rng_seed(seed);
    open_devices();
    if (rank == 0) { // with a group of one, as on a CPU, and of many
        a_device_passes_over_what_the_host_would(&r, 3, DUET_SHAPE_POSES, "simd");
        a_device_passes_over_what_the_host_would(&r, 3, DUET_SHAPE_POSES,
                                                 "simd find_interior.WG=64");
        a_device_passes_over_what_the_host_would(&r, 2, DUET_SHAPE_POSES,
                                                 "simd find_interior.WG=256");
        a_device_passes_over_what_the_host_would(&r, 2, DUET_SHAPE_BOUNDS, "simd");
        a_device_passes_over_what_the_host_would(&r, 3, DUET_SHAPE_BOUNDS,
                                                 "simd find_interior.WG=128");
        a_worker_keeps_its_objects();
        ranks_with_and_without_find_the_same_pairs(ALONE, seed);
        large_parts_find_the_same_pairs(ALONE, seed, 3, false);
        large_parts_find_the_same_pairs(ALONE, seed, 3, true);
        parts_find_the_same_pairs(ALONE, seed, true);
        parts_find_the_same_pairs(ALONE, seed, false);
    }
    MPI_Barrier(MPI_COMM_WORLD);
    ranks_with_and_without_find_the_same_pairs(2, seed);
    any_order_of_calls_finds_the_same_pairs(2, seed);
    objects_leave_in_the_order_of_their_rows(2, seed);
    newcomers_come_to_all_ranks_or_to_none(2, seed);
    objects_are_mapped_by_all_ranks_or_by_none(2, seed);
    large_parts_find_the_same_pairs(2, seed, 2, true);
    parts_find_the_same_pairs(2, seed, true);
    parts_find_the_same_pairs(2, seed, false);
    duet_device_pair_destroy(devices);
    MUST(device_live_objects() == 0, "no OpenCL object is left");
    return job_end("all facts hold");
}
