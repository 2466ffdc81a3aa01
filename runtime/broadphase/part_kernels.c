// SPDX-License-Identifier: MIT
// The kernels of a part: chosen for its task, asked for and built.
#include "runtime/broadphase/part.h"

#include "base/error.h"
#include "runtime/narrowphase/level.h"
#include "runtime/narrowphase/origin.h"

#include <string.h>

// The kernels of a step are chosen by facts of its task, of the variant and of the device.

// Whether the device alone has objects that the host may have to decide.
static bool gathers(const part *p)
{
    return p->objects.bound.mem && !p->device->info.host_memory &&
           p->task.objects->shape == DUET_SHAPE_POSES;
}

// Most levels are one if nothing is rotated, or objects have radii.
static duet_level level_of(const part_task *task)
{
    bool turned_boxes = task->objects->shape == DUET_SHAPE_POSES && task->def->rotated;
    bool differs = task->objects->shape != DUET_SHAPE_BOUNDS &&
                   (turned_boxes || level_tests_upright(task->def->level));
    return differs ? task->def->level : DUET_LEVEL_CERTIFIED;
}

static bool is_dense_of_one_level(const grid *g)
{
    return g->kind == GRID_DENSE && g->n_levels == 1;
}

// The cells that kernels have compiled in, or none: a grid whose cells change is read, so that
// objects that move never make the kernels be built again.
static cl_int4 compiled_cells(const part *p, const grid *g)
{
    bool fixed = p->variant.fixed && !g->varies && is_dense_of_one_level(g);
    return fixed ? g->levels[0].cells : (cl_int4){{0}};
}

// At least three cells wide along all axes but the last: then no cell is near another on both ways
// round a row's end.
static bool is_roomy(const part_task *task)
{
    const cl_int *cells = task->grid->levels[0].cells.s;
    return is_dense_of_one_level(task->grid) && cells[0] > 2 &&
           (task->objects->dims == 2 || cells[1] > 2);
}

// Kernels for objects that move serve any number of sizes if the grid is not roomy, unless a
// variant has its cells compiled in, or knows one size.
static bool knows_levels(const part *p, const part_task *task)
{
    const bool any = task->moves && !p->variant.fixed && p->variant.search != SEARCH_PAPER;
    return task->grid->n_levels > 1 || (any && !is_roomy(task));
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

// With fewer objects a unit, three launches more take longer than atomics and straight places.
enum { LEAST_OWN = 16384 };

// A CPU's atomics take as long as all else that it does for a cell. A part that counts without them
// goes on so down to half as many objects.
static bool counts_own_cells(const part *p)
{
    const part_task *task = &p->task;
    const uint64_t least = p->kernels.own_cells ? LEAST_OWN / 2 : LEAST_OWN;
    return task->def->ordered && p->device->info.kind == DUET_KIND_CPU &&
           p->device->info.host_memory && p->variant.search == SEARCH_SIMD &&
           p->variant.sort == SORT_COUNTING && is_roomy(task) &&
           selection_count(&task->wanted) >= least * p->device->info.units;
}

// Objects that are in order go to places side by side.
static bool goes_to_places(const part *p)
{
    return p->variant.sort == SORT_COUNTING && p->task.role == GRID_OWN && p->task.def->ordered;
}

// Boxes that are in order are near each other where they are.
static bool leaves_boxes(const part *p)
{
    const part_task *task = &p->task;
    return p->variant.search == SEARCH_GPU && task->def->ordered &&
           task->objects->shape == DUET_SHAPE_POSES && !task->objects->sizes.rows &&
           task->objects->origin == 0.0f && task->wanted.kind != SELECT_LIST;
}

// The facts that decide which kernels are asked for.
static uint32_t facts_of(const part *p)
{
    const bool boxes = p->task.objects->shape != DUET_SHAPE_BOUNDS, own = counts_own_cells(p);
    const bool to_places = goes_to_places(p) && p->variant.search == SEARCH_SIMD && boxes && !own;
    return (boxes && level_of(&p->task) != DUET_LEVEL_AABB ? PART_TESTS_BOXES : 0) |
           (leaves_boxes(p) ? PART_LEAVES_BOXES : 0) | (own ? PART_OWN_CELLS : 0) |
           (to_places ? PART_TO_PLACES : 0);
}

// The facts that cards decide.
static uint32_t facts_of_kernels(const part *p)
{
    const bool by_ids = p->variant.search == SEARCH_GPU
                            ? kernel_param(p->kernels.place, "FROM_IDS") == 1
                            : !(p->facts & PART_TO_PLACES);
    return (by_ids ? PART_BY_IDS : 0) |
           (kernel_param(p->kernels.candidates, "FUSED") == 1 ? PART_FUSED : 0);
}

// If the other part has a slab, too, many objects are in none of this one's cells.
static bool is_cut(const part_task *task)
{
    return task->range.key_from > 0 || task->range.home_to < task->grid->n_cells;
}

static void choose(const part *p, uint32_t facts, part_choice choices[PART_CHOICES])
{
    const part_task *task = &p->task;
    const variant *v = &p->variant;
    const grid_objects *o = task->objects;
    const grid *g = task->grid;
    const bool counting = v->sort == SORT_COUNTING, tested = facts & PART_TESTS_BOXES;
    const bool turned =
        o->shape != DUET_SHAPE_BOUNDS && task->def->rotated && o->shape != DUET_SHAPE_SPHERES;
    const bool unboxed = facts & PART_LEAVES_BOXES, to_places = goes_to_places(p);
    const bool in_ranges = task->wanted.kind == SELECT_RANGES;
    const bool slabs = task->def->plan.mode == DUET_MODE_SLAB;
    const cl_int4 cells = compiled_cells(p, g);
    const part_choice all[PART_CHOICES] = {
        {"DIMS", o->dims, false},
        {"SHAPE", o->shape, false},
        {"ORIGIN", origin_setting(o->origin), false},
        {"APART", o->kind == DUET_OBJECT_COMPACT_TRANSFORMS ? 2 : o->sizes.rows != NULL, false},
        {"ROTATED", turned, false},
        {"RANK", counting, false},
        {"SORTED", searches[v->search].in_cell_order && !unboxed, false},
        {"UNBOXED", unboxed, false},
        {"IDS", !tested, false},
        {"ACCURACY", level_of(task), false},
        {"GRID", g->kind, false},
        {"LEVELS", knows_levels(p, task), false},
        {"ROOMY", is_roomy(task), false},
        {"CELLS_X", cells.s[0], false},
        {"CELLS_Y", cells.s[1], false},
        {"CELLS_Z", cells.s[2], false},
        {"PACKED", task->wanted.kind == SELECT_LIST, false},
        {"OWN", (facts & PART_OWN_CELLS) != 0, false},
        {"STRAYS", in_ranges ? INPUT_BLOCK : 0, false},
        {"STRETCH", in_ranges && counting, false},
        {"GUARDED", slabs, false},
        {"SLAB", slabs && is_cut(task), false},
        {"FROM_IDS", !to_places, counting && task->role == GRID_OWN},
        {"TO_PLACES", (facts & PART_TO_PLACES) != 0, false},
        {"EMPTIES", counting, false},
        {"FUSED", tested && v->fused, tested},
    };
    memcpy(choices, all, sizeof all);
}

// Compares two lists, which have the same names.
static bool are_same(const part_choice a[PART_CHOICES], const part_choice b[PART_CHOICES])
{
    for (int i = 0; i < PART_CHOICES; ++i)
        if (a[i].value != b[i].value || a[i].open != b[i].open)
            return false;
    return true;
}

bool part_has_kernels(const part *p, const variant *asked)
{
    return p->kernels.candidates && variant_is(asked, &p->variant);
}

void part_forget_kernels(part *p)
{
    p->kernels.candidates = NULL;
}

static bool is_prepared(const part *p, const variant *asked)
{
    const part_kernels *k = &p->kernels;
    part_choice choices[PART_CHOICES];
    if (!part_has_kernels(p, asked))
        return false;
    choose(p, facts_of(p), choices);
    return are_same(choices, p->choices) && (k->gather || !gathers(p)) &&
           (k->count_pairs || !p->task.ids);
}

// Lists the choices of the scene and the stage, and then the settings of the variant, which count
// if both name a parameter.
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
                return bad_argument(err, "variant: %s is what the scene decides, and cannot be set",
                                    s->name);
        p->offers[p->n_offers++] = (gen_offer){s->kernel, s->name, s->value, GEN_OFFERED, &s->used};
    }
    return true;
}

#define ASK(p, list, err)                                                                \
    program_set_kernels((p)->programs, list, sizeof(list) / sizeof *(list), (p)->offers, \
                        (p)->n_offers, err)

static bool ask_sorts(part *p, duet_error *err)
{
    const kernel_request list[] = {SCAN_KERNELS(&p->scan, true),
                                   RADIX_SORT_KERNELS(&p->radix, p->variant.sort == SORT_RADIX)};
    return ASK(p, list, err);
}

static bool ask_grid_and_search(part *p, duet_error *err)
{
    part_kernels *k = &p->kernels;
    const int search = p->variant.search;
    const bool counting = p->variant.sort == SORT_COUNTING, own = p->facts & PART_OWN_CELLS;
    const char *const *place = searches[search].place, *starts = searches[search].starts;
    const char *candidates = searches[search].candidates;
    const kernel_request list[] = {
        {&k->clear, true, "clear", "clear", part_bindings},
        {&k->hash, true, "hash", "hash", part_bindings},
        {&k->own_cells, own, "hash", "own_cells", part_bindings},
        {&k->count_others, own, "hash", "count_others", part_bindings},
        {&k->scatter, counting, "scatter", "scatter", part_bindings},
        {&k->starts, !counting, "cell_start", starts, part_bindings},
        {&k->place, true, place[0], place[1], part_bindings},
        {&k->candidates, true, candidates, candidates, part_bindings},
    };
    return ASK(p, list, err);
}

// Fused rows leave to narrow what their buffers cannot hold, lanes nothing.
static bool ask_tests_and_reads(part *p, duet_error *err)
{
    part_kernels *k = &p->kernels;
    const char *narrow = searches[p->variant.search].narrow;
    const bool narrows = (p->facts & PART_TESTS_BOXES) &&
                         !((p->facts & PART_FUSED) && p->variant.search == SEARCH_SIMD);
    const kernel_request list[] = {
        {&k->narrow, narrows, narrow, narrow, part_bindings},
        {&k->gather, gathers(p), "read_rows", "gather_rows", part_gather_bindings},
        {&k->change_ids, p->task.ids, "count_pairs", "change_ids", part_bindings},
        {&k->count_pairs, p->task.ids, "count_pairs", "count_pairs", part_bindings},
    };
    return ASK(p, list, err);
}

bool part_prepare_interior(part *p, duet_error *err)
{
    const kernel_request list[] = {
        {&p->kernels.find_interior, true, "find_interior", "find_interior", part_bindings}};
    const bool ok = ASK(p, list, err) && program_set_build(p->programs, err);
    if (!ok)
        p->kernels.find_interior = NULL;
    return ok;
}

static bool ask_all(part *p, duet_error *err)
{
    if (!list_offers(p, err) || !ask_sorts(p, err) || !ask_grid_and_search(p, err))
        return false;
    p->facts |= facts_of_kernels(p);
    return ask_tests_and_reads(p, err);
}

// Whether some kernel has the parameter of a setting. The kernel `find_interior` comes later.
static bool is_known(const variant_setting *s)
{
    return s->used || strcmp(s->kernel, "find_interior") == 0;
}

static bool build(part *p, duet_error *err)
{
    if (!ask_all(p, err))
        return false;
    for (uint32_t i = 0; i < p->variant.n_settings; ++i) {
        const variant_setting *s = &p->variant.settings[i];
        if (!is_known(s))
            return bad_argument(err, "variant: no kernel that it runs has a parameter '%s%s%s'",
                                s->kernel, s->kernel[0] ? "." : "", s->name);
    }
    return program_set_build(p->programs, err);
}

static void choose_all(part *p, const variant *asked)
{
    p->variant = *asked;
    p->facts = facts_of(p);
    choose(p, p->facts, p->choices);
}

bool part_prepare(part *p, const variant *asked, duet_error *err)
{
    if (is_prepared(p, asked))
        return true;
    choose_all(p, asked);
    p->kernels.find_interior = NULL;
    p->zero_words = 0; // other kernels leave other words as they are
    bool ok = build(p, err);
    if (!ok)
        p->kernels = (part_kernels){0};
    return ok;
}

static void change_choice(part *p, const char *name, int64_t value)
{
    for (int i = 0; i < PART_CHOICES; ++i)
        if (strcmp(p->choices[i].name, name) == 0)
            p->choices[i].value = value;
}

static bool ask_for_grid(part *p, const variant *asked, const part_grid_kind *g, duet_error *err)
{
    choose_all(p, asked);
    change_choice(p, "GRID", g->kind);
    change_choice(p, "LEVELS", !g->roomy);
    change_choice(p, "ROOMY", g->roomy);
    change_choice(p, "GUARDED", g->cut);
    change_choice(p, "SLAB", g->cut);
    return ask_all(p, err);
}

bool part_prepare_grids(part *p, const variant *asked, const part_grid_kind kinds[], uint32_t n,
                        duet_error *err)
{
    bool ok = true;
    for (uint32_t i = 0; ok && i < n; ++i)
        ok = ask_for_grid(p, asked, &kinds[i], err);
    ok = ok && program_set_build(p->programs, err);
    p->kernels = (part_kernels){0};
    return ok;
}

const kernel *part_kernel(const part *p, const char *name)
{
    const part_kernels *k = &p->kernels;
    const kernel *all[] = {k->clear,  k->hash,       k->scatter,     k->starts,    k->place,
                           k->narrow, k->candidates, SCAN_LAST(&p->scan), p->radix.move};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; ++i)
        if (kernel_is(all[i], name))
            return all[i];
    return NULL;
}
