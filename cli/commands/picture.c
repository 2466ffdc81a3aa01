// SPDX-License-Identifier: MIT
// duet picture: draws a scene, so that one sees at once whether it is what was
// meant. No device is needed: the pairs are the plain C reference's.
#include "cli/commands.h"
#include "cli/draw/sketch.h"
#include "cli/inputs.h"
#include "cli/options.h"
#include "cli/say.h"
#include "runtime/duet.h"

enum { BOXES_2D = 500, BOXES_3D = 400 }; // more hide each other

typedef struct arguments {
    scene_options scene;
    const char *out;
    uint64_t most;
    uint64_t width;
} arguments;

static const option options[] = {
    OPTION_TEXT("o", out, "FILE", "the picture, a .svg or .png"),
    SCENE_OPTION_ROWS(scene),
    OPTION_COUNT("boxes", most, "K", "boxes that are drawn at most (500 in 2D, 400 in 3D)", 1,
                 100000),
    OPTION_COUNT("width", width, "PIXELS", "of the picture (1000)", 200, 8000),
    {0},
};

static const command_line line = {
    .name = "picture",
    .operands = "SCENE|FILE",
    .least_operands = 1,
    .most_operands = 1,
    .about = "Draws a scene with its cells and its pairs; of a large one the boxes about a\n"
             "collision, and the whole of it in a corner.",
    .options = options,
};

static uint32_t most_boxes(const arguments *args, const duet_scene *scene)
{
    if (args->most > 0)
        return (uint32_t)args->most;
    return duet_scene_get_info(scene)->dims == 2 ? BOXES_2D : BOXES_3D;
}

static bool picture(const arguments *args, const char *path, duet_error *err)
{
    sketch s = {0};
    double width = (double)args->width;
    canvas *c = canvas_open(args->out, width, width, err);
    duet_scene *scene = c ? inputs_load_scene(path, &args->scene, err) : NULL;
    bool ok = scene && sketch_make(&s, scene, most_boxes(args, scene), err);
    if (ok)
        sketch_draw(&s, c, width, width);
    ok = canvas_close(c, ok, err);
    sketch_free(&s);
    duet_scene_destroy(scene);
    return ok;
}

int command_picture(int argc, char **argv)
{
    arguments args = {.scene = SCENE_OPTIONS_DEFAULT, .width = 1000};
    char **operands = NULL;
    int n_operands = 0;
    int exit_code = EXIT_OK;
    if (!options_parse(&line, argc, argv, &args, &operands, &n_operands, &exit_code))
        return exit_code;
    if (!args.out)
        return say_wrong(line.name, "-o is missing: say where the picture goes, as -o scene.svg");
    duet_error err = {0};
    return picture(&args, operands[0], &err) ? EXIT_OK : say_failed(&err);
}
