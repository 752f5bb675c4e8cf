// A scene of tests/bench/bench_engines.py in Jolt, on one thread. Usage: jolt_scene SCENE OUT TICK...
#include <Jolt/Jolt.h>
// Needs the header above.
#include <Jolt/Core/Factory.h>
#include <Jolt/Core/JobSystemSingleThreaded.h>
#include <Jolt/Core/TempAllocator.h>
#include <Jolt/Physics/Body/BodyCreationSettings.h>
#include <Jolt/Physics/Collision/GroupFilterTable.h>
#include <Jolt/Physics/Collision/Shape/BoxShape.h>
#include <Jolt/Physics/Constraints/HingeConstraint.h>
#include <Jolt/Physics/PhysicsSystem.h>
#include <Jolt/RegisterTypes.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <string>
#include <vector>

namespace {

using namespace JPH;

double cpu_now() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

constexpr ObjectLayer kStill = 0, kMoving = 1;

class Layers final : public BroadPhaseLayerInterface {
  public:
    uint GetNumBroadPhaseLayers() const override { return 2; }
    BroadPhaseLayer GetBroadPhaseLayer(ObjectLayer layer) const override { return BroadPhaseLayer(static_cast<uint8>(layer)); }
#if defined(JPH_EXTERNAL_PROFILE) || defined(JPH_PROFILE_ENABLED)
    const char* GetBroadPhaseLayerName(BroadPhaseLayer) const override { return "layer"; }
#endif
};
class WithLayers final : public ObjectVsBroadPhaseLayerFilter {
  public:
    bool ShouldCollide(ObjectLayer one, BroadPhaseLayer other) const override {
        return one == kMoving || other == BroadPhaseLayer(static_cast<uint8>(kMoving));
    }
};
class WithObjects final : public ObjectLayerPairFilter {
  public:
    bool ShouldCollide(ObjectLayer one, ObjectLayer other) const override { return one == kMoving || other == kMoving; }
};

constexpr float kRounding = 0.02F;

}  // namespace

int main(int argc, char** argv) {
    if (argc < 4) return 2;
    RegisterDefaultAllocator();
    Factory::sInstance = new Factory();
    RegisterTypes();
    Layers layers;
    WithLayers with_layers;
    WithObjects with_objects;
    PhysicsSystem system;
    system.Init(65'536, 0, 1'000'000, 500'000, layers, with_layers, with_objects);
    TempAllocatorImpl memory(1'000'000'000);
    JobSystemSingleThreaded jobs(cMaxPhysicsJobs);
    BodyInterface& interface = system.GetBodyInterface();

    std::ifstream scene(argv[1]);
    std::string what;
    float step = 0, friction = 0;
    std::vector<BodyID> bodies;
    const auto vec = [&] {
        float x = 0, y = 0, z = 0;
        scene >> x >> y >> z;
        return Vec3(x, y, z);
    };
    const RefConst<Shape> cube = new BoxShape(Vec3::sReplicate(0.5F), kRounding);
    Ref<GroupFilterTable> not_with_each_other = new GroupFilterTable(2);
    not_with_each_other->DisableCollision(0, 1);
    while (scene >> what) {
        if (what == "step") {
            scene >> step;
        } else if (what == "gravity") {
            float down = 0;
            scene >> down;
            system.SetGravity(Vec3(0, 0, -down));
        } else if (what == "friction") {
            scene >> friction;
        } else if (what == "plane") {
            // A thick box, since not every version has planes.
            const Vec3 normal = vec();
            float offset = 0;
            scene >> offset;
            const Vec3 half = Vec3::sReplicate(200) - 190 * normal.Abs();
            BodyCreationSettings settings(new BoxShape(half), (offset - 10) * normal, Quat::sIdentity(), EMotionType::Static, kStill);
            settings.mFriction = friction;
            interface.CreateAndAddBody(settings, EActivation::DontActivate);
        } else if (what == "body") {
            const Vec3 at = vec();
            float w = 1;
            scene >> w;
            const Vec3 turn = vec(), velocity = vec(), spin = vec();
            BodyCreationSettings settings(cube, at, Quat(Vec4(turn, w)).Normalized(), EMotionType::Dynamic, kMoving);
            settings.mFriction = friction;
            settings.mAllowSleeping = false;
            settings.mLinearDamping = settings.mAngularDamping = 0;
            settings.mOverrideMassProperties = EOverrideMassProperties::CalculateInertia;
            settings.mMassPropertiesOverride.mMass = 1;
            settings.mLinearVelocity = velocity;
            settings.mAngularVelocity = spin;
            bodies.push_back(interface.CreateAndAddBody(settings, EActivation::Activate));
        } else if (what == "hinge") {
            std::size_t first = 0, second = 0;
            scene >> first >> second;
            HingeConstraintSettings settings;
            settings.mPoint1 = settings.mPoint2 = vec();
            settings.mHingeAxis1 = settings.mHingeAxis2 = vec();
            settings.mNormalAxis1 = settings.mNormalAxis2 = settings.mHingeAxis1.GetNormalizedPerpendicular();
            system.AddConstraint(interface.CreateConstraint(&settings, bodies[first], bodies[second]));
            for (const std::size_t i : {first, second}) {
                BodyLockWrite lock(system.GetBodyLockInterface(), bodies[i]);
                lock.GetBody().SetCollisionGroup(CollisionGroup(not_with_each_other, static_cast<uint32>(first), i == first ? 0 : 1));
            }
        }
    }
    system.OptimizeBroadPhase();

    std::FILE* out = std::fopen(argv[2], "w");
    const PhysicsSettings& settings = system.GetPhysicsSettings();
    std::fprintf(out, "rounding %g inertia 0.16666667 Jolt %d.%d.%d, %u + %u iterations\n", static_cast<double>(kRounding),
                 JPH_VERSION_MAJOR, JPH_VERSION_MINOR, JPH_VERSION_PATCH, settings.mNumVelocitySteps, settings.mNumPositionSteps);
    int done = 0;
    for (int i = 3; i < argc; ++i) {
        const int tick = std::atoi(argv[i]);
        const double before = cpu_now();
        for (int t = done; t < tick; ++t)
            if (system.Update(step, 1, &memory, &jobs) != EPhysicsUpdateError::None) return 1;
        std::fprintf(out, "tick %d %g\n", tick, 1e3 * (cpu_now() - before) / (tick > done ? tick - done : 1));
        done = tick;
        for (const BodyID& id : bodies) {
            const Vec3 at = interface.GetPosition(id), velocity = interface.GetLinearVelocity(id), spin = interface.GetAngularVelocity(id);
            const Quat turn = interface.GetRotation(id);
            const float numbers[] = {at.GetX(),       at.GetY(),       at.GetZ(),       turn.GetW(), turn.GetX(), turn.GetY(), turn.GetZ(),
                                     velocity.GetX(), velocity.GetY(), velocity.GetZ(), spin.GetX(), spin.GetY(), spin.GetZ()};
            for (const float number : numbers) std::fprintf(out, "%.9g ", static_cast<double>(number));
            std::fputc('\n', out);
        }
    }
    std::fclose(out);
    return 0;
}
