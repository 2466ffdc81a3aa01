// SPDX-License-Identifier: MIT
// Bodies between walls or without, as engines.lua writes them, for an engine that is not Duet.
//
//     n substeps dt gravity friction restitution
//         sleep walls continuous settled churn  lower x y z  upper x y z
//     centre x y z  half extents x y z  quaternion x y z w  radius  mass
//         velocity x y z  angular velocity x y z    (n times)
//
// A body is a box if its radius is 0, else a ball, a capsule along the one half extent that is
// not 0, or a box that is rounded. Mass 0 does not move; sleep, walls and continuous are 0 or 1.
// Before each step behind the first `settled`, `churn` bodies are removed, others each time and
// never the first, and put where they began.
//
// A program takes PILE STATES STEPS EVERY [THREADS], steps the bodies on as many threads (one
// without the last argument), writes a line of centre, half extents, quaternion, velocity and
// angular velocity for each to STATES after every EVERY steps, and prints one line: its name, the
// processor time of all threads and the clock's of a step in ms, the mean of those behind
// `settled`, and how many bodies are awake at the end.
#ifndef PILE_H
#define PILE_H

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { PILE_MAX_THREADS = 32 }; // Box3D's greatest

typedef struct pile_body {
    float centre[3], half[3], rotation[4], radius, mass, velocity[3], spin[3];
} pile_body;

// `given` are the bodies as they began; seconds are of those steps that count.
typedef struct pile {
    unsigned n, substeps, steps, every, settled, churn, threads;
    float dt, gravity, friction, restitution;
    int sleep, walls, continuous;
    float lower[3], upper[3];
    pile_body *bodies, *given;
    FILE *states;
    double seconds, wall_seconds;
} pile;

// An engine's calls: `step` makes a step, `read` puts where the bodies are into p->bodies,
// `renew` removes a body and puts p->given[i] in its place.
typedef struct pile_engine {
    void (*step)(void *world, const pile *p);
    void (*read)(void *world, pile *p);
    void (*renew)(void *world, const pile *p, unsigned i);
} pile_engine;

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
    p->given = (pile_body *)calloc(p->n, sizeof *p->given);
    for (unsigned i = 0; i < p->n; ++i) {
        pile_body *b = p->bodies + i;
        float *c = b->centre, *h = b->half, *q = b->rotation, *v = b->velocity, *s = b->spin;
        pile_need(fscanf(f, "%f %f %f %f %f %f %f %f %f %f %f %f %f %f %f %f %f %f", c, c + 1,
                         c + 2, h, h + 1, h + 2, q, q + 1, q + 2, q + 3, &b->radius, &b->mass, v,
                         v + 1, v + 2, s, s + 1, s + 2) == 18,
                  "a body has eighteen numbers");
        p->given[i] = *b;
    }
}

static inline pile pile_read(int argc, char **argv)
{
    pile p = {0};
    pile_need(argc == 5 || argc == 6, "give PILE STATES STEPS EVERY [THREADS]");
    FILE *f = fopen(argv[1], "r");
    pile_need(f != NULL, "no pile of that name");
    float *l = p.lower, *u = p.upper;
    pile_need(fscanf(f, "%u %u %f %f %f %f %d %d %d %u %u %f %f %f %f %f %f", &p.n, &p.substeps,
                     &p.dt, &p.gravity, &p.friction, &p.restitution, &p.sleep, &p.walls,
                     &p.continuous, &p.settled, &p.churn, l, l + 1, l + 2, u, u + 1, u + 2) == 17,
              "a pile begins with seventeen numbers");
    pile_read_bodies(&p, f);
    fclose(f);
    p.steps = (unsigned)atoi(argv[3]);
    p.every = (unsigned)atoi(argv[4]);
    pile_need(p.every > 0, "EVERY is 1 or more");
    int threads = argc == 6 ? atoi(argv[5]) : 1;
    pile_need(threads > 0 && threads <= PILE_MAX_THREADS, "THREADS is 1 to 32");
    p.threads = (unsigned)threads;
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
        pile_body wall = {{0}, {0}, {0, 0, 0, 1}, 0, 0, {0}, {0}};
        for (int k = 0; k < 3; ++k) {
            wall.centre[k] = 0.5f * (p->lower[k] + p->upper[k]);
            wall.half[k] = 0.5f * (p->upper[k] - p->lower[k]) + 10;
        }
        wall.half[axis] = 5;
        wall.centre[axis] = upper ? p->upper[axis] + 5 : p->lower[axis] - 5;
        add(world, &wall);
    }
}

static inline int pile_is_ball(const pile_body *b)
{
    return b->radius > 0 && b->half[0] + b->half[1] + b->half[2] == 0;
}

static inline int pile_is_rounded_box(const pile_body *b)
{
    return b->radius > 0 && (b->half[0] > 0) + (b->half[1] > 0) + (b->half[2] > 0) > 1;
}

static inline double pile_clock(clockid_t which)
{
    struct timespec t;
    clock_gettime(which, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

// `p->bodies` are where the engine left them.
static inline void pile_write(const pile *p)
{
    for (unsigned i = 0; i < p->n; ++i) {
        const float *const rows[] = {p->bodies[i].centre, p->bodies[i].half, p->bodies[i].rotation,
                                     p->bodies[i].velocity, p->bodies[i].spin};
        const int sizes[] = {3, 3, 4, 3, 3};
        for (int row = 0; row < 5; ++row)
            for (int k = 0; k < sizes[row]; ++k)
                fprintf(p->states, "%.9g ", rows[row][k]);
        fputc('\n', p->states);
    }
}

static inline void pile_renew(const pile *p, unsigned step, const pile_engine *e, void *world)
{
    unsigned first = p->churn ? 1 + step % ((p->n - 1) / p->churn) * p->churn : 0;
    for (unsigned i = first; i < first + p->churn; ++i)
        e->renew(world, p, i);
}

static inline void pile_run(pile *p, const pile_engine *e, void *world)
{
    for (unsigned i = 1; i <= p->steps; ++i) {
        double begun = pile_clock(CLOCK_PROCESS_CPUTIME_ID), at = pile_clock(CLOCK_MONOTONIC);
        if (i > p->settled)
            pile_renew(p, i, e, world);
        e->step(world, p);
        if (i > p->settled) {
            p->seconds += pile_clock(CLOCK_PROCESS_CPUTIME_ID) - begun;
            p->wall_seconds += pile_clock(CLOCK_MONOTONIC) - at;
        }
        if (i % p->every != 0 && i != p->steps)
            continue;
        e->read(world, p);
        pile_write(p);
    }
}

static inline void pile_end(const pile *p, const char *name, unsigned awake)
{
    unsigned counted = p->steps - p->settled;
    pile_need(fclose(p->states) == 0, "the states cannot be written");
    printf("%s\t%.4f\t%.4f\t%u\n", name, p->seconds * 1e3 / counted,
           p->wall_seconds * 1e3 / counted, awake);
}

#endif
