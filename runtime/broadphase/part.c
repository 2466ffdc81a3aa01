// SPDX-License-Identifier: MIT
// What a device's part is made of: its buffers, its kernels and what these are told.
#include "runtime/broadphase/part.h"

#include "base/error.h"
#include "runtime/narrowphase/level.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/opencl/device_pair.h"

#include <stddef.h>
#include <string.h>

// Of 5 MB: they travel for 0.1 ms, a launch takes some 3 microseconds.
enum { LEAST_CHUNK = 1 << 17 };

// Where a part has its buffers.
static const size_t buffers[] = {
    offsetof(part, objects),       offsetof(part, sizes),      offsetof(part, names),
    offsetof(part, keys),          offsetof(part, ids),        offsetof(part, keys_spare),
    offsetof(part, ids_spare),     offsetof(part, counts),     offsetof(part, starts),
    offsetof(part, bounds),        offsetof(part, boxes),      offsetof(part, counters),
    offsetof(part, next_counters), offsetof(part, candidates), offsetof(part, pairs),
    offsetof(part, undecided),     offsetof(part, levels),     offsetof(part, gathered),
    offsetof(part, marks),         offsetof(part, global_ids), offsetof(part, id_changes),
    offsetof(part, pair_counts),   offsetof(part, left),       offsetof(part, skimmed),
    offsetof(part, edges)};

#define BUFFER(name, type, member) BIND_BUFFER(part, name, type, member)
#define VALUE(name) BIND_VALUE(part, #name, args.name)

// What the arguments in kernels/grid and kernels/narrowphase mean. Bounds and boxes are
// laid out as the search asks for.
static const binding part_bindings[] = {BUFFER("objects", "float *", args.objects),
                                        BUFFER("sizes", "float *", sizes),
                                        BUFFER("names", "uint *", names),
                                        BUFFER("levels", "grid_level *", levels),
                                        BUFFER("keys", "uint *", keys),
                                        BUFFER("ids", "uint *", ids),
                                        BUFFER("ranks", "uint *", keys_spare),
                                        BUFFER("counts", "uint *", counts),
                                        BUFFER("edges", "uint *", edges),
                                        BUFFER("others", "uint *", ids), // until they are sorted
                                        BUFFER("starts", "uint *", starts),
                                        BUFFER("key_starts", "uint *", starts),
                                        BUFFER("bounds", "float4 *", bounds),
                                        BUFFER("bounds", "float *", bounds),
                                        BUFFER("bounds_by_id", "float4 *", bounds),
                                        BUFFER("sorted_bounds", "float4 *", bounds),
                                        BUFFER("sorted_bounds", "float *", bounds),
                                        BUFFER("boxes", "float4 *", boxes),
                                        BUFFER("boxes", "float *", boxes),
                                        BUFFER("sorted_boxes", "float4 *", boxes),
                                        BUFFER("sorted_boxes", "float *", boxes),
                                        BUFFER("candidates", "uint2 *", candidates),
                                        BUFFER("found", "uint2 *", args.found),
                                        BUFFER("pairs", "uint2 *", pairs),
                                        BUFFER("undecided", "uint2 *", undecided),
                                        BUFFER("counters", "uint *", counters),
                                        BUFFER("next_counters", "uint *", next_counters),
                                        BUFFER("marks", "uint *", marks),
                                        BUFFER("sums", "uint *", scan.sums),
                                        BUFFER("blocks", "skim_block *", skimmed),
                                        BUFFER("global_ids", "uint2 *", global_ids),
                                        BUFFER("id_changes", "uint4 *", id_changes),
                                        BUFFER("pair_counts", "uint *", pair_counts),
                                        BUFFER("left", "uint2 *", left),
                                        BIND_VALUE(part, "stamp", stamp),
                                        BIND_VALUE(part, "n_keys", args.n),
                                        BIND_VALUE(part, "place_capacity", place_capacity),
                                        BIND_VALUE(part, "n_blocks", scan.n_blocks),
                                        VALUE(n),
                                        VALUE(n_levels),
                                        VALUE(n_cells),
                                        VALUE(key_from),
                                        VALUE(n_hashed),
                                        VALUE(key_home_to),
                                        VALUE(marked_from),
                                        VALUE(marked_to),
                                        VALUE(key_to),
                                        VALUE(key_end),
                                        VALUE(n_home_cells),
                                        VALUE(n_own_cells),
                                        VALUE(n_counters),
                                        VALUE(n_counts),
                                        VALUE(first),
                                        VALUE(last),
                                        VALUE(found_capacity),
                                        VALUE(candidate_capacity),
                                        VALUE(pair_capacity),
                                        VALUE(undecided_capacity),
                                        VALUE(skim_from),
                                        VALUE(inside_lower),
                                        VALUE(inside_upper),
                                        VALUE(n_homes),
                                        VALUE(n_id_changes),
                                        VALUE(left_capacity),
                                        VALUE(cells),
                                        {0}};

// In kernels/dynamics/read_rows.cl ids are those of the undecided pairs. Of its two entries the
// first alone is launched.
static const binding gather_bindings[] = {BUFFER("rows", "uint *", args.objects),
                                          BUFFER("ids", "uint *", undecided),
                                          BUFFER("gathered", "uint *", gathered),
                                          BUFFER("last_rows", "uint *", gathered),
                                          BUFFER("changed", "uint *", gathered),
                                          VALUE(row_words),
                                          VALUE(n_ids),
                                          VALUE(n),
                                          {0}};

bool part_open(part *p, const duet_device_pair *pair, int side, duet_error *err)
{
    const device *d = &pair->devices[side];
    *p = (part){.device = d,
                .devices = pair->devices,
                .scan = {.device = d},
                .radix = {.device = d, .scan = &p->scan},
                .least_chunk = LEAST_CHUNK};
    p->gen = gen_open(pair->kernel_dir, err);
    p->programs = p->gen ? program_set_open(p->device, p->gen, &pair->builder, err) : NULL;
    p->limits = program_limits(&p->device->info);
    bool ok = p->programs &&
              buffer_reserve(&p->counters, p->device, COUNTERS * sizeof(uint32_t), err) &&
              buffer_reserve(&p->next_counters, p->device, COUNTERS * sizeof(uint32_t), err) &&
              buffer_reserve(&p->levels, p->device, sizeof((grid *)0)->levels, err);
    p->bytes = part_bytes(p);
    if (!ok)
        part_close(p);
    return ok;
}

void part_close(part *p)
{
    timeline_clear(&p->times);
    for (size_t i = 0; i < sizeof buffers / sizeof buffers[0]; ++i)
        buffer_release((buffer *)((char *)p + buffers[i]));
    scan_close(&p->scan);
    radix_sort_close(&p->radix);
    host_block_release(&p->fetched);
    host_block_release(&p->news);
    host_block_release(&p->sent);
    host_block_release(&p->marks_seen);
    host_block_release(&p->skim_seen);
    host_block_release(&p->changes);
    program_set_close(p->programs);
    gen_close(p->gen);
    *p = (part){0};
}

void part_distrust(part *p)
{
    timeline_clear(&p->times);
    p->objects_version = p->sizes_version = p->levels_version = p->ahead_version = 0;
    p->packed.objects_version = p->stretched.objects_version = p->ids_version = 0;
    p->zero_counts = 0;
    p->next_are_cleared = false;
}

void part_begin(part *p, uint64_t step)
{
    timeline_begin_step(&p->times, p->device, step);
    p->ahead_version = 0;
    p->span = (duet_span){0};
    p->counted = (part_counted){0};
    p->n_candidates = p->n_undecided = 0;
    p->runs = 0;
    p->wall_ms = 0.0;
    p->found = (part_found){.first_bad = UINT32_MAX};
}

// ---------------------------------------------------------------- kernels

// Whether the device alone has objects that the host may have to decide.
static bool gathers(const part *p, const part_task *task)
{
    return task->resident && !p->device->info.host_memory &&
           task->objects.shape == DUET_SHAPE_POSES;
}

// Objects in origin cells, or whose sizes are apart, are not skimmed.
static bool skims(const part *p, const part_task *task)
{
    const grid_objects *o = &task->objects;
    return task->skims && !p->device->info.host_memory && !o->sizes && o->origin == 0.0f &&
           !grid_has_radii(o);
}

// Where nothing is rotated, or objects have radii, most levels are one.
static duet_level level_of(const part_task *task)
{
    bool turned_boxes = task->objects.shape == DUET_SHAPE_POSES && task->rotated;
    bool differs = task->objects.shape != DUET_SHAPE_BOUNDS &&
                   (turned_boxes || level_tests_upright(task->level));
    return differs ? task->level : DUET_LEVEL_CERTIFIED;
}

// The cells that kernels have compiled in, or none: a grid whose cells change is
// read, so that objects that move never make the kernels be built again.
static cl_int4 compiled_cells(const part *p, const part_task *task)
{
    bool fixed = p->variant.fixed && !task->cells_vary && task->grid.kind == GRID_DENSE &&
                 task->grid.n_levels == 1;
    return fixed ? task->grid.levels[0].cells : (cl_int4){{0}};
}

// Dense, of one level, and at least three cells wide along all axes but the
// last: then no cell is near another on both ways round a row's end.
static bool is_roomy(const part_task *task)
{
    const cl_int *cells = task->grid.levels[0].cells.s;
    return task->grid.kind == GRID_DENSE && task->grid.n_levels == 1 && cells[0] > 2 &&
           (task->objects.dims == 2 || cells[1] > 2);
}

// Boxes that are in order are near each other where they are.
static bool leaves_boxes(const part_task *task)
{
    return task->ordered && task->objects.shape == DUET_SHAPE_POSES && !task->objects.sizes &&
           task->objects.origin == 0.0f && !task->packed;
}

// The kernels of each way to search.
static const struct {
    const char *starts;
    const char *place[2]; // kernel and its entry
    const char *candidates;
    const char *narrow;
    bool in_cell_order;
} searches[] = {
    [SEARCH_GPU] = {"row_start", {"reorder", "reorder"}, "pair_search_gpu", "narrow", true},
    [SEARCH_SIMD] =
        {"row_start", {"reorder_simd", "reorder_simd"}, "pair_search_simd", "narrow_simd", true},
    [SEARCH_PAPER] =
        {"cell_start", {"bounds", "find_bounds"}, "pair_search_paper", "narrow", false},
};

static uint32_t count_taken(const part_task *task)
{
    uint32_t n = 0;
    for (uint32_t i = 0; task->intake && i < task->intake->taken.n; ++i)
        n += task->intake->taken.list[i].to - task->intake->taken.list[i].from;
    return task->intake ? n : task->objects.n;
}

// With fewer objects a unit, three launches more take longer than atomics and straight places.
enum { LEAST_OWN = 16384 };

// A CPU's atomics take as long as all else that it does for a cell. A part that counts without them
// goes on so down to half as many objects.
static bool counts_own_cells(const part *p, const part_task *task)
{
    uint64_t least = p->kernels.own_cells ? LEAST_OWN / 2 : LEAST_OWN;
    return task->ordered && p->device->info.kind == DUET_KIND_CPU && p->device->info.host_memory &&
           p->variant.search == SEARCH_SIMD && p->variant.sort == SORT_COUNTING && is_roomy(task) &&
           count_taken(task) >= least * p->device->info.units;
}

// Whether the kernels test boxes, beyond their bounds.
static bool tests_boxes(const part_task *task)
{
    return task->objects.shape != DUET_SHAPE_BOUNDS && level_of(task) != DUET_LEVEL_AABB;
}

static bool is_unboxed(const variant *v, const part_task *task)
{
    return v->search == SEARCH_GPU && leaves_boxes(task);
}

// Objects that are in order go to places side by side.
static bool goes_to_places(const variant *v, const part_task *task)
{
    return v->sort == SORT_COUNTING && !task->shared && task->ordered;
}

static bool sums_blocks(const part *p, const part_task *task)
{
    return goes_to_places(&p->variant, task) && p->variant.search == SEARCH_SIMD &&
           task->objects.shape != DUET_SHAPE_BOUNDS && !counts_own_cells(p, task);
}

static void choose(const part *p, const part_task *task, part_choice choices[PART_CHOICES])
{
    const variant *v = &p->variant;
    bool counting = v->sort == SORT_COUNTING;
    bool turned = task->objects.shape != DUET_SHAPE_BOUNDS && task->rotated &&
                  task->objects.shape != DUET_SHAPE_SPHERES;
    bool tested = tests_boxes(task), unboxed = is_unboxed(v, task);
    bool to_places = goes_to_places(v, task), sums = sums_blocks(p, task);
    bool own = counts_own_cells(p, task);
    cl_int4 cells = compiled_cells(p, task);
    const part_choice all[PART_CHOICES] = {
        {"DIMS", task->objects.dims, false},
        {"SHAPE", task->objects.shape, false},
        {"ORIGIN", origin_setting(task->objects.origin), false},
        {"APART", task->objects.sizes ? 1 + task->objects.compact : 0, false},
        {"ROTATED", turned, false},
        {"RANK", counting, false},
        {"SORTED", searches[v->search].in_cell_order && !unboxed, false},
        {"UNBOXED", unboxed, false},
        {"IDS", !tested, false},
        {"ACCURACY", level_of(task), false},
        {"GRID", task->grid.kind, false},
        {"LEVELS", task->grid.n_levels > 1, false},
        {"ROOMY", is_roomy(task), false},
        {"CELLS_X", cells.s[0], false},
        {"CELLS_Y", cells.s[1], false},
        {"CELLS_Z", cells.s[2], false},
        {"PACKED", task->packed, false},
        {"OWN", own, false},
        {"STRAYS", task->intake ? STRAY_BLOCK : 0, false},
        {"STRETCH", task->intake && counting, false},
        {"GUARDED", task->slab, false},
        {"SLAB", task->divided, false},
        {"FROM_IDS", !to_places, counting && !task->shared},
        {"TO_PLACES", sums, false},
        {"SUM_BLOCK", 0, false}, // the scan's, once its kernels are there
        {"EMPTIES", counting, false},
        {"FUSED", tested && v->fused, tested},
    };
    memcpy(choices, all, sizeof all);
}

// Of two lists, which have the same names.
static bool are_same(const part_choice a[PART_CHOICES], const part_choice b[PART_CHOICES])
{
    for (int i = 0; i < PART_CHOICES; ++i)
        if (a[i].value != b[i].value || a[i].open != b[i].open)
            return false;
    return true;
}

bool part_is_prepared(const part *p, const part_task *task)
{
    const part_kernels *k = &p->kernels;
    part_choice choices[PART_CHOICES];
    choose(p, task, choices);
    return are_same(choices, p->choices) && (k->gather || !gathers(p, task)) &&
           (k->count_pairs || !task->ids);
}

// What the scene and the stage decide, and then what the variant sets, which counts where both do.
static bool list_offers(part *p, duet_error *err)
{
    p->n_offers = 0;
    for (int i = 0; i < PART_CHOICES; ++i)
        p->offers[p->n_offers++] =
            (gen_offer){NULL, p->choices[i].name, p->choices[i].value, GEN_OFFERED, NULL};
    for (uint32_t i = 0; i < p->variant.n_settings; ++i) {
        variant_setting *s = &p->variant.settings[i];
        for (int k = 0; k < PART_CHOICES; ++k)
            if (!p->choices[k].open && strcmp(p->choices[k].name, s->name) == 0)
                return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                                 "variant: %s is what the scene decides, and cannot be set",
                                 s->name);
        p->offers[p->n_offers++] = (gen_offer){s->kernel, s->name, s->value, GEN_OFFERED, &s->used};
    }
    return true;
}

// First those whose settings the others need: the scan's block, and whether candidates are tested
// where they are found.
static bool ask_kernels(part *p, const part_task *task, bool own, duet_error *err)
{
    enum { SORTS = 5, MAIN = 8, REST = 5 };
    part_kernels *k = &p->kernels;
    program_set *set = p->programs;
    const int search = p->variant.search;
    const bool counting = p->variant.sort == SORT_COUNTING;
    const bool gathered = gathers(p, task), skimmed = skims(p, task);
    const char *const *place = searches[search].place, *starts = searches[search].starts;
    const char *candidates = searches[search].candidates, *narrow = searches[search].narrow;
    const kernel_request list[MAIN] = {
        {&k->clear, true, "clear", "clear", part_bindings},
        {&k->hash, true, "hash", "hash", part_bindings},
        {&k->own_cells, own, "hash", "own_cells", part_bindings},
        {&k->count_others, own, "hash", "count_others", part_bindings},
        {&k->scatter, counting, "scatter", "scatter", part_bindings},
        {&k->starts, !counting, "cell_start", starts, part_bindings},
        {&k->place, true, place[0], place[1], part_bindings},
        {&k->candidates, true, candidates, candidates, part_bindings},
    };
    const kernel_request sorts[SORTS] = {SCAN_KERNELS(&p->scan, true),
                                         RADIX_SORT_KERNELS(&p->radix, !counting)};
    if (!program_set_kernels(set, sorts, SORTS, p->offers, p->n_offers, err))
        return false;
    if (k->summed)
        p->offers[p->n_offers++] =
            (gen_offer){"hash", "SUM_BLOCK", SCAN_BLOCK(&p->scan), GEN_OFFERED, NULL};
    if (!program_set_kernels(set, list, MAIN, p->offers, p->n_offers, err))
        return false;
    k->from_ids = search == SEARCH_GPU ? kernel_param(k->place, "FROM_IDS") == 1 : !k->summed;
    k->fused = kernel_param(k->candidates, "FUSED") == 1;
    // Fused rows leave to narrow what their buffers cannot hold, lanes nothing.
    const bool narrows = !k->listed && !(k->fused && search == SEARCH_SIMD);
    const kernel_request rest[REST] = {
        {&k->narrow, narrows, narrow, narrow, part_bindings},
        {&k->gather, gathered, "read_rows", "gather_rows", gather_bindings},
        {&k->skim, skimmed, "skim", "skim", part_bindings},
        {&k->change_ids, task->ids, "count_pairs", "change_ids", part_bindings},
        {&k->count_pairs, task->ids, "count_pairs", "count_pairs", part_bindings},
    };
    return program_set_kernels(set, rest, REST, p->offers, p->n_offers, err);
}

bool part_prepare(part *p, const variant *asked, const part_task *task, duet_error *err)
{
    p->variant = *asked;
    bool was_summed = p->kernels.summed, sums = sums_blocks(p, task);
    bool own = counts_own_cells(p, task);
    choose(p, task, p->choices);
    p->kernels = (part_kernels){
        .summed = sums,
        .unboxed = is_unboxed(&p->variant, task),
        .guarded = task->slab && p->variant.search != SEARCH_PAPER,
        .listed = !tests_boxes(task),
    };
    if (sums && !was_summed)
        p->zero_counts = 0; // other kernels leave the scan's sums as they are
    if (!list_offers(p, err) || !ask_kernels(p, task, own, err))
        return false;
    for (uint32_t i = 0; i < p->variant.n_settings; ++i) {
        const variant_setting *s = &p->variant.settings[i];
        if (!s->used)
            return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                             "variant: no kernel that it runs has a parameter '%s%s%s'", s->kernel,
                             s->kernel[0] ? "." : "", s->name);
    }
    return program_set_build(p->programs, err);
}

const kernel *part_kernel(const part *p, const char *name)
{
    const part_kernels *k = &p->kernels;
    const kernel *all[] = {k->clear,  k->hash,       k->scatter,     k->starts,    k->place,
                           k->narrow, k->candidates, p->scan.blocks, p->radix.move};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; ++i)
        if (kernel_is(all[i], name))
            return all[i];
    return NULL;
}

uint64_t part_bytes(const part *p)
{
    uint64_t bytes = p->scan.sums.bytes + p->radix.tiles.bytes;
    for (size_t i = 0; i < sizeof buffers / sizeof buffers[0]; ++i)
        bytes += ((const buffer *)((const char *)p + buffers[i]))->bytes;
    return bytes;
}
