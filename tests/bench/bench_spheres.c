// SPDX-License-Identifier: MIT
// Equal spheres beside as many unrotated cubes of their width, in the same places.
#include "bench.h"

#include "base/clock.h"
#include "base/error.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef struct subject {
    const char *name;
    duet_shape shape;
    duet_object_kind kind;
    const void *objects;
    duet_world *world;
    duet_result step;
    series ms, cpu;
} subject;

enum { SUBJECTS = 2 };

static bool open_world(subject *s, duet_device_pair *pair, duet_error *err)
{
    duet_world_def def = duet_default_world_def();
    def.pair = pair;
    def.shape = s->shape;
    def.rotated = false;
    s->world = duet_world_create(&def, err);
    return s->world;
}

static bool step(subject *s, uint32_t n, bool counts, duet_error *err)
{
    uint64_t begun = clock_steady_ns();
    clock_t cpu = clock();
    if (!duet_world_set_objects(s->world, s->kind, s->objects, n, err) ||
        !duet_world_step(s->world, &s->step, err))
        return false;
    if (counts) {
        series_add(&s->ms, (double)(clock_steady_ns() - begun) * 1e-6);
        series_add(&s->cpu, (double)(clock() - cpu) * 1e3 / CLOCKS_PER_SEC);
    }
    return true;
}

static bool measure(subject subjects[SUBJECTS], duet_device_pair *pair, uint32_t n, uint32_t runs,
                    duet_error *err)
{
    bool ok = open_world(&subjects[0], pair, err) && open_world(&subjects[1], pair, err);
    for (uint32_t i = 0; ok && i <= runs; ++i) // kernels are compiled in the first
        for (int k = 0; ok && k < SUBJECTS; ++k)
            ok = step(&subjects[k], n, i > 0, err);
    for (int k = 0; ok && k < SUBJECTS; ++k) {
        const subject *s = &subjects[k];
        printf("%-10s %9.1f ms %9.1f CPU ms   %llu of %llu candidates collide, %llu undecided\n",
               s->name, series_median(&s->ms), series_median(&s->cpu),
               (unsigned long long)s->step.pairs, (unsigned long long)s->step.candidates,
               (unsigned long long)s->step.undecided);
    }
    if (ok)
        printf("spheres take %.2f of the processor time of cubes\n",
               series_median(&subjects[1].cpu) / series_median(&subjects[0].cpu));
    return ok;
}

// Cubes lose their rotation.
static duet_sphere *spheres_of(duet_pose *poses, uint32_t n, duet_error *err)
{
    duet_sphere *spheres = calloc(n, sizeof *spheres);
    if (!spheres)
        error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u spheres", n);
    for (uint32_t i = 0; spheres && i < n; ++i) {
        const float *c = poses[i].centre;
        spheres[i] = (duet_sphere){{c[0], c[1], c[2]}, poses[i].half_extents[0]};
        for (int k = 0; k < 4; ++k)
            poses[i].rotation[k] = k == 3;
    }
    return spheres;
}

bool bench_spheres(const bench_options *options, duet_error *err)
{
    uint32_t n = options->n ? options->n : 1000000;
    duet_pose *poses = bench_poses(n, options, err);
    duet_sphere *spheres = poses ? spheres_of(poses, n, err) : NULL;
    duet_device_pair *pair = spheres ? bench_pair(options, err) : NULL;
    subject subjects[SUBJECTS] = {
        {.name = "cubes", DUET_SHAPE_POSES, DUET_OBJECT_POSES, .objects = poses},
        {.name = "spheres", DUET_SHAPE_SPHERES, DUET_OBJECT_SPHERES, .objects = spheres}};
    bool ok = pair && measure(subjects, pair, n, options->runs, err);
    for (int k = 0; k < SUBJECTS; ++k)
        duet_world_destroy(subjects[k].world);
    duet_device_pair_destroy(pair);
    free(spheres);
    free(poses);
    return ok;
}
