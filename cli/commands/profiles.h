// SPDX-License-Identifier: MIT
// How the profile store is opened, and the verbs of `duet profiles` that have a file of their
// own. argv[0] is the verb, as "why"; they return the exit status.
#ifndef CLI_PROFILES_H
#define CLI_PROFILES_H

#include "profiles/profile.h"
#include "profiles/store.h"

int profiles_why(int argc, char **argv);

typedef struct profiles_arguments {
    const struct verb *verb;
    const char *store;
    uint64_t samples;
    uint64_t days;
    bool dead;
    bool t4;
    bool json;
} profiles_arguments;

// The profiles by device pair and size; one, named by its first digits; two, and which is the
// quicker.
typedef bool profiles_call(store *s, const profiles_arguments *args, char **operands,
                           duet_error *err);
profiles_call profiles_list, profiles_show, profiles_diff;

// Opens the store at path (NULL: the user's), and prints a note on stderr if there is one, as
// that the store was upgraded.
store *profiles_open(const char *path, store_access access, duet_error *err);

#define PROFILE_OPTION_ROW(member) \
    OPTION_INPUT("profile", member, "FILE", "the store (DUET_PROFILE, or the user's own)")

#endif
