// SPDX-License-Identifier: MIT
// Bodies between walls or without, as piles.lua and stacks.lua write them, for an engine that is
// not Duet.
//
//     n substeps dt gravity friction sleep walls  lower x y z  upper x y z
//     centre x y z  half extents x y z  quaternion x y z w  radius  mass  velocity x y z    (n
//     lines)
//
// A body is a box if its radius is 0, else a ball, or a capsule along the one half extent that is
// not 0. Mass 0 does not move; sleep and walls are 0 or 1.
//
// A program takes PILE STATES STEPS EVERY, steps the bodies on one thread, writes a line of centre,
// half extents and quaternion for each to STATES after every EVERY steps, and prints one line: its
// name, the processor time of a step in ms, the mean of all, and how many bodies are awake at the
// end.
#ifndef PILE_H
#define PILE_H

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef struct pile_body {
    float centre[3], half[3], rotation[4], radius, mass, velocity[3];
} pile_body;

// `seconds` are of processor time, between pile_clock's answers.
typedef struct pile {
    unsigned n, substeps, steps, every;
    float dt, gravity, friction;
    int sleep, walls;
    float lower[3], upper[3];
    pile_body *bodies;
    FILE *states;
    double seconds;
} pile;

static inline void pile_need(int ok, const char *what)
{
    if (ok)
        return;
    fprintf(stderr, "%s\n", what);
    exit(1);
}

static inline void pile_read_bodies(pile *p, FILE *f)
{
    p->bodies = (pile_body *)calloc(p->n, sizeof *p->bodies);
    for (unsigned i = 0; i < p->n; ++i) {
        pile_body *b = p->bodies + i;
        float *c = b->centre, *h = b->half, *q = b->rotation, *v = b->velocity;
        pile_need(fscanf(f, "%f %f %f %f %f %f %f %f %f %f %f %f %f %f %f", c, c + 1, c + 2, h,
                         h + 1, h + 2, q, q + 1, q + 2, q + 3, &b->radius, &b->mass, v, v + 1,
                         v + 2) == 15,
                  "a body has fifteen numbers");
    }
}

static inline pile pile_read(int argc, char **argv)
{
    pile p = {0};
    pile_need(argc == 5, "give PILE STATES STEPS EVERY");
    FILE *f = fopen(argv[1], "r");
    pile_need(f != NULL, "no pile of that name");
    float *l = p.lower, *u = p.upper;
    pile_need(fscanf(f, "%u %u %f %f %f %d %d %f %f %f %f %f %f", &p.n, &p.substeps, &p.dt,
                     &p.gravity, &p.friction, &p.sleep, &p.walls, l, l + 1, l + 2, u, u + 1,
                     u + 2) == 13,
              "a pile begins with thirteen numbers");
    pile_read_bodies(&p, f);
    fclose(f);
    p.steps = (unsigned)atoi(argv[3]);
    p.every = (unsigned)atoi(argv[4]);
    pile_need(p.every > 0, "EVERY is 1 or more");
    p.states = fopen(argv[2], "w");
    pile_need(p.states != NULL, "the states cannot be written");
    return p;
}

// The floor and the four walls, as boxes 10 thick: five calls of add, or none.
static inline void pile_each_wall(const pile *p, void (*add)(void *world, const pile_body *wall),
                                  void *world)
{
    for (int side = 0; p->walls && side < 5; ++side) {
        int axis = side / 2, upper = side % 2; // 0 1 x, 2 3 y, 4 the floor
        pile_body wall = {{0}, {0}, {0, 0, 0, 1}, 0, 0, {0}};
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

// `p->bodies` are where the engine left them.
static inline void pile_write(const pile *p)
{
    for (unsigned i = 0; i < p->n; ++i) {
        const float *c = p->bodies[i].centre, *h = p->bodies[i].half, *q = p->bodies[i].rotation;
        fprintf(p->states, "%.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g\n", c[0], c[1], c[2],
                h[0], h[1], h[2], q[0], q[1], q[2], q[3]);
    }
}

// Runs all steps: `step` makes one, `read` puts where the bodies are into p->bodies.
static inline void pile_run(pile *p, void (*step)(void *world, const pile *p),
                            void (*read)(void *world, pile *p), void *world)
{
    for (unsigned i = 1; i <= p->steps; ++i) {
        double begun = pile_clock();
        step(world, p);
        p->seconds += pile_clock() - begun;
        if (i % p->every != 0 && i != p->steps)
            continue;
        read(world, p);
        pile_write(p);
    }
}

static inline void pile_end(const pile *p, const char *name, unsigned awake)
{
    pile_need(fclose(p->states) == 0, "the states cannot be written");
    printf("%s\t%.4f\t%u\n", name, p->seconds * 1e3 / p->steps, awake);
}

#endif
