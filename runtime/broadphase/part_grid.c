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
    uint32_t n_counters = PART_COUNTERS;
    buffer *starts = n_starts > 0 ? &p->starts : &p->counters;
    kernel_arg args[] = {ARG_BUFFER(p->counters), ARG(n_counters), ARG_BUFFER(*starts),
                         ARG(n_starts)};
    uint32_t work = n_starts > n_counters ? n_starts : n_counters;
    return timeline_launch(&p->times, "clear", p->kernels.clear, work, args, 4, err);
}

// ---------------------------------------------------------------- sorting

// Up to so many blocks each adds up those before it by itself.
enum { MOST_ADDED_BLOCKS = 2048 };

// Exclusive prefix sum of n words, in place.
static bool scan(part *p, const char *stage, buffer *values, uint32_t n, duet_error *err)
{
    uint32_t block = p->kernels.scan_sums->group * p->kernels.scan_sums->per_item;
    uint32_t n_blocks = (n + block - 1) / block;
    if (!buffer_reserve(&p->sums, p->device, n_blocks * sizeof(uint32_t), err))
        return false;
    kernel_arg sums[] = {ARG_BUFFER(*values), ARG(n), ARG_BUFFER(p->sums)};
    kernel_arg tops[] = {ARG_BUFFER(p->sums), ARG(n_blocks)};
    uint32_t use_tops = n_blocks > MOST_ADDED_BLOCKS;
    kernel_arg blocks[] = {ARG_BUFFER(*values), ARG(n), ARG_BUFFER(p->sums), ARG(use_tops)};
    return timeline_launch(&p->times, stage, p->kernels.scan_sums, n, sums, 3, err) &&
           (!use_tops ||
            timeline_launch(&p->times, stage, p->kernels.scan_tops, 1, tops, 2, err)) &&
           timeline_launch(&p->times, stage, p->kernels.scan_blocks, n, blocks, 4, err);
}

// Hashes the objects up to `to`, once they were sent.
static bool hash_chunk(part *p, const part_task *task, const part_range *range, uint32_t from,
                       uint32_t to, cl_event sent, duet_error *err)
{
    const grid *g = &task->grid;
    kernel_arg args[14] = {ARG_BUFFER(p->objects)};
    uint32_t n_args = 1;
    if (task->sizes)
        args[n_args++] = ARG_BUFFER(p->sizes);
    args[n_args++] = ARG(to);
    if (p->kernels.packed)
        args[n_args++] = ARG_BUFFER(p->names);
    const kernel_arg keys[] = {ARG_BUFFER(p->levels), ARG(g->n_levels),    ARG(g->n_cells),
                               ARG(range->key_from),  ARG(range->home_to), ARG(range->key_to),
                               ARG_BUFFER(p->keys)};
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; ++i)
        args[n_args++] = keys[i];
    if (p->variant.sort == SORT_COUNTING) {
        args[n_args++] = ARG_BUFFER(p->starts);
        args[n_args++] = ARG_BUFFER(p->keys_spare);
    }
    args[n_args++] = ARG_BUFFER(p->counters);
    return timeline_launch_after(&p->times, "hash", p->kernels.hash, from, to, sent, args, n_args,
                                 err);
}

// The only kernel that needs no more of the objects than have come so far.
static bool run_hash(part *p, const part_task *task, const part_range *range, duet_error *err)
{
    uint32_t from = 0;
    bool ok = true;
    for (uint32_t i = 0; ok && i < p->n_chunks; ++i) {
        ok = hash_chunk(p, task, range, from, p->chunks[i].to, p->chunks[i].sent, err);
        from = p->chunks[i].to;
    }
    return ok && hash_chunk(p, task, range, from, task->n, NULL, err);
}

// The keys count into starts, and the ranks tell them apart.
static bool counting_sort(part *p, const part_task *task, const part_range *range, duet_error *err)
{
    uint32_t n_starts = count_starts(range);
    kernel_arg args[] = {ARG_BUFFER(p->keys), ARG_BUFFER(p->keys_spare), ARG(task->n),
                         ARG_BUFFER(p->starts), ARG_BUFFER(p->ids)};
    return run_hash(p, task, range, err) && scan(p, "sort", &p->starts, n_starts, err) &&
           (!p->kernels.from_ids ||
            timeline_launch(&p->times, "sort", p->kernels.scatter, task->n, args, 5, err));
}

static void swap(buffer *a, buffer *b)
{
    buffer other = *a;
    *a = *b;
    *b = other;
}

static bool radix_pass(part *p, const part_task *task, uint32_t shift, duet_error *err)
{
    uint32_t tile = p->kernels.radix_count->group * p->kernels.radix_count->per_item;
    uint32_t n_tiles = (task->n + tile - 1) / tile;
    uint32_t n_counts = n_tiles << p->kernels.radix_bits;
    uint32_t first_pass = shift == 0;
    if (!buffer_reserve(&p->tiles, p->device, n_counts * sizeof(uint32_t), err))
        return false;
    kernel_arg count[] = {ARG_BUFFER(p->keys), ARG(task->n), ARG(shift), ARG_BUFFER(p->tiles)};
    kernel_arg move[] = {ARG_BUFFER(p->keys),
                         ARG_BUFFER(p->ids),
                         ARG(task->n),
                         ARG(shift),
                         ARG(first_pass),
                         ARG_BUFFER(p->tiles),
                         ARG_BUFFER(p->keys_spare),
                         ARG_BUFFER(p->ids_spare)};
    bool ok = timeline_launch(&p->times, "sort", p->kernels.radix_count, task->n, count, 4, err) &&
              scan(p, "sort", &p->tiles, n_counts, err) &&
              timeline_launch(&p->times, "sort", p->kernels.radix_move, task->n, move, 8, err);
    swap(&p->keys, &p->keys_spare);
    swap(&p->ids, &p->ids_spare);
    return ok;
}

static bool find_starts(part *p, const part_task *task, const part_range *range, duet_error *err)
{
    bool paper = p->variant.search == SEARCH_PAPER;
    uint32_t n_cells = paper ? own_cells(range) : count_starts(range) - 1;
    uint64_t work = task->n + (paper ? UINT64_C(0) : UINT64_C(1));
    kernel_arg args[] = {ARG_BUFFER(p->keys), ARG(task->n), ARG(n_cells), ARG_BUFFER(p->starts)};
    if (paper && !timeline_fill(&p->times, "cell start", &p->starts, UINT32_MAX, 0, n_cells, err))
        return false;
    return timeline_launch(&p->times, "cell start", p->kernels.starts, work, args, 4, err);
}

// Objects that are not in the grid have all bits set, so they come last.
static bool radix_sort(part *p, const part_task *task, const part_range *range, duet_error *err)
{
    bool ok = run_hash(p, task, range, err);
    for (uint32_t shift = 0; ok && shift < task->grid.key_bits; shift += p->kernels.radix_bits)
        ok = radix_pass(p, task, shift, err);
    return ok && find_starts(p, task, range, err);
}

// ---------------------------------------------------------------- placing

// The paper's kernels read bounds by id.
static bool place_by_id(part *p, const part_task *task, duet_error *err)
{
    kernel_arg args[] = {ARG_BUFFER(p->objects),   ARG(task->n),          ARG_BUFFER(p->levels),
                         ARG(task->grid.n_levels), ARG_BUFFER(p->bounds), ARG_BUFFER(p->counters)};
    return timeline_launch(&p->times, "bounds", p->kernels.place, task->n, args, 6, err);
}

static bool place_in_cell_order(part *p, const part_task *task, const part_range *range,
                                duet_error *err)
{
    uint32_t n_cells = own_cells(range);
    bool from_ids = p->kernels.from_ids;
    uint32_t capacity = p->place_capacity;
    uint32_t work = from_ids && capacity < task->n ? capacity : task->n;
    kernel_arg args[17] = {ARG_BUFFER(p->objects)};
    uint32_t n_args = 1;
    if (task->sizes)
        args[n_args++] = ARG_BUFFER(p->sizes);
    if (p->kernels.packed)
        args[n_args++] = ARG_BUFFER(p->names);
    args[n_args++] = from_ids ? ARG_BUFFER(p->ids) : ARG_BUFFER(p->keys);
    if (!from_ids)
        args[n_args++] = ARG_BUFFER(p->keys_spare);
    const kernel_arg where[] = {ARG(task->n),  ARG_BUFFER(p->starts), ARG(n_cells),
                                ARG(capacity), ARG_BUFFER(p->levels), ARG(task->grid.n_levels)};
    for (size_t i = 0; i < sizeof where / sizeof where[0]; ++i)
        args[n_args++] = where[i];
    if (p->variant.search == SEARCH_SIMD) {
        args[n_args++] = ARG(task->grid.n_cells);
        args[n_args++] = ARG(range->key_from);
    }
    args[n_args++] = ARG_BUFFER(p->bounds);
    if (task->shape == DUET_SHAPE_POSES)
        args[n_args++] = ARG_BUFFER(p->boxes);
    args[n_args++] = ARG_BUFFER(p->counters);
    return timeline_launch(&p->times, "reorder", p->kernels.place, work, args, n_args, err);
}

static bool place(part *p, const part_task *task, const part_range *range, duet_error *err)
{
    return p->variant.search == SEARCH_PAPER ? place_by_id(p, task, err)
                                             : place_in_cell_order(p, task, range, err);
}

typedef struct place_bytes {
    size_t bounds;
    size_t boxes;
} place_bytes;

// Bounds and boxes of n objects as the search reads them. Columns of lanes run
// past n, for whole vectors are read and written there.
static place_bytes bytes_of_places(const part *p, const part_task *task, size_t n)
{
    enum { LANES = 8 };
    bool poses = task->shape == DUET_SHAPE_POSES;
    bool placed = task->origin > 0.0f;
    if (p->variant.search == SEARCH_SIMD) {
        size_t column = (n + 2 * LANES - 1) / LANES * LANES;
        size_t words = (task->rotated && task->dims == 3 ? 16 : 8) + (placed ? 8 : 0);
        size_t columns = 2 * task->dims + 1 + (placed ? task->dims : 0);
        return (place_bytes){.bounds = column * columns * sizeof(float),
                             .boxes = poses ? column * words * sizeof(float) : 0};
    }
    bool boxes = poses && p->variant.search == SEARCH_GPU;
    return (place_bytes){.bounds = n * (placed ? 3 : 2) * sizeof(cl_float4),
                         .boxes = boxes ? n * (placed ? 4 : 3) * sizeof(cl_float4) : 0};
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
    if (!reserve_grid(p, task, range, err) || !clear(p, counting ? count_starts(range) : 0, err))
        return false;
    bool ok = counting ? counting_sort(p, task, range, err) : radix_sort(p, task, range, err);
    return ok && place(p, task, range, err);
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
    return reserve_places(to, task, task->n, err) && place(to, task, range, err);
}
