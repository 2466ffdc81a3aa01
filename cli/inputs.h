// SPDX-License-Identifier: MIT
// What most subcommands take: a scene with its settings, a device pair, a plan.
// Their option rows are here too, so that they are the same everywhere.
#ifndef CLI_INPUTS_H
#define CLI_INPUTS_H

#include "base/text.h"
#include "cli/options.h"
#include "cli/say.h"
#include "runtime/duet.h"

typedef struct scene_options {
    uint64_t n;    // UINT64_MAX: the scene's own
    uint64_t seed; // UINT64_MAX: the scene's own
    option_list settings;
} scene_options;

typedef struct plan_options {
    uint32_t share; // UINT32_MAX: not given; the rest NULL
    const char *mode;
    const char *variant;
    const char *variants[2];
    const char *prefix; // of the options' names, "other-"
} plan_options;

#define SCENE_OPTIONS_DEFAULT               \
    {                                       \
        .n = UINT64_MAX, .seed = UINT64_MAX \
    }
#define PLAN_OPTIONS_DEFAULT              \
    {                                     \
        .share = UINT32_MAX, .prefix = "" \
    }

// Rows of an option table; member is one of the arguments.
#define SCENE_OPTION_ROWS(member)                                                            \
    OPTION_COUNT("objects", member.n, "N",                                                   \
                 "number of objects, such as 1000 or 250k, if the scene lets you choose", 0, \
                 DUET_MOST_OBJECTS),                                                         \
        OPTION_COUNT("seed", member.seed, "S", "seed of the scene's random numbers", 0,      \
                     UINT32_MAX),                                                            \
        OPTION_SETTINGS("set", member.settings, "K=V",                                       \
                        "another parameter, as 'duet scenes SCENE' shows; may be repeated")

#define PAIR_OPTION_ROW(member)        \
    OPTION_TEXT("pair", member, "A,B", \
                "devices: cpu,gpu; cpu alone; halves of the CPU; or names from 'duet devices'")

#define PLAN_OPTION_ROWS(member)                                                           \
    OPTION_SHARE("share", member.share, "R", "A's part of the work, such as 0.25 or 1/4"), \
        OPTION_TEXT("mode", member.mode, "M",                                              \
                    "how grids are built: shared, own, slab or default"),                  \
        OPTION_TEXT("variant", member.variant, "V",                                        \
                    "kernels of both devices: auto, simd, gpu or paper"),                  \
        OPTION_TEXT("variant-a", member.variants[0], "V", "kernels of A"),                 \
        OPTION_TEXT("variant-b", member.variants[1], "V", "kernels of B")

// The accuracy that a world is asked for: the scene's, or this one.
typedef struct level_options {
    const char *level; // NULL: not given
    double missed;     // below 0: not given
    double false_rate;
} level_options;

#define LEVEL_OPTIONS_DEFAULT          \
    {                                  \
        .missed = -1, .false_rate = -1 \
    }

#define LEVEL_OPTION_ROW(member)      \
    OPTION_TEXT("level", member, "L", \
                "level of accuracy: certified (the default), aabb, sphere, sat6, sat15 or double")
#define ACCURACY_OPTION_ROWS(member)                                                               \
    OPTION_NUMBER("missed", member.missed, "R",                                                    \
                  "accept any level that misses at most this part of the pairs, such as 0.001", 0, \
                  1),                                                                              \
        OPTION_NUMBER(                                                                             \
            "false-rate", member.false_rate, "R",                                                  \
            "accept any level that adds at most R false pairs for each true one, such as 0.02", 0, \
            0)
#define SCENE_LEVEL_OPTION_ROWS(member)                                                     \
    OPTION_TEXT(                                                                            \
        "level", member.level, "L",                                                         \
        "level of accuracy: certified, aabb, sphere, sat6, sat15 or double (the scene's)"), \
        ACCURACY_OPTION_ROWS(member)

// NULL: certified. BAD_ARGUMENT for a name that no level has.
bool inputs_read_level(const char *name, duet_level *level, duet_error *err);

// Once no profile could be loaded: tells of a store that cannot be read, without which the default
// plan does. A device that failed ends the run.
bool inputs_do_without_profile(const duet_error *why, duet_error *err);

// Makes the scene's motion by the plan that was given, else by the one that was measured. The def
// is the scene's, with the pair that selectors opened. *profile says where the plan is from, unless
// it was given.
duet_motion *inputs_make_motion(const duet_scene *scene, duet_motion_def *def,
                                const char *selectors, const plan_options *options,
                                duet_profile *profile, duet_error *err);
// The plan of its searches. A motion that finds no pairs has the default plan, and B does all.
duet_plan inputs_motion_plan(const duet_motion *motion);
// Refuses more steps than a recording has.
bool inputs_check_recorded(const duet_replay *replay, const char *path, uint64_t steps,
                           duet_error *err);

// Whether an accuracy was given; what of it was not is then 0.
bool inputs_accuracy_given(const level_options *options, duet_accuracy *accuracy);

// Puts what was given in the place of what the scene says.
bool inputs_change_level(const level_options *options, duet_world_def *def, duet_error *err);

// A duet_compile_callback that tells how far it is.
void inputs_show_compiling(void *context, const duet_device_info *device, const char *kernel,
                           uint32_t k, uint32_t n);

// Whether that has told of any: a driver may compile each kernel for the device when it first runs.
bool inputs_have_compiled(void);

// NULL selectors: the default pair.
duet_device_pair *inputs_open_pair(const char *selectors, duet_error *err);

// Reads a task file with the settings of the options.
duet_task_file *inputs_load_task(const char *path, const scene_options *options, duet_error *err);

// Settings of a scene, as the library takes them.
typedef struct scene_settings {
    duet_setting list[OPTION_LIST_MOST + 2];
    uint32_t n;
    char objects[24];
    char seed[24];
} scene_settings;

void inputs_make_settings(scene_settings *s, const scene_options *options);
// Begins a line that tells of a file that is read.
progress inputs_begin_reading(const char *path);
void inputs_tell_empty(const duet_scene_info *info); // a note if there are no objects

duet_scene *inputs_load_scene(const char *path, const scene_options *options, duet_error *err);
// The same where a scene without objects is BAD_ARGUMENT.
duet_scene *inputs_load_objects(const char *path, const scene_options *options, duet_error *err);

// Puts the scene's objects into the order of their cells. The caller frees *ids, what they were
// called before, with duet_free.
bool inputs_put_in_order(duet_scene *scene, duet_device_pair *pair, uint32_t **ids,
                         duet_error *err);
duet_scene *inputs_load_pairs(const char *path, duet_error *err);

// duet_reference, with a line that tells how far it is.
bool inputs_find_reference(const duet_scene *scene, duet_level level, duet_pair **pairs,
                           uint64_t *n, duet_error *err);
bool inputs_plan_given(const plan_options *options); // anything of a plan
// Puts what was given into the plan. BAD_ARGUMENT for an unknown mode, and for what does nothing
// with the pair, which inputs_open_pair opened with these selectors. NULL: it is not known yet.
bool inputs_change_plan(const plan_options *options, const duet_device_pair *pair,
                        const char *selectors, duet_plan *plan, duet_error *err);

#endif
