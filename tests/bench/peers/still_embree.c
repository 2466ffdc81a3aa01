// SPDX-License-Identifier: MIT
// Pairs of boxes whose bounds overlap, and the boxes that rays meet first, by Embree on one
// thread.
//
//     still_embree BOXES RAYS RUNS
//
// RAYS has rows of seven floats: origin, direction, greatest t. Prints the least processor time
// in ms of the tree, of the pairs and of the rays; then the pairs found and the rays that meet a
// box.
#include "boxes.h"

#include <embree3/rtcore.h>
#include <string.h>

typedef struct shape {
    float centre[3], half[3], axes[3][3], reach[3];
} shape;

typedef struct ray_row {
    float origin[3], direction[3], t_max;
} ray_row;

static void bounds_of(const struct RTCBoundsFunctionArguments *args)
{
    const shape *s = (const shape *)args->geometryUserPtr + args->primID;
    struct RTCBounds *b = args->bounds_o;
    b->lower_x = s->centre[0] - s->reach[0], b->upper_x = s->centre[0] + s->reach[0];
    b->lower_y = s->centre[1] - s->reach[1], b->upper_y = s->centre[1] + s->reach[1];
    b->lower_z = s->centre[2] - s->reach[2], b->upper_z = s->centre[2] + s->reach[2];
}

// Finds where the ray enters the box, by its slabs in the box's frame.
static void intersect(const struct RTCIntersectFunctionNArguments *args)
{
    const shape *s = (const shape *)args->geometryUserPtr + args->primID;
    struct RTCRayHit *r = (struct RTCRayHit *)args->rayhit; // packets of one
    if (!args->valid[0])
        return;
    float from[3] = {r->ray.org_x - s->centre[0], r->ray.org_y - s->centre[1],
                     r->ray.org_z - s->centre[2]};
    float enter = r->ray.tnear, leave = r->ray.tfar;
    for (int k = 0; k < 3; ++k) {
        float o = s->axes[0][k] * from[0] + s->axes[1][k] * from[1] + s->axes[2][k] * from[2];
        float d = s->axes[0][k] * r->ray.dir_x + s->axes[1][k] * r->ray.dir_y +
                  s->axes[2][k] * r->ray.dir_z;
        float a = (-s->half[k] - o) / d, b = (s->half[k] - o) / d;
        enter = fmaxf(enter, fminf(a, b));
        leave = fminf(leave, fmaxf(a, b));
    }
    if (enter > leave)
        return;
    r->ray.tfar = enter;
    r->hit.geomID = args->geomID;
    r->hit.primID = args->primID;
}

// Each pair arrives from both sides.
static void count_pairs(void *count, struct RTCCollision *found, unsigned n)
{
    for (unsigned i = 0; i < n; ++i)
        *(size_t *)count += found[i].primID0 < found[i].primID1;
}

static RTCScene make_scene(RTCDevice device, shape *shapes, size_t n)
{
    RTCScene scene = rtcNewScene(device);
    RTCGeometry boxes = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(boxes, (unsigned)n);
    rtcSetGeometryUserData(boxes, shapes);
    rtcSetGeometryBoundsFunction(boxes, bounds_of, NULL);
    rtcSetGeometryIntersectFunction(boxes, intersect);
    rtcCommitGeometry(boxes);
    rtcAttachGeometry(scene, boxes);
    rtcReleaseGeometry(boxes);
    return scene;
}

int main(int argc, char **argv)
{
    need(argc == 4, "give BOXES RAYS RUNS");
    size_t n, n_rays, pairs = 0, hits = 0;
    box *boxes = read_rows(argv[1], sizeof *boxes, &n);
    ray_row *rays = read_rows(argv[2], sizeof *rays, &n_rays);
    shape *shapes = malloc(n * sizeof *shapes);
    need(shapes != NULL, "no memory");
    for (size_t i = 0; i < n; ++i) {
        memcpy(shapes[i].centre, boxes[i].centre, sizeof boxes[i].centre);
        memcpy(shapes[i].half, boxes[i].half, sizeof boxes[i].half);
        box_axes(boxes + i, shapes[i].axes);
        box_reach(boxes + i, shapes[i].reach);
    }
    RTCDevice device = rtcNewDevice("threads=1,set_affinity=0");
    lap tree_least = {0}, pairs_least = {0}, rays_least = {0};
    for (int run = 0; run < atoi(argv[3]); ++run) {
        lap begun = lap_begin();
        RTCScene scene = make_scene(device, shapes, n);
        rtcCommitScene(scene);
        lap_end(begun, &tree_least);
        pairs = 0;
        begun = lap_begin();
        rtcCollide(scene, scene, count_pairs, &pairs);
        lap_end(begun, &pairs_least);

        hits = 0;
        begun = lap_begin();
        for (size_t i = 0; i < n_rays; ++i) {
            struct RTCIntersectContext context;
            struct RTCRayHit r = {0};
            rtcInitIntersectContext(&context);
            r.ray.org_x = rays[i].origin[0], r.ray.dir_x = rays[i].direction[0];
            r.ray.org_y = rays[i].origin[1], r.ray.dir_y = rays[i].direction[1];
            r.ray.org_z = rays[i].origin[2], r.ray.dir_z = rays[i].direction[2];
            r.ray.tfar = rays[i].t_max;
            r.ray.mask = ~0u;
            r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
            rtcIntersect1(scene, &context, &r);
            hits += r.hit.geomID != RTC_INVALID_GEOMETRY_ID;
        }
        lap_end(begun, &rays_least);
        rtcReleaseScene(scene);
    }
    printf("%.3f\t%.3f\t%.3f\t%zu\t%zu\n", tree_least.processor, pairs_least.processor,
           rays_least.processor, pairs, hits);
    rtcReleaseDevice(device);
    free(shapes);
    free(rays);
    free(boxes);
    return 0;
}
