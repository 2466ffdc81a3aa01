// SPDX-License-Identifier: MIT
// A pile in Jolt Physics.
#include <Jolt/Jolt.h>

#include <Jolt/Core/Factory.h>
#include <Jolt/Core/JobSystemSingleThreaded.h>
#include <Jolt/Core/TempAllocator.h>
#include <Jolt/Physics/Body/BodyCreationSettings.h>
#include <Jolt/Physics/Collision/Shape/BoxShape.h>
#include <Jolt/Physics/PhysicsSystem.h>
#include <Jolt/RegisterTypes.h>

#include "pile.h"

#include <algorithm>
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
    float friction;
};

JPH::BodyID add(World *w, const pile_box *box, JPH::EMotionType type)
{
    using namespace JPH;
    const float *c = box->centre, *h = box->half, *q = box->rotation;
    float least = std::min({h[0], h[1], h[2]});
    Ref<Shape> shape =
        new BoxShape(Vec3(h[0], h[1], h[2]), std::min(cDefaultConvexRadius, 0.5f * least));
    bool moves = type == EMotionType::Dynamic;
    BodyCreationSettings body(shape, RVec3(c[0], c[1], c[2]),
                              Quat(q[0], q[1], q[2], q[3]).Normalized(), type,
                              moves ? moving : still);
    body.mFriction = w->friction;
    body.mRestitution = 0;
    body.mLinearDamping = body.mAngularDamping = 0;
    body.mOverrideMassProperties = EOverrideMassProperties::CalculateInertia;
    body.mMassPropertiesOverride.mMass = 1;
    return w->system->GetBodyInterface().CreateAndAddBody(body, moves ? EActivation::Activate
                                                                      : EActivation::DontActivate);
}

void add_wall(void *w, const pile_box *box)
{
    add(static_cast<World *>(w), box, JPH::EMotionType::Static);
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
    JobSystemSingleThreaded jobs(cMaxPhysicsJobs);
    Layers layers;
    MeetsLayer meets_layer;
    Meets meets;
    PhysicsSystem system;
    system.Init(p.n + 64, 0, 16 * p.n + 4096, 12 * p.n + 4096, layers, meets_layer, meets);
    system.SetGravity(Vec3(0, 0, p.gravity));
    World w = {&system, p.friction};
    std::vector<BodyID> ids(p.n);
    pile_each_wall(&p, add_wall, &w);
    for (unsigned i = 0; i < p.n; ++i)
        ids[i] = add(&w, p.boxes + i, EMotionType::Dynamic);
    system.OptimizeBroadPhase();

    pile_begin(&p);
    for (unsigned step = 0; step < p.steps; ++step)
        pile_need(system.Update(p.dt, 1, &memory, &jobs) == EPhysicsUpdateError::None,
                  "a step of Jolt failed");
    double ended = pile_clock();

    for (unsigned i = 0; i < p.n; ++i) {
        RVec3 at = system.GetBodyInterface().GetCenterOfMassPosition(ids[i]);
        Quat q = system.GetBodyInterface().GetRotation(ids[i]);
        for (unsigned k = 0; k < 3; ++k)
            p.boxes[i].centre[k] = static_cast<float>(at[k]);
        for (unsigned k = 0; k < 4; ++k)
            p.boxes[i].rotation[k] = q.GetXYZW()[k];
    }
    char name[64];
    snprintf(name, sizeof name, "Jolt %d.%d.%d", JPH_VERSION_MAJOR, JPH_VERSION_MINOR,
             JPH_VERSION_PATCH);
    pile_end(&p, ended, name, system.GetNumActiveBodies(EBodyType::RigidBody));
    fflush(nullptr);
    _Exit(0);
}
