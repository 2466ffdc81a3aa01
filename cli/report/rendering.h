// SPDX-License-Identifier: MIT
// Makes a page, a picture or a report for people of a JSON object, by the program's own Lua
// scripts.
#ifndef CLI_RENDERING_H
#define CLI_RENDERING_H

#include "duet_error.h"

#include <cjson/cJSON.h>
#include <stdbool.h>

// Writes a text; "-" is stdout. Each part, a carried script, is given what the one before it
// returned, and the last returns a function from the object, as a Lua table, to the text. parts
// ends with NULL.
bool rendering_write(const char *path, const char *const *parts, const cJSON *shown,
                     duet_error *err);

// Draws the shapes that a carried script returns as a .svg or .png.
bool rendering_draw(const char *path, const char *name, const cJSON *shown, duet_error *err);

// Prints the lines and tables that a carried script returns: cli/report/words.lua says how, and
// layout.lua lays them out.
bool rendering_print(const char *name, const cJSON *shown, duet_error *err);

// Prints the object as JSON or by that script, and deletes it.
bool rendering_tell(cJSON *o, bool json, const char *name, duet_error *err);

#endif
