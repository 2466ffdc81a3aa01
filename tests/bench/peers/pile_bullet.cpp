// SPDX-License-Identifier: MIT
// A pile in Bullet 3's rigid bodies on the CPU.
#include "pile.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcherMt.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolverMt.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorldMt.h>
#include <LinearMath/btThreads.h>
#include <btBulletDynamicsCommon.h>
#include <memory>
#include <vector>

namespace
{
// A world and what it is made of: on one thread the classes that Bullet has had for long, on more
// those whose names end in Mt.
struct Simulation {
    btDefaultCollisionConfiguration configuration;
    btDbvtBroadphase broad_phase;
    btSequentialImpulseConstraintSolver solver;
    std::unique_ptr<btCollisionDispatcher> dispatcher;
    std::unique_ptr<btConstraintSolverPoolMt> pool;
    std::unique_ptr<btSequentialImpulseConstraintSolverMt> solver_mt;
    std::unique_ptr<btDiscreteDynamicsWorld> dynamics;

    explicit Simulation(unsigned threads)
    {
        if (threads == 1)
            make_sequential();
        else
            make_parallel(static_cast<int>(threads));
    }

  private:
    void make_sequential()
    {
        dispatcher = std::make_unique<btCollisionDispatcher>(&configuration);
        dynamics = std::make_unique<btDiscreteDynamicsWorld>(dispatcher.get(), &broad_phase,
                                                             &solver, &configuration);
    }
    void make_parallel(int threads)
    {
        btITaskScheduler *scheduler = btCreateDefaultTaskScheduler();
        pile_need(scheduler != nullptr, "Bullet was built without threads");
        scheduler->setNumThreads(threads);
        btSetTaskScheduler(scheduler);
        dispatcher = std::make_unique<btCollisionDispatcherMt>(&configuration);
        pool = std::make_unique<btConstraintSolverPoolMt>(threads);
        solver_mt = std::make_unique<btSequentialImpulseConstraintSolverMt>();
        dynamics = std::make_unique<btDiscreteDynamicsWorldMt>(
            dispatcher.get(), &broad_phase, pool.get(), solver_mt.get(), &configuration);
    }
};

struct World {
    btDiscreteDynamicsWorld *dynamics;
    const pile *p;
    std::vector<btRigidBody *> bodies;
};

btCollisionShape *shape_of(const pile_body *b)
{
    const float *h = b->half;
    pile_need(!pile_is_rounded_box(b), "Bullet's boxes collide without their margin");
    if (b->radius == 0)
        return new btBoxShape(btVector3(h[0], h[1], h[2]));
    if (h[0] > 0)
        return new btCapsuleShapeX(b->radius, 2 * h[0]);
    if (h[1] > 0)
        return new btCapsuleShape(b->radius, 2 * h[1]);
    if (h[2] > 0)
        return new btCapsuleShapeZ(b->radius, 2 * h[2]);
    return new btSphereShape(b->radius);
}

btRigidBody *add(World *w, const pile_body *b)
{
    const float *c = b->centre, *q = b->rotation, *v = b->velocity;
    btCollisionShape *shape = shape_of(b);
    btVector3 inertia(0, 0, 0);
    if (b->mass > 0)
        shape->calculateLocalInertia(b->mass, inertia);
    btRigidBody::btRigidBodyConstructionInfo info(b->mass, nullptr, shape, inertia);
    info.m_startWorldTransform =
        btTransform(btQuaternion(q[0], q[1], q[2], q[3]).normalized(), btVector3(c[0], c[1], c[2]));
    info.m_friction = btSqrt(w->p->friction); // Bullet multiplies the two
    info.m_restitution = btSqrt(w->p->restitution);
    auto *body = new btRigidBody(info);
    if (b->mass > 0) {
        body->setLinearVelocity(btVector3(v[0], v[1], v[2]));
        body->setAngularVelocity(btVector3(b->spin[0], b->spin[1], b->spin[2]));
    }
    if (w->p->continuous && pile_is_ball(b)) {
        body->setCcdMotionThreshold(b->radius);
        body->setCcdSweptSphereRadius(0.8f * b->radius);
    }
    if (!w->p->sleep)
        body->setActivationState(DISABLE_DEACTIVATION);
    w->dynamics->addRigidBody(body);
    return body;
}

void add_wall(void *w, const pile_body *wall)
{
    add(static_cast<World *>(w), wall);
}

void step(void *w, const pile *p)
{
    static_cast<World *>(w)->dynamics->stepSimulation(p->dt, 0, p->dt);
}

void read(void *w, pile *p)
{
    for (unsigned i = 0; i < p->n; ++i) {
        const btTransform &at = static_cast<World *>(w)->bodies[i]->getWorldTransform();
        btQuaternion q = at.getRotation();
        for (int k = 0; k < 3; ++k) {
            const btRigidBody *body = static_cast<World *>(w)->bodies[i];
            p->bodies[i].centre[k] = static_cast<float>(at.getOrigin()[k]);
            p->bodies[i].velocity[k] = static_cast<float>(body->getLinearVelocity()[k]);
            p->bodies[i].spin[k] = static_cast<float>(body->getAngularVelocity()[k]);
        }
        for (int k = 0; k < 4; ++k)
            p->bodies[i].rotation[k] = static_cast<float>(q[k]);
    }
}

void renew(void *world, const pile *p, unsigned i)
{
    auto *w = static_cast<World *>(world);
    btRigidBody *body = w->bodies[i];
    w->dynamics->removeRigidBody(body);
    delete body->getCollisionShape();
    delete body;
    w->bodies[i] = add(w, p->given + i);
}
} // namespace

int main(int argc, char **argv)
{
    pile p = pile_read(argc, argv);
    Simulation simulation(p.threads);
    simulation.dynamics->setGravity(btVector3(0, 0, p.gravity));
    World w = {simulation.dynamics.get(), &p, {}};
    pile_each_wall(&p, add_wall, &w);
    for (unsigned i = 0; i < p.n; ++i)
        w.bodies.push_back(add(&w, p.bodies + i));

    const pile_engine engine = {step, read, renew};
    pile_run(&p, &engine, &w);

    unsigned awake = 0;
    for (unsigned i = 0; i < p.n; ++i)
        awake += p.bodies[i].mass > 0 && w.bodies[i]->isActive();
    char name[64];
    snprintf(name, sizeof name, "Bullet %d.%02d", btGetVersion() / 100, btGetVersion() % 100);
    pile_end(&p, name, awake);
    fflush(nullptr);
    _Exit(0);
}
