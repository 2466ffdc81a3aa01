// SPDX-License-Identifier: MIT
// duet scenes: the scenes that come with Duet; all subcommands take their names.
#include "base/error.h"
#include "cli/commands.h"
#include "cli/options.h"
#include "cli/report/json.h"
#include "cli/report/rendering.h"
#include "runtime/scene/shipped.h"

#include <stdio.h>

typedef struct arguments {
    bool json;
} arguments;

static const option options[] = {
    OPTION_FLAG("json", json, "print one JSON object"),
    {0},
};

static const char *refuse(const void *given, char **operands)
{
    return operands[0] && ((const arguments *)given)->json
               ? "--json is of the list; NAME prints a scene as it is"
               : NULL;
}

static const command_line line = {
    .name = "scenes",
    .operands = "[NAME]",
    .about = "Lists the scenes that come with Duet; all subcommands take their names, as in\n"
             "'duet run paper'. With NAME prints the Lua text of one, to begin one's own\n"
             "with.",
    .options = options,
    .refuse = refuse,
};

static bool print_scene(const char *name, duet_error *err)
{
    shipped_scene scene;
    bool found = shipped_find(name, &scene);
    if (!found && shipped_find_nearest(name, &scene))
        return bad_argument(err, "there is no scene '%s'; did you mean '%s'?", name, scene.name);
    if (!found)
        return bad_argument(err, "there is no scene '%s'; 'duet scenes' lists those there are",
                            name);
    fwrite(scene.file->bytes, 1, scene.file->length, stdout);
    return true;
}

static cJSON *describe(void)
{
    shipped_scene scene;
    cJSON *o = cJSON_CreateObject();
    cJSON *scenes = cJSON_AddArrayToObject(o, "scenes");
    for (unsigned i = 0; shipped_at(i, &scene); ++i) {
        cJSON *one = json_add_row(scenes);
        json_add(one, STRING("name", scene.name), STRING("about", scene.about));
    }
    return o;
}

static bool run(void *given, char **operands, duet_error *err)
{
    if (operands[0])
        return print_scene(operands[0], err);
    return rendering_tell(describe(), ((const arguments *)given)->json, "cli/report/scenes.lua",
                          err);
}

SUBCOMMAND(scenes, 0)
