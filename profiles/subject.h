// SPDX-License-Identifier: MIT
// What a row is of: a pair of devices, with what drives them; a workload, the class of
// scenes, or of queries, that one profile serves; or the network of a cluster.
//
// A device is known by what it is and not by which specimen: two cards of one
// model are one device. Strings are whole, never cut; NULL is unknown.
#ifndef PROFILES_SUBJECT_H
#define PROFILES_SUBJECT_H

#include "profiles/key.h"
#include "profiles/store.h"

// Nothing here changes with a driver.
typedef struct profile_device {
    const char *kind; // "cpu", "gpu" or "accel"
    const char *vendor;
    const char *name;
    const char *arch;      // may be NULL
    uint32_t units;        // compute units of the whole device
    uint32_t max_group;    // work-items in a work-group
    uint64_t local_bytes;  //
    uint64_t global_bytes; // counts only off the host: a host's memory varies
} profile_device;

// A device with the software that drives it and the limits set on it.
typedef struct profile_env {
    profile_device device;
    const char *platform;
    const char *platform_version;
    const char *driver;
    const char *cl_version;
    const char *part;    // "0-0" for a part of a CPU; NULL: the whole device
    uint32_t part_units; // 0: the whole device
    const char *limits;  // clock lock, power cap, affinity, governor; NULL: none known
} profile_env;

#define PROFILE_SECOND "second" // ends the part of B if nothing else tells B from A

// Ordered: A takes the share, B the rest. One device alone is a pair of itself.
typedef struct profile_pair {
    profile_env a;
    profile_env b;
} profile_pair;

// The sha256 of the canonical fields; a seat leaves out the versions.
void profile_device_key(const profile_device *device, char key[PROFILE_SHA]);
void profile_env_key(const profile_env *env, char key[PROFILE_SHA]);
void profile_env_keys(const profile_env *env, char key[PROFILE_SHA], char seat[PROFILE_SHA]);

// Finds or adds the pair with its devices.
bool profile_pair_put(store *s, const profile_pair *pair, int64_t *pair_id, duet_error *err);

// The machine as a hash, so that rows of two machines can be told apart and
// neither is named.
void profile_host(char host[PROFILE_SHA]);

// ---------------------------------------------------------------- workloads

typedef struct profile_workload {
    uint32_t dims;       // 2 or 3
    uint64_t n;          // objects
    uint32_t cells[3];   // the grid; in 2D cells[2] is not read
    double cell;         // cell edge
    double occ_mean;     // objects in a cell, over all cells
    double occ_p99;      // and in the fullest hundredth of them
    double size_ratio;   // largest extent by smallest; 1: all alike
    const char *shape;   // "poses", "bounds", "rounded boxes" or "spheres"
    bool rotated;        // some object has a rotation
    const char *effects; // words in any order, "gravity motion"; NULL: none. Of bodies that move,
                         // as they lie at the start, one is PROFILE_MOVING
    const char *level;   // the level of accuracy, "certified"; "auto": any that meets the budget
    const char *query;   // "rays closest": asked of a tree, and n are its items; NULL: steps of a
                         // world. A query has no cells, occupancy and sizes
    uint64_t boxes;      // in the tree
    const char *name;    // the scene's; told to people and not part of the key
} profile_workload;

// The text that the key is made of. Measures of the objects are rounded
// to parts of an octave, so that two draws of one scene are one workload.
void profile_workload_text(const profile_workload *w, text *t);

#define PROFILE_MOVING "moving"
#define PROFILE_IS_MOVING \
    "(' ' || w.effects || ' ') LIKE '% " PROFILE_MOVING " %'" // in a query on w

// Whether it is the steps of a motion, and not of a still world or a query.
bool profile_workload_moves(const profile_workload *w);

// The part of the key that workloads of different size share if they are neighbours.
void profile_workload_family(const profile_workload *w, text *t);

bool profile_workload_key(const profile_workload *w, char key[PROFILE_SHA], duet_error *err);

// Finds or adds it. BAD_ARGUMENT names a field that cannot be.
bool profile_workload_put(store *s, const profile_workload *w, int64_t *workload_id,
                          duet_error *err);

// ---------------------------------------------------------------- keys

// Makes the key of a row of "device", "env", "workload" or "script" again from its
// fields. right is true if it is the one that is stored.
bool key_check(store *s, const char *table, int64_t id, bool *right, duet_error *err);

#endif
