// SPDX-License-Identifier: MIT
// Which rows of an array lie on a device, and how they get there.
//
// A view is the device's memory for an array of the host's. The array has a generation, which
// changes with its content. view_update makes what lies there equal to what is wanted, and sends
// what is missing:
//
//   wanted   there before              sent
//   ALL      nothing                   every row, in chunks if kernels can begin with the first
//   ALL      the first rows            the rows behind them: sending the first rows is prefetching
//   RANGES   other ranges              the wanted rows that are not there
//   LIST     anything else             the listed rows, while threads find them (compaction.h)
//   any      the wanted rows, or more  nothing
//   any      memory of another's       nothing: such a view is right already
//
// Invariants, which view_update asserts:
// 1. Each row of `there` is the array's of that generation. Generation 0 is unknown content.
// 2. ALL and RANGES: row i of the array is row i of the buffer. LIST: the rows lie side by side,
//    and ids[i] is the row of the i-th.
// 3. Chunks lie one behind the other from row 0, and all of `there` is in them. While `there` is a
//    range of the first rows, a step has not taken them yet: they are prefetched.
// 4. A view on host memory wraps the array, so that all rows are there.
#ifndef RUNTIME_VIEW_H
#define RUNTIME_VIEW_H

#include "runtime/broadphase/grid_objects.h"
#include "runtime/opencl/timeline.h"

struct compaction;

// Rows [from, to).
typedef struct row_span {
    uint32_t from, to;
} row_span;

enum { SELECTION_RANGES = 18 };

typedef enum selection_kind { SELECT_ALL, SELECT_RANGES, SELECT_LIST } selection_kind;

// Rows of an array.
typedef struct selection {
    selection_kind kind;
    uint32_t n_ranges;
    row_span ranges[SELECTION_RANGES]; // ALL: one; RANGES: ascending, none touches the next
    uint32_t own;                      // RANGES: the one with the rows that no other device owns
    uint32_t key_from, key_to;         // LIST: the rows whose objects have these keys of the grid
} selection;

selection select_all(uint32_t n);
uint32_t selection_count(const selection *s); // rows of ALL or RANGES

enum { VIEW_CHUNKS = 8 };

// Rows that travel together, from the chunk before up to row `to`.
typedef struct view_chunk {
    uint32_t to;
    cl_event sent; // the timeline's
} view_chunk;

typedef struct device_view {
    uint64_t generation;
    selection there;
    buffer own;                         // the view's memory
    buffer bound;                       // another's memory, read in its place; empty: none
    buffer ids;                         // LIST
    uint32_t n;                         // rows to read: of the array, or of the list
    view_chunk chunks[2 * VIEW_CHUNKS]; // that kernels must wait for
    uint32_t n_chunks;
} device_view;

// Reads memory of another's from now on, which has all rows; NULL: the view's own again.
void view_bind(device_view *v, const buffer *memory);

// Forgets what lies there: after a failure it may not have arrived.
void view_forget(device_view *v);

// Whether the wanted rows of that generation lie there.
bool view_has(const device_view *v, uint64_t generation, const selection *wanted);

// Whether the first rows of its generation are there, or on their way, before a step wants all.
bool view_is_prefetched(const device_view *v);

// Whether view_update would send only what lies behind the prefetched rows.
bool view_continues(const device_view *v, const host_array *from, const selection *wanted);

// Makes the view equal to `wanted`, ALL or RANGES of the array. chunk: rows in each of the pieces
// that travel beside the kernels; 0: kernels wait for all rows.
bool view_update(device_view *v, timeline *t, const host_array *from, const selection *wanted,
                 uint32_t chunk, duet_error *err);

// Makes the view equal to the wanted LIST: sends it while the threads find it, unless the view has
// it. The view has no list afterwards if the slab has more objects than were expected.
bool view_update_list(device_view *v, timeline *t, struct compaction *c, int side,
                      uint64_t generation, const selection *wanted, duet_error *err);

#endif
