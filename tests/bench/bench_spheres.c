// SPDX-License-Identifier: MIT
// Equal spheres beside as many unrotated cubes of their width, in the same places.
#include "bench.h"

typedef struct subject {
    const char *name;
    duet_shape shape;
    duet_object_kind kind;
    const void *objects;
    uint32_t n;
    duet_world *world;
    duet_result step;
} subject;

static void step(void *of)
{
    subject *s = of;
    must(duet_world_set_objects(s->world, s->kind, s->objects, s->n, ERR));
    must(duet_world_step(s->world, &s->step, ERR));
}

// Cubes lose their rotation.
static duet_sphere *spheres_of(duet_pose *poses, uint32_t n)
{
    duet_sphere *spheres = bench_alloc(n * sizeof *spheres);
    for (uint32_t i = 0; i < n; ++i) {
        const float *c = poses[i].centre;
        spheres[i] = (duet_sphere){{c[0], c[1], c[2]}, poses[i].half_extents[0]};
        for (int k = 0; k < 4; ++k)
            poses[i].rotation[k] = k == 3;
    }
    return spheres;
}

void bench_spheres(const bench_options *options)
{
    uint32_t n = options->n ? options->n : 1000000;
    duet_pose *poses = bench_poses(n, options);
    duet_device_pair *pair = bench_pair(options);
    subject subjects[] = {
        {"cubes", DUET_SHAPE_POSES, DUET_OBJECT_POSES, .objects = poses, .n = n},
        {"spheres", DUET_SHAPE_SPHERES, DUET_OBJECT_SPHERES, spheres_of(poses, n), .n = n}};
    static bench_side sides[2];
    for (int k = 0; k < 2; ++k) {
        duet_world_def def = duet_default_world_def();
        def.shape = subjects[k].shape;
        def.rotated = false;
        subjects[k].world = bench_world(pair, def);
        sides[k] = (bench_side){.run = step, .of = &subjects[k]};
    }
    bench_sides_run(sides, 2, options->runs);
    for (int k = 0; k < 2; ++k)
        printf("%-10s %9.1f ms %9.1f CPU ms   %" PRIu64 " of %" PRIu64
               " candidates collide, %" PRIu64 " undecided\n",
               subjects[k].name, series_median(&sides[k].ms), series_median(&sides[k].cpu),
               subjects[k].step.pairs, subjects[k].step.candidates, subjects[k].step.undecided);
    printf("spheres take %.2f of the processor time of cubes\n",
           series_median(&sides[1].cpu) / series_median(&sides[0].cpu));
}
