// SPDX-License-Identifier: MIT
// A step: fit the grid, let both devices find the pairs of their objects at
// the same time, and hand out what they found.
//
// A takes the first share of the objects in cell order and B the rest. Each
// pair is found from its first object, so no pair is found twice and none is
// lost between the parts.
#include "runtime/broadphase/world.h"

#include "base/budget.h"
#include "base/clock.h"
#include "base/error.h"

#include <math.h>

// A device keeps its pairs where it can hand them over without the host, and gains by it.
static void choose_keepers(duet_world *world)
{
    const device *to = world->left.device;
    for (int side = 0; side < 2; ++side) {
        const device *from = world->parts[side].device;
        world->keeps_pairs[side] = to && !from->info.host_memory && from->context == to->context;
    }
}

static part_task describe_task(const duet_world *world, const grid_objects *objects, int side)
{
    const resident *r = &world->resident;
    return (part_task){
        .shared = world->def.plan.mode == DUET_MODE_SHARED,
        .slab = world->def.plan.mode == DUET_MODE_SLAB,
        .rotated = world->def.rotated,
        .ordered = world->def.ordered,
        .level = world->def.level,
        .objects = *objects,
        .resident = r->on[side] && !r->only_seen ? &r->objects : NULL,
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
    part *grid_from; // NULL: the part builds its own
    bool has_grid;
    pack *pack; // that its objects come from, where they are packed
    int side;
    part_task task;
    part_range range;
    bool placed; // the grid had space for its objects
    bool ok;
    duet_error err;
} job;

static bool get_grid(job *j)
{
    if (j->has_grid)
        return true;
    if (j->grid_from)
        return part_receive_grid(j->part, j->grid_from, &j->task, &j->range, &j->err);
    return part_send_objects(j->part, &j->task, &j->err) &&
           (!j->task.packed || part_receive_slab(j->part, j->pack, j->side, &j->task, &j->range,
                                                 &j->placed, &j->err)) &&
           (!j->placed || part_build_grid(j->part, &j->task, &j->range, &j->err));
}

// A part that failed may lack what it was sent.
static void run_job(void *arg)
{
    job *j = arg;
    uint64_t begun = clock_steady_ns();
    j->ok = get_grid(j);
    if (!j->ok)
        pack_abandon(j->pack);
    else if (j->placed)
        j->ok = part_search(j->part, &j->task, &j->range, &j->placed, &j->err);
    if (!j->ok)
        part_distrust(j->part);
    j->part->bytes = part_bytes(j->part);
    j->part->wall_ms += clock_ms_since(begun);
}

static bool has_work(const part_range *range)
{
    return range->first < range->last;
}

// Figure 11: B builds the grid and sends it; then both search.
static bool lend_grid(job *a, job *b)
{
    uint64_t begun = clock_steady_ns();
    a->task.receives = true;
    a->grid_from = b->part;
    b->has_grid = part_send_objects(b->part, &b->task, &b->err) &&
                  part_send_objects(a->part, &a->task, &b->err) &&
                  part_build_grid(b->part, &b->task, &b->range, &b->err) &&
                  part_send_grid(b->part, a->part, &b->task, &b->err);
    b->part->wall_ms = clock_ms_since(begun);
    if (!b->has_grid) {
        part_distrust(a->part);
        part_distrust(b->part);
    }
    return b->has_grid;
}

// The jobs of the parts in use. An object's slab is known only once its row of cells is, so that
// each device's part of the objects is packed by all threads that there are, while the jobs run.
static bool run_jobs(duet_world *world, job jobs[2], const bool use[2], duet_error *err)
{
    const part_range ranges[2] = {jobs[0].range, jobs[1].range};
    const bool packed[2] = {jobs[0].task.packed, jobs[1].task.packed};
    thread_pool *packers = NULL;
    if (!pack_start(&world->pack, world->parts, &jobs[0].task, ranges, packed, &packers, err))
        return false;
    thread_pool_run_both(world->driver, run_job, use[0] ? &jobs[0] : NULL,
                         use[1] ? &jobs[1] : NULL);
    thread_pool_wait(packers);
    return jobs[0].ok && jobs[1].ok;
}

// But for those that objects were sent ahead to, which began then.
static void begin_parts(duet_world *world)
{
    for (int side = 0; side < 2; ++side)
        if (world->parts[side].ahead_version != world->objects_version || world->n == 0)
            part_begin(&world->parts[side], world->steps);
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

// The paper's kernels take every object by its id. Each device marks what the other one wants, so
// that both take stretches or none does.
static bool takes_stretches(const duet_world *world)
{
    bool takes = world->def.ordered && world->def.plan.mode == DUET_MODE_SLAB;
    for (int side = 0; side < 2; ++side)
        takes &= (!world->resident.on[side] || world->resident.only_seen) &&
                 world->variants[side].search != SEARCH_PAPER;
    return takes;
}

static bool describe_jobs(job jobs[2], duet_world *world, const grid_objects *objects,
                          duet_error *err)
{
    const bool stretched = takes_stretches(world);
    for (int side = 0; side < 2; ++side)
        jobs[side] = (job){.part = &world->parts[side],
                           .pack = &world->pack,
                           .side = side,
                           .task = describe_task(world, objects, side),
                           .placed = true,
                           .ok = true};
    part_range ranges[2];
    if (!divide(world, &jobs[1].task, ranges, err))
        return false;
    for (int side = 0; side < 2; ++side) {
        job *j = &jobs[side];
        j->range = ranges[side];
        j->task.divided = j->task.slab && has_work(&ranges[0]) && has_work(&ranges[1]);
        j->task.intake = stretched ? &world->strays.intakes[side] : NULL;
        j->task.packed = j->task.slab && !stretched && !j->task.resident &&
                         pack_pays(&j->task, ranges, side, j->part, &world->variants[side]);
    }
    return !stretched || strays_begin(&world->strays, &jobs[1].task, ranges, err);
}

static bool prepare(duet_world *world, const job jobs[2], const bool use[2], duet_error *err)
{
    for (int side = 0; side < 2; ++side) {
        const part_task *task = &jobs[side].task;
        part *p = &world->parts[side];
        if (!use[side] || (world->prepared[side] && part_is_prepared(p, task)))
            continue;
        world->prepared[side] = part_prepare(p, &world->variants[side], task, err);
        if (!world->prepared[side])
            return false;
    }
    return true;
}

// *found_all is false where a slab had more objects than it had space for, or strays were missed:
// both are known then, and the parts are to be run again.
static bool run_parts(duet_world *world, const grid_objects *objects, bool *found_all,
                      duet_error *err)
{
    job jobs[2];
    if (!describe_jobs(jobs, world, objects, err))
        return false;
    const bool shared = jobs[0].task.shared && has_work(&jobs[0].range);
    const bool use[2] = {has_work(&jobs[0].range), shared || has_work(&jobs[1].range)};
    const bool stretched = jobs[0].task.intake;
    if (!prepare(world, jobs, use, err))
        return false;
    if ((shared && !lend_grid(&jobs[0], &jobs[1])) || !run_jobs(world, jobs, use, err)) {
        error_copy(err, &jobs[0].err);
        return error_copy(err, &jobs[1].err);
    }
    const bool placed = jobs[0].placed && jobs[1].placed;
    const stray_marks marks[2] = {strays_marks_of(jobs[0].part), strays_marks_of(jobs[1].part)};
    world->split.stale |= !placed;
    *found_all = placed && (!stretched || strays_guessed_all(&world->strays, marks));
    return true;
}

// ---------------------------------------------------------------- a step

// Cells that are too small, a slab without space, strays. A second widening would mean that
// objects grew while the step ran.
enum { MOST_FITS = 4 };

static bool find_all(duet_world *world, duet_error *err)
{
    bool fits = false;
    for (int fit = 0; !fits; ++fit) {
        grid_objects objects;
        begin_parts(world);
        if (!budget_check(err) || !world_fit_grid(world, &objects, false, NULL, err))
            return false;
        if (world->n == 0)
            return true;
        bool found_all = false;
        if (!run_parts(world, &objects, &found_all, err))
            return false;
        float widest = fmaxf(world->parts[0].found.widest, world->parts[1].found.widest);
        world->fitted = !(widest > 0.0f);
        fits = world->fitted && found_all;
        if (!fits && fit == MOST_FITS)
            return error_set(err, DUET_STATUS_CELL_TOO_SMALL,
                             "an object's extent of %g does not fit a cell of %g", widest,
                             world->grid.edge);
    }
    return true;
}

static bool find_pairs(duet_world *world, duet_error *err)
{
    bool ok = find_all(world, err);
    ++world->steps;
    world_end_sight(world);
    return ok;
}

static bool run_step(duet_world *world, duet_result *result, duet_error *err)
{
    uint64_t begun = clock_steady_ns();
    choose_keepers(world);
    if (world->def.stage_times)
        world->steps = 0;
    bool found = find_pairs(world, err);
    return world_hand_out(world, found, begun, result, err);
}

bool duet_world_step(duet_world *world, duet_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    return world_is_idle(world, __func__, err) && error_given(result, __func__, "result", err) &&
           run_step(world, result, err);
}

// ---------------------------------------------------------------- of what B has

// Whether B searches around all objects and needs nothing of A or the host for it.
static bool is_b_alone(const duet_world *world)
{
    const duet_plan *plan = &world->def.plan;
    bool slabs = plan->mode == DUET_MODE_SLAB || (world->mode_open && world->alike);
    return plan->share == 0 && !slabs;
}

bool world_step_resident(duet_world *world, const buffer *bounds, uint32_t n, bool untimed,
                         duet_result *result, const buffer **pairs, duet_error *err)
{
    uint64_t begun = clock_steady_ns();
    world->resident =
        (resident){.objects = *bounds, .on = {false, true}, .only_seen = !is_b_alone(world)};
    world->left.device = world->parts[1].device;
    world->n = n;
    ++world->objects_version;
    world->steps = untimed ? 1 : 0;
    for (int side = 0; side < 2; ++side)
        world->keeps_pairs[side] = side == 1;
    bool ok = world_hand_out(world, find_pairs(world, err), begun, result, err);
    world->resident = (resident){0};
    *pairs = world->left.joined;
    return ok;
}

// ---------------------------------------------------------------- counted

bool world_step_counting(duet_world *world, const global_ids *ids, duet_result *result,
                         part_counted counted[2], duet_error *err)
{
    global_ids own = *ids;
    own.before = world->ids_version;
    if (!world->ids_ahead)
        world->ids_version += world->ids_version == 0 || ids->all_changed || ids->n_changed > 0;
    world->ids_ahead = false;
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

// ---------------------------------------------------------------- a step in two halves

// A thread of the world's own carries it while the caller works.

// What waits for a failed event hangs under PoCL 3.1, or ends the process: a step that failed has
// rather left 0 pairs.
static void tell(step_half *h, bool told)
{
    if (!h->done)
        return;
    clSetUserEventStatus(h->done, told ? CL_COMPLETE : -1);
    clReleaseEvent(h->done);
    device_object_gone();
    h->done = NULL;
}

static void run(void *arg)
{
    duet_world *world = arg;
    world->background.ok = run_step(world, &world->half.result, &world->background.err);
    tell(&world->half, world->left.told);
}

static void start(duet_world *world)
{
    world->half.result = (duet_result){0};
    background_start(&world->background, run, world);
}

bool duet_world_step_begin(duet_world *world, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!world_is_idle(world, __func__, err) || !background_open(&world->background, err))
        return false;
    start(world);
    return true;
}

bool duet_world_step_begin_event(duet_world *world, cl_event *done, duet_error *err)
{
    PUBLIC_CALL(err);
    cl_int code = CL_SUCCESS;
    if (!world_is_idle(world, __func__, err) || !error_given(done, __func__, "done", err))
        return false;
    *done = NULL;
    if (!world->left.device)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "%s: pairs come to the host; expected duet_world_leave_pairs first",
                         __func__);
    if (!background_open(&world->background, err))
        return false;
    cl_event event = clCreateUserEvent(world->left.device->context, &code);
    if (code != CL_SUCCESS)
        return error_set_cl(err, code, "%s: making an event", __func__);
    device_object_made();
    clRetainEvent(event);
    world->half.done = *done = event;
    start(world);
    return true;
}

bool duet_world_step_end(duet_world *world, duet_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(world, __func__, "world", err) ||
        !error_given(result, __func__, "result", err))
        return false;
    if (!world_is_under_way(world))
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "%s: no step is under way; expected duet_world_step_begin first",
                         __func__);
    bool ok = background_end(&world->background, err);
    *result = world->half.result;
    return ok;
}

// ---------------------------------------------------------------- before a step

// A device that is sent all objects, into memory of its own. The kernels of the step may be others,
// of another grid: in how many pieces objects travel is all that these decide.
static bool can_send_ahead(const duet_world *world, int side)
{
    uint32_t share = world->def.plan.share;
    return world->prepared[side] && world->def.plan.mode == DUET_MODE_OWN &&
           !world->parts[side].device->info.host_memory && !world->def.separate_sizes &&
           (side == 0 ? share > 0 : share < DUET_SHARE_ONE);
}

void world_send_ahead(duet_world *world, uint32_t n, const global_ids *ids)
{
    global_ids own = ids ? *ids : (global_ids){0};
    uint64_t step = world->def.stage_times ? 0 : world->steps;
    world->ids_ahead = ids;
    if (ids)
        own.version = ++world->ids_version;
    for (int side = 0; side < 2 && n > 0 && !world->resident.objects.mem; ++side) {
        const grid_objects objects = world_objects(world);
        part_task task = describe_task(world, &objects, side);
        size_t bytes = world->lent ? world->n * task.objects.row_bytes : world->objects.size;
        task.objects.n = n;
        task.ids = ids ? &own : NULL;
        if (can_send_ahead(world, side) &&
            !part_send_ahead(&world->parts[side], &task, bytes, step, NULL))
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
    world->ids_ahead = false;
}
