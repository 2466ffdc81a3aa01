// SPDX-License-Identifier: MIT
// Worlds: objects on a device pair that do not move by themselves, the plan of a step, its result,
// and the profile that brings the best plan known.
#ifndef DUET_WORLD_H
#define DUET_WORLD_H

#include "duet_device.h"
#include "duet_scene.h"

#include <stdbool.h>
#include <stdint.h>

DUET_C_BEGIN

// ---------------------------------------------------------------- plans

#define DUET_SHARE_ONE 65536u
#define DUET_SHARE_DEFAULT UINT32_MAX // the share of duet_default_plan for the device pair

typedef enum duet_mode {
    DUET_MODE_SHARED, // B builds the grid and A receives it (the paper, section 4.1)
    DUET_MODE_OWN,    // each device builds the whole grid from its own poses
    DUET_MODE_SLAB,   // each device builds only its slab of the grid and the ghost rows ahead
    DUET_MODE_DEFAULT // slab between parts of one CPU, or two equal devices, if objects have about
                      // one size; otherwise own
} duet_mode;

DUET_API const char *duet_mode_name(duet_mode mode); // "shared"; NULL outside

#define DUET_VARIANT 192 // bytes of a variant's text, with its end

// How a step is done: what a tuner chooses and a profile stores.
typedef struct duet_plan {
    uint32_t share; // A's part of the objects, out of DUET_SHARE_ONE (r in the paper), or
                    // DUET_SHARE_DEFAULT
    duet_mode mode;
    char variant_a[DUET_VARIANT]; // "auto", "simd", "gpu" or "paper", or with settings: "auto
                                  // sort=radix"; "": the device's default
    char variant_b[DUET_VARIANT]; // likewise
} duet_plan;

// Returns the plan of a device pair without measurements: "simd" on a CPU and "auto" elsewhere; a
// share by units between parts of one CPU, or two equal devices, else 0. NULL: a plan that leaves
// these to the world that it is given to, as the default defs have it.
DUET_API duet_plan duet_default_plan(const duet_device_pair *pair);

// ---------------------------------------------------------------- worlds

// Objects on a device pair, stepped again and again.
typedef struct duet_world duet_world;

// The part of each pose that a step gets. The sizes of transforms are set by themselves, and
// seldom.
typedef enum duet_pose_form {
    DUET_POSE_WHOLE,     // duet_pose, 40 bytes
    DUET_POSE_TRANSFORM, // duet_transform, 28 bytes
    DUET_POSE_COMPACT    // duet_compact_transform, 20 bytes
} duet_pose_form;

typedef struct duet_world_def {
    duet_device_pair *pair; // held until the world is destroyed
    duet_plan plan;
    uint32_t dims; // 2 or 3
    duet_shape shape;
    duet_level level; // accuracy for poses; bounds are exact
    // With has_accuracy a profile may bring any level that was measured to be
    // within accuracy; until then level holds. Without, level always holds.
    bool has_accuracy;
    duet_accuracy accuracy;
    bool rotated;    // false promises identity rotations: fewer axes are tested
    float cell;      // cell edge; 0: the largest extent found
    bool cell_fixed; // fails with CELL_TOO_SMALL instead of widening
    bool has_world;  // lower and upper are given; objects outside are still found
    float lower[3];
    float upper[3];
    float origin_edge; // above 0: large poses, in origin cells of that edge, a power of two
    duet_pose_form pose_form;
    bool ordered;       // promises that objects are kept in about duet_world_order's order
    bool keep_bad;      // leaves bad objects out and counts them, instead of BAD_OBJECT
    uint64_t max_pairs; // fails with TOO_MANY above it; 0: as memory allows
    // Times every step by stages. Without, a device with memory of its own times one step in
    // 16, because its driver takes up to half as long as a small step for that.
    bool stage_times;
    int cookie;
} duet_world_def;

DUET_API duet_world_def duet_default_world_def(void);
// Makes a def with the scene's dims, shape, cell, world, level and accuracy; the default def
// for NULL.
DUET_API duet_world_def duet_scene_world_def(const duet_scene *scene, duet_device_pair *pair);

DUET_API duet_world *duet_world_create(const duet_world_def *def, duet_error *err);
DUET_API void duet_world_destroy(duet_world *world);

// Copies n objects of the world's kind: BOUNDS for the shape bounds, otherwise POSES, or
// LARGE_POSES with an origin_edge. A world of transforms takes POSES too, and splits them; compact
// ones are rounded (duet_compact_transform_set).
DUET_API bool duet_world_set_objects(duet_world *world, duet_object_kind kind, const void *objects,
                                     uint32_t n, duet_error *err);
DUET_API bool duet_world_set_scene(duet_world *world, const duet_scene *scene, duet_error *err);

// Maps space for n objects, in memory that the devices read without a further copy; it keeps its
// contents as long as n is the same. Valid until the next map, set or destroy: map, write,
// then step. Objects that were neither set nor mapped since the last step are not sent again.
//
// Offsets of LARGE_POSES must be multiples of 2^-24 of an edge, from 0 up to below it, as
// duet_large_pose_set makes them: others are bad objects.
//
// A world whose pose_form is not WHOLE sends TRANSFORMS or COMPACT_TRANSFORMS in each step, and
// SIZES only after they were mapped again. There must be as many sizes as transforms when the world
// is stepped.
DUET_API void *duet_world_map_objects(duet_world *world, duet_object_kind kind, uint32_t n,
                                      duet_error *err);

DUET_API bool duet_world_set_plan(duet_world *world, const duet_plan *plan, duet_error *err);
DUET_API const duet_plan *duet_world_get_plan(const duet_world *world);

// Sets the level of the following steps, whatever profile is loaded later.
DUET_API bool duet_world_set_level(duet_world *world, duet_level level, duet_error *err);
DUET_API duet_level duet_world_get_level(const duet_world *world); // certified for NULL

// Finds the order of the objects by cell: (*order)[i] is the id of the i-th object in the world's
// grid, row after row of cells, and within a cell by id. *n is the number of the world's objects.
// The caller frees *order with duet_free, and may move its objects into this order now and then:
// objects that are near each other in the world are then near each other in memory. A world of
// transforms needs its sizes for it. It uses the host's idle processors, and 16 bytes of memory
// an object besides *order.
DUET_API bool duet_world_order(duet_world *world, uint32_t **order, uint32_t *n, duet_error *err);

// ---------------------------------------------------------------- results

// One kernel or transfer of a step on one device.
typedef struct duet_stage {
    const char *name; // "hash", "sort", ... ; static
    int device;       // 0: A, 1: B
    double ms;        // from OpenCL events; a host stage from the clock
    bool transfer;
    double begin_ms; // start of its first command, in host time since its device's part began
    double end_ms;   // end of its last one; between them the device may have done other things
} duet_stage;

typedef struct duet_span {
    const duet_pair *pairs;
    uint64_t n;
} duet_span;

// The findings of a step. Its memory is the world's and lasts until the next step.
typedef struct duet_result {
    uint32_t objects;
    uint32_t bad;       // objects left out (keep_bad)
    uint32_t first_bad; // the least id among them
    uint64_t candidates;
    uint64_t pairs;
    duet_span spans[2];  // A's pairs and B's (the paper, section 4.2)
    uint64_t undecided;  // pairs that float left open and the host decided
    double total_ms;     // wall clock, poses in to pairs on the host
    double device_ms[2]; // wall clock of each device's part
    double kernel_ms[2]; // from the start of its first kernel to the end of its last
    const duet_stage *stages;
    uint32_t n_stages;
    bool timed;           // stages and kernel_ms are of this step; otherwise of the last timed one
    uint64_t bytes[2];    // memory held on each device
    uint32_t cells[3];    // cells of the grid's finest level along each axis
    float cell;           // their least edge
    uint32_t grid_levels; // each with cells of its own size
    bool hashed;          // cells share a table's entries, as in a sparse world
    bool cell_widened;    // the cell edge asked for was below the largest object
    uint32_t runs;        // 1, or more if a buffer had to grow
} duet_result;

// Finds all pairs among the world's objects.
//
// BAD_OBJECT names the first object that is NaN, infinite, negative or without
// rotation; CELL_TOO_SMALL names edge and extent (cell_fixed only); TOO_MANY
// names the count; BUILD_FAILED the kernel. After a failure the world can be
// stepped again.
DUET_API bool duet_world_step(duet_world *world, duet_result *result, duet_error *err);

// A step in two halves: begin returns at once, and a thread of Duet's own carries the step while
// the caller does other things; end waits for it and returns the step's result or failure. Do not
// write to mapped objects in between. Between the two, duet_world_destroy waits,
// duet_world_get_level works, duet_world_get_plan is NULL, and all other calls on the world
// are BAD_ARGUMENT.
DUET_API bool duet_world_step_begin(duet_world *world, duet_error *err);
DUET_API bool duet_world_step_end(duet_world *world, duet_result *result, duet_error *err);

// Returns pair i of both spans, i < result->pairs; 0 and 0, which is no pair, past the end.
DUET_API duet_pair duet_result_get_pair(const duet_result *result, uint64_t i);

// The pair hash: for each pair k = a << 32 | b; k *= 0x9E3779B97F4A7C15;
// k ^= k >> 29; k *= 0xBF58476D1CE4E5B9; k ^= k >> 32; summed modulo 2^64.
DUET_API uint64_t duet_result_get_hash(const duet_result *result);

// ---------------------------------------------------------------- profiles

// How much evidence there is for a plan, best first; docs/store.md says more.
typedef enum duet_grade {
    DUET_GRADE_EXACT,        // measured on these devices, drivers and kernels, for such objects
    DUET_GRADE_OTHER_DRIVER, // the same, under another version of a driver
    DUET_GRADE_INTERPOLATED, // next to, or between, sizes that were measured of a scene like this
    DUET_GRADE_TRANSFERRED,  // the plan of another workload, without its figures
    DUET_GRADE_STALE,        // measured with other kernels: not used
    DUET_GRADE_DEFAULT       // nothing is known
} duet_grade;

DUET_API const char *duet_grade_name(duet_grade grade); // "other driver"; NULL outside

// The knowledge of a store of profiles about a world.
typedef struct duet_profile {
    duet_plan plan; // the world's after the call
    duet_grade grade;
    duet_level level;       // the world's after the call
    duet_accuracy accuracy; // accuracy of that level, as measured with the plan for this workload
    uint64_t true_pairs;    // pairs that accuracy was measured on; 0: it was not
    double step_ms; // by that plan; predicted if INTERPOLATED. From TRANSFERRED on this and what
                    // follows is 0, because nothing is known about this workload
    double gain;    // over the best single device: 0.25 is a quarter faster
    double gain_low;
    double gain_high;
    char verdict[16];   // "faster", "same", "slower", "ambiguous"; empty from TRANSFERRED on
    int64_t measured_s; // since 1970, UTC; 0: predicted
} duet_profile;

// Gives the world the best plan that is known for its objects, which must be
// set. A world with a level gets what was measured at that level and keeps it. A world with
// has_accuracy gets, among the levels measured to be within its accuracy, the plan with the best
// evidence and then the fastest, and its level; if there is none, it keeps its own. So no profile
// ever brings less than was asked for.
//
// path is the store; NULL is the user's (DUET_PROFILE) and under it the system's. Nothing is
// written, and the file need not exist. After a failure (a store that cannot be read) the plan
// comes from the stores that could be read, or is as before: an application may go on.
DUET_API bool duet_world_load_profile(duet_world *world, const char *path, duet_profile *profile,
                                      duet_error *err);

// Explains the choice: a line for each grade that was looked up, from the best down, and what
// came of it. The caller frees *why with duet_free. The world stays as it is.
DUET_API bool duet_world_explain_profile(duet_world *world, const char *path, char **why,
                                         duet_error *err);

DUET_C_END

#endif
