// SPDX-License-Identifier: MIT
// A pile in Box3D.
#include "pile.h"

#include <box3d/box3d.h>
#include <string.h>

enum { PI_TIMES_1E6 = 3141593 };

typedef struct world {
    b3WorldId id;
    const pile *p;
    b3BodyId *bodies;
} world;

// m3
static float volume(const pile_body *b)
{
    const float *h = b->half, pi = 1e-6f * PI_TIMES_1E6, r = b->radius;
    if (r == 0)
        return 8 * h[0] * h[1] * h[2];
    return pi * r * r * (4.0f / 3 * r + 2 * (h[0] + h[1] + h[2]));
}

static void add_shape(b3BodyId id, const b3ShapeDef *def, const pile_body *b)
{
    const float *h = b->half;
    pile_need(!pile_is_rounded_box(b), "Box3D has no rounded boxes");
    if (b->radius == 0) {
        b3BoxHull hull = b3MakeBoxHull(h[0], h[1], h[2]);
        b3CreateHullShape(id, def, &hull.base);
    } else if (pile_is_ball(b)) {
        b3CreateSphereShape(id, def, &(b3Sphere){{0, 0, 0}, b->radius});
    } else {
        b3CreateCapsuleShape(id, def,
                             &(b3Capsule){{-h[0], -h[1], -h[2]}, {h[0], h[1], h[2]}, b->radius});
    }
}

static b3BodyId add(const world *w, const pile_body *b)
{
    b3BodyDef body = b3DefaultBodyDef();
    b3ShapeDef shape = b3DefaultShapeDef();
    body.type = b->mass > 0 ? b3_dynamicBody : b3_staticBody;
    body.position = (b3Pos){b->centre[0], b->centre[1], b->centre[2]};
    body.linearVelocity = (b3Vec3){b->velocity[0], b->velocity[1], b->velocity[2]};
    memcpy(&body.rotation, b->rotation, sizeof b->rotation);
    body.angularVelocity = (b3Vec3){b->spin[0], b->spin[1], b->spin[2]};
    body.isBullet = w->p->continuous && b->mass > 0;
    shape.density = b->mass / volume(b);
    shape.baseMaterial.friction = w->p->friction;
    shape.baseMaterial.restitution = w->p->restitution;
    b3BodyId id = b3CreateBody(w->id, &body);
    add_shape(id, &shape, b);
    return id;
}

static void add_wall(void *w, const pile_body *wall)
{
    add(w, wall);
}

static void step(void *w, const pile *p)
{
    b3World_Step(((world *)w)->id, p->dt, (int)p->substeps);
}

static void read(void *w, pile *p)
{
    for (unsigned i = 0; i < p->n; ++i) {
        b3BodyId id = ((world *)w)->bodies[i];
        b3Pos at = b3Body_GetPosition(id);
        b3Quat q = b3Body_GetRotation(id);
        b3Vec3 v = b3Body_GetLinearVelocity(id), s = b3Body_GetAngularVelocity(id);
        p->bodies[i].centre[0] = (float)at.x;
        p->bodies[i].centre[1] = (float)at.y;
        p->bodies[i].centre[2] = (float)at.z;
        memcpy(p->bodies[i].rotation, &q, sizeof q);
        memcpy(p->bodies[i].velocity, &v, sizeof v);
        memcpy(p->bodies[i].spin, &s, sizeof s);
    }
}

static void renew(void *world_, const pile *p, unsigned i)
{
    world *w = world_;
    b3DestroyBody(w->bodies[i]);
    w->bodies[i] = add(w, p->given + i);
}

int main(int argc, char **argv)
{
    pile p = pile_read(argc, argv);
    b3WorldDef def = b3DefaultWorldDef();
    def.gravity = (b3Vec3){0, 0, p.gravity};
    def.workerCount = p.threads;
    def.enableSleep = p.sleep;
    world w = {b3CreateWorld(&def), &p, malloc(p.n * sizeof *w.bodies)};
    pile_each_wall(&p, add_wall, &w);
    for (unsigned i = 0; i < p.n; ++i)
        w.bodies[i] = add(&w, p.bodies + i);

    pile_run(&p, &(pile_engine){step, read, renew}, &w);

    b3Version v = b3GetVersion();
    char name[64];
    snprintf(name, sizeof name, "Box3D %d.%d.%d", v.major, v.minor, v.revision);
    pile_end(&p, name, (unsigned)b3World_GetAwakeBodyCount(w.id));
    b3DestroyWorld(w.id);
    free(w.bodies);
    free(p.bodies);
    return 0;
}
