// SPDX-License-Identifier: MIT
// Which devices a row belongs to: the silicon, what drives it, and the pair.
//
// A device is known by what it is and not by which specimen: two cards of one
// model are one device. Strings are whole, never cut; NULL is unknown.
#ifndef PROFILES_DEVICE_H
#define PROFILES_DEVICE_H

#include "profiles/store.h"

#define PROFILE_SHA 65 // 64 hex digits and a NUL

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

// Ordered: A takes the share, B the rest.
typedef struct profile_pair {
    profile_env a;
    profile_env b;
} profile_pair;

// The sha256 of the canonical fields; a seat leaves out the versions.
void profile_device_key(const profile_device *device, char key[PROFILE_SHA]);
void profile_env_key(const profile_env *env, char key[PROFILE_SHA]);
void profile_env_seat(const profile_env *env, char key[PROFILE_SHA]);

// Finds or adds the pair with its devices.
bool profile_pair_put(store *s, const profile_pair *pair, int64_t *pair_id, duet_error *err);

// The machine as a hash, so that rows of two machines can be told apart and
// neither is named.
void profile_host(char host[PROFILE_SHA]);

#endif
