// SPDX-License-Identifier: MIT
// Whether stored rows are what their keys say. Internal to this module.
#ifndef PROFILES_KEYS_H
#define PROFILES_KEYS_H

#include "profiles/store.h"

// Makes the key of a row of "device", "env", "workload" or "script" again from
// its fields. right is true where it is the one that is stored.
bool key_check(store *s, const char *table, int64_t id, bool *right, duet_error *err);

#endif
