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
    *p = (part){
        .device = &pair->devices[side], .devices = pair->devices, .least_chunk = LEAST_CHUNK};
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
    p->step = step;
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

enum { MAX_SETTINGS = 24 };

// Every parameter of the kernel's card that the scene, the stage or the variant
// sets; the others keep the card's own value.
static bool gather_settings(part *p, const char *name, const part_choice *choices,
                            uint32_t n_choices, gen_setting settings[MAX_SETTINGS],
                            uint32_t *n_settings, duet_error *err)
{
    const gen_param *params = NULL;
    uint32_t n_params = 0;
    if (!gen_params(p->gen, name, &p->limits, &params, &n_params, err))
        return false;
    *n_settings = n_params < MAX_SETTINGS ? n_params : MAX_SETTINGS;
    for (uint32_t i = 0; i < *n_settings; ++i) {
        const part_choice *choice = NULL;
        for (uint32_t k = 0; k < n_choices; ++k)
            if (strcmp(choices[k].name, params[i].name) == 0)
                choice = &choices[k];
        settings[i] = (gen_setting){params[i].name, choice ? choice->value : params[i].fallback};
        if (variant_take(&p->variant, name, params[i].name, &settings[i].value) && choice &&
            !choice->open)
            return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                             "variant: %s is what the scene decides, and cannot be set",
                             params[i].name);
    }
    return true;
}

static kernel *get_kernel(part *p, const char *name, const char *entry, bindings from,
                          duet_error *err)
{
    gen_setting settings[MAX_SETTINGS];
    uint32_t n = 0;
    if (!gather_settings(p, name, p->choices, PART_CHOICES, settings, &n, err))
        return NULL;
    return program_set_kernel(p->programs, name, entry, settings, n, from, err);
}

// Whether the device alone has objects that the host may have to decide.
static bool gathers(const part *p, const part_task *task)
{
    return task->resident && !p->device->info.host_memory &&
           task->objects.shape == DUET_SHAPE_POSES;
}

static bool ask_gather(part *p, const part_task *task, duet_error *err)
{
    if (!gathers(p, task))
        return true;
    p->kernels.gather = get_kernel(p, "read_rows", "gather_rows", gather_bindings, err);
    return p->kernels.gather;
}

// Objects in origin cells, or whose sizes are apart, are not skimmed.
static bool ask_skim(part *p, const part_task *task, duet_error *err)
{
    const grid_objects *o = &task->objects;
    bool skims = task->skims && !p->device->info.host_memory && !o->sizes && o->origin == 0.0f &&
                 !grid_has_radii(o);
    if (skims)
        p->kernels.skim = get_kernel(p, "skim", "skim", part_bindings, err);
    return !skims || p->kernels.skim;
}

static bool ask_count(part *p, const part_task *task, duet_error *err)
{
    if (!task->ids)
        return true;
    p->kernels.change_ids = get_kernel(p, "count_pairs", "change_ids", part_bindings, err);
    p->kernels.count_pairs = get_kernel(p, "count_pairs", "count_pairs", part_bindings, err);
    return p->kernels.change_ids && p->kernels.count_pairs;
}

// The primitives, with what the variant sets of them.
static bool open_sorts(part *p, duet_error *err)
{
    const char *const names[] = {"scan", "radix"};
    const bool sorts = p->variant.sort == SORT_RADIX;
    const part_choice empties = {"EMPTIES", !sorts, false}; // the scan's
    gen_setting settings[2][MAX_SETTINGS];
    uint32_t n[2] = {0};
    p->radix.count = p->radix.move = NULL; // of a variant before
    for (int i = 0; i < (sorts ? 2 : 1); ++i)
        if (!gather_settings(p, names[i], &empties, 1, settings[i], &n[i], err))
            return false;
    return scan_open(&p->scan, p->device, p->programs, settings[0], n[0], err) &&
           (!sorts ||
            radix_sort_open(&p->radix, p->device, p->programs, &p->scan, settings[1], n[1], err));
}

static bool all_settings_used(const part *p, duet_error *err)
{
    for (uint32_t i = 0; i < p->variant.n_settings; ++i)
        if (!p->variant.settings[i].used)
            return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                             "variant: no kernel that it runs has a parameter '%s%s%s'",
                             p->variant.settings[i].kernel,
                             p->variant.settings[i].kernel[0] ? "." : "",
                             p->variant.settings[i].name);
    return true;
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
        {"SUM_BLOCK", sums ? p->scan.block : 0, false},
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

bool part_prepare(part *p, const variant *asked, const part_task *task, duet_error *err)
{
    p->variant = *asked;
    const int search = p->variant.search;
    bool counting = p->variant.sort == SORT_COUNTING, tested = tests_boxes(task);
    bool was_summed = p->kernels.summed, sums = sums_blocks(p, task);
    bool own = counts_own_cells(p, task);
    const struct {
        kernel **at;
        bool wanted;
        const char *name;
        const char *entry;
    } list[] = {
        {&p->kernels.clear, true, "clear", "clear"},
        {&p->kernels.hash, true, "hash", "hash"},
        {&p->kernels.own_cells, own, "hash", "own_cells"},
        {&p->kernels.count_others, own, "hash", "count_others"},
        {&p->kernels.scatter, counting, "scatter", "scatter"},
        {&p->kernels.starts, !counting, "cell_start", searches[search].starts},
        {&p->kernels.place, true, searches[search].place[0], searches[search].place[1]},
        {&p->kernels.candidates, true, searches[search].candidates, searches[search].candidates},
    };
    if (!open_sorts(p, err))
        return false;
    choose(p, task, p->choices);
    p->kernels = (part_kernels){
        .summed = sums,
        .unboxed = is_unboxed(&p->variant, task),
        .guarded = task->slab && search != SEARCH_PAPER,
        .listed = !tested,
    };
    if (sums && !was_summed)
        p->zero_counts = 0; // other kernels leave the scan's sums as they are
    for (size_t i = 0; i < sizeof list / sizeof list[0]; ++i) {
        if (!list[i].wanted)
            continue;
        *list[i].at = get_kernel(p, list[i].name, list[i].entry, part_bindings, err);
        if (!*list[i].at)
            return false;
    }
    p->kernels.from_ids =
        search == SEARCH_GPU ? kernel_param(p->kernels.place, "FROM_IDS") == 1 : !sums;
    p->kernels.fused = kernel_param(p->kernels.candidates, "FUSED") == 1;
    // Fused rows leave to narrow what their buffers cannot hold, lanes nothing.
    if (tested && !(p->kernels.fused && search == SEARCH_SIMD)) {
        const char *narrow = searches[search].narrow;
        p->kernels.narrow = get_kernel(p, narrow, narrow, part_bindings, err);
        if (!p->kernels.narrow)
            return false;
    }
    return ask_gather(p, task, err) && ask_skim(p, task, err) && ask_count(p, task, err) &&
           all_settings_used(p, err) && program_set_build(p->programs, err);
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
