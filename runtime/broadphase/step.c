// SPDX-License-Identifier: MIT
// A step: fit the grid, let both devices find the pairs of their objects at
// the same time, and hand out what they found.
//
// A takes the first share of the objects in cell order and B the rest. Each
// pair is found from its first object, so no pair is found twice and none is
// lost between the parts.
#include "runtime/broadphase/pair_hash.h"
#include "runtime/broadphase/world.h"

#include "base/budget.h"
#include "base/clock.h"
#include "base/error.h"

#include <math.h>
#include <string.h>

// Grids are fitted again where the number of objects has changed this much.
enum { REFIT_FACTOR = 2 };

// A second widening would mean that objects grew while the step ran.
enum { MOST_FITS = 3 };

// ---------------------------------------------------------------- the grid

// The grid is another than the one before.
static void take_grid(duet_world *world, const grid *before, uint32_t n)
{
    const cl_int4 was = before->levels[0].cells, is = world->grid.levels[0].cells;
    world->cells_vary |= was.s[0] > 0 && memcmp(&was, &is, sizeof is) != 0;
    world->fitted = true;
    world->fitted_n = n;
    world_choose_mode(world);
    world->split.stale = true;
    ++world->grid_version;
    world->prepared[0] = world->prepared[1] = false;
}

void world_swap_fit(duet_world *world, world_fit *fit)
{
    world_fit before = {world->fitted, world->cell_widened, world->fitted_n, world->grid};
    world->fitted = fit->fitted;
    if (fit->fitted) {
        world->grid = fit->grid;
        world->cell_widened = fit->cell_widened;
        take_grid(world, &before.grid, fit->n);
    }
    *fit = before;
}

static bool fit_grid(duet_world *world, duet_error *err)
{
    const duet_world_def *def = &world->def;
    if (!world_see_objects(world, err))
        return false;
    grid_objects objects = world_objects(world);
    grid_needs needs;
    grid_needs_of(&needs, &objects);
    bool too_small = def->cell > 0.0f && needs.widest > def->cell;
    if (too_small && def->cell_fixed)
        return error_set(err, DUET_STATUS_CELL_TOO_SMALL,
                         "the cell edge %g is below the extent %.9g of object %u; expected a "
                         "cell at least that wide",
                         def->cell, needs.widest, needs.widest_id);
    grid_wish wish = world->wish;
    wish.has_world = def->has_world;
    wish.edge = def->cell;
    for (int k = 0; k < 3; ++k) {
        wish.lower[k] = def->lower[k];
        wish.upper[k] = def->upper[k];
    }
    const grid before = world->grid;
    if (!grid_fit(&world->grid, &needs, &wish, &objects, err))
        return false;
    world->cell_widened = too_small;
    take_grid(world, &before, world->n);
    return true;
}

static bool needs_fit(const duet_world *world)
{
    uint64_t n = world->n;
    return !world->fitted || n > REFIT_FACTOR * (uint64_t)world->fitted_n ||
           REFIT_FACTOR * n < world->fitted_n;
}

bool world_fit_grid(duet_world *world, duet_error *err)
{
    return !needs_fit(world) || fit_grid(world, err);
}

// Where pairs stay on a device that has memory of its own.
static void choose_keepers(duet_world *world)
{
    for (int side = 0; side < 2; ++side)
        world->keeps_pairs[side] =
            pair_buffers_can_copy(&world->left, &world->def.pair->devices[side]);
}

static void choose_timed(duet_world *world)
{
    if (world->def.stage_times)
        world->steps = 0;
    for (int side = 0; side < 2; ++side) {
        part *p = &world->parts[side];
        p->untimed =
            !world->def.stage_times && !timeline_is_due(&p->times, p->device, world->steps);
    }
    ++world->steps;
}

static part_task describe_task(const duet_world *world, int side)
{
    const resident *r = &world->resident;
    return (part_task){
        .shared = world->def.plan.mode == DUET_MODE_SHARED,
        .rotated = world->def.rotated,
        .ordered = world->def.ordered,
        .level = world->def.level,
        .objects = world_objects(world),
        .resident = r->on[side] ? &r->objects : NULL,
        .keeps_pairs = world->keeps_pairs[side],
        .skims = world->skims,
        .ids = world->parts[side].device->info.host_memory ? NULL : world->ids,
        .objects_version = world->objects_version,
        .sizes_version = world->sizes_version,
        .grid = world->grid,
        .grid_version = world->grid_version,
        .cells_vary = world->cells_vary,
        .max_pairs = world->def.max_pairs,
    };
}

// ---------------------------------------------------------------- parts

// What one part does, possibly in the driver's thread.
typedef struct job {
    part *part;
    part *grid_from; // NULL: builds its own
    pack *pack;      // that its objects come from, where they are packed
    int side;
    part_task task;
    part_range range;
    bool placed; // the grid had space for its objects
    bool ok;
    duet_error err;
} job;

static bool build_own_grid(job *j)
{
    return part_begin(j->part, &j->task, &j->err) &&
           (!j->task.packed || part_receive_slab(j->part, j->pack, j->side, &j->task, &j->range,
                                                 &j->placed, &j->err)) &&
           (!j->placed || part_build_grid(j->part, &j->task, &j->range, &j->err));
}

static void run_job(void *arg)
{
    job *j = arg;
    uint64_t begun = clock_steady_ns();
    j->ok = j->grid_from ? part_receive_grid(j->part, j->grid_from, &j->task, &j->range, &j->err)
                         : build_own_grid(j);
    if (!j->ok)
        pack_abandon(j->pack);
    else if (j->placed)
        j->ok = part_search(j->part, &j->task, &j->range, &j->placed, &j->err);
    j->part->wall_ms += clock_ms_since(begun);
}

static bool has_work(const job *j)
{
    return j->range.first < j->range.last;
}

// Own grids, whole ones or slabs.
static bool run_own(duet_world *world, job jobs[2])
{
    bool use[2] = {has_work(&jobs[0]), has_work(&jobs[1])};
    thread_pool_run_both(world->driver, run_job, use[0] ? &jobs[0] : NULL,
                         use[1] ? &jobs[1] : NULL);
    return (!use[0] || jobs[0].ok) && (!use[1] || jobs[1].ok);
}

// Figure 11: B builds the grid and sends it; then both search.
static bool run_shared(duet_world *world, job jobs[2])
{
    job *a = &jobs[0];
    job *b = &jobs[1];
    a->task.receives = true;
    uint64_t begun = clock_steady_ns();
    b->ok = part_begin(b->part, &b->task, &b->err) && part_begin(a->part, &a->task, &b->err) &&
            part_build_grid(b->part, &b->task, &b->range, &b->err) &&
            part_send_grid(b->part, a->part, &b->task, &b->err);
    b->part->wall_ms = clock_ms_since(begun);
    if (!b->ok)
        return false;
    a->grid_from = b->part;
    thread_pool_start(world->driver, run_job, a);
    begun = clock_steady_ns();
    b->ok = part_search(b->part, &b->task, &b->range, &b->placed, &b->err);
    b->part->wall_ms += clock_ms_since(begun);
    thread_pool_wait(world->driver);
    return a->ok && b->ok;
}

// An object's slab is known only once its row of cells is, so that each device's part of the
// objects is packed by all threads that there are.
static bool run_packed(duet_world *world, job jobs[2], duet_error *err)
{
    const part_range ranges[2] = {jobs[0].range, jobs[1].range};
    const bool packed[2] = {jobs[0].task.packed, jobs[1].task.packed};
    bool ok = pack_start(&world->pack, world->parts, &jobs[0].task, ranges, packed, err) &&
              run_own(world, jobs);
    pack_wait(&world->pack);
    return ok;
}

static void forget_last_step(duet_world *world)
{
    for (int side = 0; side < 2; ++side)
        if (world->parts[side].ahead_version != world->objects_version || world->n == 0)
            part_forget(&world->parts[side]);
}

static bool strays_were_missed(duet_world *world, const job jobs[2])
{
    const stray_marks marks[2] = {part_marks(jobs[0].part), part_marks(jobs[1].part)};
    return jobs[0].placed && jobs[1].placed && !strays_guessed_all(&world->strays, marks);
}

// Once strays were missed they are known, and no second guess misses any.
static bool run_stretched(duet_world *world, job jobs[2], duet_error *err)
{
    const part_range ranges[2] = {jobs[0].range, jobs[1].range};
    if (!strays_begin(&world->strays, &jobs[1].task, ranges, err) || !run_own(world, jobs))
        return false;
    if (!strays_were_missed(world, jobs))
        return true;
    forget_last_step(world);
    return run_own(world, jobs);
}

static bool prepare(duet_world *world, const job jobs[2], const bool use[2], duet_error *err)
{
    for (int side = 0; side < 2; ++side) {
        const part_task *task = &jobs[side].task;
        part *p = &world->parts[side];
        bool as_before =
            p->kernels.packed == task->packed && p->kernels.stretched == (task->strays != NULL) &&
            (p->kernels.gather || !part_gathers(p, task)) && (p->kernels.count_pairs || !task->ids);
        if (!use[side] || (world->prepared[side] && as_before))
            continue;
        world->prepared[side] = part_prepare(p, &world->variants[side], task, err);
        if (!world->prepared[side])
            return false;
    }
    return true;
}

// Which objects each part searches around: parts of one sorted order, or slabs.
static bool divide(duet_world *world, const part_task *task, part_range ranges[2], duet_error *err)
{
    uint32_t share = world->def.plan.share;
    if (world->def.plan.mode == DUET_MODE_SLAB)
        return split_cut(&world->split, task, share, ranges, err);
    uint32_t n_cells = task->grid.n_cells;
    uint32_t cut = (uint32_t)((uint64_t)task->objects.n * share / DUET_SHARE_ONE);
    part_range whole = {.home_to = n_cells, .key_to = n_cells, .expected = task->objects.n};
    ranges[0] = ranges[1] = whole;
    ranges[0].last = ranges[1].first = cut;
    ranges[1].last = task->objects.n;
    return true;
}

// Whether the host must see objects that a device has: to send them to the other one, or to
// decide in the device's memory what float leaves open.
static bool needs_sight(const duet_world *world, const bool use[2])
{
    bool needs = false;
    for (int side = 0; side < 2; ++side)
        needs |= use[side] &&
                 (!world->resident.on[side] || (world->def.shape == DUET_SHAPE_POSES &&
                                                world->parts[side].device->info.host_memory));
    return needs;
}

// The paper's kernels take every object by its id. Each device marks what the other one wants, so
// that both take stretches or none does.
static bool takes_stretches(const duet_world *world)
{
    bool takes = world->def.ordered && world->def.plan.mode == DUET_MODE_SLAB;
    for (int side = 0; side < 2; ++side)
        takes &= !world->resident.on[side] && world->variants[side].search != SEARCH_PAPER;
    return takes;
}

// *placed is false where a slab had more objects than it had space for.
static bool run_parts(duet_world *world, bool *placed, duet_error *err)
{
    bool slabs = world->def.plan.mode == DUET_MODE_SLAB;
    if (slabs && world->split.stale && !world_see_objects(world, err))
        return false;
    part_task task = describe_task(world, 1);
    part_range ranges[2];
    forget_last_step(world);
    if (!divide(world, &task, ranges, err))
        return false;
    bool shared = world->def.plan.mode == DUET_MODE_SHARED && ranges[0].first < ranges[0].last;
    const bool use[2] = {ranges[0].first < ranges[0].last,
                         shared || ranges[1].first < ranges[1].last};
    if (needs_sight(world, use) && !world_see_objects(world, err))
        return false;
    const bool stretched = takes_stretches(world);
    job jobs[2];
    for (int side = 0; side < 2; ++side) {
        part_task own = describe_task(world, side);
        own.side = side;
        own.slab = slabs;
        own.strays = stretched ? &world->strays : NULL;
        own.packed = slabs && !own.strays && !own.resident &&
                     pack_pays(&own, ranges, side, &world->parts[side], &world->variants[side]);
        jobs[side] = (job){.part = &world->parts[side],
                           .pack = &world->pack,
                           .side = side,
                           .task = own,
                           .range = ranges[side],
                           .placed = true};
    }
    if (!prepare(world, jobs, use, err))
        return false;
    bool ok = shared      ? run_shared(world, jobs)
              : stretched ? run_stretched(world, jobs, err)
                          : run_packed(world, jobs, err);
    for (int side = 0; side < 2 && !ok; ++side) {
        part_distrust(&world->parts[side]);
        if (jobs[side].err.status != DUET_STATUS_OK && err && err->status == DUET_STATUS_OK)
            *err = jobs[side].err;
    }
    *placed = jobs[0].placed && jobs[1].placed;
    return ok;
}

// ---------------------------------------------------------------- before a step

// A device that is sent all objects, into memory of its own, by kernels that are there.
static bool can_send_ahead(const duet_world *world, int side)
{
    uint32_t share = world->def.plan.share;
    return world->prepared[side] && world->def.plan.mode == DUET_MODE_OWN &&
           !world->parts[side].device->info.host_memory && !world->def.separate_sizes &&
           (side == 0 ? share > 0 : share < DUET_SHARE_ONE);
}

void world_send_ahead(duet_world *world, uint32_t n)
{
    for (int side = 0; side < 2 && n > 0 && !world->resident.objects.mem; ++side) {
        part_task task = describe_task(world, side);
        task.objects.n = n;
        if (can_send_ahead(world, side) &&
            !part_send_ahead(&world->parts[side], &task, world->objects.size, NULL))
            part_distrust(&world->parts[side]);
    }
}

// B, which has most of the work, unless A alone was sent them.
static part *skimmer(duet_world *world)
{
    return &world->parts[world->parts[1].ahead_version > 0];
}

bool world_skim(duet_world *world, const float inside_lower[3], const float inside_upper[3])
{
    return part_skim(skimmer(world), inside_lower, inside_upper, NULL);
}

uint32_t world_await_skim(duet_world *world, uint32_t from, const skim_block **blocks)
{
    return part_await_skim(skimmer(world), from, blocks);
}

void world_stop_ahead(duet_world *world)
{
    for (int side = 0; side < 2; ++side)
        if (world->parts[side].ahead_version > 0)
            part_distrust(&world->parts[side]);
}

// ---------------------------------------------------------------- result

static uint32_t largest(uint32_t a, uint32_t b)
{
    return a > b ? a : b;
}

static uint32_t smallest(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

// A part reports the bad objects of its own cells. Two slabs share no cells; two whole
// grids are identical.
static uint32_t count_bad(const duet_world *world)
{
    uint32_t a = world->parts[0].found.bad;
    uint32_t b = world->parts[1].found.bad;
    return world->def.plan.mode == DUET_MODE_SLAB ? a + b : largest(a, b);
}

static bool check_bad(const duet_world *world, duet_error *err)
{
    const part *a = &world->parts[0];
    const part *b = &world->parts[1];
    uint32_t bad = count_bad(world);
    if (bad == 0 || world->def.keep_bad)
        return true;
    return error_set(err, DUET_STATUS_BAD_OBJECT,
                     "object %u of %u is not a number, infinite, negative or without rotation "
                     "(%u such objects)",
                     smallest(a->found.first_bad, b->found.first_bad), world->n, bad);
}

static double kernel_ms(const part *p)
{
    return (double)(p->times.last_end - p->times.first_begin) * 1e-6;
}

static void fill_result(duet_world *world, duet_result *result)
{
    const part *a = &world->parts[0];
    const part *b = &world->parts[1];
    uint32_t bad = count_bad(world);
    const grid_level *finest = &world->grid.levels[0];
    *result = (duet_result){
        .objects = world->n,
        .bad = bad,
        .first_bad = bad ? smallest(a->found.first_bad, b->found.first_bad) : 0,
        .candidates = a->n_candidates + b->n_candidates,
        .pairs = a->span.n + b->span.n,
        .spans = {a->span, b->span},
        .undecided = a->n_undecided + b->n_undecided,
        .device_ms = {a->wall_ms, b->wall_ms},
        .kernel_ms = {kernel_ms(a), kernel_ms(b)},
        .bytes = {part_bytes(a), part_bytes(b)},
        .cells = {(uint32_t)finest->cells.s[0], (uint32_t)finest->cells.s[1],
                  (uint32_t)finest->cells.s[2]},
        .grid_levels = world->grid.n_levels,
        .hashed = world->grid.kind == GRID_HASHED,
        .cell = world->grid.edge,
        .cell_widened = world->cell_widened,
        .runs = largest(a->runs, b->runs),
        .stages = world->stages,
        .timed = !a->times.untimed && !b->times.untimed,
    };
    for (int side = 0; side < 2; ++side) {
        const timeline *t = &world->parts[side].times;
        for (int i = 0; i < t->n_stages; ++i) {
            world->stages[result->n_stages] = t->stages[i];
            world->stages[result->n_stages++].device = side;
        }
    }
}

static bool find_pairs(duet_world *world, duet_error *err)
{
    bool fits = world->n == 0;
    if (fits)
        forget_last_step(world);
    for (int fit = 0; !fits; ++fit) {
        if (!budget_check(err) || !world_fit_grid(world, err))
            return false;
        bool placed = true;
        if (!run_parts(world, &placed, err))
            return false;
        float widest = fmaxf(world->parts[0].found.widest, world->parts[1].found.widest);
        world->fitted = !(widest > 0.0f);
        world->split.stale |= !placed;
        fits = world->fitted && placed;
        if (!fits && fit == MOST_FITS)
            return error_set(err, DUET_STATUS_CELL_TOO_SMALL,
                             "an object's extent of %g does not fit a cell of %g", widest,
                             world->grid.edge);
    }
    return check_bad(world, err);
}

static bool find_pairs_when_ready(duet_world *world, duet_error *err)
{
    bool ok = resident_await(&world->resident, err) && find_pairs(world, err);
    world_end_sight(world);
    return ok;
}

static bool leave_pairs(duet_world *world, duet_result *result, duet_error *err)
{
    part *parts[2] = {&world->parts[0], &world->parts[1]};
    bool ok = pair_buffers_fill(&world->left, parts, world->keeps_pairs, err);
    fill_result(world, result);
    result->spans[0].pairs = result->spans[1].pairs = NULL;
    return ok;
}

static bool run_step(duet_world *world, duet_result *result, duet_error *err)
{
    uint64_t begun = clock_steady_ns();
    choose_keepers(world);
    choose_timed(world);
    if (!world_check_sizes(world, err) || !find_pairs_when_ready(world, err))
        return false;
    bool ok = true;
    if (world->left.device)
        ok = leave_pairs(world, result, err);
    else
        fill_result(world, result);
    result->total_ms = clock_ms_since(begun);
    return ok;
}

bool world_run_step(duet_world *world, duet_result *result, bool *told, duet_error *err)
{
    bool ok = run_step(world, result, err);
    *told = ok || (world->left.device && pair_buffers_clear(&world->left));
    return ok;
}

bool duet_world_step(duet_world *world, duet_result *result, duet_error *err)
{
    bool told;
    return world_is_idle(world, __func__, err) && error_given(result, __func__, "result", err) &&
           world_run_step(world, result, &told, err);
}

bool world_step_resident(duet_world *world, const buffer *bounds, uint32_t n, duet_result *result,
                         const buffer **pairs, duet_error *err)
{
    uint64_t begun = clock_steady_ns();
    world->resident = (resident){.objects = *bounds, .on = {false, true}};
    world->keeps_pairs[0] = false;
    world->keeps_pairs[1] = true;
    world->n = n;
    ++world->objects_version;
    bool ok = find_pairs_when_ready(world, err);
    world->resident = (resident){0};
    *pairs = &world->parts[1].pairs;
    if (!ok)
        return false;
    fill_result(world, result);
    result->total_ms = clock_ms_since(begun);
    return true;
}

bool world_step_counting(duet_world *world, const global_ids *ids, duet_result *result,
                         part_counted counted[2], duet_error *err)
{
    global_ids own = *ids;
    own.before = world->ids_version;
    world->ids_version += world->ids_version == 0 || ids->all_changed || ids->n_changed > 0;
    own.version = world->ids_version;
    world->ids = &own;
    bool ok = duet_world_step(world, result, err);
    world->ids = NULL;
    for (int side = 0; side < 2; ++side)
        counted[side] = world->parts[side].counted;
    return ok;
}

bool world_bring_counted(duet_world *world, duet_span spans[2], duet_error *err)
{
    bool ok = true;
    for (int side = 0; ok && side < 2; ++side) {
        ok = part_bring_counted(&world->parts[side], err);
        spans[side] = world->parts[side].span;
    }
    return ok;
}

// ---------------------------------------------------------------- pairs

// Pairs as a set, whoever found them and in whatever order.
uint64_t duet_pairs_hash(const duet_pair *pairs, uint64_t n)
{
    uint64_t sum = 0;
    for (uint64_t i = 0; pairs && i < n; ++i)
        sum += pair_hash((uint64_t)pairs[i].a << 32 | pairs[i].b);
    return sum;
}

uint64_t duet_result_get_hash(const duet_result *result)
{
    if (!result)
        return 0;
    return duet_pairs_hash(result->spans[0].pairs, result->spans[0].n) +
           duet_pairs_hash(result->spans[1].pairs, result->spans[1].n);
}

duet_pair duet_result_get_pair(const duet_result *result, uint64_t i)
{
    if (!result || i >= result->spans[0].n + result->spans[1].n)
        return (duet_pair){0, 0};
    bool of_a = i < result->spans[0].n;
    const duet_pair *pairs = result->spans[of_a ? 0 : 1].pairs;
    return pairs ? pairs[of_a ? i : i - result->spans[0].n] : (duet_pair){0, 0};
}
