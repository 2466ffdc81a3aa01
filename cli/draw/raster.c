// SPDX-License-Identifier: MIT
// Triangles are filled line by line into twice as many samples each way as
// there are pixels, so that edges are smooth. The file is written whole at the
// end, so that no one ever sees half of it.
#include "cli/draw/raster.h"

#include "base/error.h"
#include "base/text.h"

#include <math.h>
#include <png.h>
#include <stdlib.h>
#include <string.h>

enum { FINE = 2, CHANNELS = 3 };

struct raster {
    const char *path;
    int width, height;      // in samples
    unsigned char *samples; // [height][width][CHANNELS]
    float *nearest;         // [height][width]
};

static void put_tint(unsigned char *at, tint t)
{
    const double parts[CHANNELS] = {t.red, t.green, t.blue};
    for (int k = 0; k < CHANNELS; ++k)
        at[k] = (unsigned char)(255.0 * fmin(1.0, fmax(0.0, parts[k])));
}

static void clear(raster *r, tint paper)
{
    for (size_t i = 0; i < (size_t)r->width * (size_t)r->height; ++i) {
        put_tint(&r->samples[CHANNELS * i], paper);
        r->nearest[i] = -INFINITY;
    }
}

raster *raster_open(const char *path, int width, int height, tint paper, duet_error *err)
{
    size_t n = strlen(path);
    if (n < 5 || strcmp(path + n - 4, ".png") != 0) {
        error_set(err, DUET_STATUS_BAD_ARGUMENT, "'%s': the name of a run's picture ends with .png",
                  path);
        return NULL;
    }
    raster *r = calloc(1, sizeof *r);
    size_t samples = (size_t)width * (size_t)height * FINE * FINE;
    if (r) {
        *r = (raster){path, FINE * width, FINE * height, malloc(samples * CHANNELS),
                      malloc(samples * sizeof(float))};
    }
    if (!r || !r->samples || !r->nearest) {
        error_set(err, DUET_STATUS_NO_MEMORY, "%s: no memory for a picture", path);
        raster_close(r, false, NULL);
        return NULL;
    }
    clear(r, paper);
    return r;
}

// ---------------------------------------------------------------- filling

// Twice the area of the triangle from a and b to x, y.
static double area_to(spot a, spot b, double x, double y)
{
    return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

static void put_sample(raster *r, int x, int y, float nearness, tint fill)
{
    size_t at = (size_t)y * (size_t)r->width + (size_t)x;
    if (nearness <= r->nearest[at])
        return;
    r->nearest[at] = nearness;
    put_tint(&r->samples[CHANNELS * at], fill);
}

void raster_triangle(raster *r, const spot corners[3], tint fill)
{
    spot a = corners[0], b = corners[1], c = corners[2];
    double area = area_to(a, b, c.x, c.y);
    if (!(fabs(area) > 1e-12))
        return;
    int x0 = (int)fmax(0, FINE * fmin(a.x, fmin(b.x, c.x)));
    int x1 = (int)fmin(r->width - 1, FINE * fmax(a.x, fmax(b.x, c.x)));
    int y0 = (int)fmax(0, FINE * fmin(a.y, fmin(b.y, c.y)));
    int y1 = (int)fmin(r->height - 1, FINE * fmax(a.y, fmax(b.y, c.y)));
    for (int y = y0; y <= y1; ++y) {
        for (int x = x0; x <= x1; ++x) {
            double px = (x + 0.5) / FINE, py = (y + 0.5) / FINE;
            double u = area_to(b, c, px, py) / area, v = area_to(c, a, px, py) / area;
            double w = 1.0 - u - v;
            if (u >= 0 && v >= 0 && w >= 0)
                put_sample(r, x, y, (float)(u * a.nearness + v * b.nearness + w * c.nearness),
                           fill);
        }
    }
}

// ---------------------------------------------------------------- the file

// Each pixel is the mean of its samples, which it takes the place of.
static void shrink(raster *r)
{
    size_t row = (size_t)r->width * CHANNELS;
    for (int y = 0; y < r->height / FINE; ++y)
        for (int x = 0; x < r->width / FINE; ++x)
            for (int k = 0; k < CHANNELS; ++k) {
                unsigned sum = 0;
                for (int j = 0; j < FINE * FINE; ++j)
                    sum += r->samples[(size_t)(FINE * y + j / FINE) * row +
                                      (size_t)(CHANNELS * (FINE * x + j % FINE) + k)];
                r->samples[(size_t)y * row / FINE + (size_t)(CHANNELS * x + k)] =
                    (unsigned char)(sum / (FINE * FINE));
            }
}

static bool write_png(raster *r, duet_error *err)
{
    png_image image = {.version = PNG_IMAGE_VERSION,
                       .width = (png_uint_32)(r->width / FINE),
                       .height = (png_uint_32)(r->height / FINE),
                       .format = PNG_FORMAT_RGB};
    png_alloc_size_t capacity = PNG_IMAGE_PNG_SIZE_MAX(image), n = capacity;
    char *bytes = malloc(capacity);
    if (!bytes)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%s: no memory for a picture", r->path);
    shrink(r);
    bool ok = png_image_write_to_memory(&image, bytes, &n, 0, r->samples, 0, NULL) ||
              error_set(err, DUET_STATUS_IO_FAILED, "%s: %s", r->path, image.message);
    ok = ok && text_write_file(r->path, bytes, n, err);
    free(bytes);
    return ok;
}

bool raster_close(raster *r, bool keep, duet_error *err)
{
    if (!r)
        return false;
    bool ok = keep && write_png(r, err);
    free(r->samples);
    free(r->nearest);
    free(r);
    return ok;
}
