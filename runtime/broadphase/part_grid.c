// SPDX-License-Identifier: MIT
// Building the grid on one device, and giving it to the other.
#include "runtime/broadphase/part.h"

#include "base/error.h"

static uint32_t own_cells(const part_range *range)
{
    return range->key_to - range->key_from;
}

// A search reads so many words behind the last one: nothing begins there.
enum { STARTS_BEHIND = 3 };

// The first place of each cell, then how many objects have one.
static uint32_t count_starts(const part_range *range)
{
    return own_cells(range) + 1 + STARTS_BEHIND;
}

// Zeroes the counters, and with them n_starts words of the starts.
static bool clear(part *p, uint32_t n_starts, duet_error *err)
{
    uint32_t work = n_starts > COUNTERS ? n_starts : COUNTERS;
    p->args.n_starts = n_starts;
    return timeline_launch(&p->times, "clear", p->kernels.clear, work, p, err);
}

// ---------------------------------------------------------------- sorting

// Hashes the objects up to `to`, once they were sent.
static bool hash_chunk(part *p, uint32_t from, uint32_t to, cl_event sent, duet_error *err)
{
    p->args.n = to;
    return timeline_launch_after(&p->times, "hash", p->kernels.hash, from, to, sent, p, err);
}

// The only kernel that needs no more of the objects than have come so far.
static bool run_hash(part *p, const part_task *task, duet_error *err)
{
    uint32_t from = 0;
    bool ok = true;
    for (uint32_t i = 0; ok && i < p->n_chunks; ++i) {
        ok = hash_chunk(p, from, p->chunks[i].to, p->chunks[i].sent, err);
        from = p->chunks[i].to;
    }
    return ok && hash_chunk(p, from, task->n, NULL, err);
}

// The keys count into starts, and the ranks tell them apart.
static bool counting_sort(part *p, const part_task *task, const part_range *range, duet_error *err)
{
    return run_hash(p, task, err) &&
           scan_run(&p->scan, &p->times, "sort", &p->starts, count_starts(range), err) &&
           (!p->kernels.from_ids ||
            timeline_launch(&p->times, "sort", p->kernels.scatter, task->n, p, err));
}

static bool find_starts(part *p, const part_task *task, const part_range *range, duet_error *err)
{
    bool paper = p->variant.search == SEARCH_PAPER;
    uint64_t work = task->n + (paper ? UINT64_C(0) : UINT64_C(1));
    p->args.key_end = paper ? own_cells(range) : count_starts(range) - 1;
    if (paper &&
        !timeline_fill(&p->times, "cell start", &p->starts, UINT32_MAX, 0, p->args.key_end, err))
        return false;
    return timeline_launch(&p->times, "cell start", p->kernels.starts, work, p, err);
}

// Objects that are not in the grid have all bits set, so they come last.
static bool radix_sort_keys(part *p, const part_task *task, const part_range *range,
                            duet_error *err)
{
    const radix_lists lists = {&p->keys, &p->ids, &p->keys_spare, &p->ids_spare};
    return run_hash(p, task, err) &&
           radix_sort_run(&p->radix, &p->times, "sort", &lists, task->n, task->grid.key_bits,
                          err) &&
           find_starts(p, task, range, err);
}

// ---------------------------------------------------------------- placing

// The paper's kernels read bounds by id; the others read objects in cell order.
static bool place(part *p, const part_task *task, duet_error *err)
{
    bool by_id = p->variant.search == SEARCH_PAPER;
    bool gathers = !by_id && p->kernels.from_ids && p->place_capacity < task->n;
    return timeline_launch(&p->times, by_id ? "bounds" : "reorder", p->kernels.place,
                           gathers ? p->place_capacity : task->n, p, err);
}

typedef struct place_bytes {
    size_t bounds;
    size_t boxes;
} place_bytes;

// Bounds and boxes of n objects as the search reads them. Columns of lanes run
// past n, for whole vectors are read and written there.
static place_bytes bytes_of_places(const part *p, const part_task *task, size_t n)
{
    bool poses = task->shape == DUET_SHAPE_POSES;
    bool has_origin = task->origin > 0.0f;
    if (p->variant.search == SEARCH_SIMD) {
        size_t columns = BOUNDS_COLUMNS_OF(task->dims, has_origin);
        size_t words = BOX_WORDS_OF(MOST_MORE_OF(task->dims, task->rotated), has_origin);
        return (place_bytes){.bounds = COLUMN(n) * columns * sizeof(float),
                             .boxes = poses ? COLUMN(n) * words * sizeof(float) : 0};
    }
    bool boxes = poses && p->variant.search == SEARCH_GPU;
    return (place_bytes){.bounds = n * BOUNDS_QUADS_OF(has_origin) * sizeof(cl_float4),
                         .boxes = boxes ? n * BOX_QUADS_OF(has_origin) * sizeof(cl_float4) : 0};
}

static bool reserve_places(part *p, const part_task *task, size_t n, duet_error *err)
{
    size_t places = p->variant.search == SEARCH_PAPER ? task->n : n;
    place_bytes bytes = bytes_of_places(p, task, places);
    p->place_capacity = (uint32_t)places;
    return buffer_reserve(&p->bounds, p->device, bytes.bounds, err) &&
           (bytes.boxes == 0 || buffer_reserve(&p->boxes, p->device, bytes.boxes, err));
}

static bool reserve_grid(part *p, const part_task *task, const part_range *range, duet_error *err)
{
    size_t words = task->n * sizeof(uint32_t);
    return buffer_reserve(&p->keys, p->device, words, err) &&
           buffer_reserve(&p->keys_spare, p->device, words, err) &&
           (!p->kernels.from_ids || buffer_reserve(&p->ids, p->device, words, err)) &&
           (p->variant.sort == SORT_COUNTING ||
            buffer_reserve(&p->ids_spare, p->device, words, err)) &&
           buffer_reserve(&p->starts, p->device, count_starts(range) * sizeof(uint32_t), err) &&
           reserve_places(p, task, range->expected, err);
}

bool part_build_grid(part *p, const part_task *task, const part_range *range, duet_error *err)
{
    bool counting = p->variant.sort == SORT_COUNTING;
    part_set_args(p, task, range);
    if (!reserve_grid(p, task, range, err) || !clear(p, counting ? count_starts(range) : 0, err))
        return false;
    bool ok = counting ? counting_sort(p, task, range, err) : radix_sort_keys(p, task, range, err);
    return ok && place(p, task, err);
}

// ---------------------------------------------------------------- sending

// The state of the world that a search needs (section 4.1): the sorted hash
// table and the cell start array. rows needs of the table only the ids.
typedef struct grid_piece {
    buffer *from;
    buffer *to;
    size_t bytes;
} grid_piece;

enum { PIECES = 3 };

static int grid_pieces(part *from, part *to, const part_task *task, grid_piece pieces[PIECES])
{
    size_t words = task->n * sizeof(uint32_t);
    size_t starts = ((size_t)task->grid.n_cells + 1 + STARTS_BEHIND) * sizeof(uint32_t);
    pieces[0] = (grid_piece){&from->ids, &to->ids, words};
    pieces[1] = (grid_piece){&from->starts, &to->starts, starts};
    pieces[2] = (grid_piece){&from->keys, &to->keys, words};
    return from->variant.search == SEARCH_PAPER ? 3 : 2;
}

bool part_send_grid(part *from, part *to, const part_task *task, duet_error *err)
{
    grid_piece pieces[PIECES];
    int n = grid_pieces(from, to, task, pieces);
    size_t total = 0;
    for (int i = 0; i < n; ++i)
        total += pieces[i].bytes;
    if (!from->device->info.host_memory &&
        !host_block_reserve(&from->sent, from->devices, 2, total, err))
        return false;
    char *at = from->sent.bytes;
    for (int i = 0; i < n; ++i) {
        void *host = pieces[i].from->host ? pieces[i].from->host : at;
        if (!timeline_read(&from->times, "send grid", pieces[i].from, host, pieces[i].bytes, err))
            return false;
        at = pieces[i].from->host ? at : at + pieces[i].bytes;
    }
    return true;
}

static bool receive_piece(part *to, grid_piece piece, void *host, duet_error *err)
{
    return buffer_hold(piece.to, to->device, host, piece.bytes, err) &&
           timeline_write(&to->times, "receive grid", piece.to, host, piece.bytes, err);
}

// Where both work on host memory the bounds and boxes are there already.
static bool borrow_places(part *to, const part *from, const part_task *task, duet_error *err)
{
    place_bytes bytes = bytes_of_places(from, task, from->place_capacity);
    to->place_capacity = from->place_capacity;
    bool ok =
        buffer_borrow(&to->bounds, to->device, from->bounds.host, bytes.bounds, err) &&
        timeline_write(&to->times, "receive grid", &to->bounds, to->bounds.host, bytes.bounds, err);
    if (ok && bytes.boxes)
        ok = buffer_borrow(&to->boxes, to->device, from->boxes.host, bytes.boxes, err) &&
             timeline_write(&to->times, "receive grid", &to->boxes, to->boxes.host, bytes.boxes,
                            err);
    return ok;
}

bool part_receive_grid(part *to, part *from, const part_task *task, const part_range *range,
                       duet_error *err)
{
    grid_piece pieces[PIECES];
    int n = grid_pieces(from, to, task, pieces);
    char *at = from->sent.bytes;
    part_set_args(to, task, range);
    if (!clear(to, 0, err))
        return false;
    for (int i = 0; i < n; ++i) {
        void *host = pieces[i].from->host ? pieces[i].from->host : at;
        if (!receive_piece(to, pieces[i], host, err))
            return false;
        at = pieces[i].from->host ? at : at + pieces[i].bytes;
    }
    if (to->variant.search == from->variant.search && to->device->info.host_memory &&
        from->device->info.host_memory)
        return borrow_places(to, from, task, err);
    return reserve_places(to, task, task->n, err) && place(to, task, err);
}
