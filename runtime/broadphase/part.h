// SPDX-License-Identifier: MIT
// One device's part of a step: its kernels, its memory, its grid, its search.
//
// A part is driven by one thread at a time. Sorting and searching follow its
// variant; where the objects are cut between the parts is decided outside.
#ifndef RUNTIME_PART_H
#define RUNTIME_PART_H

#include "kernels/counters.h"
#include "kernels/grid/skim.h"
#include "runtime/broadphase/global_ids.h"
#include "runtime/broadphase/grid.h"
#include "runtime/broadphase/variant.h"
#include "runtime/opencl/radix_sort.h"

// Objects of the input that lie side by side, [from, to).
typedef struct stretch {
    uint32_t from, to;
} stretch;

enum { STRETCHES = 18 };

typedef struct stretches {
    stretch list[STRETCHES]; // ascending
    uint32_t n;
    uint32_t own; // the one that is the part's own, in any order of the objects
} stretches;

// Objects that are taken together: whole work-items of every kernel that takes them.
enum { STRAY_BLOCK = 1024 };

// What a part takes of the input where that is not all of it (strays.h).
typedef struct part_intake {
    stretches sent;
    stretches taken;                 // the same, those side by side as one
    uint64_t strays_version;         // changes with those that are not the part's own
    uint32_t marked_from, marked_to; // keys that the other part wants: its blocks are marked
} part_intake;

// What both parts are told about the objects.
typedef struct part_task {
    bool shared;   // the grid is for both parts
    bool receives; // the grid comes from the other part
    bool slab;     // the part's grid has some of the cells, and space for about their objects
    bool divided;  // so does the other part: many objects are in none of this one's
    bool packed;   // the part is sent the objects of its slab, with their ids
    bool ordered;  // the objects are in about the order of their cells
    bool rotated;
    const part_intake *intake; // NULL: all of the input
    duet_level level;          // of accuracy, for poses
    grid_objects objects;      // that the part is sent; the array has all of them
    const buffer *resident;    // the objects where the part's device has them already, or NULL
    bool keeps_pairs;          // they stay on the device
    bool skims;                // objects that are sent ahead may be skimmed
    const global_ids *ids;    // pairs of objects that have one stay there, and are counted; or NULL
    uint64_t objects_version; // changes with the objects' content
    uint64_t sizes_version;   // changes with the sizes
    grid grid;
    uint64_t grid_version; // changes with the grid
    bool cells_vary;       // the grid had other cells before
    uint64_t max_pairs;
} part_task;

// Which of the objects a part deals with. Its grid has the keys from key_from
// to key_to; of those it searches around the ones up to home_to, and of the
// sorted objects first .. last - 1. A whole grid has all keys; a slab the home
// keys and as many more as a neighbour can be ahead.
typedef struct part_range {
    uint32_t key_from, home_to, key_to;
    uint32_t first, last;
    uint32_t homes;                           // of a slab, when they were last counted
    uint32_t expected;                        // about how many objects its grid gets
    uint32_t expected_homes, expected_ghosts; // of a slab, likewise
} part_range;

// Objects that travel together: those from the chunk before it up to `to`.
typedef struct part_chunk {
    uint32_t to;
    cl_event sent;    // the timeline's, as all here
    cl_event skimmed; // its blocks are on the host
} part_chunk;

enum { PART_CHUNKS = 8 };

typedef struct part_kernels {
    kernel *clear;
    kernel *hash;
    kernel *own_cells; // NULL where all counting is atomic, and with it
    kernel *count_others;
    kernel *scatter;
    kernel *starts;
    kernel *place; // bounds by id (paper), or everything into cell order (gpu, simd)
    kernel *candidates;
    kernel *narrow; // NULL where the candidates' kernel finds pairs
    kernel *gather; // NULL where the host sees objects that are to be decided
    kernel *change_ids;
    kernel *count_pairs; // NULL where pairs come to the host
    kernel *skim;        // NULL where it cannot be
    bool fused;          // candidates are tested where they are found
    bool listed;         // what overlaps is a pair, without a test
    bool unboxed;        // boxes are read by id, where the objects are
    bool from_ids;       // objects reach cell order by their sorted ids
    bool summed;         // objects are counted by the scan's blocks, too
    bool guarded;        // the search finds nothing where the grid got more than it has space for
} part_kernels;

// What the scene and the stage decide of the kernels. A choice that is open may be set
// otherwise by the variant.
typedef struct part_choice {
    const char *name;
    int64_t value;
    bool open;
} part_choice;

enum { PART_CHOICES = 27, PART_OFFERS = PART_CHOICES + VARIANT_SETTINGS + 1 };

// What kernels are told besides the part's buffers, by the names that their cards use.
typedef struct part_args {
    cl_uint n, n_levels, n_cells;
    cl_uint n_hashed;
    cl_uint key_from, key_home_to, key_to, key_end;
    cl_uint n_home_cells, n_own_cells;
    cl_uint n_counters, n_counts;
    cl_uint first, last;
    cl_uint found_capacity, candidate_capacity, pair_capacity, undecided_capacity;
    cl_uint row_words, n_ids; // gathered
    cl_uint n_homes, n_id_changes, left_capacity;
    cl_uint marked_from, marked_to;
    cl_uint skim_from;
    cl_float4 inside_lower, inside_upper;
    cl_int4 cells;
    buffer objects;
    buffer found; // pairs, or candidates where they are tested later
} part_args;

// What the counters say (kernels/counters.h).
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

// Of the pairs that stay on the device.
typedef struct part_counted {
    uint64_t n;
    uint64_t hash; // by global ids (kernels/grid/count_pairs.cl)
    uint64_t left; // others, which come to the host
} part_counted;

typedef struct part {
    const device *device;
    const device *devices; // the device pair, for host memory
    gen *gen;
    program_set *programs;
    gen_limits limits; // the device's
    variant variant;
    part_choice choices[PART_CHOICES];
    gen_offer offers[PART_OFFERS]; // the choices, and what the variant sets
    uint32_t n_offers;
    part_kernels kernels;
    part_args args;
    scan scan;
    radix_sort radix;
    timeline times;

    buffer objects;
    uint64_t objects_version; // of what was sent last
    buffer sizes;             // where the objects are transforms
    uint64_t sizes_version;   // of what was sent last
    uint32_t least_chunk;     // objects
    part_chunk chunks[2 * PART_CHUNKS];
    uint32_t n_chunks;      // under way; 0 where the objects are there
    uint64_t ahead_version; // of the objects whose first chunks are sent before the step; 0: none
    buffer skimmed;         // blocks of the objects that were sent ahead
    host_block skim_seen;   // the same on the host
    buffer names;           // of packed objects: their ids
    struct {
        uint64_t objects_version, grid_version; // of what was sent last; 0: nothing
        uint32_t key_from, key_to;
        uint32_t n, n_homes;
    } packed;
    struct {
        uint64_t objects_version; // of what was sent last; 0: nothing
        uint64_t strays_version;  // of the stretches that are not the part's own
        stretch own;
    } stretched;
    buffer marks;                 // [n / STRAY_BLOCK] blocks that the other part wants
    host_block marks_seen;        // where the device has memory of its own
    cl_uint stamp;                // of the last step's marks
    buffer levels;                // the grid's
    uint64_t levels_version;      // of what was sent last
    buffer keys, ids;             // of the objects; in cell order once sorted
    buffer keys_spare, ids_spare; // the other half of the radix sort; keys_spare also the ranks
    buffer counts;                // objects a cell, until the scan makes starts of them
    uint32_t zero_counts;         // of them that are zero between steps
    buffer edges;                 // first own cell of each work-item that counts
    buffer starts;                // first of each cell
    buffer bounds;                // [n][2], by id or in cell order; simd: by columns
    buffer boxes;                 // [n][3], in cell order; simd: rows of numbers
    cl_uint place_capacity;       // objects that have a place in both
    buffer candidates, pairs, undecided;
    buffer gathered; // objects of the undecided pairs
    buffer counters;
    buffer next_counters;  // the next step's
    bool next_are_cleared; // they are zero
    buffer global_ids;
    bool ids_ahead;       // their list was sent ahead, and not which have none
    uint64_t ids_version; // of what was sent last; 0: nothing
    buffer id_changes;
    host_block changes; // on their way there
    buffer pair_counts, left;
    part_counted counted;

    part_found found;     // by what was read last of the counters
    host_block fetched;   // pairs on the host, where the device has memory of its own
    uint64_t pairs_ahead; // of them, sent before their number was known
    host_block news;      // what is sent ahead besides them
    host_block sent;      // grid on its way to the other part
    duet_span span;
    uint64_t n_candidates, n_undecided;
    uint32_t runs;  // searches, more than one where a buffer had to grow
    uint64_t bytes; // held on the device once the last job was over
    double wall_ms;
} part;

bool part_open(part *p, const duet_device_pair *pair, int side, duet_error *err);
void part_close(part *p);

// Generates and builds what the variant needs for such objects.
bool part_prepare(part *p, const variant *asked, const part_task *task, duet_error *err);

// Whether kernels that were made for such a world are also those of this step.
bool part_is_prepared(const part *p, const part_task *task);

// The kernel of that name that the part has prepared; NULL where it runs another.
const kernel *part_kernel(const part *p, const char *name);

// After a step that failed: waits for what is under way. What was sent may not have
// arrived, so the next step sends all of it again.
void part_distrust(part *p);

// Begins to send the task's objects before a step that has these and perhaps more; there is
// space for `bytes` of them all. Only for a device with memory of its own. step: as part_begin has
// it.
bool part_send_ahead(part *p, const part_task *task, size_t bytes, uint64_t step, duet_error *err);

// Skims the objects that were sent ahead, chunk after chunk as they come: which lie deep inside of
// the box (kernels/grid/skim.h). False where the device does not; nothing is lost then.
bool part_skim(part *p, const float inside_lower[3], const float inside_upper[3], duet_error *err);
// Waits for the blocks of objects from `from` on, which begins a chunk: up to which they are there.
// The blocks are those of all objects. What failed on the device fails in the step.
uint32_t part_await_skim(part *p, uint32_t from, const skim_block **blocks);

// Begins a step, so many after one whose stages were asked for: forgets what the last one found,
// counted and took, and what was sent ahead of one.
void part_begin(part *p, uint64_t step);

// Then sends the objects, unless they are packed or there, and what belongs to them:
// sizes, the grid's levels, ids.
bool part_send_objects(part *p, const part_task *task, duet_error *err);

// Builds the grid of the range from the objects.
bool part_build_grid(part *p, const part_task *task, const part_range *range, duet_error *err);

// Gives the grid that `from` built to `to` (the paper, section 4.1): the sender
// brings it to the host, the receiver takes it and makes what it lacks.
bool part_send_grid(part *from, part *to, const part_task *task, duet_error *err);
bool part_receive_grid(part *to, part *from, const part_task *task, const part_range *range,
                       duet_error *err);

// Finds the pairs of the range's objects, of the grid that was built or received last, with those
// that come after them in cell order, and brings them to the host. *placed is false where the grid
// had more objects than there was space for; there is more space afterwards, and the grid must be
// built again.
bool part_search(part *p, const part_task *task, const part_range *range, bool *placed,
                 duet_error *err);

// What was counted on the device joins the part's span, which then has all pairs of the last step.
bool part_bring_counted(part *p, duet_error *err);

uint64_t part_bytes(const part *p); // memory held on the device

#endif
