// SPDX-License-Identifier: MIT
// What a device does in a step, in this order: it gets the objects, sorts them into its grid,
// finds their pairs and brings these to the host.
#include "runtime/broadphase/part.h"

#include "runtime/broadphase/pair_count.h"
#include "runtime/broadphase/strays.h"

#include "base/clock.h"
#include "base/error.h"
#include "kernels/grid/pair_counts.h"
#include "runtime/narrowphase/narrow.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/narrowphase/rounded.h"

#include <stdlib.h>
#include <string.h>

part_found part_found_of(const uint32_t counts[COUNTERS])
{
    part_found found = {
        .candidates = (uint64_t)counts[COUNT_CANDIDATES + 1] << 32 | counts[COUNT_CANDIDATES],
        .pairs = (uint64_t)counts[COUNT_PAIRS + 1] << 32 | counts[COUNT_PAIRS],
        .undecided = (uint64_t)counts[COUNT_UNDECIDED + 1] << 32 | counts[COUNT_UNDECIDED],
        .tested = (uint64_t)counts[COUNT_TESTED + 1] << 32 | counts[COUNT_TESTED],
        .bad = counts[COUNT_BAD],
        .first_bad = ~counts[FIRST_BAD],
        .placed = counts[COUNT_PLACED],
    };
    memcpy(&found.widest, &counts[WIDEST], sizeof found.widest);
    return found;
}

void part_distrust(part *p)
{
    timeline_clear(&p->times);
    p->objects_version = p->sizes_version = p->levels_version = p->ahead_version = 0;
    p->packed.objects_version = p->stretched.objects_version = p->ids_version = 0;
    p->zero_counts = 0;
    p->next_are_cleared = false;
}

void part_forget(part *p)
{
    if (p->untimed)
        timeline_begin_untimed(&p->times, p->device);
    else
        timeline_begin(&p->times, p->device);
    p->ahead_version = 0;
    p->span = (duet_span){0};
    p->counted = (part_counted){0};
    p->n_candidates = p->n_undecided = 0;
    p->runs = 0;
    p->wall_ms = 0.0;
    p->found = part_found_of((uint32_t[COUNTERS]){0});
}

// ---------------------------------------------------------------- objects

// A chunk is whole groups of the kernels that take them, the last one apart. All are powers of two.
static uint32_t chunk_size(const part *p, uint32_t n)
{
    uint64_t unit = (uint64_t)p->kernels.hash->group * p->kernels.hash->per_item;
    unit = p->kernels.skim && unit < SKIM_ROWS ? SKIM_ROWS : unit;
    uint64_t size = (uint64_t)n / PART_CHUNKS + 1;
    size = size < p->least_chunk ? p->least_chunk : size;
    size = (size + unit - 1) / unit * unit;
    return size < n ? (uint32_t)size : n;
}

// All chunks of those from `from` on are on their way at once, beside the kernels.
static bool send_chunks(part *p, const part_task *task, uint32_t from, duet_error *err)
{
    size_t bytes = grid_object_bytes(&task->objects);
    uint32_t size = chunk_size(p, task->objects.n - from);
    for (; from < task->objects.n; from = p->chunks[p->n_chunks - 1].to) {
        uint32_t n = task->objects.n - from < size ? task->objects.n - from : size;
        if (!timeline_write_beside(&p->times, "send objects", &p->objects, from * bytes,
                                   (const char *)task->objects.array + from * bytes, n * bytes,
                                   err))
            return false;
        p->chunks[p->n_chunks++] =
            (part_chunk){.to = from + n, .sent = timeline_last_event(&p->times)};
    }
    return true;
}

static bool wants_chunks(const part *p, const part_task *task)
{
    return p->variant.send == SEND_CHUNKS && !task->receives && !p->device->info.host_memory;
}

// Objects that the device has already are not sent again.
static bool send_objects(part *p, const part_task *task, size_t bytes, duet_error *err)
{
    p->packed.objects_version = 0;
    bool ok = buffer_hold(&p->objects, p->device, (void *)task->objects.array, bytes, err);
    if (task->strays && !p->device->info.host_memory)
        return ok; // part_build_grid sends its stretches
    uint32_t ahead = p->n_chunks > 0 ? p->chunks[p->n_chunks - 1].to : 0;
    if (ok && p->objects_version != task->objects_version)
        ok = ahead > 0 || wants_chunks(p, task)
                 ? send_chunks(p, task, ahead, err)
                 : timeline_write(&p->times, "send objects", &p->objects, task->objects.array,
                                  bytes, err);
    p->objects_version = ok ? task->objects_version : 0;
    return ok;
}

static bool send_sizes(part *p, const part_task *task, duet_error *err)
{
    if (!task->objects.sizes || p->sizes_version == task->sizes_version)
        return true;
    size_t bytes = ((size_t)task->objects.n + 1) * sizeof *task->objects.sizes;
    bool ok = buffer_hold(&p->sizes, p->device, (void *)task->objects.sizes, bytes, err) &&
              timeline_write(&p->times, "send objects", &p->sizes, task->objects.sizes, bytes, err);
    p->sizes_version = ok ? task->sizes_version : 0;
    return ok;
}

static bool send_levels(part *p, const part_task *task, duet_error *err)
{
    if (p->levels_version == task->grid_version)
        return true;
    bool ok = timeline_write(&p->times, "send objects", &p->levels, task->grid.levels,
                             task->grid.n_levels * sizeof task->grid.levels[0], err);
    p->levels_version = ok ? task->grid_version : 0;
    return ok;
}

bool part_send_ahead(part *p, const part_task *task, size_t bytes, duet_error *err)
{
    part_forget(p);
    p->n_chunks = 0;
    p->objects_version = p->packed.objects_version = p->stretched.objects_version = 0;
    if (!buffer_reserve(&p->objects, p->device, bytes, err) || !send_chunks(p, task, 0, err))
        return false;
    p->ahead_version = task->objects_version;
    return true;
}

// Blocks of a chunk travel while the next one is on its way.
static bool skim_chunk(part *p, uint32_t from, part_chunk *c, duet_error *err)
{
    size_t at = from / SKIM_ROWS, end = ((size_t)c->to + SKIM_ROWS - 1) / SKIM_ROWS;
    p->args.skim_from = from;
    p->args.n = c->to;
    bool ok =
        timeline_launch_after(&p->times, "skim", p->kernels.skim, c->to - from, c->sent, p, err) &&
        timeline_start_read(&p->times, "fetch skim", &p->skimmed, at * sizeof(skim_block),
                            (skim_block *)p->skim_seen.bytes + at, (end - at) * sizeof(skim_block),
                            err);
    c->skimmed = timeline_last_event(&p->times);
    return ok;
}

bool part_skim(part *p, const float inside_lower[3], const float inside_upper[3], duet_error *err)
{
    if (!p->kernels.skim || p->ahead_version == 0 || p->n_chunks == 0)
        return false;
    uint32_t n = p->chunks[p->n_chunks - 1].to, from = 0;
    size_t bytes = ((size_t)n + SKIM_ROWS - 1) / SKIM_ROWS * sizeof(skim_block);
    bool ok = buffer_reserve(&p->skimmed, p->device, bytes, err) &&
              host_block_reserve(&p->skim_seen, p->device, 1, bytes, err);
    p->args = (part_args){.objects = p->objects};
    memcpy(&p->args.inside_lower, inside_lower, 3 * sizeof *inside_lower);
    memcpy(&p->args.inside_upper, inside_upper, 3 * sizeof *inside_upper);
    for (uint32_t i = 0; ok && i < p->n_chunks; from = p->chunks[i++].to)
        ok = skim_chunk(p, from, &p->chunks[i], err);
    return ok;
}

uint32_t part_await_skim(part *p, uint32_t from, const skim_block **blocks)
{
    uint32_t i = 0;
    while (p->chunks[i].to <= from)
        ++i;
    timeline_spin(&p->times, p->chunks[i].skimmed);
    *blocks = p->skim_seen.bytes;
    return p->chunks[i].to;
}

// What was sent ahead is of use where all objects are sent, to where it is.
static void take_ahead(part *p, const part_task *task, size_t bytes)
{
    bool takes = p->ahead_version == task->objects_version && !task->packed && !task->strays &&
                 !task->resident && p->objects.bytes >= bytes;
    if (p->ahead_version > 0 && !takes)
        timeline_clear(&p->times);
    p->n_chunks = takes ? p->n_chunks : 0;
    p->ahead_version = 0;
}

bool part_begin(part *p, const part_task *task, duet_error *err)
{
    size_t bytes = task->objects.n * grid_object_bytes(&task->objects);
    take_ahead(p, task, bytes);
    if (bytes == 0)
        return true;
    return (task->packed || task->resident || send_objects(p, task, bytes, err)) &&
           send_sizes(p, task, err) && send_levels(p, task, err) &&
           (!task->ids || part_send_ids(p, task->ids, err));
}

// ---------------------------------------------------------------- grid

// Waits for all that was launched.
static bool read_counters(part *p, duet_error *err)
{
    uint32_t counts[COUNTERS];
    bool ok = timeline_read(&p->times, "fetch pairs", &p->counters, counts, sizeof counts, err);
    if (ok)
        p->found = part_found_of(counts);
    return ok;
}

static void set_args(part *p, const part_task *task, const part_range *range)
{
    bool paper = p->variant.search == SEARCH_PAPER;
    uint32_t placed = range->last < range->expected ? range->last : range->expected;
    p->args = (part_args){
        .n = task->objects.n,
        .n_levels = task->grid.n_levels,
        .n_cells = task->grid.n_cells,
        .key_from = range->key_from,
        .key_home_to = range->home_to,
        .key_to = range->key_to,
        .n_home_cells = range->home_to - range->key_from,
        .n_own_cells = range->key_to - range->key_from,
        .n_counters = COUNTERS,
        .n_homes = task->ids ? task->ids->n : 0,
        .first = range->first,
        .last = paper ? range->last : placed,
        .cells = task->grid.levels[0].cells,
        .objects = task->resident ? *task->resident : p->objects,
    };
}

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

// Zeroes the counters, and with them n_counts of the objects a cell. Mostly the step before has
// done that: it left the counts at zero, and these counters.
static bool clear(part *p, uint32_t n_counts, duet_error *err)
{
    uint32_t work = n_counts > COUNTERS ? n_counts : COUNTERS;
    bool is_done = p->next_are_cleared && n_counts <= p->zero_counts;
    buffer_swap(&p->counters, &p->next_counters);
    p->next_are_cleared = false;
    p->zero_counts = n_counts > p->zero_counts ? n_counts : p->zero_counts;
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
static bool run_hash(part *p, const part_task *task, duet_error *err)
{
    uint32_t from = 0;
    bool ok = true;
    for (uint32_t i = 0; ok && i < p->n_chunks; ++i) {
        ok = hash_chunk(p, from, p->chunks[i].to, p->chunks[i].sent, err);
        from = p->chunks[i].to;
    }
    return ok && hash_chunk(p, from, task->objects.n, NULL, err);
}

static bool send_stretch(part *p, const part_task *task, stretch s, duet_error *err)
{
    size_t bytes = grid_object_bytes(&task->objects);
    const char *rows = (const char *)task->objects.array + s.from * bytes;
    return timeline_write_at(&p->times, "send objects", &p->objects, s.from * bytes, rows,
                             (s.to - s.from) * bytes, err);
}

// Sends the part what it takes of the input and does not have: its own stretch first.
static bool send_stretches(part *p, const part_task *task, duet_error *err)
{
    const strays *s = task->strays;
    bool all = p->device->info.host_memory || p->objects_version == task->objects_version;
    bool own = p->stretched.objects_version == task->objects_version && p->stretched.cut == s->cut;
    bool others = own && p->stretched.strays_version == s->version;
    p->taken = strays_taken(s, task->side);
    if (all)
        return true;
    p->objects_version = p->stretched.objects_version = 0;
    bool ok = own || send_stretch(p, task, strays_own(s, task->side), err);
    for (uint32_t i = 0; ok && !others && i < p->taken.n; ++i)
        ok = i == p->taken.own || send_stretch(p, task, p->taken.list[i], err);
    if (ok) {
        p->stretched.objects_version = task->objects_version;
        p->stretched.strays_version = s->version;
        p->stretched.cut = s->cut;
    }
    return ok;
}

// Marks of steps before are other stamps.
static bool reserve_marks(part *p, uint32_t n, duet_error *err)
{
    size_t words = n / STRAY_BLOCK + 1;
    size_t before = p->marks.bytes;
    ++p->stamp;
    return buffer_reserve(&p->marks, p->device, words * sizeof(uint32_t), err) &&
           (p->marks.bytes == before || timeline_fill(&p->times, "clear", &p->marks, 0, 0,
                                                      p->marks.bytes / sizeof(uint32_t), err));
}

stray_marks part_marks(const part *p)
{
    return (stray_marks){p->marks.host ? p->marks.host : p->marks_seen.bytes, p->stamp};
}

// On their way where the device has memory of its own; else the search shows them.
static bool ask_for_marks(part *p, duet_error *err)
{
    return p->device->info.host_memory ||
           (host_block_reserve(&p->marks_seen, p->device, 1, p->marks.bytes, err) &&
            timeline_start_read(&p->times, "fetch marks", &p->marks, 0, p->marks_seen.bytes,
                                p->marks.bytes, err));
}

// The part marks what the other one wants of its own stretch, which comes first; marks of others
// that lie side by side with it are nobody's concern.
static bool hash_stretches(part *p, const part_task *task, duet_error *err)
{
    const part_range *other = strays_wanted_by_other(task->strays, task->side);
    const stretches taken = strays_joined(&p->taken);
    const stretch *own = &taken.list[taken.own];
    p->args.marked_from = other->key_from;
    p->args.marked_to = other->key_to;
    bool ok = hash_chunk(p, own->from, own->to, NULL, err) && ask_for_marks(p, err);
    p->args.marked_from = p->args.marked_to = 0;
    for (uint32_t i = 0; ok && i < taken.n; ++i)
        ok = i == taken.own || hash_chunk(p, taken.list[i].from, taken.list[i].to, NULL, err);
    p->args.n = task->objects.n;
    return ok;
}

// Objects that were not taken are nowhere.
static bool pass_over_rest(part *p, uint32_t n, duet_error *err)
{
    uint32_t from = 0;
    bool ok = true;
    for (uint32_t i = 0; ok && i < p->taken.n; ++i) {
        const stretch *s = &p->taken.list[i];
        ok = timeline_fill(&p->times, "hash", &p->keys, UINT32_MAX, from, s->from, err);
        from = s->to;
    }
    return ok && timeline_fill(&p->times, "hash", &p->keys, UINT32_MAX, from, n, err);
}

// all: kernels follow that look at every object's key.
static bool hash_objects(part *p, const part_task *task, bool all, duet_error *err)
{
    return task->strays
               ? hash_stretches(p, task, err) && (!all || pass_over_rest(p, task->objects.n, err))
               : run_hash(p, task, err);
}

// Runs a kernel over the objects that were taken.
static bool launch_over_taken(part *p, const part_task *task, const char *stage, const kernel *k,
                              duet_error *err)
{
    const stretches all = {.list = {{0, task->objects.n}}, .n = 1};
    const stretches taken = task->strays ? strays_joined(&p->taken) : all;
    bool ok = true;
    for (uint32_t i = 0; ok && i < taken.n; ++i) {
        const stretch *s = &taken.list[i];
        p->args.n_hashed = s->from;
        p->args.n = s->to;
        ok = timeline_launch(&p->times, stage, k, s->to - s->from, p, err);
    }
    p->args.n = task->objects.n;
    return ok;
}

// The keys count into starts, and the ranks tell them apart.
static bool counting_sort(part *p, const part_task *task, const part_range *range, duet_error *err)
{
    return hash_objects(p, task, false, err) &&
           scan_run(&p->scan, &p->times, "sort", &p->counts, &p->starts, count_starts(range),
                    err) &&
           (!p->kernels.from_ids || launch_over_taken(p, task, "sort", p->kernels.scatter, err));
}

static bool find_starts(part *p, const part_task *task, const part_range *range, duet_error *err)
{
    bool paper = p->variant.search == SEARCH_PAPER;
    uint64_t work = task->objects.n + (paper ? UINT64_C(0) : UINT64_C(1));
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
    return hash_objects(p, task, true, err) &&
           radix_sort_run(&p->radix, &p->times, "sort", &lists, task->objects.n,
                          task->grid.key_bits, err) &&
           find_starts(p, task, range, err);
}

// ---------------------------------------------------------------- placing

// The paper's kernels read bounds by id; the others read objects in cell order.
static bool place(part *p, const part_task *task, duet_error *err)
{
    uint32_t n = task->objects.n;
    if (p->variant.search == SEARCH_PAPER)
        return timeline_launch(&p->times, "bounds", p->kernels.place, n, p, err);
    uint32_t work = n < p->place_capacity ? n : p->place_capacity;
    uint32_t launches_before = p->times.n_launches;
    bool ok = p->kernels.from_ids
                  ? timeline_launch(&p->times, "reorder", p->kernels.place, work, p, err)
                  : launch_over_taken(p, task, "reorder", p->kernels.place, err);
    p->next_are_cleared = p->times.n_launches > launches_before; // none where no object was taken
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
static place_bytes bytes_of_places(const part *p, const part_task *task, size_t n)
{
    bool poses = task->objects.shape != DUET_SHAPE_BOUNDS;
    bool turned = task->rotated && task->objects.shape != DUET_SHAPE_SPHERES;
    bool has_origin = task->objects.origin > 0.0f;
    if (p->variant.search == SEARCH_SIMD) {
        size_t columns = BOUNDS_COLUMNS_OF(task->objects.dims, has_origin);
        size_t more = MOST_MORE_OF(task->objects.dims, turned);
        if (grid_has_radii(&task->objects) && turned)
            more = ROUNDED_MORE;
        size_t words = BOX_WORDS_OF(more, has_origin);
        return (place_bytes){.bounds = COLUMN(n) * columns * sizeof(float),
                             .boxes = poses ? COLUMN(n) * words * sizeof(float) : 0};
    }
    bool boxes = poses && p->variant.search == SEARCH_GPU && !p->kernels.unboxed;
    return (place_bytes){.bounds = n * BOUNDS_QUADS_OF(has_origin) * sizeof(cl_float4),
                         .boxes = boxes ? n * BOX_QUADS_OF(has_origin) * sizeof(cl_float4) : 0};
}

static bool reserve_places(part *p, const part_task *task, size_t n, duet_error *err)
{
    size_t places = p->variant.search == SEARCH_PAPER ? task->objects.n : n;
    place_bytes bytes = bytes_of_places(p, task, places);
    p->place_capacity = (uint32_t)places;
    return buffer_reserve(&p->bounds, p->device, bytes.bounds, err) &&
           (bytes.boxes == 0 || buffer_reserve(&p->boxes, p->device, bytes.boxes, err));
}

// Without a counting sort nothing is counted.
static bool reserve_counts(part *p, const part_range *range, duet_error *err)
{
    size_t before = p->counts.bytes;
    size_t words = p->variant.sort == SORT_COUNTING ? count_starts(range) : 1;
    bool ok = buffer_reserve(&p->counts, p->device, words * sizeof(uint32_t), err);
    if (p->counts.bytes != before)
        p->zero_counts = 0;
    return ok;
}

static bool reserve_grid(part *p, const part_task *task, const part_range *range, duet_error *err)
{
    size_t words = task->objects.n * sizeof(uint32_t);
    return buffer_reserve(&p->keys, p->device, words, err) &&
           buffer_reserve(&p->keys_spare, p->device, words, err) &&
           (!p->kernels.from_ids || buffer_reserve(&p->ids, p->device, words, err)) &&
           (p->variant.sort == SORT_COUNTING ||
            buffer_reserve(&p->ids_spare, p->device, words, err)) &&
           buffer_reserve(&p->starts, p->device, count_starts(range) * sizeof(uint32_t), err) &&
           reserve_counts(p, range, err) && reserve_places(p, task, range->expected, err);
}

bool part_build_grid(part *p, const part_task *task, const part_range *range, duet_error *err)
{
    bool counting = p->variant.sort == SORT_COUNTING;
    set_args(p, task, range);
    bool ok = reserve_grid(p, task, range, err) &&
              (!task->strays ||
               (send_stretches(p, task, err) && reserve_marks(p, task->objects.n, err))) &&
              clear(p, counting ? count_starts(range) : 0, err);
    if (!ok)
        return false;
    ok = counting ? counting_sort(p, task, range, err) : radix_sort_keys(p, task, range, err);
    return ok && place(p, task, err);
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

static int grid_pieces(part *from, part *to, const part_task *task, grid_piece pieces[PIECES])
{
    size_t words = task->objects.n * sizeof(uint32_t);
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
    set_args(to, task, range);
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
    return reserve_places(to, task, task->objects.n, err) && place(to, task, err);
}

// ---------------------------------------------------------------- searching

enum { LEAST_CAPACITY = 1024 };

// Pairs that fit a buffer; the kernels count places in 32 bits.
static uint32_t capacity_of(const buffer *b)
{
    size_t capacity = b->bytes / sizeof(duet_pair);
    return capacity > UINT32_MAX ? UINT32_MAX : (uint32_t)capacity;
}

static bool reserve_pairs(part *p, buffer *b, uint64_t pairs, duet_error *err)
{
    if (pairs > UINT32_MAX)
        return error_set(err, DUET_STATUS_TOO_MANY,
                         "%s: %llu pairs, more than the %u that one device can list",
                         p->device->info.selector, (unsigned long long)pairs, UINT32_MAX);
    if (pairs < LEAST_CAPACITY)
        pairs = LEAST_CAPACITY;
    return buffer_reserve(b, p->device, (size_t)pairs * sizeof(duet_pair), err);
}

static size_t smaller(size_t a, size_t b)
{
    return a < b ? a : b;
}

// Objects around which to search, at most.
static uint32_t search_work(const part_task *task, const part_range *range)
{
    return (uint32_t)smaller(range->last, smaller(range->expected, task->objects.n)) - range->first;
}

static bool run_narrow(part *p, uint64_t work, duet_error *err)
{
    return timeline_launch(&p->times, "narrow", p->kernels.narrow, work, p, err);
}

static bool run_candidates(part *p, const part_task *task, const part_range *range, duet_error *err)
{
    part_args *a = &p->args;
    a->found = p->kernels.narrow ? p->candidates : p->pairs;
    a->found_capacity = capacity_of(&a->found);
    a->candidate_capacity = capacity_of(&p->candidates);
    a->pair_capacity = capacity_of(&p->pairs);
    a->undecided_capacity = capacity_of(&p->undecided);
    a->left_capacity = capacity_of(&p->left);
    bool decides = p->variant.search == SEARCH_SIMD && p->kernels.fused;
    return timeline_launch(&p->times, decides ? "search" : "candidates", p->kernels.candidates,
                           search_work(task, range), p, err);
}

// Candidates are not counted on the host before they are tested: the narrow
// kernel reads their number itself, and enough work-items for the last step's
// number are sent.
static uint64_t narrow_work(const part *p, uint32_t objects)
{
    uint64_t capacity = capacity_of(&p->candidates);
    uint64_t expected = 2 * (uint64_t)objects + LEAST_CAPACITY;
    return expected < capacity ? expected : capacity;
}

// True where all that was found has its place; else makes more.
static bool everything_fits(part *p, bool *fits, duet_error *err)
{
    struct {
        buffer *list;
        uint64_t found;
    } lists[] = {
        {&p->candidates, p->found.candidates},
        {&p->undecided, p->found.undecided},
        {&p->left, p->counted.left},
        // undecided pairs may join the pairs
        {&p->pairs, p->found.pairs + p->found.undecided},
    };
    *fits = true;
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; ++i) {
        uint64_t found = lists[i].found;
        if (found == 0 || found <= capacity_of(lists[i].list))
            continue;
        *fits = false;
        if (!reserve_pairs(p, lists[i].list, found + found / 16, err))
            return false;
    }
    return true;
}

// A device with memory of its own sends as many pairs as the last step had
// right behind the search, before anyone has asked how many there are: asking
// first takes as long as a tenth of the pairs.

// Undecided pairs that are sent unasked; there are mostly fewer.
enum { OPEN_AHEAD = 1024 };

// What is sent unasked besides the pairs.
typedef struct news {
    uint32_t counters[COUNTERS];
    uint32_t pair_counts[PAIR_COUNTS];
    duet_pair open[OPEN_AHEAD];
} news;

// Where pairs are counted only those that are left travel.
static buffer *pairs_to_fetch(part *p, const part_task *task)
{
    return task->ids ? &p->left : &p->pairs;
}

static uint64_t count_to_fetch(const part *p, const part_task *task)
{
    return task->ids ? p->counted.left : p->found.pairs;
}

// The counters come first: the host goes on with them while the pairs travel.
static bool ask_ahead(part *p, const part_task *task, cl_event *told, duet_error *err)
{
    buffer *pairs = pairs_to_fetch(p, task);
    size_t open_bytes = smaller(p->undecided.bytes, sizeof((news *)0)->open);
    size_t bytes = smaller(p->pairs_ahead * sizeof(duet_pair), p->fetched.size);
    bytes = smaller(bytes, pairs->bytes);
    if (!host_block_reserve(&p->news, p->device, 1, sizeof(news), err))
        return false;
    news *n = p->news.bytes;
    p->pairs_ahead = bytes / sizeof(duet_pair);
    bool ok =
        timeline_start_read(&p->times, "fetch pairs", &p->undecided, 0, n->open, open_bytes, err) &&
        (!task->ids || timeline_start_read(&p->times, "fetch pairs", &p->pair_counts, 0,
                                           n->pair_counts, sizeof n->pair_counts, err)) &&
        timeline_start_read(&p->times, "fetch pairs", &p->counters, 0, n->counters,
                            sizeof n->counters, err);
    *told = timeline_last_event(&p->times);
    return ok &&
           timeline_start_read(&p->times, "fetch pairs", pairs, 0, p->fetched.bytes, bytes, err);
}

static uint64_t wide(const uint32_t *words)
{
    return (uint64_t)words[1] << 32 | words[0];
}

// All that the host reads of memory that it shares with the device.
static bool see_found(part *p, duet_error *err)
{
    const buffer *const found[] = {&p->marks, &p->undecided, &p->pairs, &p->counters};
    bool ok = timeline_see(&p->times, "fetch pairs", found, sizeof found / sizeof found[0], err);
    if (ok)
        p->found = part_found_of(p->counters.host);
    return ok;
}

static bool hear(part *p, const part_task *task, duet_error *err)
{
    cl_event told = NULL;
    if (p->device->info.host_memory)
        return see_found(p, err);
    if (task->keeps_pairs)
        return read_counters(p, err);
    if ((task->ids && !part_count_pairs(p, err)) || !ask_ahead(p, task, &told, err))
        return false;
    timeline_spin(&p->times, told);
    if (!timeline_collect_to(&p->times, told, err))
        return false;
    const news *heard = p->news.bytes;
    const uint32_t *counts = heard->pair_counts;
    p->found = part_found_of(heard->counters);
    if (task->ids)
        p->counted = (part_counted){wide(counts + COUNT_COUNTED), wide(counts + COUNTED_HASH),
                                    wide(counts + COUNT_LEFT)};
    return true;
}

// Where candidates are tested as they are found, the narrow kernel gets what a
// group had no space for, which is mostly nothing.
static bool test_listed(part *p, const part_task *task, const part_range *range, duet_error *err)
{
    if (!p->kernels.narrow)
        return hear(p, task, err);
    if (!p->kernels.fused)
        return run_narrow(p, narrow_work(p, search_work(task, range)), err) && hear(p, task, err);
    if (!hear(p, task, err))
        return false;
    uint64_t listed = p->found.candidates;
    return listed == 0 || listed > capacity_of(&p->candidates) ||
           (run_narrow(p, listed, err) && hear(p, task, err));
}

// The first search finds its counters as the step cleared them.
static bool search_once(part *p, const part_task *task, const part_range *range, duet_error *err)
{
    return (p->runs++ == 0 ||
            timeline_fill(&p->times, "clear", &p->counters, 0, 0, COUNT_BAD, err)) &&
           run_candidates(p, task, range, err) && test_listed(p, task, range, err);
}

static bool under_limit(const part *p, const part_task *task, duet_error *err)
{
    uint64_t pairs = p->found.pairs;
    if (task->max_pairs && pairs > task->max_pairs)
        return error_set(err, DUET_STATUS_TOO_MANY, "%llu pairs on %s, and the world allows %llu",
                         (unsigned long long)pairs, p->device->info.selector,
                         (unsigned long long)task->max_pairs);
    return true;
}

static bool reserve_first(part *p, const part_task *task, uint32_t objects, duet_error *err)
{
    uint64_t guess = objects;
    bool ok = p->pairs.mem || reserve_pairs(p, &p->pairs, guess, err);
    if (task->objects.shape != DUET_SHAPE_BOUNDS)
        ok = ok && (p->undecided.mem || reserve_pairs(p, &p->undecided, guess / 64, err));
    if (task->ids)
        ok = ok && (p->left.mem || reserve_pairs(p, &p->left, guess / 64, err));
    if (p->kernels.narrow)
        ok = ok &&
             (p->candidates.mem ||
              reserve_pairs(p, &p->candidates, p->kernels.fused ? guess / 64 : 2 * guess, err));
    return ok;
}

// A grid with space for fewer objects than there are may get more than it holds, and
// its starts then point past its end. A search that is guarded checks that itself and finds
// nothing, so the host need not wait between grid and search.
static bool check_placed(part *p, const part_task *task, const part_range *range, bool *placed,
                         duet_error *err)
{
    *placed = true;
    if (range->expected >= task->objects.n || p->kernels.guarded)
        return true;
    bool ok = read_counters(p, err);
    *placed = p->found.placed <= range->expected;
    return ok;
}

// ---------------------------------------------------------------- fetching

// Where pairs come to lie on the host, with space behind them for the undecided.
// A block that must grow loses what was sent ahead, and locking its pages takes
// longer than a step: it grows by more than it must.
static bool reserve_span(part *p, uint64_t n, duet_pair **pairs, duet_error *err)
{
    uint64_t most = n + p->found.undecided;
    size_t bytes = (size_t)most * sizeof(duet_pair);
    *pairs = p->pairs.host;
    if (*pairs)
        return true;
    if (bytes > p->fetched.size) {
        p->pairs_ahead = 0;
        bytes += bytes / 16;
    }
    bool ok = host_block_reserve(&p->fetched, p->device, 1, bytes, err);
    *pairs = p->fetched.bytes;
    return ok;
}

// The pairs that were not sent ahead start to travel, unless the host has seen them; those for the
// next step are a few more than now.
static bool fetch_rest(part *p, buffer *from, duet_pair *pairs, uint64_t n, duet_error *err)
{
    uint64_t there = p->pairs_ahead;
    bool ok = from->host || there >= n ||
              timeline_start_read(&p->times, "fetch pairs", from, there * sizeof(duet_pair),
                                  pairs + there, (n - there) * sizeof(duet_pair), err);
    p->pairs_ahead = n + n / 64;
    return ok;
}

static bool fetch_open(part *p, const duet_pair **open, duet_pair *scratch, duet_error *err)
{
    const news *n = p->news.bytes;
    bool ahead = n && p->n_undecided <= OPEN_AHEAD;
    *open = p->undecided.host ? p->undecided.host : ahead ? n->open : scratch;
    return *open != scratch || timeline_read(&p->times, "fetch pairs", &p->undecided, (void *)*open,
                                             p->n_undecided * sizeof **open, err);
}

static bool collide(const grid_objects *objects, uint32_t a, uint32_t b)
{
    if (grid_has_radii(objects)) {
        const duet_rounded_box of_a = grid_rounded_box_of(objects, a);
        const duet_rounded_box of_b = grid_rounded_box_of(objects, b);
        return rounded_decide(&of_a, &of_b, objects->dims);
    }
    double shift[3];
    duet_pose scratch[2];
    const duet_pose *of_a = grid_pose_of(objects, a, &scratch[0]);
    const duet_pose *of_b = grid_pose_of(objects, b, &scratch[1]);
    origin_shift(shift, objects->array, objects->origin, a, b);
    return narrow_decide_apart(of_a, of_b, shift, objects->dims);
}

// What the host decides with: all objects, or where it does not see them those of the open
// pairs, two for each.
typedef struct open_objects {
    grid_objects objects;
    void *rows; // gathered; NULL: all are seen
    duet_size *sizes;
} open_objects;

static void free_open_objects(open_objects *o)
{
    free(o->rows);
    free(o->sizes);
}

static bool gather(part *p, const part_task *task, const duet_pair *open, open_objects *o,
                   duet_error *err)
{
    size_t row = grid_object_bytes(&task->objects), n = 2 * (size_t)p->n_undecided;
    o->rows = malloc(n * row);
    o->sizes = malloc(n * sizeof *o->sizes);
    if (!o->rows || !o->sizes)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no host memory for %zu objects", n);
    for (size_t i = 0; task->objects.sizes && i < n; ++i)
        o->sizes[i] = task->objects.sizes[i % 2 ? open[i / 2].b : open[i / 2].a];
    o->objects.array = o->rows;
    o->objects.sizes = task->objects.sizes ? o->sizes : NULL;
    if (!buffer_reserve(&p->gathered, p->device, n * row, err))
        return false;
    p->args.row_words = (cl_uint)(row / sizeof(cl_uint));
    p->args.n_ids = (cl_uint)n;
    return timeline_launch(&p->times, "fetch objects", p->kernels.gather, n, p, err) &&
           timeline_read(&p->times, "fetch objects", &p->gathered, o->rows, n * row, err);
}

static bool see_open_objects(part *p, const part_task *task, const duet_pair *open, open_objects *o,
                             duet_error *err)
{
    *o = (open_objects){.objects = task->objects};
    return task->objects.array || p->n_undecided == 0 || gather(p, task, open, o, err);
}

// Decides on the host what float left open. Returns how many of them collide,
// which are written to colliding, which may be where the open ones are.
static uint64_t decide(part *p, const open_objects *o, const duet_pair *open, duet_pair *colliding)
{
    uint64_t begun = clock_steady_ns();
    uint64_t n = 0;
    for (uint64_t i = 0; i < p->n_undecided; ++i) {
        uint32_t first = o->rows ? 2 * (uint32_t)i : open[i].a;
        uint32_t second = o->rows ? first + 1 : open[i].b;
        if (collide(&o->objects, first, second))
            colliding[n++] = open[i];
    }
    if (p->n_undecided > 0)
        timeline_add_host(&p->times, "decide", clock_ms_since(begun));
    return n;
}

// The undecided are decided while the pairs travel, and follow them once they
// are there.
static bool fetch_and_decide(part *p, const part_task *task, duet_pair *colliding, duet_error *err)
{
    duet_pair *pairs = NULL;
    const duet_pair *open = NULL;
    uint64_t n = count_to_fetch(p, task);
    uint64_t n_colliding = 0;
    open_objects seen = {0};
    bool ok = reserve_span(p, n, &pairs, err) &&
              fetch_rest(p, pairs_to_fetch(p, task), pairs, n, err) &&
              fetch_open(p, &open, colliding, err) && see_open_objects(p, task, open, &seen, err);
    if (ok)
        n_colliding = decide(p, &seen, open, colliding);
    free_open_objects(&seen);
    ok = ok && timeline_finish(&p->times, err);
    if (ok && n_colliding > 0)
        memcpy(pairs + n, colliding, (size_t)n_colliding * sizeof *pairs);
    p->span = ok ? (duet_span){pairs, n + n_colliding} : (duet_span){0};
    return ok;
}

// The pairs stay where they are, those that are decided follow them, and the span only
// counts them.
static bool keep_and_decide(part *p, const part_task *task, duet_pair *colliding, duet_error *err)
{
    uint64_t n_colliding = 0;
    open_objects seen = {0};
    bool ok = timeline_read(&p->times, "fetch pairs", &p->undecided, colliding,
                            p->n_undecided * sizeof *colliding, err) &&
              see_open_objects(p, task, colliding, &seen, err);
    if (ok)
        n_colliding = decide(p, &seen, colliding, colliding);
    free_open_objects(&seen);
    p->span.n = p->found.pairs + n_colliding;
    return ok &&
           timeline_write_at(&p->times, "send pairs", &p->pairs, p->found.pairs * sizeof *colliding,
                             colliding, (size_t)n_colliding * sizeof *colliding, err) &&
           timeline_finish(&p->times, err);
}

static bool fetch(part *p, const part_task *task, duet_error *err)
{
    p->n_undecided = p->found.undecided;
    size_t bytes = (size_t)p->n_undecided * sizeof(duet_pair);
    duet_pair *colliding = malloc(bytes + 1);
    if (!colliding)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no host memory for %zu bytes", bytes);
    bool ok = task->keeps_pairs ? keep_and_decide(p, task, colliding, err)
                                : fetch_and_decide(p, task, colliding, err);
    free(colliding);
    return ok;
}

bool part_search(part *p, const part_task *task, const part_range *range, bool *placed,
                 duet_error *err)
{
    *placed = true;
    if (range->first >= range->last)
        return read_counters(p, err) && timeline_finish(&p->times, err);
    set_args(p, task, range);
    bool ok = check_placed(p, task, range, placed, err) &&
              reserve_first(p, task, search_work(task, range), err);
    bool fits = false;
    uint32_t extra = p->extra_searches;
    while (ok && *placed && (!fits || extra-- > 0)) {
        ok = search_once(p, task, range, err) && under_limit(p, task, err) &&
             everything_fits(p, &fits, err);
        *placed = p->found.placed <= range->expected;
    }
    if (!ok || !*placed)
        return ok;
    p->n_candidates = p->kernels.listed ? p->found.pairs : p->found.candidates + p->found.tested;
    return fetch(p, task, err);
}
