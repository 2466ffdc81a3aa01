// SPDX-License-Identifier: MIT
// Duet: collisions among boxes, found by two OpenCL devices together. "The paper" is
// M. Tayyub and G. N. Khan, "Heterogeneous Design and Efficient CPU-GPU Implementation
// of Collision Detection".
//
// Owners are opaque pointers with one _create and one _destroy. Makers return a
// pointer or NULL and doers return bool; both take a duet_error last (NULL
// allowed). A def is filled by its duet_default_..._def() first. Two worlds in
// two threads are independent; one world belongs to one thread at a time.
//
// A pointer that is NULL is BAD_ARGUMENT, unless its call says what NULL means; rows
// may be NULL where there are 0 of them. Calls without a duet_error answer NULL, or a
// place past the end, with NULL, false or 0, unless they say otherwise. Destroying NULL
// does nothing.
//
// Owners can be destroyed in any order: what was made on a device pair holds it open, and
// a share that is kept on line holds its world. Each is destroyed once, by who made it,
// and is not used after that. Memory that a call hands out goes with the owner it names.
//
// Units are the caller's (metres, say); floats are IEEE single; ids are the
// objects' places in the input, from 0. Sets are closed: touching collides.
#ifndef DUET_H
#define DUET_H

#include "duet_error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

DUET_API const char *duet_version(void); // "1.0.0"

// ---------------------------------------------------------------- objects

// An oriented box. The rotation is M(q)/|q|^2, so any quaternion but zero is
// legal. In 2D centre[2], half[2], rotation[0] and rotation[1] are not read.
typedef struct duet_pose {
    float centre[3];
    float half_extents[3]; // half extents, >= 0
    float rotation[4];     // quaternion x y z w
} duet_pose;

// Where a box is, apart from its size: what changes from step to step.
typedef struct duet_transform {
    float centre[3];
    float rotation[4]; // as a pose's
} duet_transform;

typedef struct duet_size {
    float half_extents[3]; // half extents, >= 0
} duet_size;

// An oriented box however far from 0: along each axis its centre is at
// cell * edge + pose.centre, the edge being a power of two that the scene or the
// world states (origin_edge). Offsets are kept to 2^-24 of an edge, so that precision
// is the same everywhere up to 2^30 edges from 0.
typedef struct duet_large_pose {
    duet_pose pose;
    int32_t cell[3];
    int32_t unused;
} duet_large_pose;

// Sets cell and pose.centre to the position nearest to a centre. BAD_ARGUMENT
// for another edge than a power of two, BAD_OBJECT beyond 2^30 edges.
DUET_API bool duet_large_pose_set(duet_large_pose *pose, const double centre[3], float edge,
                                  duet_error *err);

// An axis-aligned box. In 2D lower[2] and upper[2] are not read.
typedef struct duet_bounds {
    float lower[3];
    float upper[3]; // >= lower
} duet_bounds;

// A confirmed collision, a < b.
typedef struct duet_pair {
    uint32_t a;
    uint32_t b;
} duet_pair;

// The sum over pairs that every variant, device and share must agree on: see
// duet_result_get_hash. Independent of the pairs' order.
DUET_API uint64_t duet_pairs_hash(const duet_pair *pairs, uint64_t n);

// ---------------------------------------------------------------- devices

typedef enum duet_device_kind {
    DUET_KIND_CPU,
    DUET_KIND_GPU,
    DUET_KIND_ACCELERATOR
} duet_device_kind;

typedef struct duet_device_info {
    char selector[64]; // "pocl:0", "nvidia:1"; a part of a CPU is "pocl:0[0-1]"
    char platform[128];
    char platform_version[128];
    char name[256];
    char vendor[128];
    char driver[128];
    char cl_version[128];
    duet_device_kind kind;
    uint32_t units; // compute units
    uint32_t clock_mhz;
    uint32_t max_group; // work-items in a work-group
    uint64_t global_bytes;
    uint64_t local_bytes;
    uint64_t max_buffer_bytes;
    bool host_memory; // works on host memory without copies
    bool fp64;        // has double
    bool can_cut;     // its units can be cut into parts with [first-last]
} duet_device_info;

typedef struct duet_device_list duet_device_list;

// All root devices of all platforms. A list may be empty; NULL only where
// memory runs out.
DUET_API duet_device_list *duet_device_list_create(duet_error *err);
DUET_API void duet_device_list_destroy(duet_device_list *list);
DUET_API uint32_t duet_device_list_get_count(const duet_device_list *list);
DUET_API const duet_device_info *duet_device_list_get_info(const duet_device_list *list,
                                                           uint32_t i);

// What a driver does that Duet works round, a line each, from 0; NULL past the last.
DUET_API const char *duet_device_info_get_quirk(const duet_device_info *info, uint32_t i);

// An ordered device pair. A takes the share, B the rest. Where both are one device B does
// all of the work, unless a share is asked for.
typedef struct duet_device_pair duet_device_pair;

// Told before a kernel is compiled, which can take seconds: it is the k-th of n, from 1,
// that the device needs and that neither the cache nor the pair has. After the last it is
// told once more, with kernel NULL. One call comes after the other, from any thread.
typedef void duet_compile_callback(void *context, const duet_device_info *device,
                                   const char *kernel, uint32_t k, uint32_t n);

typedef struct duet_device_pair_def {
    const char *a;          // selector of A, and
    const char *b;          // of B; see below
    const char *kernel_dir; // reads kernels from this folder instead of the carried ones
    const char *cache_dir;  // keeps built programs here. NULL: in $XDG_CACHE_HOME/duet or
                            // ~/.cache/duet, but those of PoCL, which keeps its own; "": nowhere
    duet_compile_callback *on_compile; // NULL: nobody is told
    void *context;                     // handed to it
    int cookie;
} duet_device_pair_def;

// A selector is "pocl:0"; "cpu" or "gpu", the strongest of each; or a part of a CPU, as its
// units "pocl:0[0-3]" or as the k-th of n equal parts "cpu[1/2]". With b NULL, a is one
// selector for both, "A,B" for the two, or "halves" for the two halves of the CPU. With
// both NULL: the CPU and the strongest GPU, or where there is no GPU the CPU as both.

// a, kernel_dir and cache_dir from DUET_PAIR, DUET_KERNEL_DIR and DUET_CACHE, "off" for
// nowhere.
DUET_API duet_device_pair_def duet_default_device_pair_def(void);

// NO_DEVICE where there is none, NOT_FOUND for an unknown selector: the line
// lists what is there. Closing may come before the worlds made on the pair are destroyed:
// the devices are let go with the last of them.
DUET_API duet_device_pair *duet_device_pair_create(const duet_device_pair_def *def,
                                                   duet_error *err);
DUET_API void duet_device_pair_destroy(duet_device_pair *pair);
// Whether A and B are the same device, so that B does all of the work by default; false
// for NULL.
DUET_API bool duet_device_pair_is_one(const duet_device_pair *pair);
// False, with a line that says why, where built programs are to be kept and cannot be: all
// works, but they are compiled again each time.
DUET_API bool duet_device_pair_check_cache(const duet_device_pair *pair, duet_error *err);
DUET_API const duet_device_info *duet_device_pair_get_info(const duet_device_pair *pair,
                                                           int device); // 0: A, 1: B, else NULL

// ---------------------------------------------------------------- levels

// Levels of accuracy: what may be taken for a collision, and what may be missed.
// Every level starts from the pairs whose bounds, rounded outward, overlap, and
// finds the same pairs on every device, at every share and in every grid.
typedef enum duet_level {
    DUET_LEVEL_CERTIFIED, // the default: never wrong
    DUET_LEVEL_AABB,      // the bounds alone: misses none
    DUET_LEVEL_SPHERE,    // bounding spheres: misses none
    DUET_LEVEL_SAT6,      // the faces' axes: misses none
    DUET_LEVEL_SAT15,     // 15 axes in float as textbooks have it: wrong both ways, within bounds
    DUET_LEVEL_DOUBLE     // 15 axes in double (the devices must have it): the same, far closer
} duet_level;

#define DUET_LEVELS 6

// What a level promises for boxes of which |t|_1 and all half extents add up to
// S, 2^-70 <= S <= 2^100. A separation is the greatest of the 15 axes (4 in 2D), where
// an axis across two edges has the length of the sine between them. Where
// nothing is rotated all levels but aabb and sphere are exact.
typedef struct duet_level_info {
    const char *name;
    const char *about; // what is tested
    double missed;     // a colliding pair is missed only where its separation is above -missed * S
    double added;      // a separated one is reported only where it is at most added * S
} duet_level_info;

DUET_API const duet_level_info *duet_level_get_info(duet_level level); // NULL outside

// False where no level is called that.
DUET_API bool duet_level_from_name(const char *name, duet_level *level);

// Whether a level promises all that another does: certified does so for all,
// aabb, sphere and sat6 for each other (none is missed), double for sat15. False for
// what is no level.
DUET_API bool duet_level_covers(duet_level level, duet_level other);

// How much may be wrong, by the number of pairs that collide: 0.02 is two in a
// hundred. Levels are measured for it on a workload; certified is within any.
typedef struct duet_accuracy {
    double missed;     // of those pairs, not found; 0 to 1
    double false_rate; // found besides those pairs; >= 0
} duet_accuracy;

// ---------------------------------------------------------------- scenes

// What an array of objects holds.
typedef enum duet_object_kind {
    DUET_OBJECT_POSES,       // duet_pose
    DUET_OBJECT_BOUNDS,      // duet_bounds
    DUET_OBJECT_LARGE_POSES, // duet_large_pose
    DUET_OBJECT_TRANSFORMS,  // duet_transform, with
    DUET_OBJECT_SIZES        // duet_size
} duet_object_kind;

typedef enum duet_shape {
    DUET_SHAPE_POSES, // oriented boxes
    DUET_SHAPE_BOUNDS // axis-aligned boxes, given by their corners
} duet_shape;

// Objects with the world they live in, as read from a file.
typedef struct duet_scene duet_scene;

typedef struct duet_scene_info {
    const char *name; // of the file or the scene's own; the scene's
    uint32_t dims;    // 2 or 3
    duet_shape shape;
    uint32_t n;
    bool rotated;    // some object has a rotation other than the identity
    float cell;      // cell edge asked for; 0: chosen from the objects
    bool cell_fixed; // refuse rather than widen a cell that is too small
    bool has_world;  // lower and upper are given
    float lower[3];
    float upper[3];
    duet_level level;  // that the scene wants; certified where it says nothing
    bool has_accuracy; // it leaves the level to a profile within accuracy
    duet_accuracy accuracy;
    float origin_edge; // above 0: objects are large poses, in origin cells of that edge
} duet_scene_info;

// A scene's parameter set from outside, for Lua scenes: "n" = "1000".
typedef struct duet_setting {
    const char *name;
    const char *value; // a number, true, false, or else a string
} duet_setting;

// Reads .lua, .npy, or numbers as text (.csv, .txt, any other ending), and "-", stdin; the
// number of columns says what a row is (docs/formats.md). A word without '/' and '.' is
// first the name of a scene that comes with Duet, as "paper". Values that are not
// finite, negative extents and zero quaternions are refused with their place.
DUET_API duet_scene *duet_scene_load(const char *path, const duet_setting *settings,
                                     uint32_t n_settings, duet_error *err);
// Reads pairs for duet_pair_query_run, .npy or text: two poses a row, 20 numbers or in
// 2D 10. Objects 2 i and 2 i + 1 are row i's.
DUET_API duet_scene *duet_scene_load_pairs(const char *path, duet_error *err);
// Copies n objects: POSES, BOUNDS or LARGE_POSES. dims is 2 or 3. origin_edge is that
// of the origin cells of LARGE_POSES, a power of two, else 0.
DUET_API duet_scene *duet_scene_create(duet_object_kind kind, const void *objects, uint32_t n,
                                       uint32_t dims, float origin_edge, duet_error *err);
DUET_API void duet_scene_destroy(duet_scene *scene);
DUET_API const duet_scene_info *duet_scene_get_info(const duet_scene *scene);
// [n] of the kind, which the scene owns; NULL where it has none of it. LARGE_POSES are
// there as POSES too, rounded.
DUET_API const void *duet_scene_get_objects(const duet_scene *scene, duet_object_kind kind);

// ---------------------------------------------------------------- plans

#define DUET_SHARE_ONE 65536u
#define DUET_SHARE_DEFAULT UINT32_MAX // that of duet_default_plan for the device pair

typedef enum duet_mode {
    DUET_MODE_SHARED, // B builds the grid and A receives it (the paper, section 4.1)
    DUET_MODE_OWN,    // each device builds the whole grid from its own poses
    DUET_MODE_SLAB,   // each device builds only its slab of the grid and the ghost rows ahead
    DUET_MODE_DEFAULT // slab between parts of one CPU, or two equal devices, where objects are of
                      // about one size; own elsewhere
} duet_mode;

DUET_API const char *duet_mode_name(duet_mode mode); // "shared"; NULL outside

#define DUET_VARIANT 192 // bytes of a variant's text, its end counted

// How a step is to be done: what a tuner chooses and a profile stores.
typedef struct duet_plan {
    uint32_t share; // A's part of the objects, out of DUET_SHARE_ONE (r in the paper), or
                    // DUET_SHARE_DEFAULT
    duet_mode mode;
    char variant_a[DUET_VARIANT]; // "auto", "simd", "gpu" or "paper", or with settings: "auto
                                  // sort=radix";
    char variant_b[DUET_VARIANT]; // "" is the default one for the device
} duet_plan;

// What is done on this device pair where nothing was measured: "simd" on a CPU and "auto"
// elsewhere, a share by units between parts of one CPU, or two equal devices, else 0. For
// NULL a plan that leaves these to the world it is given to, as the default defs have it.
DUET_API duet_plan duet_default_plan(const duet_device_pair *pair);

// ---------------------------------------------------------------- worlds

// Objects on a device pair, stepped again and again.
typedef struct duet_world duet_world;

typedef struct duet_world_def {
    duet_device_pair *pair; // held until the world is destroyed
    duet_plan plan;
    uint32_t dims; // 2 or 3
    duet_shape shape;
    duet_level level; // of accuracy, for poses; bounds are exact
    // With has_accuracy a profile may bring any level that was measured to be
    // within accuracy; until then level holds. Without, level always holds.
    bool has_accuracy;
    duet_accuracy accuracy;
    bool rotated;    // false promises identity rotations: fewer axes are tested
    float cell;      // cell edge; 0: the largest extent found
    bool cell_fixed; // CELL_TOO_SMALL instead of widening
    bool has_world;  // lower and upper are given; objects outside are still found
    float lower[3];
    float upper[3];
    float origin_edge;   // above 0: large poses, in origin cells of that edge, a power of two
    bool separate_sizes; // objects are transforms, and their sizes are set by themselves
    bool keep_bad;       // leave bad objects out and count them, instead of BAD_OBJECT
    uint64_t max_pairs;  // TOO_MANY above it; 0: as memory allows
    int cookie;
} duet_world_def;

DUET_API duet_world_def duet_default_world_def(void);
// A def with the scene's dims, shape, cell, world, level and accuracy; the default one
// for NULL.
DUET_API duet_world_def duet_scene_world_def(const duet_scene *scene, duet_device_pair *pair);

DUET_API duet_world *duet_world_create(const duet_world_def *def, duet_error *err);
DUET_API void duet_world_destroy(duet_world *world);

// Copies n objects of the kind that the world was made for: BOUNDS for the shape
// bounds, else POSES, or LARGE_POSES where it has an origin_edge. POSES may also be set
// in a world with separate_sizes, which takes them apart.
DUET_API bool duet_world_set_objects(duet_world *world, duet_object_kind kind, const void *objects,
                                     uint32_t n, duet_error *err);
DUET_API bool duet_world_set_scene(duet_world *world, const duet_scene *scene, duet_error *err);

// Space for n objects in memory that the devices read without a copy of ours; for the
// same n it keeps what it held. Valid until the next map, set or destroy: map, write,
// then step. Objects that were neither set nor mapped since the last step are not sent
// again.
//
// Offsets of LARGE_POSES must be multiples of 2^-24 of an edge, from 0 up to below it, as
// duet_large_pose_set makes them: others are bad objects.
//
// In a world with separate_sizes TRANSFORMS are what a step sends, 28 bytes an object
// instead of 40, and SIZES are sent again only once they were mapped again. There must
// be as many of both when the world is stepped.
DUET_API void *duet_world_map_objects(duet_world *world, duet_object_kind kind, uint32_t n,
                                      duet_error *err);

DUET_API bool duet_world_set_plan(duet_world *world, const duet_plan *plan, duet_error *err);
DUET_API const duet_plan *duet_world_get_plan(const duet_world *world);

// From the next step on, and whatever profile is loaded later.
DUET_API bool duet_world_set_level(duet_world *world, duet_level level, duet_error *err);
DUET_API duet_level duet_world_get_level(const duet_world *world); // certified for NULL

// ---------------------------------------------------------------- profiles

// How good the grounds of a plan are, best first; docs/store.md says more.
typedef enum duet_grade {
    DUET_GRADE_EXACT,        // measured on these devices, drivers and kernels, for such objects
    DUET_GRADE_OTHER_DRIVER, // the same, under another version of a driver
    DUET_GRADE_INTERPOLATED, // between sizes that were measured on this pair
    DUET_GRADE_TRANSFERRED,  // from what each of the devices took elsewhere
    DUET_GRADE_STALE,        // measured with other kernels: not used
    DUET_GRADE_DEFAULT       // nothing is known
} duet_grade;

DUET_API const char *duet_grade_name(duet_grade grade); // "other driver"; NULL outside

// What a store of profiles knows of a world.
typedef struct duet_profile {
    duet_plan plan; // the world's after the call
    duet_grade grade;
    duet_level level;       // and its level
    duet_accuracy accuracy; // of that level, as measured with the plan
    uint64_t true_pairs;    // that it was measured on; 0: it was not
    double step_ms; // by that plan; predicted, unless measured. 0 from STALE on, as what follows
    double gain;    // over the best single device: 0.25 is a quarter faster
    double gain_low;
    double gain_high;
    char verdict[16];   // "faster", "same", "slower", "ambiguous"; empty from STALE on
    int64_t measured_s; // since 1970, UTC; 0: predicted
} duet_profile;

// Gives the world the best plan that is known for its objects, which must be
// set. A world with a level gets what was measured at that level and keeps it.
// One with has_accuracy gets, of the levels that were measured to be within its
// accuracy, the best founded and then the fastest, and that level with it; where
// there is none it keeps its own. So no profile ever brings less than was asked
// for. path is the store; NULL is the user's (DUET_PROFILE) and under it the
// system's. Nothing is written, and no file need be there. On failure (a store
// that cannot be read) the plan is still that of whatever could be, or as it
// was: an application may go on.
DUET_API bool duet_world_load_profile(duet_world *world, const char *path, duet_profile *profile,
                                      duet_error *err);

// Why: a line for each ground that was looked for, from the best down, and what
// came of it. The caller frees *why with duet_free. The world stays as it is.
DUET_API bool duet_world_explain_profile(duet_world *world, const char *path, char **why,
                                         duet_error *err);

// ---------------------------------------------------------------- results

// Where a step's time went: one kernel or transfer on one device.
typedef struct duet_stage {
    const char *name; // "hash", "sort", ... ; static
    int device;       // 0: A, 1: B
    double ms;        // from OpenCL events; a host stage from the clock
    bool transfer;
} duet_stage;

typedef struct duet_span {
    const duet_pair *pairs;
    uint64_t n;
} duet_span;

// What a step found. Its memory is the world's and lasts until the next step.
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
    double kernel_ms[2]; // from the begin of its first kernel to the end of its last
    const duet_stage *stages;
    uint32_t n_stages;
    uint64_t bytes[2]; // memory held on each device
    uint32_t cells[3]; // of the grid's finest level
    float cell;        // their least edge
    uint32_t levels;   // sizes of cells
    bool hashed;       // cells share a table's entries, as in a sparse world
    bool cell_widened; // the edge asked for was below the largest object
    uint32_t runs;     // 1, or more where a buffer had to grow
} duet_result;

// Finds all pairs among the world's objects.
//
// BAD_OBJECT names the first object that is NaN, infinite, negative or without
// rotation; CELL_TOO_SMALL names edge and extent (cell_fixed only); TOO_MANY
// names the count; BUILD_FAILED the kernel. After a failure the world can be
// stepped again.
DUET_API bool duet_world_step(duet_world *world, duet_result *result, duet_error *err);

// Pair i of both spans, i < result->pairs; 0 and 0, which is no pair, past the end.
DUET_API duet_pair duet_result_get_pair(const duet_result *result, uint64_t i);

// The pair hash: for each pair k = a << 32 | b; k *= 0x9E3779B97F4A7C15;
// k ^= k >> 29; k *= 0xBF58476D1CE4E5B9; k ^= k >> 32; summed modulo 2^64.
DUET_API uint64_t duet_result_get_hash(const duet_result *result);

// ---------------------------------------------------------------- narrow phase alone

// Tests pairs that the caller brings as a step tests its candidates, on a
// device pair, again and again.
typedef struct duet_pair_query duet_pair_query;

typedef struct duet_pair_query_def {
    duet_device_pair *pair; // held until the close
    uint32_t share;         // A's part of the pairs, out of DUET_SHARE_ONE; 0: B alone
    duet_level level;       // of accuracy
    uint32_t dims;          // 2 or 3
    int cookie;
} duet_pair_query_def;

DUET_API duet_pair_query_def duet_default_pair_query_def(void);

typedef struct duet_pair_query_result {
    uint64_t colliding;
    uint64_t undecided;  // that float left open and the host decided
    double total_ms;     // wall clock
    double device_ms[2]; // of each device's part
} duet_pair_query_result;

// Builds the kernels that it needs.
DUET_API duet_pair_query *duet_pair_query_create(const duet_pair_query_def *def, duet_error *err);
DUET_API void duet_pair_query_destroy(duet_pair_query *test);

// Tests n pairs; pair i is poses[2 i] and poses[2 i + 1].
//
//   verdicts [n] 0 separated, 1 colliding; the same for (a, b) and (b, a)
//   separations     [n] duet_poses_separation of each, on the host; NULL: not wanted
//
// A verdict depends on its two poses alone, as if both were rotated. BAD_OBJECT
// names the first pair with a pose that is NaN, infinite, negative or without
// rotation; verdicts and separations are then not to be used.
DUET_API bool duet_pair_query_run(duet_pair_query *test, const duet_pose *poses, uint64_t n,
                                  uint8_t *verdicts, double *separations,
                                  duet_pair_query_result *result, duet_error *err);

// ---------------------------------------------------------------- motion

// What a scene can call for. A motion runs those that its objects and its def
// call for and nothing else: docs/effects.md says by what each is called for.
typedef enum duet_effect {
    DUET_EFFECT_ROTATION = 1u << 0,         // orientation matters
    DUET_EFFECT_MOTION = 1u << 1,           // objects have velocities
    DUET_EFFECT_ANGULAR_VELOCITY = 1u << 2, // and turn
    DUET_EFFECT_GRAVITY = 1u << 3,          // uniform, or towards a point
    DUET_EFFECT_DRAG = 1u << 4,             // velocities decay
    DUET_EFFECT_BOUNDARY = 1u << 5,         // walls, or a world that repeats itself
    DUET_EFFECT_CONTACT = 1u << 6,          // where objects touch
    DUET_EFFECT_CONTACT_RESPONSE = 1u << 7, // contacts push, and bounce
    DUET_EFFECT_FRICTION = 1u << 8,         // contacts have friction
    DUET_EFFECT_CONTINUOUS = 1u << 9,       // fast bodies do not tunnel through thin ones
    DUET_EFFECT_FILTER = 1u << 10,          // groups and masks
    DUET_EFFECT_SLEEP = 1u << 11,           // what rests leaves the work
    DUET_EFFECT_SKIN = 1u << 12,            // the grid lasts until something leaves its skin
    DUET_EFFECT_EVENTS = 1u << 13,          // contacts that begin and end are told
    DUET_EFFECT_ALL = (1u << 14) - 1
} duet_effect;

DUET_API const char *duet_effect_name(uint32_t effect); // one bit: "rotation"; NULL for others

// What an object is besides its pose.
typedef struct duet_body {
    float velocity[3];         // of the centre, a second
    float angular_velocity[3]; // angular velocity, radians a second, along the world's axes
    float mass;                // 0: nothing changes its velocity
    float restitution;         // what of an impact's speed comes back, 0 .. 1
    float friction;            // >= 0; a contact has the geometric mean of its two objects'
    uint32_t group;            // two objects can touch where each one's group has a bit
    uint32_t mask;             // of the other's mask
    bool fixed_rotation;       // never turned by others
} duet_body;

DUET_API duet_body duet_default_body(void); // at rest, mass 1, friction 0, all groups

// Where an object is and how it moves. In 2D only z of rotation and angular velocity count.
typedef struct duet_state {
    double centre[3];
    double rotation[4]; // of length 1
    double velocity[3];
    double angular_velocity[3];
} duet_state;

typedef enum duet_boundary {
    DUET_BOUNDARY_NONE,
    DUET_BOUNDARY_WALLS,   // lower and upper are walls
    DUET_BOUNDARY_PERIODIC // what leaves on one side comes in on the other
} duet_boundary;

typedef enum duet_integrator {
    DUET_INTEGRATOR_EULER,  // semi-implicit, first order
    DUET_INTEGRATOR_VERLET, // second order, symmetric; without contact response
    DUET_INTEGRATOR_YOSHIDA // fourth order, symmetric; without contact response
} duet_integrator;

typedef struct duet_motion_def {
    duet_device_pair *pair; // held; B has the state, both find pairs
    duet_plan plan;         // how pairs are found
    uint32_t dims;          // 2 or 3
    uint32_t wants;         // effects asked for besides those that the objects call for
    bool doubles;           // the state is in double
    double origin[3];       // where the poses' 0 lies; far away needs doubles, or origin cells
    float origin_edge;      // above 0: the state is in origin cells of that edge, a power of two
    double gravity[3];      // an acceleration
    double attraction;      // not 0: attraction / distance^2 towards the point `centre`
    double centre[3];
    double drag; // a velocity falls by the factor e in 1 / drag seconds
    duet_boundary boundary;
    double lower[3]; // the world's box
    double upper[3];
    double dt;
    uint32_t substeps;
    duet_integrator integrator;
    double skin;                  // > 0: how far bounds are grown so that the grid lasts
    double slop;                  // contacts are kept to 4 slops apart; 0: from the objects' sizes
    double max_push_speed;        // greatest speed at which overlap is resolved
    double restitution_threshold; // impacts below it do not bounce
    double sleep_speed; // what is slower rests, and what is faster takes back twice the time
    double sleep_after; // seconds of rest: sleeps, if nothing that moves touches it
    int cookie;
} duet_motion_def;

DUET_API duet_motion_def duet_default_motion_def(void); // 60 steps a second, 4 substeps

// Objects that move.
typedef struct duet_motion duet_motion;

// A def with what the scene says of motion, the default one for NULL, and its objects'
// bodies: [n], or NULL where nothing is said of any.
DUET_API duet_motion_def duet_scene_motion_def(const duet_scene *scene, duet_device_pair *pair);
DUET_API const duet_body *duet_scene_get_bodies(const duet_scene *scene);

// Copies n poses and bodies (NULL: duet_default_body each). BAD_ARGUMENT names
// the field of the def, BAD_OBJECT the object, that is wrong and what would be
// right.
DUET_API duet_motion *duet_motion_create(const duet_motion_def *def, const duet_pose *poses,
                                         const duet_body *bodies, uint32_t n, duet_error *err);
// The same of a scene's objects, in its origin cells where it has some. bodies
// NULL: those that the scene gives.
DUET_API duet_motion *duet_motion_create_from_scene(const duet_motion_def *def,
                                                    const duet_scene *scene,
                                                    const duet_body *bodies, duet_error *err);
DUET_API void duet_motion_destroy(duet_motion *motion);

// A contact that began or ended, a < b; a wall 2 k or 2 k + 1, the lower or
// upper one of axis k, is object n + 2 k or n + 2 k + 1.
typedef struct duet_event {
    uint32_t a;
    uint32_t b;
    bool begins;
} duet_event;

// What a step did. Its memory is the motion's and lasts until the next step.
typedef struct duet_motion_result {
    uint64_t step;     // steps since the start
    double time;       // step * dt
    uint64_t pairs;    // that may touch
    uint64_t contacts; // that push
    uint32_t colours;  // rounds of a solution
    bool rebuilt;      // pairs were searched in this step
    const duet_event *events;
    uint64_t n_events;
    double total_ms;
    const duet_stage *stages; // named by effect
    uint32_t n_stages;
} duet_motion_result;

// Advances all objects by dt. After a failure half a step may be done: until a saved
// motion is loaded into it, the motion can only be destroyed, and the calls below that
// take an error are BAD_ARGUMENT.
DUET_API bool duet_motion_advance(duet_motion *motion, duet_motion_result *result, duet_error *err);

DUET_API uint32_t duet_motion_get_effects(const duet_motion *motion); // bits of duet_effect
DUET_API uint32_t duet_motion_get_count(const duet_motion *motion);

// Copies the state of all objects to states [n]. BAD_OBJECT where a number of it is no
// longer finite; the states are copied all the same.
DUET_API bool duet_motion_get_states(duet_motion *motion, duet_state *states, duet_error *err);

// A sum over the state's bits, equal on all devices, at any share and in any
// split mode.
DUET_API bool duet_motion_get_hash(duet_motion *motion, uint64_t *hash, duet_error *err);

typedef struct duet_energy {
    double kinetic; // of objects with a mass
    double turning; // of their rotation
    double potential;
    double momentum[3];
    double angular[3]; // momentum about the origin
} duet_energy;

DUET_API bool duet_motion_get_energy(duet_motion *motion, duet_energy *energy, duet_error *err);

// Where two objects touched in the last step.
typedef struct duet_contact {
    uint32_t a, b;   // a has a mass; b may be below a, or a wall as in duet_event
    float normal[3]; // from a to b
    uint32_t n;      // points, 1 .. 4
    struct {
        float anchor[3];      // from a's centre
        float separation;     // below 0: depth
        float normal_impulse; // of the last substep, with contact response
    } points[4];
} duet_contact;

// Copies those contacts; the caller frees *contacts with duet_free. They are
// ascending.
DUET_API bool duet_motion_get_contacts(duet_motion *motion, duet_contact **contacts, uint64_t *n,
                                       duet_error *err);

// A motion as a file: advanced after loading, it goes on bit for bit as the
// saved one does. Objects, bodies and def must be those of the saved motion.
// BAD_INPUT where the file says what this motion could not have saved; files may come
// from anyone. After a failure the motion is as before.
DUET_API bool duet_motion_save(duet_motion *motion, const char *path, duet_error *err);
DUET_API bool duet_motion_load(duet_motion *motion, const char *path, duet_error *err);

// One effect of a motion, as duet explain shows it.
typedef struct duet_effect_info {
    const char *name;
    bool active;
    const char *called_by; // what calls for it, or would
    const char *kernels;   // those that have code for it
    uint32_t bytes;        // of state an object, on B
} duet_effect_info;

// Effect i, and after the last one how positions are kept ("origin"); false past that.
DUET_API bool duet_motion_explain(const duet_motion *motion, uint32_t i, duet_effect_info *info);

// ---------------------------------------------------------------- reference

// The plain-C twin: all pairs that a level of accuracy finds in the scene, operation for
// operation; certified is exact. The caller frees *pairs with duet_free; they are
// ascending.
DUET_API bool duet_reference(const duet_scene *scene, duet_level level, duet_pair **pairs,
                             uint64_t *n, duet_error *err);

// true where the exact boxes share a point; false where one is no box, or dims is
// neither 2 nor 3.
DUET_API bool duet_poses_collide(const duet_pose *a, const duet_pose *b, uint32_t dims);

// How far two boxes are apart along the best of the 15 (4) axes, each of length
// one, in double; below 0 it is how deep they are in each other. NaN where there is none.
DUET_API double duet_poses_separation(const duet_pose *a, const duet_pose *b, uint32_t dims);

// The same for large poses, in origin cells of that edge.
DUET_API bool duet_large_poses_collide(const duet_large_pose *a, const duet_large_pose *b,
                                       float edge, uint32_t dims);
DUET_API double duet_large_poses_separation(const duet_large_pose *a, const duet_large_pose *b,
                                            float edge, uint32_t dims);

DUET_API void duet_free(void *memory);

#ifdef __cplusplus
}
#endif
#endif
