// SPDX-License-Identifier: MIT
// One device's part of a step: its kernels, its memory, its grid, its search.
//
// A part is driven by one thread at a time. Sorting and searching follow its variant; the caller
// decides which objects and which cells are the part's (part_task).
#ifndef RUNTIME_PART_H
#define RUNTIME_PART_H

#include "kernels/counters.h"
#include "kernels/grid/interior.h"
#include "runtime/broadphase/compaction.h"
#include "runtime/broadphase/global_ids.h"
#include "runtime/broadphase/input_ranges.h"
#include "runtime/broadphase/variant.h"
#include "runtime/opencl/radix_sort.h"

// The source of a part's grid (the paper, section 4.1).
typedef enum grid_role {
    GRID_OWN,     // each part builds its own
    GRID_BUILT,   // built here, and sent to the other part
    GRID_RECEIVED // built by the other part
} grid_role;

// The work of a part in a step. Lists and ranges need slabs, and slabs GRID_OWN; all other
// combinations of the selection, the role, the pairs and the ids are legal (test_views).
typedef struct part_task {
    const duet_world_def *def;   // with the mode that the grid suits
    const grid_objects *objects; // the world's; those on the device are the view's
    const grid *grid;
    grid_role role;
    struct part *other;    // the other device's part
    part_range range;      // the grid's
    selection wanted;      // the objects'
    compaction *lists;     // that find a wanted LIST
    const global_ids *ids; // pairs of objects that have one stay there, and are counted; or NULL
    bool pairs_on_device;  // the pairs stay on the device
    bool moves;            // the objects; grids of other kinds may follow
} part_task;

// How far a part is in a step (part_run.c):
//
//   part_take        build or receive the grid        search
//   ---------> BEGUN -------------------------> HAS_GRID ----> DONE
//                |                                 |
//                +---- no space for all objects ---+---------> CROWDED
//                +---- the device failed ----------+---------> FAILED
typedef enum part_state {
    PART_BEGUN,    // it has a task, and its views may be those of another
    PART_HAS_GRID, // its views are what the task wants, its grid has the task's range
    PART_DONE,     // its result has all pairs of the range
    PART_CROWDED,  // nothing was found; memory that was too small is larger
    PART_FAILED    // nothing is known of the device, and its views are forgotten
} part_state;

typedef struct part_kernels {
    kernel *clear;
    kernel *hash;
    kernel *own_cells; // NULL if all counting is atomic, and with it
    kernel *count_others;
    kernel *scatter;
    kernel *starts;
    kernel *place; // bounds by id (paper), or everything into cell order (gpu, simd)
    kernel *candidates;
    kernel *narrow; // NULL if the candidates' kernel finds pairs
    kernel *gather; // NULL if the host sees objects that are to be decided
    kernel *change_ids;
    kernel *count_pairs;   // NULL if pairs come to the host
    kernel *find_interior; // NULL if it cannot be
} part_kernels;

// A parameter of the kernels that the scene or the stage decides. A choice that is open may be set
// otherwise by the variant.
typedef struct part_choice {
    const char *name;
    int64_t value;
    bool open;
} part_choice;

enum { PART_CHOICES = 26, PART_OFFERS = PART_CHOICES + VARIANT_SETTINGS };

// Facts of the kernels that a part has, by the task and the variant that they were built for.
typedef enum part_fact {
    PART_TESTS_BOXES = 1 << 0,  // beyond their bounds
    PART_LEAVES_BOXES = 1 << 1, // boxes are read by id, where the objects are
    PART_OWN_CELLS = 1 << 2,    // objects are counted without atomics
    PART_TO_PLACES = 1 << 3,    // objects reach cell order by key and rank
    PART_BY_IDS = 1 << 4,       // objects reach cell order by their sorted ids
    PART_FUSED = 1 << 5         // candidates are tested where they are found
} part_fact;

// Arguments of kernels besides the part's buffers, by the names that their cards use.
typedef struct part_args {
    cl_uint n, n_levels, n_cells;
    cl_uint n_hashed;
    cl_uint key_end;
    cl_uint n_home_cells, n_own_cells;
    cl_uint n_counters, n_counts;
    cl_uint last;
    cl_uint found_capacity, candidate_capacity, pair_capacity, undecided_capacity;
    cl_uint row_words, n_ids; // gathered
    cl_uint n_owned, n_id_changes, left_capacity;
    cl_uint marked_from, marked_to;
    cl_uint interior_from;
    cl_float4 inside_lower, inside_upper;
    cl_int4 cells;
    buffer objects;
    buffer found; // pairs, or candidates if they are tested later
} part_args;

// The counters, read (kernels/counters.h).
typedef struct part_found {
    uint64_t candidates; // that were listed
    uint64_t tested;     // candidates that were tested where they were found
    uint64_t pairs, undecided;
    uint32_t bad;       // objects that were left out
    uint32_t first_bad; // the least id among them
    uint32_t placed;    // objects in the grid
    float widest;       // the largest extent that did not fit; 0: all fit
} part_found;

part_found part_found_of(const uint32_t counts[COUNTERS]);

// A summary of the pairs that stay on the device.
typedef struct part_counted {
    uint64_t n;
    uint64_t hash; // by global ids (kernels/grid/count_pairs.cl)
    uint64_t left; // others with one of the first n objects (global_ids.h): these come to the host
} part_counted;

// The findings of a step, and its cost.
typedef struct part_result {
    part_found found; // by what was read last of the counters
    part_counted counted;
    duet_span span; // without pairs if they stay on the device
    uint64_t n_candidates, n_undecided;
    uint32_t runs; // searches, more than one if a buffer had to grow
    double wall_ms;
} part_result;

// Invariants:
// 1. The kernels and the facts are those of `variant` and `choices`; without candidates there are
//    none.
// 2. The views say what lies on the device of the world's arrays. All else in its memory is
//    made anew in each step, but for zero_words and pairs_early.
// 3. `result` is that of the last step that part_begin began.
typedef struct part {
    const device *device;
    const device *devices; // the device pair, for host memory
    int side;              // the part's, in the pair
    scan scan;
    radix_sort radix;
    timeline times;
    uint64_t bytes; // held on the device once the last step was over

    struct { // the kernels
        gen *gen;
        program_set *programs;
        gen_limits limits; // the device's
        variant variant;
        part_choice choices[PART_CHOICES];
        gen_offer offers[PART_OFFERS]; // the choices, and what the variant sets
        uint32_t n_offers, facts;      // bits of part_fact
        part_kernels kernels;
        part_args args;
    };

    struct { // the step
        part_task task;
        part_state state;
        duet_error err; // if it failed
        part_result result;
    };

    struct { // the world's arrays on the device
        device_view objects;
        device_view sizes;      // if the objects are transforms
        device_view levels;     // the grid's
        device_view global_ids; // 64 bits each
        uint32_t least_chunk;   // objects
        buffer id_changes;
        host_block changes; // on their way there
    };
    struct {
        buffer blocks;                  // kernels/grid/interior.h, of objects that were prefetched
        host_block on_host;             // the same on the host
        cl_event done[2 * VIEW_CHUNKS]; // when those of a chunk are
    } interior;
    struct {
        buffer words;        // [n / INPUT_BLOCK] the epoch, if the other part needs the block
        host_block on_host;  // on the host, if the device has memory of its own
        block_requests last; // the last step's
    } requests;

    struct {                          // the grid
        buffer keys, ids;             // the objects'; in cell order once sorted
        buffer keys_spare, ids_spare; // the other half of the radix sort; keys_spare also the ranks
        buffer counts;                // objects a cell, until the scan makes starts of them
        buffer counters, next_counters; // this step's, and the next step's
        uint32_t zero_words;            // zero words of next_counters and then counts; 0: unknown
        buffer edges;                   // first own cell of each work-item that counts
        buffer starts;                  // first of each cell
        buffer bounds;                  // [n][2], by id or in cell order; simd: by columns
        buffer boxes;                   // [n][3], in cell order; simd: rows of numbers
        cl_uint place_capacity;         // objects that have a place in both
        host_block sent;                // on its way to the other part
    };

    struct { // the pairs
        buffer candidates, pairs, undecided;
        buffer gathered; // objects of the undecided pairs
        buffer pair_counts, left;
        host_block fetched;   // on the host, if the device has memory of its own
        uint64_t pairs_early; // pairs that are read before their number is known
        host_block early;     // data that are read with them
    };
} part;

// Arguments of the launches of a part, by name, and those of the kernel that
// gathers undecided objects.
extern const binding part_bindings[], part_gather_bindings[];

bool part_open(part *p, const duet_device_pair *pair, int side, duet_error *err);
void part_close(part *p);

// Generates and builds what the variant needs for the task, unless that is what the part has.
bool part_prepare(part *p, const variant *asked, duet_error *err);

// A kind of grid, as kernels tell them apart.
typedef struct part_grid_kind {
    grid_kind kind;
    bool roomy; // dense, of one size, with space around each cell; else of any number of sizes
    bool cut;   // into slabs
} part_grid_kind;

// Builds what the variant needs for the task with each of these kinds, so that steps find it built.
bool part_prepare_grids(part *p, const variant *asked, const part_grid_kind kinds[], uint32_t n,
                        duet_error *err);

// Whether the part was prepared for that variant, and since then not told to forget its kernels.
bool part_has_kernels(const part *p, const variant *asked);
void part_forget_kernels(part *p);

// Builds the kernel that classifies prefetched objects (prefetch.c), too.
bool part_prepare_interior(part *p, duet_error *err);

// The kernel of that name that the part has prepared; NULL if it runs another.
const kernel *part_kernel(const part *p, const char *name);

// Invalidates what lies on the device, after a step that failed: waits for what is under way. It
// may not have arrived, so the next step sends all of it again.
void part_invalidate(part *p);

// Forgets what was made from the grid: it is another.
void part_forget_grid(part *p);

// Begins a step of these objects, `step` steps after one whose times were asked for: forgets what
// the last one found and counted, and what was prefetched of others. A step whose objects are
// prefetched has begun.
void part_begin(part *p, const host_array *objects, uint64_t step);

// Enters the next state.
void part_enter(part *p, part_state to);

// Takes the work of a step, or of the next try.
void part_take(part *p, const part_task *task);

// Runs a part from where it is to DONE, CROWDED or FAILED, in any thread.
void part_run(void *part);

// Figure 11 of the paper: one builds the grid and sends it, so that both can search.
bool part_share_grid(part *from, part *to, duet_error *err);

// How many objects travel together, if n do.
uint32_t part_chunk_size(const part *p, uint32_t n);

// Makes the views of the objects, their sizes, the grid's levels and the ids equal to what the task
// wants.
bool part_update_views(part *p, duet_error *err);

// Builds the task's range of the grid from the objects.
bool part_build_grid(part *p, duet_error *err);

// Gives the grid that `from` built to `to` (the paper, section 4.1): the sender brings it to the
// host, the receiver takes it and makes what it lacks.
bool part_send_grid(part *from, part *to, duet_error *err);
bool part_receive_grid(part *to, part *from, duet_error *err);

// Finds the pairs of the range's objects, of the grid that was built or received last, with those
// that come after them in cell order, and brings them to the host. After CROWDED there is more
// space, and the grid must be built again.
bool part_search(part *p, duet_error *err);

// Brings the pairs that stayed on the device, so that the part's span has all of the last step.
bool part_read_counted(part *p, duet_error *err);

uint64_t part_bytes(const part *p); // memory held on the device

#endif
