// SPDX-License-Identifier: MIT
// Boxes as still.lua writes them: rows of ten floats, centre, half extents and quaternion.
#ifndef BOXES_H
#define BOXES_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef struct box {
    float centre[3], half[3], rotation[4];
} box;

static inline void need(int ok, const char *what)
{
    if (ok)
        return;
    fprintf(stderr, "%s\n", what);
    exit(1);
}

// Rows of `size` bytes; the caller frees them.
static inline void *read_rows(const char *path, size_t size, size_t *n)
{
    FILE *f = fopen(path, "rb");
    need(f && fseek(f, 0, SEEK_END) == 0, "no file of that name");
    *n = (size_t)ftell(f) / size;
    rewind(f);
    void *rows = malloc(*n * size + 1);
    need(rows && fread(rows, size, *n, f) == *n, "the file cannot be read");
    fclose(f);
    return rows;
}

// Columns are the box's axes.
static inline void box_axes(const box *b, float axes[3][3])
{
    const float *q = b->rotation;
    float l = 1 / sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    float x = q[0] * l, y = q[1] * l, z = q[2] * l, w = q[3] * l;
    const float m[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                           {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                           {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
    for (int i = 0; i < 9; ++i)
        axes[i / 3][i % 3] = m[i / 3][i % 3];
}

static inline void box_reach(const box *b, float reach[3])
{
    float axes[3][3];
    box_axes(b, axes);
    for (int i = 0; i < 3; ++i)
        reach[i] = fabsf(axes[i][0]) * b->half[0] + fabsf(axes[i][1]) * b->half[1] +
                   fabsf(axes[i][2]) * b->half[2];
}

// ms
static inline double clock_of(clockid_t which)
{
    struct timespec t;
    clock_gettime(which, &t);
    return (double)t.tv_sec * 1e3 + 1e-6 * (double)t.tv_nsec;
}

typedef struct lap {
    double wall, processor; // ms
} lap;

static inline lap lap_begin(void)
{
    return (lap){clock_of(CLOCK_MONOTONIC), clock_of(CLOCK_PROCESS_CPUTIME_ID)};
}

// Keeps the least of all laps in `least`, which begins with zeros.
static inline void lap_end(lap begun, lap *least)
{
    double wall = clock_of(CLOCK_MONOTONIC) - begun.wall;
    double processor = clock_of(CLOCK_PROCESS_CPUTIME_ID) - begun.processor;
    if (least->wall == 0 || wall < least->wall)
        least->wall = wall;
    if (least->processor == 0 || processor < least->processor)
        least->processor = processor;
}

#endif
