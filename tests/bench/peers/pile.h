// SPDX-License-Identifier: MIT
// A pile of boxes as piles.lua writes it, for an engine that is not Duet.
//
//     n substeps dt gravity friction  lower x y z  upper x y z
//     centre x y z  half extents x y z  quaternion x y z w      (n lines, 1 kg each)
//
// A program takes PILE STATES STEPS, steps the pile on one thread, writes a line of centre,
// half extents and quaternion for each box to STATES, and prints one line: its name, the
// processor time of a step in ms, the mean of all, and how many boxes are awake at the end.
#ifndef PILE_H
#define PILE_H

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef struct pile_box {
    float centre[3], half[3], rotation[4];
} pile_box;

typedef struct pile {
    unsigned n, substeps, steps;
    float dt, gravity, friction, lower[3], upper[3];
    pile_box *boxes;
    const char *states;
    double begun; // s of processor time
} pile;

static inline void pile_need(int ok, const char *what)
{
    if (ok)
        return;
    fprintf(stderr, "%s\n", what);
    exit(1);
}

static inline pile pile_read(int argc, char **argv)
{
    pile p = {0};
    pile_need(argc == 4, "give PILE STATES STEPS");
    FILE *f = fopen(argv[1], "r");
    pile_need(f != NULL, "no pile of that name");
    float *l = p.lower, *u = p.upper;
    pile_need(fscanf(f, "%u %u %f %f %f %f %f %f %f %f %f", &p.n, &p.substeps, &p.dt, &p.gravity,
                     &p.friction, l, l + 1, l + 2, u, u + 1, u + 2) == 11,
              "a pile begins with eleven numbers");
    p.boxes = (pile_box *)calloc(p.n, sizeof *p.boxes);
    for (unsigned i = 0; i < p.n; ++i) {
        float *c = p.boxes[i].centre, *h = p.boxes[i].half, *q = p.boxes[i].rotation;
        pile_need(fscanf(f, "%f %f %f %f %f %f %f %f %f %f", c, c + 1, c + 2, h, h + 1, h + 2, q,
                         q + 1, q + 2, q + 3) == 10,
                  "a box has ten numbers");
    }
    fclose(f);
    p.states = argv[2];
    p.steps = (unsigned)atoi(argv[3]);
    return p;
}

// The floor and the four walls, as boxes 10 thick: five calls of add.
static inline void pile_each_wall(const pile *p, void (*add)(void *world, const pile_box *wall),
                                  void *world)
{
    for (int side = 0; side < 5; ++side) {
        int axis = side / 2, upper = side % 2; // 0 1 x, 2 3 y, 4 the floor
        pile_box wall = {{0}, {0}, {0, 0, 0, 1}};
        for (int k = 0; k < 3; ++k) {
            wall.centre[k] = 0.5f * (p->lower[k] + p->upper[k]);
            wall.half[k] = 0.5f * (p->upper[k] - p->lower[k]) + 10;
        }
        wall.half[axis] = 5;
        wall.centre[axis] = upper ? p->upper[axis] + 5 : p->lower[axis] - 5;
        add(world, &wall);
    }
}

static inline double pile_clock(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static inline void pile_begin(pile *p)
{
    p->begun = pile_clock();
}

// `p->boxes` are where the engine left them.
static inline void pile_end(const pile *p, double ended, const char *name, unsigned awake)
{
    FILE *f = fopen(p->states, "w");
    pile_need(f != NULL, "the states cannot be written");
    for (unsigned i = 0; i < p->n; ++i) {
        const float *c = p->boxes[i].centre, *h = p->boxes[i].half, *q = p->boxes[i].rotation;
        fprintf(f, "%.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g\n", c[0], c[1], c[2], h[0],
                h[1], h[2], q[0], q[1], q[2], q[3]);
    }
    pile_need(fclose(f) == 0, "the states cannot be written");
    printf("%s\t%.4f\t%u\n", name, (ended - p->begun) * 1e3 / p->steps, awake);
}

#endif
