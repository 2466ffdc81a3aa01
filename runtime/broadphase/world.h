// SPDX-License-Identifier: MIT
// A world's insides, for the files that make up its step.
#ifndef RUNTIME_WORLD_H
#define RUNTIME_WORLD_H

#include "runtime/broadphase/part.h"
#include "runtime/broadphase/workload_stats.h"
#include "runtime/duet_opencl.h"
#include "runtime/opencl/background.h"
#include "runtime/opencl/callers_buffer.h"
#include "runtime/opencl/device_pair.h"
#include "runtime/opencl/thread_pool.h"

// Objects in a buffer on devices, which B's kernels made or the caller brings. The views of the
// devices that have the buffer are bound to it; the host sees the objects if a step needs it to.
typedef struct resident {
    cl_mem mem;           // held; NULL: the objects are the host's
    callers_events ready; // wait for these before the buffer is read; none once they are over
} resident;

// Pairs that a step leaves on a device instead of bringing them to the host.
typedef struct pair_buffers {
    const device *device; // NULL: pairs come to the host
    cl_mem pairs, count;  // the caller's, held; NULL: own
    uint64_t capacity;    // the caller's
    buffer own_pairs, own_count;
    const buffer *joined;   // our buffer that has all pairs: own_pairs or a part's
    duet_pair_buffers last; // the last step's; its mems may be a part's. Without a count that is
                            // not on the device, 0 after a failure; without pairs then
} pair_buffers;

// The first half of a step leaves these for the second.
typedef struct step_half {
    cl_event done; // the caller's commands may wait for it; NULL: none do
    duet_result result;
} step_half;

// A step makes these, each from the one before it, unless it is right already:
//
//     objects ---> grid ---> split ---> input ranges ---> selections ---> views of the objects
//                    `---> views of the levels, and of lists of a slab's objects
//
//   grid     right if fitted_n > 0 and n is no more than REFIT_FACTOR from it; made again once an
//            object does not fit (world_fit_grid)
//   split    right until the grid is another, or a slab had no space for its objects; cut again for
//            another share or n (split_cut)
//   ranges   a guess, right until a device requests a block that it has not (input_ranges_begin)
//   views    right if they have the rows of the array's generation; what is made from the grid is
//            forgotten with it (view_update)
//
// Invariants:
// 1. The objects lie in one place: their block or the resident buffer. Their rows are where the
//    host sees them, and NULL only if they are resident and not seen.
// 2. def.plan has no default left: its mode is asked_mode, or what suits the grid.
// 3. Only a part's views know what lies on its device.
struct duet_world {
    duet_world_def def;
    uint32_t users;       // the creator, and shares that are kept on line
    duet_mode asked_mode; // the plan's
    variant variants[2];  // the plan's
    grid_wish wish;       // the plan's

    grid_objects objects; // in the kind that the def asks for
    host_block objects_block, sizes_block;
    resident resident;
    workload_stats stats; // taken of the objects that were set first

    grid grid;
    bool moves;          // the objects, whose grid may become any (world_expect_motion)
    uint32_t fitted_n;   // objects that the grid was fitted to; 0: it is to be fitted
    split split;         // the grid's, in mode slab
    input_ranges ranges; // the slabs' objects, if they are ordered
    compaction lists;    // the slabs' objects, if they are not ordered

    part parts[2];             // A, B
    thread_pool *driver;       // drives A while the caller's thread drives B
    global_ids ids;            // the last ones that a step counted pairs by
    const global_ids *counted; // the same in a step that counts; else NULL
    pair_buffers left;         // the buffers that pairs are left in
    uint64_t steps;            // since the last whose stages were asked for
    background background;     // runs a step in two halves
    step_half half;
    duet_stage stages[2 * TIMELINE_STAGES]; // the last step's
};

// Whether a step has begun that was not ended; whether a public call has a world where none
// has, BAD_ARGUMENT if it has not.
bool world_is_under_way(const duet_world *world);
bool world_is_idle(const duet_world *world, const char *call, duet_error *err);

// The name of a kind of objects, "poses", and the bytes of its row; the kind of the objects of such
// a world, and its name.
const char *world_kind_name(duet_object_kind kind);
size_t world_kind_bytes(duet_object_kind kind);
duet_object_kind world_objects_kind(const duet_world_def *def);
const char *world_objects_name(const duet_world_def *def);

// Begins to send the first n objects of those that were mapped, where that can be, while the caller
// writes others behind them; the next step is of all of these. Until then the first n stay as they
// are. The step sends again what fails.
void world_prefetch(duet_world *world, uint32_t n);
void world_cancel_prefetch(duet_world *world); // waits for it, and forgets it

// Goes through what was sent ahead, by a device to which it goes anyway: which of the objects lie
// deep inside of the box. False if none does, or if not all were sent. The other one waits for the
// blocks from `from` on, 0 at first, and returns up to which object they are there (part.h).
bool world_find_interior(duet_world *world, const float inside_lower[3],
                         const float inside_upper[3]);
uint32_t world_await_interior(duet_world *world, uint32_t from, const interior_block **blocks);

// From now on the world has n of the objects that were mapped and those that were written behind
// them; NULL if there is no space for so many.
void *world_extend_objects(duet_world *world, duet_object_kind kind, uint32_t n);

// One user more, until it destroys the world.
void world_hold(duet_world *world);

// Sets the level of a loaded profile. Later profiles may use any level within the requested
// accuracy.
void world_change_level(duet_world *world, duet_level level);

// Builds the kernels of a motion's world, whose bounds lie on B, for all grids that its steps may
// come to need. spreads: bodies may leave the others far behind.
bool world_expect_motion(duet_world *world, bool spreads, duet_error *err);

// The next step lays its grid anew, whatever the last one found.
void world_forget_grid(duet_world *world);

// The same, but as another grid of the same objects, which moved: kernels have no cells of it
// compiled in.
void world_refit_grid(duet_world *world);

// A grid that was fitted to n objects; 0: there is none.
typedef struct world_fit {
    uint32_t n;
    grid grid;
} world_fit;

// The world's becomes this one, and this one the world's: of objects that take turns each have
// a grid of their own.
void world_swap_fit(duet_world *world, world_fit *fit);

// Takes the objects, and fits a grid to them if the last one does not suit them, by these
// threads and the caller's; NULL: by that alone. The host sees the objects if that is asked
// for, if a grid is fitted or slabs of it are to be cut anew, and if a search needs it.
bool world_fit_grid(duet_world *world, bool seen, thread_pool *threads, duet_error *err);

// All of a def but its device pair and its plan.
bool world_check_def(const duet_world_def *def, duet_error *err);

// Sets the plan's mode to the asked one, or by the grid if that is the default.
void world_choose_mode(duet_world *world);

// Whether the device has the kernels of the plan, which the first step with it builds.
bool world_is_prepared(const duet_world *world, int side);

// Whether the devices do work in proportion to their units: parts of one CPU, or two of one kind.
bool world_pair_is_alike(const duet_device_pair *pair);

// The objects are others, or lie elsewhere.
void world_renew_objects(duet_world *world);

// Waits for what must be over before the objects are read. BAD_ARGUMENT unless each has a size,
// whichever of the two was set first. The host then sees them, in place or in the world's own
// memory, if `seen` or if a search by the plan needs it. In place it sees them until
// world_unmap_objects, for a step at most.
bool world_take_objects(duet_world *world, bool seen, duet_error *err);
void world_unmap_objects(duet_world *world);

// The next steps are of n objects in a buffer that these devices have. Takes r over.
void world_bind_resident(duet_world *world, resident r, size_t bytes, const bool on[2], uint32_t n);
void world_drop_resident(duet_world *world);
void resident_release(resident *r);

// Maps n transforms, of the kind that the world was made for, and fills them from poses.
bool world_take_transforms(duet_world *world, const duet_pose *poses, uint32_t n, duet_error *err);

void pair_buffers_drop(pair_buffers *b);

// Hands out the result of a step that began at `begun`, if its parts `found` their pairs.
// BAD_OBJECT if there are bad objects that the world does not keep. Pairs that are left on a device
// are joined in one buffer; TOO_MANY if the caller's has no space for them. After a failure their
// number there is 0, so that kernels which read it do nothing.
bool world_hand_out(duet_world *world, bool found, uint64_t begun, duet_result *result,
                    duet_error *err);

// A step of an idle world.
bool world_step(duet_world *world, duet_result *result, duet_error *err);

// A step over n bounds in B's memory. *pairs has as many as the result says, in B's memory until
// the next step; its spans have none. Neither bounds nor pairs come to the host if B searches
// alone.
bool world_step_resident(duet_world *world, const buffer *bounds, uint32_t n, bool untimed,
                         duet_result *result, const buffer **pairs, duet_error *err);

// A step in which a device with memory of its own counts the pairs of objects that have global ids,
// and adds up their hash, in counted[side]. The result's pairs and spans have only the others, less
// those of two objects behind the ids, and all that other devices found.
bool world_step_counting(duet_world *world, const global_ids *ids, duet_result *result,
                         part_counted counted[2], duet_error *err);

// Brings the pairs that stayed on devices: the spans then have all of that step, until the next.
bool world_read_counted(duet_world *world, duet_span spans[2], duet_error *err);

#endif
