// SPDX-License-Identifier: MIT
// How the profile store is opened, and the verbs of `duet profiles` that have a file of their
// own. argv[0] is the verb, as "why"; they return the exit status.
#ifndef CLI_PROFILES_H
#define CLI_PROFILES_H

#include "profiles/profile.h"
#include "profiles/store.h"

int profiles_why(int argc, char **argv);

bool profiles_list(store *s, bool dead, bool json, duet_error *err);

// A profile, named by its first digits.
bool profiles_show(store *s, const char *uid, bool json, duet_error *err);

// Two profiles, named by their first digits, and which is the quicker.
bool profiles_diff(store *s, const char *first, const char *second, bool json, duet_error *err);

// Opens the store at path (NULL: the user's), and prints a note on stderr if there is one, as
// that the store was upgraded.
store *profiles_open(const char *path, store_access access, duet_error *err);

#define PROFILE_OPTION_ROW(member) \
    OPTION_INPUT("profile", member, "FILE", "the store (DUET_PROFILE, or the user's own)")

#endif
