// SPDX-License-Identifier: MIT
// A tune.lua: what to tune, and how. docs/tuning.md lists the fields.
#ifndef CLI_TUNE_CONFIG_H
#define CLI_TUNE_CONFIG_H

#include "base/text.h"
#include "gen/field.h"
#include "gen/script.h"
#include "tuner/duet_tune.h"

enum { CONFIG_WORKLOADS = 256, CONFIG_SETTINGS = 16 };

// One scene or task at one size, or what a tree of the scene is asked.
typedef struct config_workload {
    const char *scene;                     // a path, from the tune file's folder unless absolute
    const char *task;                      // likewise; NULL: a scene is tuned, else scene is NULL
    int64_t n;                             // objects or items; -1: as the file has them
    const char *settings[CONFIG_SETTINGS]; // "name=value"
    uint32_t n_settings;
    const char *query; // a query of a tree of the objects, or NULL: steps
    uint64_t items;    // items of the query; 0: as many as objects
    uint32_t steps;    // steps of the scene's motion; 0: still steps
} config_workload;

typedef struct tune_config {
    config_workload workloads[CONFIG_WORKLOADS];
    uint32_t n_workloads;
    const char *pair;         // "A,B", or NULL
    duet_tune_def def;        // the rest of what the file says: how to tune each workload
    field_name_list variants; // the def's lists
    duet_mode modes[FIELD_NAMES];
    duet_level levels[FIELD_NAMES];
    script *script; // keeps the strings
    text text;      // the file's text
    text list;      // variants that a caller gave as one text
} tune_config;

// The default def, and no workloads.
void tune_config_begin(tune_config *config);

// BAD_INPUT with file:line for a field that is wrong or that there is not.
bool tune_config_load(tune_config *config, const char *path, duet_error *err);
void tune_config_free(tune_config *config);

#endif
