// SPDX-License-Identifier: MIT
// Cairo draws; the file is written whole at the end, so that no one ever sees
// half of it.
#include "cli/draw/canvas.h"

#include "base/error.h"
#include "base/text.h"
#include "base/text_file.h"

#include <cairo-svg.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

const colour canvas_ink = {0.13, 0.14, 0.16, 1};
const colour canvas_grey = {0.42, 0.45, 0.50, 1};

struct canvas {
    const char *path;
    bool is_png;
    cairo_surface_t *surface;
    cairo_t *cairo;
    text bytes; // the file's
};

static cairo_status_t add_bytes(void *bytes, const unsigned char *data, unsigned int n)
{
    text_add_bytes(bytes, (const char *)data, n);
    return ((text *)bytes)->failed ? CAIRO_STATUS_NO_MEMORY : CAIRO_STATUS_SUCCESS;
}

canvas *canvas_open(const char *path, double width, double height, duet_error *err)
{
    bool is_png = text_ends_with(path, ".png");
    if (!is_png && !text_ends_with(path, ".svg") && strcmp(path, "-") != 0)
        return error_null(err, DUET_STATUS_BAD_ARGUMENT,
                          "'%s': a picture's name ends with .svg or .png", path);
    canvas *c = calloc(1, sizeof *c);
    if (!c)
        return null_no_memory(err, "the picture %s", path);
    c->path = path;
    c->is_png = is_png;
    c->surface = is_png ? cairo_image_surface_create(CAIRO_FORMAT_RGB24, (int)width, (int)height)
                        : cairo_svg_surface_create_for_stream(add_bytes, &c->bytes, width, height);
    c->cairo = cairo_create(c->surface);
    cairo_set_source_rgb(c->cairo, 1, 1, 1);
    cairo_paint(c->cairo);
    cairo_set_line_join(c->cairo, CAIRO_LINE_JOIN_ROUND);
    return c;
}

static void use(canvas *c, colour ink)
{
    cairo_set_source_rgba(c->cairo, ink.red, ink.green, ink.blue, ink.alpha);
}

void canvas_line(canvas *c, point from, point to, colour ink, double width)
{
    use(c, ink);
    cairo_set_line_width(c->cairo, width);
    cairo_move_to(c->cairo, from.x, from.y);
    cairo_line_to(c->cairo, to.x, to.y);
    cairo_stroke(c->cairo);
}

void canvas_polygon(canvas *c, const point *corners, int n, colour fill, colour edge)
{
    cairo_new_path(c->cairo); // text leaves a path begun
    for (int i = 0; i < n; ++i)
        cairo_line_to(c->cairo, corners[i].x, corners[i].y);
    cairo_close_path(c->cairo);
    use(c, fill);
    if (edge.alpha == 0) {
        cairo_fill(c->cairo);
        return;
    }
    cairo_fill_preserve(c->cairo);
    use(c, edge);
    cairo_set_line_width(c->cairo, 1);
    cairo_stroke(c->cairo);
}

void canvas_dot(canvas *c, point at, double radius, colour fill)
{
    use(c, fill);
    cairo_new_sub_path(c->cairo);
    cairo_arc(c->cairo, at.x, at.y, radius, 0, 2 * acos(-1));
    cairo_fill(c->cairo);
}

double canvas_words(canvas *c, point at, double size, colour ink, const char *words)
{
    use(c, ink);
    cairo_select_font_face(c->cairo, "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                           CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(c->cairo, size);
    cairo_move_to(c->cairo, at.x, at.y);
    text shown = {0}; // cairo draws nothing more after what is no UTF-8
    text_add_visible(&shown, words, strlen(words), "");
    cairo_show_text(c->cairo, text_chars(&shown));
    text_free(&shown);
    cairo_get_current_point(c->cairo, &at.x, &at.y);
    return at.x;
}

static bool finish(canvas *c, duet_error *err)
{
    cairo_status_t status = cairo_status(c->cairo);
    if (status == CAIRO_STATUS_SUCCESS && c->is_png)
        status = cairo_surface_write_to_png_stream(c->surface, add_bytes, &c->bytes);
    cairo_surface_finish(c->surface); // writes the end of an SVG
    if (status == CAIRO_STATUS_SUCCESS)
        status = cairo_surface_status(c->surface);
    return status == CAIRO_STATUS_SUCCESS ||
           error_set(err, DUET_STATUS_NO_MEMORY, "%s: %s", c->path, cairo_status_to_string(status));
}

bool canvas_close(canvas *c, bool keep, duet_error *err)
{
    if (!c)
        return false;
    bool ok = keep && finish(c, err) && text_ok(&c->bytes, err);
    cairo_destroy(c->cairo);
    cairo_surface_destroy(c->surface);
    ok = ok && text_write_file(c->path, text_chars(&c->bytes), c->bytes.length, err);
    text_free(&c->bytes);
    free(c);
    return ok;
}
