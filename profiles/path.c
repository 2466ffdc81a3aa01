// SPDX-License-Identifier: MIT
// Where the store lies when nobody says, and how SQLite is told of a path.
#include "profiles/sql.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char *set(const char *name)
{
    const char *value = getenv(name);
    return value && *value ? value : NULL;
}

bool store_user_path(text *path, duet_error *err)
{
    if (set("DUET_PROFILE"))
        text_add(path, "%s", set("DUET_PROFILE"));
    else if (set("XDG_DATA_HOME"))
        text_add(path, "%s/duet/profiles.db", set("XDG_DATA_HOME"));
    else if (set("HOME"))
        text_add(path, "%s/.local/share/duet/profiles.db", set("HOME"));
    else
        return error_set(err, DUET_STATUS_NOT_FOUND,
                         "no place for the profile store: set DUET_PROFILE to a file, or HOME");
    return text_ok(path, err);
}

bool store_system_path(text *path)
{
    const char *at = set("XDG_DATA_DIRS");
    for (at = at ? at : "/usr/local/share:/usr/share"; *at; at += strspn(at, ":")) {
        int length = (int)strcspn(at, ":");
        text_free(path);
        text_add(path, "%.*s/duet/profiles.db", length, at);
        if (length > 0 && text_ok(path, NULL) && access(text_chars(path), R_OK) == 0)
            return true;
        at += length;
    }
    text_free(path);
    return false;
}

// To SQLite a leading "file:" or ":" is no part of a name; after a slash it is.
void store_file_name(const char *path, text *name)
{
    text_add(name, "%s%s", *path == '/' ? "" : "./", path);
}
