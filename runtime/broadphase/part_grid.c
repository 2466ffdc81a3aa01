// SPDX-License-Identifier: MIT
// How a part gets its grid: it sorts the objects by their cells and puts them into that order, or
// takes what the other part has sorted.
#include "runtime/broadphase/part.h"

static void set_args(part *p)
{
    const part_range *range = &p->task.range;
    bool paper = p->variant.search == SEARCH_PAPER;
    uint32_t placed = range->last < range->expected ? range->last : range->expected;
    p->args = (part_args){
        .n = p->objects.n,
        .n_levels = p->task.grid->n_levels,
        .n_cells = p->task.grid->n_cells,
        .n_home_cells = range->home_to - range->key_from,
        .n_own_cells = range->key_to - range->key_from,
        .n_counters = COUNTERS,
        .n_owned = p->task.ids ? p->task.ids->n : 0,
        .last = paper ? range->last : placed,
        .cells = p->task.grid->levels[0].cells,
        .objects = p->objects.bound.mem ? p->objects.bound : p->objects.own,
    };
}

static uint32_t own_cells(const part *p)
{
    return p->task.range.key_to - p->task.range.key_from;
}

// A search reads so many words behind the last one: nothing begins there.
enum { STARTS_BEHIND = 3 };

// The first place of each cell, then how many objects have one.
static uint32_t count_starts(const part *p)
{
    return own_cells(p) + 1 + STARTS_BEHIND;
}

// Zeroes the counters, and with them n_counts of the objects a cell. Mostly the step before has done that (p->zero_words).
static bool clear(part *p, uint32_t n_counts, duet_error *err)
{
    uint32_t work = n_counts > COUNTERS ? n_counts : COUNTERS;
    bool is_done = COUNTERS + n_counts <= p->zero_words;
    buffer_swap(&p->counters, &p->next_counters);
    p->zero_words = 0;
    p->args.n_counts = n_counts;
    return is_done || timeline_launch(&p->times, "clear", p->kernels.clear, work, p, err);
}

// ---------------------------------------------------------------- sorting

// Hashes the objects up to `to`, once they were sent.
static bool hash_chunk(part *p, uint32_t from, uint32_t to, cl_event sent, duet_error *err)
{
    p->args.n_hashed = from;
    p->args.n = to;
    return timeline_launch_after(&p->times, "hash", p->kernels.hash, to - from, sent, p, err);
}

// The only kernel that needs no more of the objects than have come so far.
static bool hash_chunks(part *p, duet_error *err)
{
    const device_view *v = &p->objects;
    uint32_t from = 0;
    bool ok = true;
    for (uint32_t i = 0; ok && i < v->n_chunks; from = v->chunks[i++].to)
        ok = hash_chunk(p, from, v->chunks[i].to, v->chunks[i].sent, err);
    return ok && hash_chunk(p, from, p->objects.n, NULL, err);
}

// Words of earlier steps have another epoch.
static bool reserve_requests(part *p, uint32_t n, duet_error *err)
{
    buffer *b = &p->requests.words;
    size_t before = b->bytes;
    ++p->requests.last.epoch;
    return buffer_reserve(b, p->device, (n / INPUT_BLOCK + 1) * sizeof(uint32_t), err) &&
           (b->bytes == before ||
            timeline_fill(&p->times, "clear", b, 0, 0, b->bytes / sizeof(uint32_t), err));
}

// Starts to read the requests if the device has memory of its own; else the search shows them.
static bool read_requests(part *p, duet_error *err)
{
    const buffer *words = &p->requests.words;
    const size_t bytes = words->bytes;
    bool ok = p->device->info.host_memory ||
              (host_block_reserve(&p->requests.on_host, p->device, 1, bytes, err) &&
               timeline_start_read(&p->times, "fetch marks", &p->requests.words, 0,
                                   p->requests.on_host.bytes, bytes, err));
    p->requests.last.words = words->host ? words->host : p->requests.on_host.bytes;
    return ok;
}

// The part marks which objects of its own range, the first one, the other part needs. Nobody reads
// the marks of other ranges.
static bool hash_ranges(part *p, duet_error *err)
{
    const selection *s = &p->task.wanted;
    const row_span *own = &s->ranges[s->own];
    p->args.marked_from = p->task.range.other_from;
    p->args.marked_to = p->task.range.other_to;
    bool ok = hash_chunk(p, own->from, own->to, NULL, err) && read_requests(p, err);
    p->args.marked_from = p->args.marked_to = 0;
    for (uint32_t i = 0; ok && i < s->n_ranges; ++i)
        ok = i == s->own || hash_chunk(p, s->ranges[i].from, s->ranges[i].to, NULL, err);
    p->args.n = p->objects.n;
    return ok;
}

// Objects outside the ranges get no key.
static bool fill_gaps(part *p, duet_error *err)
{
    const selection *s = &p->task.wanted;
    uint32_t from = 0;
    bool ok = true;
    for (uint32_t i = 0; ok && i < s->n_ranges; from = s->ranges[i++].to)
        ok = timeline_fill(&p->times, "hash", &p->keys, UINT32_MAX, from, s->ranges[i].from, err);
    return ok && timeline_fill(&p->times, "hash", &p->keys, UINT32_MAX, from, p->objects.n, err);
}

static bool find_own_cells(part *p, duet_error *err)
{
    size_t edges = p->objects.n / (size_t)p->kernels.hash->per_item + 2;
    p->args.n = p->objects.n;
    return buffer_reserve(&p->edges, p->device, edges * sizeof(uint32_t), err) &&
           timeline_launch(&p->times, "hash", p->kernels.own_cells, 1, p, err);
}

// all: kernels follow that read every object's key.
static bool hash_objects(part *p, bool all, duet_error *err)
{
    const bool in_ranges = p->task.wanted.kind == SELECT_RANGES;
    uint32_t n = p->objects.n;
    bool ok = !p->kernels.own_cells || n == 0 || find_own_cells(p, err);
    ok = ok && (in_ranges ? hash_ranges(p, err) : hash_chunks(p, err)) &&
         (!in_ranges || !all || fill_gaps(p, err));
    return ok && (!p->kernels.count_others ||
                  timeline_launch(&p->times, "hash", p->kernels.count_others, n, p, err));
}

// Runs a kernel over the objects that the part reads.
static bool launch_over_objects(part *p, const char *stage, const kernel *k, duet_error *err)
{
    const selection all = select_all(p->objects.n);
    const selection *s = p->task.wanted.kind == SELECT_RANGES ? &p->task.wanted : &all;
    bool ok = true;
    for (uint32_t i = 0; ok && i < s->n_ranges; ++i) {
        p->args.n_hashed = s->ranges[i].from;
        p->args.n = s->ranges[i].to;
        ok = timeline_launch(&p->times, stage, k, s->ranges[i].to - s->ranges[i].from, p, err);
    }
    p->args.n = p->objects.n;
    return ok;
}

// Counting by key yields the cells' starts; the rank is the place within the cell.
static bool counting_sort(part *p, duet_error *err)
{
    return hash_objects(p, false, err) &&
           scan_run(&p->scan, &p->times, "sort", &p->counts, &p->starts, count_starts(p), err) &&
           (!(p->facts & PART_BY_IDS) || launch_over_objects(p, "sort", p->kernels.scatter, err));
}

static bool find_starts(part *p, duet_error *err)
{
    bool paper = p->variant.search == SEARCH_PAPER;
    uint64_t work = p->objects.n + (paper ? UINT64_C(0) : UINT64_C(1));
    p->args.key_end = paper ? own_cells(p) : count_starts(p) - 1;
    if (paper &&
        !timeline_fill(&p->times, "cell start", &p->starts, UINT32_MAX, 0, p->args.key_end, err))
        return false;
    return timeline_launch(&p->times, "cell start", p->kernels.starts, work, p, err);
}

// Objects that are not in the grid have all bits set, so they come last.
static bool radix_sort_keys(part *p, duet_error *err)
{
    const radix_lists lists = {&p->keys, &p->ids, &p->keys_spare, &p->ids_spare};
    return hash_objects(p, true, err) &&
           radix_sort_run(&p->radix, &p->times, "sort", &lists, p->objects.n,
                          p->task.grid->key_bits, err) &&
           find_starts(p, err);
}

// ---------------------------------------------------------------- placing

// The paper's kernels read bounds by id; the others read objects in cell order.
static bool place(part *p, duet_error *err)
{
    uint32_t n = p->objects.n;
    if (p->variant.search == SEARCH_PAPER)
        return timeline_launch(&p->times, "bounds", p->kernels.place, n, p, err);
    uint32_t work = n < p->place_capacity ? n : p->place_capacity;
    uint32_t launches_before = p->times.n_launches;
    bool ok = (p->facts & PART_BY_IDS)
                  ? timeline_launch(&p->times, "reorder", p->kernels.place, work, p, err)
                  : launch_over_objects(p, "reorder", p->kernels.place, err);
    if (p->times.n_launches > launches_before) // none, if the part reads no object
        p->zero_words = COUNTERS + p->args.n_counts;
    return ok;
}

// Rotated boxes that have a radius: a quaternion and that, in 2D fewer
// (kernels/narrowphase/sat.clh).
enum { ROUNDED_MORE = 5 };

typedef struct place_bytes {
    size_t bounds;
    size_t boxes;
} place_bytes;

// Bounds and boxes of n objects as the search reads them. Columns of lanes run
// past n, for whole vectors are read and written there.
static place_bytes bytes_of_places(const part *p, size_t n)
{
    bool poses = p->task.objects->shape != DUET_SHAPE_BOUNDS;
    bool turned = p->task.def->rotated && p->task.objects->shape != DUET_SHAPE_SPHERES;
    bool has_origin = p->task.objects->origin > 0.0f;
    if (p->variant.search == SEARCH_SIMD) {
        size_t columns = BOUNDS_COLUMNS_OF(p->task.objects->dims, has_origin);
        size_t more = MOST_MORE_OF(p->task.objects->dims, turned);
        if (grid_has_radii(p->task.objects) && turned)
            more = ROUNDED_MORE;
        size_t words = BOX_WORDS_OF(more, has_origin);
        return (place_bytes){.bounds = COLUMN(n) * columns * sizeof(float),
                             .boxes = poses ? COLUMN(n) * words * sizeof(float) : 0};
    }
    bool boxes = poses && p->variant.search == SEARCH_GPU && !(p->facts & PART_LEAVES_BOXES);
    return (place_bytes){.bounds = n * BOUNDS_QUADS_OF(has_origin) * sizeof(cl_float4),
                         .boxes = boxes ? n * BOX_QUADS_OF(has_origin) * sizeof(cl_float4) : 0};
}

static bool reserve_places(part *p, size_t n, duet_error *err)
{
    size_t places = p->variant.search == SEARCH_PAPER ? p->objects.n : n;
    place_bytes bytes = bytes_of_places(p, places);
    p->place_capacity = (uint32_t)places;
    return buffer_reserve(&p->bounds, p->device, bytes.bounds, err) &&
           (bytes.boxes == 0 || buffer_reserve(&p->boxes, p->device, bytes.boxes, err));
}

// Without a counting sort nothing is counted.
static bool reserve_counts(part *p, duet_error *err)
{
    size_t before = p->counts.bytes;
    size_t words = p->variant.sort == SORT_COUNTING ? count_starts(p) : 1;
    bool ok = buffer_reserve(&p->counts, p->device, words * sizeof(uint32_t), err);
    if (p->counts.bytes != before)
        p->zero_words = 0;
    return ok;
}

static bool reserve_grid(part *p, duet_error *err)
{
    size_t words = p->objects.n * sizeof(uint32_t);
    return buffer_reserve(&p->keys, p->device, words, err) &&
           buffer_reserve(&p->keys_spare, p->device, words, err) &&
           (!(p->facts & PART_BY_IDS) || buffer_reserve(&p->ids, p->device, words, err)) &&
           (p->variant.sort == SORT_COUNTING ||
            buffer_reserve(&p->ids_spare, p->device, words, err)) &&
           buffer_reserve(&p->starts, p->device, count_starts(p) * sizeof(uint32_t), err) &&
           reserve_counts(p, err) && reserve_places(p, p->task.range.expected, err);
}

bool part_build_grid(part *p, duet_error *err)
{
    bool counting = p->variant.sort == SORT_COUNTING;
    set_args(p);
    bool ok = reserve_grid(p, err) &&
              (p->task.wanted.kind != SELECT_RANGES || reserve_requests(p, p->objects.n, err)) &&
              clear(p, counting ? count_starts(p) : 0, err);
    if (!ok)
        return false;
    ok = counting ? counting_sort(p, err) : radix_sort_keys(p, err);
    return ok && place(p, err);
}

// ---------------------------------------------------------------- a grid for both

// The state of the world that a search needs (section 4.1): the sorted hash
// table and the cell start array. rows needs of the table only the ids.
typedef struct grid_piece {
    buffer *from;
    buffer *to;
    size_t bytes;
} grid_piece;

enum { PIECES = 3 };

static int grid_pieces(part *from, part *to, grid_piece pieces[PIECES])
{
    size_t words = from->objects.n * sizeof(uint32_t);
    size_t starts = ((size_t)from->task.grid->n_cells + 1 + STARTS_BEHIND) * sizeof(uint32_t);
    pieces[0] = (grid_piece){&from->ids, &to->ids, words};
    pieces[1] = (grid_piece){&from->starts, &to->starts, starts};
    pieces[2] = (grid_piece){&from->keys, &to->keys, words};
    return from->variant.search == SEARCH_PAPER ? 3 : 2;
}

// The place of a piece on the host: where the sender has it, or the next in the block.
static void *place_on_host(const grid_piece *piece, char **next)
{
    char *at = *next;
    if (piece->from->host)
        return piece->from->host;
    *next += piece->bytes;
    return at;
}

bool part_send_grid(part *from, part *to, duet_error *err)
{
    grid_piece pieces[PIECES];
    int n = grid_pieces(from, to, pieces);
    size_t total = 0;
    for (int i = 0; i < n; ++i)
        total += pieces[i].bytes;
    if (!from->device->info.host_memory &&
        !host_block_reserve(&from->sent, from->devices, 2, total, err))
        return false;
    char *next = from->sent.bytes;
    bool ok = true;
    for (int i = 0; ok && i < n; ++i)
        ok = timeline_read(&from->times, "send grid", pieces[i].from,
                           place_on_host(&pieces[i], &next), pieces[i].bytes, err);
    return ok;
}

static bool receive_piece(part *to, grid_piece piece, void *host, duet_error *err)
{
    return buffer_hold(piece.to, to->device, host, piece.bytes, err) &&
           timeline_write(&to->times, "receive grid", piece.to, host, piece.bytes, err);
}

// The bounds and boxes are there already if both devices work on host memory.
static bool borrow_places(part *to, const part *from, duet_error *err)
{
    place_bytes bytes = bytes_of_places(from, from->place_capacity);
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

bool part_receive_grid(part *to, part *from, duet_error *err)
{
    grid_piece pieces[PIECES];
    int n = grid_pieces(from, to, pieces);
    char *next = from->sent.bytes;
    set_args(to);
    bool ok = clear(to, 0, err);
    for (int i = 0; ok && i < n; ++i)
        ok = receive_piece(to, pieces[i], place_on_host(&pieces[i], &next), err);
    if (!ok)
        return false;
    if (to->variant.search == from->variant.search && to->device->info.host_memory &&
        from->device->info.host_memory)
        return borrow_places(to, from, err);
    return reserve_places(to, to->objects.n, err) && place(to, err);
}
