// SPDX-License-Identifier: MIT
// A pile in Bullet 3's rigid bodies on the CPU.
#include "pile.h"

#include <btBulletDynamicsCommon.h>
#include <vector>

namespace
{
struct World {
    btDiscreteDynamicsWorld *dynamics;
    float friction;
};

btRigidBody *add(World *w, const pile_box *box, bool moves)
{
    const float *c = box->centre, *h = box->half, *q = box->rotation;
    auto *shape = new btBoxShape(btVector3(h[0], h[1], h[2]));
    btScalar mass = moves ? 1 : 0;
    btVector3 inertia(0, 0, 0);
    if (moves)
        shape->calculateLocalInertia(mass, inertia);
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape, inertia);
    info.m_startWorldTransform =
        btTransform(btQuaternion(q[0], q[1], q[2], q[3]).normalized(), btVector3(c[0], c[1], c[2]));
    info.m_friction = btSqrt(w->friction); // Bullet multiplies the two
    info.m_restitution = 0;
    auto *body = new btRigidBody(info);
    w->dynamics->addRigidBody(body);
    return body;
}

void add_wall(void *w, const pile_box *box)
{
    add(static_cast<World *>(w), box, false);
}
} // namespace

int main(int argc, char **argv)
{
    pile p = pile_read(argc, argv);
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broad_phase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld dynamics(&dispatcher, &broad_phase, &solver, &configuration);
    dynamics.setGravity(btVector3(0, 0, p.gravity));
    World w = {&dynamics, p.friction};
    std::vector<btRigidBody *> bodies(p.n);
    pile_each_wall(&p, add_wall, &w);
    for (unsigned i = 0; i < p.n; ++i)
        bodies[i] = add(&w, p.boxes + i, true);

    pile_begin(&p);
    for (unsigned step = 0; step < p.steps; ++step)
        dynamics.stepSimulation(p.dt, 0, p.dt);
    double ended = pile_clock();

    unsigned awake = 0;
    for (unsigned i = 0; i < p.n; ++i) {
        const btTransform &at = bodies[i]->getWorldTransform();
        btQuaternion q = at.getRotation();
        for (int k = 0; k < 3; ++k)
            p.boxes[i].centre[k] = static_cast<float>(at.getOrigin()[k]);
        for (int k = 0; k < 4; ++k)
            p.boxes[i].rotation[k] = static_cast<float>(q[k]);
        awake += bodies[i]->isActive();
    }
    char name[64];
    snprintf(name, sizeof name, "Bullet %d.%02d", btGetVersion() / 100, btGetVersion() % 100);
    pile_end(&p, ended, name, awake);
    fflush(nullptr);
    _Exit(0);
}
