// SPDX-License-Identifier: MIT
// A pile in Jolt Physics.
#include <Jolt/Jolt.h>

#include <Jolt/Core/Factory.h>
#include <Jolt/Core/JobSystemSingleThreaded.h>
#include <Jolt/Core/JobSystemThreadPool.h>
#include <Jolt/Core/TempAllocator.h>
#include <Jolt/Physics/Body/BodyCreationSettings.h>
#include <Jolt/Physics/Collision/Shape/BoxShape.h>
#include <Jolt/Physics/Collision/Shape/CapsuleShape.h>
#include <Jolt/Physics/Collision/Shape/RotatedTranslatedShape.h>
#include <Jolt/Physics/Collision/Shape/SphereShape.h>
#include <Jolt/Physics/PhysicsSystem.h>
#include <Jolt/RegisterTypes.h>

#include "pile.h"

#include <algorithm>
#include <memory>
#include <vector>

namespace
{
enum : JPH::ObjectLayer { still, moving, n_layers };

struct Layers final : JPH::BroadPhaseLayerInterface {
    JPH::uint GetNumBroadPhaseLayers() const override
    {
        return n_layers;
    }
    JPH::BroadPhaseLayer GetBroadPhaseLayer(JPH::ObjectLayer layer) const override
    {
        return JPH::BroadPhaseLayer(static_cast<JPH::uint8>(layer));
    }
};

struct MeetsLayer final : JPH::ObjectVsBroadPhaseLayerFilter {
    bool ShouldCollide(JPH::ObjectLayer a, JPH::BroadPhaseLayer b) const override
    {
        return a == moving || b == JPH::BroadPhaseLayer(moving);
    }
};

struct Meets final : JPH::ObjectLayerPairFilter {
    bool ShouldCollide(JPH::ObjectLayer a, JPH::ObjectLayer b) const override
    {
        return a == moving || b == moving;
    }
};

struct World {
    JPH::PhysicsSystem *system;
    const pile *p;
    JPH::TempAllocator *memory;
    JPH::JobSystem *jobs;
    std::vector<JPH::BodyID> ids;
};

JPH::Ref<JPH::Shape> shape_of(const pile_body *b)
{
    using namespace JPH;
    const float *h = b->half;
    if (b->radius == 0) {
        float least = std::min({h[0], h[1], h[2]});
        return new BoxShape(Vec3(h[0], h[1], h[2]), std::min(cDefaultConvexRadius, 0.5f * least));
    }
    if (pile_is_rounded_box(b))
        return new BoxShape(Vec3(h[0], h[1], h[2]) + Vec3::sReplicate(b->radius), b->radius);
    float length = h[0] + h[1] + h[2];
    if (length == 0)
        return new SphereShape(b->radius);
    Quat along =
        Quat::sFromTo(Vec3::sAxisY(), Vec3(h[0], h[1], h[2]) / length); // Jolt's lie along y
    return new RotatedTranslatedShape(Vec3::sZero(), along, new CapsuleShape(length, b->radius));
}

JPH::BodyID add(World *w, const pile_body *b)
{
    using namespace JPH;
    const float *c = b->centre, *q = b->rotation, *v = b->velocity;
    bool moves = b->mass > 0;
    BodyCreationSettings body(
        shape_of(b), RVec3(c[0], c[1], c[2]), Quat(q[0], q[1], q[2], q[3]).Normalized(),
        moves ? EMotionType::Dynamic : EMotionType::Static, moves ? moving : still);
    body.mFriction = w->p->friction;
    body.mRestitution = w->p->restitution;
    body.mAngularVelocity = Vec3(b->spin[0], b->spin[1], b->spin[2]);
    body.mMaxAngularVelocity = 1e3f;
    if (w->p->continuous)
        body.mMotionQuality = EMotionQuality::LinearCast;
    body.mLinearDamping = body.mAngularDamping = 0;
    body.mLinearVelocity = Vec3(v[0], v[1], v[2]);
    body.mAllowSleeping = w->p->sleep;
    body.mOverrideMassProperties = EOverrideMassProperties::CalculateInertia;
    body.mMassPropertiesOverride.mMass = moves ? b->mass : 1;
    return w->system->GetBodyInterface().CreateAndAddBody(body, moves ? EActivation::Activate
                                                                      : EActivation::DontActivate);
}

void add_wall(void *w, const pile_body *wall)
{
    add(static_cast<World *>(w), wall);
}

void step(void *world, const pile *p)
{
    auto *w = static_cast<World *>(world);
    pile_need(w->system->Update(p->dt, 1, w->memory, w->jobs) == JPH::EPhysicsUpdateError::None,
              "a step of Jolt failed");
}

void read(void *world, pile *p)
{
    auto *w = static_cast<World *>(world);
    for (unsigned i = 0; i < p->n; ++i) {
        JPH::RVec3 at = w->system->GetBodyInterface().GetCenterOfMassPosition(w->ids[i]);
        JPH::Quat q = w->system->GetBodyInterface().GetRotation(w->ids[i]);
        JPH::Vec3 v, s;
        w->system->GetBodyInterface().GetLinearAndAngularVelocity(w->ids[i], v, s);
        for (unsigned k = 0; k < 3; ++k) {
            p->bodies[i].centre[k] = static_cast<float>(at[k]);
            p->bodies[i].velocity[k] = v[k];
            p->bodies[i].spin[k] = s[k];
        }
        for (unsigned k = 0; k < 4; ++k)
            p->bodies[i].rotation[k] = q.GetXYZW()[k];
    }
}

void renew(void *world, const pile *p, unsigned i)
{
    auto *w = static_cast<World *>(world);
    w->system->GetBodyInterface().RemoveBody(w->ids[i]);
    w->system->GetBodyInterface().DestroyBody(w->ids[i]);
    w->ids[i] = add(w, p->given + i);
}

// The thread that steps does jobs too.
std::unique_ptr<JPH::JobSystem> make_jobs(unsigned threads)
{
    using namespace JPH;
    if (threads == 1)
        return std::make_unique<JobSystemSingleThreaded>(cMaxPhysicsJobs);
    return std::make_unique<JobSystemThreadPool>(cMaxPhysicsJobs, cMaxPhysicsBarriers,
                                                 static_cast<int>(threads) - 1);
}
} // namespace

int main(int argc, char **argv)
{
    using namespace JPH;
    pile p = pile_read(argc, argv);
    RegisterDefaultAllocator();
    Factory::sInstance = new Factory;
    RegisterTypes();
    TempAllocatorImpl memory(1u << 30);
    std::unique_ptr<JobSystem> jobs = make_jobs(p.threads);
    Layers layers;
    MeetsLayer meets_layer;
    Meets meets;
    PhysicsSystem system;
    system.Init(p.n + 64, 0, 16 * p.n + 4096, 12 * p.n + 4096, layers, meets_layer, meets);
    system.SetGravity(Vec3(0, 0, p.gravity));
    World w = {&system, &p, &memory, jobs.get(), {}};
    pile_each_wall(&p, add_wall, &w);
    for (unsigned i = 0; i < p.n; ++i)
        w.ids.push_back(add(&w, p.bodies + i));
    system.OptimizeBroadPhase();

    const pile_engine engine = {step, read, renew};
    pile_run(&p, &engine, &w);

    char name[64];
    snprintf(name, sizeof name, "Jolt %d.%d.%d", JPH_VERSION_MAJOR, JPH_VERSION_MINOR,
             JPH_VERSION_PATCH);
    pile_end(&p, name, system.GetNumActiveBodies(EBodyType::RigidBody));
    fflush(nullptr);
    _Exit(0);
}
