// SPDX-License-Identifier: MIT
// duet picture: draws a scene, so that one sees at once whether it is what was
// meant. No device is needed: the pairs are the plain C reference's.
#include "cli/commands.h"
#include "cli/draw/sketch.h"
#include "cli/inputs.h"

enum { BOXES_2D = 500, BOXES_3D = 400 }; // more hide each other

typedef struct arguments {
    scene_options scene;
    const char *out;
    uint64_t most;
    uint64_t width;
} arguments;

static const option options[] = {
    OPTION_OUTPUT("output", out, "FILE", "the picture, a .svg or .png"),
    SCENE_OPTION_ROWS(scene),
    OPTION_COUNT("boxes", most, "K", "draw at most K boxes (500 in 2D, 400 in 3D)", 1, 100000),
    OPTION_COUNT("width", width, "PIXELS", "width of the picture (1000)", 200, 8000),
    {0},
};

static const char *refuse(const void *given, char **operands)
{
    (void)operands;
    return ((const arguments *)given)->out
               ? NULL
               : "-o is missing: say where the picture goes, as -o scene.svg";
}

static const command_line line = {
    .name = "picture",
    .operands = "SCENE|FILE",
    .about = "Draws a scene with its cells, its pairs and a scale bar. A large scene is drawn\n"
             "around a collision, with the whole of it in a corner.",
    .options = options,
    .refuse = refuse,
};

static uint32_t most_boxes(const arguments *args, const duet_scene *scene)
{
    if (args->most > 0)
        return (uint32_t)args->most;
    return duet_scene_get_info(scene)->dims == 2 ? BOXES_2D : BOXES_3D;
}

static bool run(void *given, char **operands, duet_error *err)
{
    const arguments *args = given;
    sketch s = {0};
    double width = (double)args->width;
    canvas *c = canvas_open(args->out, width, width, err);
    duet_scene *scene = c ? inputs_load_scene(operands[0], &args->scene, err) : NULL;
    bool ok = scene && sketch_make(&s, scene, most_boxes(args, scene), err);
    if (ok)
        sketch_draw(&s, c, width, width);
    ok = canvas_close(c, ok, err);
    sketch_free(&s);
    duet_scene_destroy(scene);
    return ok;
}

SUBCOMMAND(picture, .scene = SCENE_OPTIONS_DEFAULT, .width = 1000)
