// SPDX-License-Identifier: MIT
// Finds how two devices share a scene's work best, and keeps it in a store.
#ifndef DUET_TUNE_H
#define DUET_TUNE_H

#include "duet.h"

DUET_C_BEGIN

// Reports the progress of a tuning, after each trial and while it waits.
typedef struct duet_tune_progress {
    const char *stage; // "level", "variant of B", "share", "verdict"
    const duet_plan *plan;
    double ms;            // time of the trial; 0 if the plan did not run
    uint32_t trials;      // so far
    uint32_t most_trials; // the most there will be, or about so many if kernels are searched; 0:
                          // not known
    uint32_t launches;
    double seconds;
    bool remembered;         // from an interrupted session, not measured again
    double expected_seconds; // that the tuning takes in all, about; 0: not known yet
    const char *waiting; // why nothing is measured now, as "other programs have 1.4 of 2 cores";
                         // NULL: a trial was measured
} duet_tune_progress;

// Returns false to stop the tuning with INTERRUPTED; the same call resumes it.
typedef bool duet_tune_watch(void *context, const duet_tune_progress *progress);

// Says what happens to a tuning's result.
typedef enum duet_keep {
    DUET_KEEP_NOTHING, // no store is used at all
    DUET_KEEP_DEFAULT, // stored; applications load what the default strategy found
    DUET_KEEP_ALWAYS   // applications load what another strategy found, too
} duet_keep;

typedef struct duet_tune_def {
    duet_device_pair *pair; // stays open until the call returns, as the scene does
    const duet_scene *scene;
    duet_task_file *task; // tunes this kernel of the user's; stays until the call returns. scene is
                          // then NULL. NULL: tunes the scene
    const char *query; // tunes the share of this query of a tree of the scene's objects, named as
                       // in duet_tree_load_profile; NULL: tunes a step
    uint64_t items;    // items of the query, drawn among the objects by the seed; 0: as many as
                       // objects
    uint32_t steps; // tunes this many steps of the scene's motion from its start; 0: tunes a still
                    // step
    const char *store; // profile file; NULL: the user's (DUET_PROFILE)
    duet_keep keep;
    bool ordered;              // the scene's objects are in about duet_world_order's order
    bool fresh;                // measures again what is finished
    const char *strategy;      // "balance"; duet_strategy_get_name lists them
    const char *strategy_lua;  // text of a script that returns a function, if strategy is "lua"
    const char *strategy_name; // name of that text in messages, as its file; NULL: "strategy"
    const char *objective;     // what is made small: "time", or "energy" by the counters that the
                           // system has; NOT_FOUND if none can be read. A strategy that evens out
                           // times gives way to "annealing" then
    const char *search; // "kernels": their parameters too, or one kernel's by its name; NULL: none
    const char *const *variants; // to choose from, for each device
    uint32_t n_variants;         // 0: the default list
    const duet_mode *modes;
    uint32_t n_modes;         // 0: all
    const duet_level *levels; // accuracy levels; several only with has_accuracy
    uint32_t n_levels;        // 0: as the scene says; with has_accuracy all
    bool has_accuracy;        // chooses the quickest level that is within accuracy
    duet_accuracy accuracy;
    double budget_seconds;  // 0: no limit
    double wait_seconds;    // longest total wait while other programs take the cores; 0: takes
                            // disturbed launches as they are. Below 0: as DUET_WAIT says, or else
                            // 60. Waiting is part of the budget
    uint32_t budget_trials; // 0: no limit; BAD_ARGUMENT if a verdict takes more
    uint32_t repeats;       // launches of a trial, after one to warm up; 0: 3
    uint64_t seed;
    const char *script; // text of the tune.lua, kept with the session; may be NULL
    duet_tune_watch *watch;
    void *watch_context;
    int cookie;
} duet_tune_def;

DUET_API duet_tune_def duet_default_tune_def(void);

// Return the name and the summary of strategy i, the default first; NULL past the end.
DUET_API const char *duet_strategy_get_name(uint32_t i);
DUET_API const char *duet_strategy_get_summary(uint32_t i);

// The terms of equations 4 to 6 in milliseconds, A in the CPU's place and B in
// the GPU's. T_1, the hash and the sort, is before them. docs/tuning.md says
// which stage counts to which.
typedef struct duet_tune_terms {
    double t1;
    double cpu1;      // A's search, in own grids with A's grid
    double cpu2;      // A's narrow phase
    double gpu1;      // cell start
    double gpu2;      // B's search
    double gpu3;      // B's narrow phase
    double bus1;      // grid, from B
    double bus2;      // grid, to A
    double bus3;      // pairs, to the host
    double imbalance; // A's side of equation 4 less B's side, as part of the longer side
    double joules;    // that a launch takes; 0: it was not measured
} duet_tune_terms;

// Holds the result of a search of a device's kernels.
typedef struct duet_kernel_search {
    uint32_t configs; // configs of the kernels searched; 0: nothing was searched
    uint32_t tried;
    uint32_t launches; // until the last race
    double gain;       // gain by all kernels of the device: 0.25 is a quarter faster
    double gain_low;
    double gain_high;
    char verdict[16]; // the kernels are used only if it is "faster"
} duet_kernel_search;

typedef struct duet_tune_outcome {
    duet_plan plan; // to use
    duet_plan best; // the best that shares the work; taken only if it is faster
    uint32_t objects;
    duet_level level;       // that was tuned
    duet_accuracy accuracy; // the level's accuracy, as measured on these objects
    uint64_t true_pairs;    // that the accuracy was measured on; 0: it was not measured
    double gain; // gain of the best plan over the better single device: 0.25 is a quarter faster
    double gain_low;
    double gain_high;
    char verdict[16];   // on the best plan: "faster", "same", "slower" or "ambiguous"
    uint32_t rounds;    // rounds of the race that gave the verdict
    uint32_t watched;   // launches whose threads were watched; 0: the system cannot
    uint32_t disturbed; // watched launches that waited for a core
    double step_ms;     // by the plan to use, the median; 0: the tuning gave up
    double step_low_ms; // and its interval
    double step_high_ms;
    double single_joules; // by the better single device, as terms.joules by the plan to use; 0:
                          // energy was not measured
    double single_ms;     // by the better single device; NaN: not known
    double whole_ms;      // by the one device that A and B are parts of, or of a motion by A as the
                          // only one; NaN: not raced
    double whole_gain;    // gain of the plan to use over that device; NaN: not raced
    double whole_gain_low;
    double whole_gain_high;
    duet_tune_terms terms;         // terms of the best plan; zero if a store has none
    duet_kernel_search kernels[2]; // A's, B's; a store keeps only what they led to
    uint32_t plans; // that a strategy for kernels and share together could choose from; 0: it was
                    // none
    uint32_t plans_tried; // by it
    uint32_t trials;
    uint32_t launches; // all, of interrupted sessions too
    double seconds;
    bool known;       // the same was asked and finished before: nothing was measured
    bool resumed;     // continued an interrupted session
    char uid[40];     // uid of the profile in the store; empty: no profile is kept
    char unused[128]; // why applications do not load it; empty: they do
} duet_tune_outcome;

// Chooses the level if an accuracy is asked for, each device's variant, then mode and share, then
// races the result against the single devices, and against the whole device if both are parts of
// one. A profile that applications load is replaced only by a profile that is founded at least as
// well (docs/store.md). BAD_ARGUMENT for an unknown strategy; NOT_FOUND if no level is within the
// accuracy; WRONG_RESULT if a plan of the default variant does not give the reference's pairs.
//
// A launch that other programs disturbed is repeated. If most launches are disturbed, the tuning
// waits and reports why to its watch. It gives up after wait_seconds: the verdict is "ambiguous",
// `unused` says why, step_ms is 0, the plan is the default one and no profile is kept; the same
// call goes on from there. While another process tunes on one of the devices, the call waits for
// its end.
//
// A tuning of a query searches only the share, and races it in the same way. A query has no modes,
// variants, levels and accuracy to choose from: BAD_ARGUMENT. step_ms is then the time of a run,
// and true_pairs the number of hits, which are those of device B alone at every share.
//
// A trial with steps is a run of that many steps from the scene's start, verified by its state's
// hash at the end, and step_ms is what a step takes in the mean after the first. The tuning
// searches the parameters of B's kernels (search NULL is then "kernels"), and how pairs are
// searched. A motion has no levels, accuracy and order to choose: BAD_ARGUMENT.
DUET_API bool duet_tune_run(const duet_tune_def *def, duet_tune_outcome *outcome, duet_error *err);

// ---------------------------------------------------------------- on line

// Keeps the plan of a world, a motion or a task near its best while frames go by.
typedef struct duet_online duet_online;

// A world, a motion or a task.
typedef struct duet_online_def {
    duet_world *world;           // held until the close; begins with the plan that it has
    duet_motion *motion;         // the caller's, and there until the close; only its share moves
    duet_task *task;             // likewise; only its share moves
    double most_extra;           // a frame may be expected to take so much longer for a trial: 0.1
    const duet_mode *modes;      // to choose from
    uint32_t n_modes;            // 0: all
    const char *const *variants; // to choose from for each device, besides those of the plan
    uint32_t n_variants; // up to four with those of the plan; a motion has no choice of both
    bool keep;         // stores at the close what was learned; it is loaded from then on if a tuned
                       // profile was before; false for a motion: a phase is not its run
    const char *store; // in this file; NULL: the user's (DUET_PROFILE)
    int cookie;
} duet_online_def;

DUET_API duet_online_def duet_default_online_def(void);

// If the world has objects, steps it with every mode and variant, some twenty steps for each
// variant, so that their kernels are built and their times known: call it while the application
// loads. Without objects only the share is moved later. BAD_ARGUMENT for an unknown variant.
DUET_API duet_online *duet_online_create(const duet_online_def *def, duet_error *err);

// Steps the world in the place of duet_world_step, with a plan that it sets. BAD_ARGUMENT if the
// def had no world. If frames take other times than before, or one device waits for the other, the
// next few frames move the share a little. Another mode, other kernels, and one device or two, are
// tried if most_extra allows what they are expected to take, and kept with a verdict as a tuning's.
// Nothing is read or written.
DUET_API bool duet_online_step(duet_online *online, duet_result *result, duet_error *err);

// Advances the motion in the place of duet_motion_advance, with a share that it sets. It watches
// the searches of all pairs, and follows the phases of a run: in the air, in a crash and at rest
// the devices need other shares. A motion of one device, by its pair or its plan, keeps its share.
// BAD_ARGUMENT if the def had no motion.
DUET_API bool duet_online_advance(duet_online *online, duet_motion_result *result, duet_error *err);

// Runs the task in the place of duet_task_run, with a share that it sets. BAD_ARGUMENT if the def
// had no task.
DUET_API bool duet_online_run(duet_online *online, duet_task_result *result, duet_error *err);

// Returns how often the share was tuned again, or another plan taken.
DUET_API uint32_t duet_online_get_tunings(const duet_online *online);

// Returns false if what was learned was to be kept and could not be; closes it all the same.
// Returns true for NULL.
DUET_API bool duet_online_destroy(duet_online *online, duet_error *err);

DUET_C_END

#endif
