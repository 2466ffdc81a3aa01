// SPDX-License-Identifier: MIT
// The profile store: one SQLite file that keeps what was measured.
//
// It is opened for look-up by every application and for writing by the tuner;
// several processes may do both at once. Whatever lies at the path that is not
// a store of ours is left as it is.
#ifndef PROFILES_STORE_H
#define PROFILES_STORE_H

#include "base/error.h"
#include "base/text.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct store store;

typedef enum store_access {
    STORE_READ, // the file must exist, and nothing is written if no writer left it half-done
    STORE_WRITE // makes folders and file where they do not exist, and upgrades an older file
} store_access;

// NOT_FOUND for STORE_READ if there is no file; STORE_FAILED with one line
// for a file that is foreign, corrupt, locked, of another version, or cannot be
// written. path NULL: the user's, by store_user_path.
store *store_open(const char *path, store_access access, duet_error *err);
void store_close(store *s); // NULL allowed

// Whether what was read since the store was opened belongs together: false with
// a line if a file that is read without locks was written meanwhile.
bool store_check_read(const store *s, duet_error *err);

const char *store_path(const store *s);
bool store_writable(const store *s);
const char *store_note(const store *s); // what a user should know of this file; NULL: nothing

// Opens a transaction. May be nested: only the outermost writes, and a failure
// anywhere inside undoes all of it. A begin that succeeded is ended by
// store_end, which gives back `ok` and whether it could be written.
bool store_begin(store *s, duet_error *err);
bool store_end(store *s, bool ok, duet_error *err);

// DUET_PROFILE, else duet/profiles.db in XDG_DATA_HOME, else in
// ~/.local/share. NOT_FOUND if none of these is set.
bool store_user_path(text *path, duet_error *err);

// The first duet/profiles.db that exists in XDG_DATA_DIRS (default
// /usr/local/share:/usr/share); false if there is none.
bool store_system_path(text *path);

#endif
