// SPDX-License-Identifier: MIT
// Counting sort into cells, boxes moved into cell order, half the
// neighbourhood as five merged rows, candidates and axes eight at a time.
//
// The grid has an empty cell all round it, so that no row needs a border case.
// Each thread counts its half of the objects in a table of its own: no atomic
// operation anywhere but on the number of the next chunk.
#define _DEFAULT_SOURCE
#include "limit_avx2.h"

#include "base/clock.h"
#include "lanes_avx2.h"
#include "sat_avx2.h"
#include "workers.h"

#include <stdatomic.h>
#include <string.h>
#include <sys/mman.h>

#define MAX_THREADS 16
#define CHUNK 4096        // objects that a thread takes at a time
#define LANES 8           // slack that whole vectors may read past the end
#define WAITING 1024      // candidates a thread collects before it tests them
#define ROUND_UP 0x1p-20f // more than the relative error of a half extent

// Memory that one thread alone writes.
typedef struct search {
    uint32_t first[WAITING + SAT_SLACK];
    uint32_t second[WAITING + SAT_SLACK];
    uint32_t n_waiting;
    sat_result found;
    uint64_t capacity;
    uint64_t narrow_ns;
    bool full;
} search;

struct limit {
    workers *workers;
    uint32_t threads;
    uint32_t n;
    uint32_t n_cells;
    uint32_t side; // cells along an edge, the empty ones counted
    float per_cell;
    const duet_pose *poses;
    uint32_t *key;    // [n] cell of each object
    uint32_t *at;     // [threads][n_cells] counts, then next places, then ends
    uint32_t *order;  // [n] object at each place
    uint32_t *key_at; // [n] cell at each place
    float *lower[3];  // [n] bounds at each place
    float *upper[3];  //
    sat_box *boxes;   // [n] at each place
    uint32_t sums[MAX_THREADS];
    atomic_uint next_chunk;
    search *searches[MAX_THREADS];
};

// Large pages: the tables are read at random and would miss the small ones'
// translations.
static void *reserve(size_t bytes)
{
    size_t page = (size_t)1 << 21;
    size_t whole = (bytes + page - 1) & ~(page - 1);
    void *memory = aligned_alloc(page, whole);
    if (!memory)
        return NULL;
    madvise(memory, whole, MADV_HUGEPAGE);
    memset(memory, 0, whole);
    return memory;
}

// ---------------------------------------------------------------- sort

static uint32_t part_begin(const limit *l, uint32_t worker, uint32_t n)
{
    return (uint32_t)((uint64_t)n * worker / l->threads);
}

static inline uint32_t axis_cell(const limit *l, float x)
{
    float cell = x * l->per_cell;
    float last = (float)(l->side - 3);
    cell = cell > 0 ? cell : 0;
    return (uint32_t)(cell < last ? cell : last) + 1;
}

static inline uint32_t pose_cell(const limit *l, const float centre[3])
{
    uint32_t row = axis_cell(l, centre[2]) * l->side + axis_cell(l, centre[1]);
    return row * l->side + axis_cell(l, centre[0]);
}

static void count_objects(void *context, uint32_t worker)
{
    limit *l = context;
    uint32_t *count = l->at + (size_t)worker * l->n_cells;
    memset(count, 0, l->n_cells * sizeof *count);
    uint32_t end = part_begin(l, worker + 1, l->n);
    for (uint32_t i = part_begin(l, worker, l->n); i < end; ++i) {
        l->key[i] = pose_cell(l, l->poses[i].centre);
        ++count[l->key[i]];
    }
}

static void sum_cells(void *context, uint32_t worker)
{
    limit *l = context;
    uint32_t begin = part_begin(l, worker, l->n_cells), end = part_begin(l, worker + 1, l->n_cells);
    uint32_t sum = 0;
    for (uint32_t t = 0; t < l->threads; ++t)
        for (uint32_t c = begin; c < end; ++c)
            sum += l->at[(size_t)t * l->n_cells + c];
    l->sums[worker] = sum;
}

// A cell's objects lie in the order of the threads that counted them.
static void scan_cells(void *context, uint32_t worker)
{
    limit *l = context;
    uint32_t begin = part_begin(l, worker, l->n_cells), end = part_begin(l, worker + 1, l->n_cells);
    uint32_t sum = 0;
    for (uint32_t w = 0; w < worker; ++w)
        sum += l->sums[w];
    for (uint32_t c = begin; c < end; ++c) {
        for (uint32_t t = 0; t < l->threads; ++t) {
            uint32_t *at = &l->at[(size_t)t * l->n_cells + c];
            uint32_t count = *at;
            *at = sum;
            sum += count;
        }
    }
}

static void place_objects(void *context, uint32_t worker)
{
    limit *l = context;
    uint32_t *next = l->at + (size_t)worker * l->n_cells;
    uint32_t end = part_begin(l, worker + 1, l->n);
    for (uint32_t i = part_begin(l, worker, l->n); i < end; ++i)
        l->order[next[l->key[i]]++] = i;
}

// The last thread's places have moved to where each cell ends.
static const uint32_t *cell_ends(const limit *l)
{
    return l->at + (size_t)(l->threads - 1) * l->n_cells;
}

// ---------------------------------------------------------------- reorder

// Eight poses, one a lane.
typedef struct poses8 {
    __m256 centre[3];
    __m256 half[3];
    __m256 turn[4];
} poses8;

static void load_poses(const duet_pose *poses, const uint32_t *ids, poses8 *p)
{
    __m256 v[8];
    for (int i = 0; i < 8; ++i)
        v[i] = _mm256_loadu_ps((const float *)&poses[ids[i]]);
    lanes_transpose(v);
    for (int i = 0; i < 3; ++i) {
        p->centre[i] = v[i];
        p->half[i] = v[3 + i];
    }
    p->turn[0] = v[6];
    p->turn[1] = v[7];
    __m256i at = _mm256_mullo_epi32(_mm256_loadu_si256((const __m256i *)ids), _mm256_set1_epi32(5));
    const double *last = (const double *)&poses[0].rotation[2]; // z and w in one load
    __m256d low = _mm256_i32gather_pd(last, _mm256_castsi256_si128(at), 8);
    __m256d high = _mm256_i32gather_pd(last, _mm256_extracti128_si256(at, 1), 8);
    __m256 even = _mm256_shuffle_ps(_mm256_castpd_ps(low), _mm256_castpd_ps(high), 0x88);
    __m256 odd = _mm256_shuffle_ps(_mm256_castpd_ps(low), _mm256_castpd_ps(high), 0xdd);
    const __m256i in_order = _mm256_setr_epi32(0, 1, 4, 5, 2, 3, 6, 7);
    p->turn[2] = _mm256_permutevar8x32_ps(even, in_order);
    p->turn[3] = _mm256_permutevar8x32_ps(odd, in_order);
}

// axes[i] is the box's own axis i: column i of M(q) / |q|^2.
static void rotation_axes(const __m256 q[4], __m256 axes[3][3])
{
    __m256 square = _mm256_mul_ps(q[3], q[3]);
    for (int i = 0; i < 3; ++i)
        square = _mm256_fmadd_ps(q[i], q[i], square);
    __m256 scale = _mm256_div_ps(_mm256_set1_ps(2), square);
    for (int i = 0; i < 3; ++i) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        __m256 others = _mm256_fmadd_ps(q[j], q[j], _mm256_mul_ps(q[k], q[k]));
        axes[i][i] = _mm256_fnmadd_ps(scale, others, _mm256_set1_ps(1));
        __m256 turned = _mm256_mul_ps(q[k], q[3]);
        axes[i][j] = _mm256_mul_ps(scale, _mm256_fmadd_ps(q[i], q[j], turned));
        axes[j][i] = _mm256_mul_ps(scale, _mm256_fmsub_ps(q[i], q[j], turned));
    }
}

static void store_bounds(limit *l, uint32_t at, const poses8 *p, __m256 axes[3][3])
{
    const __m256 sign = _mm256_set1_ps(-0.0f);
    for (int x = 0; x < 3; ++x) {
        __m256 reach = _mm256_setzero_ps();
        for (int i = 0; i < 3; ++i)
            reach = _mm256_fmadd_ps(_mm256_andnot_ps(sign, axes[i][x]), p->half[i], reach);
        __m256 sizes = _mm256_add_ps(reach, _mm256_andnot_ps(sign, p->centre[x]));
        reach = _mm256_fmadd_ps(sizes, _mm256_set1_ps(ROUND_UP), reach);
        _mm256_storeu_ps(l->lower[x] + at, _mm256_sub_ps(p->centre[x], reach));
        _mm256_storeu_ps(l->upper[x] + at, _mm256_add_ps(p->centre[x], reach));
    }
}

static void store_boxes(sat_box *to, const uint32_t *ids, const poses8 *p, __m256 axes[3][3])
{
    __m256 low[8] = {p->centre[0], p->centre[1], p->centre[2], p->half[0],
                     p->half[1],   p->half[2],   axes[0][0],   axes[0][1]};
    __m256 id = _mm256_castsi256_ps(_mm256_loadu_si256((const __m256i *)ids));
    __m256 high[8] = {axes[0][2], axes[1][0], axes[1][1], axes[1][2],
                      axes[2][0], axes[2][1], axes[2][2], id};
    lanes_transpose(low);
    lanes_transpose(high);
    for (int i = 0; i < 8; ++i) {
        _mm256_store_ps((float *)&to[i], low[i]);
        _mm256_store_ps((float *)&to[i] + 8, high[i]);
    }
}

static __m256i axis_cell8(const limit *l, __m256 x)
{
    __m256 cell = _mm256_mul_ps(x, _mm256_set1_ps(l->per_cell));
    cell = _mm256_max_ps(cell, _mm256_setzero_ps());
    cell = _mm256_min_ps(cell, _mm256_set1_ps((float)(l->side - 3)));
    return _mm256_add_epi32(_mm256_cvttps_epi32(cell), _mm256_set1_epi32(1));
}

static void store_cells(limit *l, uint32_t at, const poses8 *p)
{
    __m256i side = _mm256_set1_epi32((int)l->side);
    __m256i cell = axis_cell8(l, p->centre[2]);
    cell = _mm256_add_epi32(_mm256_mullo_epi32(cell, side), axis_cell8(l, p->centre[1]));
    cell = _mm256_add_epi32(_mm256_mullo_epi32(cell, side), axis_cell8(l, p->centre[0]));
    _mm256_storeu_si256((__m256i *)(l->key_at + at), cell);
}

// The next chunk's first object; false where all are taken.
static bool take_chunk(limit *l, uint32_t *begin, uint32_t *end)
{
    *begin = CHUNK * atomic_fetch_add(&l->next_chunk, 1);
    *end = l->n - *begin < CHUNK ? l->n : *begin + CHUNK;
    return *begin < l->n;
}

// Half of the poses lie across two cache lines.
static inline void ask_for_poses(const limit *l, uint32_t at)
{
    for (int i = 0; i < LANES; ++i) {
        const char *pose = (const char *)&l->poses[l->order[at + (uint32_t)i]];
        _mm_prefetch(pose, _MM_HINT_T0);
        _mm_prefetch(pose + sizeof(duet_pose) - 1, _MM_HINT_T0);
    }
}

// Arrays have space for whole eights; what lies past n is the object 0 again.
static void reorder_objects(void *context, uint32_t worker)
{
    (void)worker;
    limit *l = context;
    uint32_t begin, end;
    while (take_chunk(l, &begin, &end)) {
        for (uint32_t at = begin; at < end; at += LANES) {
            ask_for_poses(l, at + 4 * LANES);
            poses8 p;
            __m256 axes[3][3];
            load_poses(l->poses, l->order + at, &p);
            rotation_axes(p.turn, axes);
            store_bounds(l, at, &p, axes);
            store_boxes(l->boxes + at, l->order + at, &p, axes);
            store_cells(l, at, &p);
        }
    }
}

// ---------------------------------------------------------------- search

// Bounds of one object, each corner in all lanes.
typedef struct bounds1 {
    __m256 lower[3];
    __m256 upper[3];
} bounds1;

static inline unsigned overlapping(const limit *l, const bounds1 *box, uint32_t at)
{
    __m256 all = _mm256_castsi256_ps(_mm256_set1_epi32(-1));
    for (int x = 0; x < 3; ++x) {
        __m256 lower = _mm256_loadu_ps(l->lower[x] + at);
        __m256 upper = _mm256_loadu_ps(l->upper[x] + at);
        all = _mm256_and_ps(all, _mm256_cmp_ps(lower, box->upper[x], _CMP_LE_OQ));
        all = _mm256_and_ps(all, _mm256_cmp_ps(upper, box->lower[x], _CMP_GE_OQ));
    }
    return (unsigned)_mm256_movemask_ps(all);
}

static void test_waiting(limit *l, search *s)
{
    uint64_t begun = clock_steady_ns();
    if (s->found.n_pairs + WAITING + LANES > s->capacity)
        s->full = true;
    else
        sat_avx2(l->boxes, l->poses, s->first, s->second, s->n_waiting, &s->found);
    s->n_waiting = 0;
    s->narrow_ns += clock_steady_ns() - begun;
}

// Adds the overlapping ones among places from .. to - 1 to those waiting. The
// store is unconditional: whether a candidate comes is a coin's toss.
static inline void search_row(limit *l, search *s, const bounds1 *box, uint32_t self, uint32_t from,
                              uint32_t to)
{
    const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    do {
        uint32_t left = to - from;
        unsigned mask = overlapping(l, box, from) & (left < LANES ? (1u << left) - 1 : 0xff);
        __m256i places = _mm256_add_epi32(_mm256_set1_epi32((int)from), lane);
        _mm256_storeu_si256((__m256i *)(s->first + s->n_waiting), _mm256_set1_epi32((int)self));
        _mm256_storeu_si256((__m256i *)(s->second + s->n_waiting), lanes_pack(places, mask));
        s->n_waiting += (unsigned)__builtin_popcount(mask);
        if (s->n_waiting > WAITING - LANES)
            test_waiting(l, s);
        from += LANES;
    } while (from < to);
}

static inline void search_object(limit *l, search *s, uint32_t self)
{
    const uint32_t *ends = cell_ends(l);
    uint32_t side = l->side, plane = side * side;
    uint32_t cell = l->key_at[self];
    const uint32_t rows[4] = {cell + side, cell + plane - side, cell + plane, cell + plane + side};
    bounds1 box;
    for (int x = 0; x < 3; ++x) {
        box.lower[x] = _mm256_set1_ps(l->lower[x][self]);
        box.upper[x] = _mm256_set1_ps(l->upper[x][self]);
    }
    search_row(l, s, &box, self, self + 1, ends[cell + 1]);
    for (int i = 0; i < 4; ++i)
        search_row(l, s, &box, self, ends[rows[i] - 2], ends[rows[i] + 1]);
}

static void search_objects(void *context, uint32_t worker)
{
    limit *l = context;
    search *s = l->searches[worker];
    uint32_t begin, end;
    while (take_chunk(l, &begin, &end))
        for (uint32_t i = begin; i < end; ++i)
            search_object(l, s, i);
    test_waiting(l, s);
}

// ---------------------------------------------------------------- run

static double run_stage(limit *l, stage_part *part)
{
    atomic_store(&l->next_chunk, 0);
    uint64_t begun = clock_steady_ns();
    workers_run(l->workers, part, l);
    return (double)(clock_steady_ns() - begun) * 1e-6;
}

static void forget_pairs(limit *l)
{
    for (uint32_t t = 0; t < l->threads; ++t) {
        search *s = l->searches[t];
        s->found = (sat_result){.pairs = s->found.pairs};
        s->narrow_ns = 0;
        s->full = false;
    }
}

bool limit_run(limit *l, const duet_pose *poses, limit_times *times)
{
    uint64_t begun = clock_steady_ns(), cpu_begun = workers_cpu_ns(l->workers);
    l->poses = poses;
    forget_pairs(l);
    times->count = run_stage(l, count_objects);
    times->scan = run_stage(l, sum_cells);
    times->scan += run_stage(l, scan_cells);
    times->place = run_stage(l, place_objects);
    times->reorder = run_stage(l, reorder_objects);
    double search_ms = run_stage(l, search_objects);
    double wall_ns = (double)(clock_steady_ns() - begun);
    bool full = false;
    times->narrow = 0;
    for (uint32_t t = 0; t < l->threads; ++t) {
        full = full || l->searches[t]->full;
        times->narrow += (double)l->searches[t]->narrow_ns * 1e-6 / l->threads;
    }
    times->candidates = search_ms - times->narrow;
    times->total = wall_ns * 1e-6;
    times->processors = (double)(workers_cpu_ns(l->workers) - cpu_begun) / wall_ns;
    return !full;
}

duet_span limit_span(const limit *l, uint32_t thread)
{
    const sat_result *found = &l->searches[thread]->found;
    return (duet_span){found->pairs, found->n_pairs};
}

// ---------------------------------------------------------------- memory

static search *search_open(uint64_t capacity)
{
    search *s = reserve(sizeof *s);
    if (!s)
        return NULL;
    s->capacity = capacity;
    s->found.pairs = reserve(capacity * sizeof(duet_pair));
    return s;
}

static bool reserve_all(limit *l)
{
    size_t n = (size_t)l->n + 5 * LANES; // reorder reads ahead by four eights
    l->key = reserve(n * sizeof *l->key);
    l->at = reserve((size_t)l->threads * l->n_cells * sizeof *l->at);
    l->order = reserve(n * sizeof *l->order);
    l->key_at = reserve(n * sizeof *l->key_at);
    l->boxes = reserve(n * sizeof *l->boxes);
    bool ok = l->key && l->at && l->order && l->key_at && l->boxes;
    for (int x = 0; x < 3; ++x) {
        l->lower[x] = reserve(n * sizeof *l->lower[x]);
        l->upper[x] = reserve(n * sizeof *l->upper[x]);
        ok = ok && l->lower[x] && l->upper[x];
    }
    for (uint32_t t = 0; t < l->threads; ++t) {
        l->searches[t] = search_open(l->n + WAITING);
        ok = ok && l->searches[t] && l->searches[t]->found.pairs;
    }
    return ok;
}

limit *limit_open(uint32_t n, float world, float cell, uint32_t threads)
{
    lanes_prepare();
    limit *l = calloc(1, sizeof *l);
    if (!l)
        return NULL;
    l->n = n;
    l->threads = threads;
    l->side = (uint32_t)(world / cell) + 2;
    l->n_cells = l->side * l->side * l->side;
    l->per_cell = (float)(l->side - 2) / world;
    l->workers = workers_open(threads);
    if (l->workers && reserve_all(l))
        return l;
    limit_close(l);
    return NULL;
}

void limit_close(limit *l)
{
    if (!l)
        return;
    workers_close(l->workers);
    for (uint32_t t = 0; t < l->threads; ++t) {
        if (l->searches[t])
            free(l->searches[t]->found.pairs);
        free(l->searches[t]);
    }
    for (int x = 0; x < 3; ++x) {
        free(l->lower[x]);
        free(l->upper[x]);
    }
    free(l->key);
    free(l->at);
    free(l->order);
    free(l->key_at);
    free(l->boxes);
    free(l);
}
