// SPDX-License-Identifier: MIT
// A pile in Box3D.
#include "pile.h"

#include <box3d/box3d.h>
#include <string.h>

typedef struct world {
    b3WorldId id;
    float friction;
} world;

static b3BodyId add(const world *w, const pile_box *box, b3BodyType type)
{
    b3BodyDef body = b3DefaultBodyDef();
    b3ShapeDef shape = b3DefaultShapeDef();
    b3BoxHull hull = b3MakeBoxHull(box->half[0], box->half[1], box->half[2]);
    body.type = type;
    body.position = (b3Pos){box->centre[0], box->centre[1], box->centre[2]};
    memcpy(&body.rotation, box->rotation, sizeof box->rotation);
    shape.density = 1 / (8 * box->half[0] * box->half[1] * box->half[2]);
    shape.baseMaterial.friction = w->friction;
    shape.baseMaterial.restitution = 0;
    b3BodyId id = b3CreateBody(w->id, &body);
    b3CreateHullShape(id, &shape, &hull.base);
    return id;
}

static void add_wall(void *w, const pile_box *box)
{
    add(w, box, b3_staticBody);
}

int main(int argc, char **argv)
{
    pile p = pile_read(argc, argv);
    b3WorldDef def = b3DefaultWorldDef();
    def.gravity = (b3Vec3){0, 0, p.gravity};
    def.workerCount = 1;
    world w = {b3CreateWorld(&def), p.friction};
    b3BodyId *ids = malloc(p.n * sizeof *ids);
    pile_each_wall(&p, add_wall, &w);
    for (unsigned i = 0; i < p.n; ++i)
        ids[i] = add(&w, p.boxes + i, b3_dynamicBody);

    pile_begin(&p);
    for (unsigned step = 0; step < p.steps; ++step)
        b3World_Step(w.id, p.dt, (int)p.substeps);
    double ended = pile_clock();

    for (unsigned i = 0; i < p.n; ++i) {
        b3Pos at = b3Body_GetPosition(ids[i]);
        b3Quat q = b3Body_GetRotation(ids[i]);
        p.boxes[i].centre[0] = (float)at.x;
        p.boxes[i].centre[1] = (float)at.y;
        p.boxes[i].centre[2] = (float)at.z;
        memcpy(p.boxes[i].rotation, &q, sizeof q);
    }
    b3Version v = b3GetVersion();
    char name[64];
    snprintf(name, sizeof name, "Box3D %d.%d.%d", v.major, v.minor, v.revision);
    pile_end(&p, ended, name, (unsigned)b3World_GetAwakeBodyCount(w.id));
    b3DestroyWorld(w.id);
    free(ids);
    free(p.boxes);
    return 0;
}
