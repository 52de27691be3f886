// Contract 1 on the whole servo: ingest, cycle, devices and publication run under the detectors while the scene, the
// clients and the safety state change around them.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <iostream>
#include <limits>
#include <string>
#include <thread>
#include <utility>

#include "daemon/builder/build.h"
#include "daemon/ipc/snapshot_memory.h"
#include "rt/cycle/realtime.h"
#include "tests/support/detectors.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/shape/test_surface.h"
#include "tests/support/stepped/house.h"
#include "tests/unit/builder/meshes.h"

namespace hapticd {
namespace {

using test::House;

constexpr int kCycles = 10'000;
constexpr int kWarmUp = 100;

/** Runs `change` every 100 cycles outside the scope, the cycles inside it. */
void expectClean(const std::function<void(House&, int)>& change,
                 const std::string& uri = "sim://default?motion=circle") {
  House house(uri);
  test::RtViolations seen;
  bool trapped = false;
  std::thread([&] {
    disableDenormals();
    prefaultStack(128 * 1024);
    // Both passes run the same code; the first brings in pages.
    for (int i = 0; i < kWarmUp; ++i) {
      change(house, i);
      house.step();
    }
    // As the daemon does after its start; without it the kernel may take pages back and give faults of its own.
    const auto locked = lockMemory();
    if (!locked) std::cout << "memory is not locked: " << toString(locked.error()) << '\n';
    trapped = test::trapSystemCalls();
    for (int i = 0; i < kCycles && seen == test::RtViolations{}; i += 100) {
      change(house, kWarmUp + i);
      test::RtScope scope;
      for (int k = 0; k < 100; ++k) house.step();
      seen = scope.finish();
    }
  }).join();
  EXPECT_TRUE(trapped);
  EXPECT_EQ(seen, test::RtViolations{});
  EXPECT_GE(house.servo->counters.cycles.load(), static_cast<std::uint64_t>(kCycles));
}

TEST(ServoCycle, IsCleanAtRest) {
  expectClean([](House&, int) {});
}

TEST(ServoCycle, IsCleanInContact) {
  double most = 0;
  expectClean(
      [&most](House& house, int) { most = std::max(most, house.servo->lastOutput().device[0].command.force.norm()); },
      "sim://default?motion=tap&centre=0,0,0.005&direction=0,0,-1&depth=0.015&period=0.5&hand_stiffness=400");
  EXPECT_GT(most, 0.5) << "the test must press on something";
}

TEST(ServoCycle, IsCleanWhileItIsRecorded) {
  // Of the size the recorder makes it; drained now and then as the recorder does, and full in between.
  const auto log = std::make_unique<CycleLog>();
  LoggedCycle cycle;
  std::array<Command, kMaxCommandsPerCycle> commands;
  std::uint64_t taken = 0;
  expectClean([&](House& house, int i) {
    house.servo->log = log.get();
    const hd_object_pose pose = poseMessage(makeObjectId(2, 1), {});
    for (int k = 0; k < 16; ++k) house.push(HD_COMMAND_OBJECT_POSE, pose);
    if (i < 6000) {
      while (log->pop(cycle, commands)) ++taken;
    }
  });
  EXPECT_GT(taken, 5000u);
  EXPECT_GT(log->lost(), 0u) << "a full log has to be seen as well";
}

TEST(ServoCycle, IsCleanWhileObjectsMove) {
  expectClean([](House& house, int i) {
    const Pose X{{0, 0, 0.001 * (i % 7)}, Quat::Identity()};
    house.push(HD_COMMAND_OBJECT_POSE, poseMessage(makeObjectId(2, 1), X, {Vec3::Zero(), Vec3::UnitZ()}));
  });
}

TEST(ServoCycle, IsCleanWhileObjectsComeAndGo) {
  expectClean([](House& house, int i) {
    const std::uint32_t id = makeObjectId(9, static_cast<std::uint32_t>(i / 2) + 1);
    house.order(CommandKind::kAddObject, test::solid(id, ShapeKind::kSphere, {500, 0, 0, 0}, {}, {0.03, 0, 0}));
    house.order(CommandKind::kRemoveObject, ObjectRef{id});
  });
}

/** A deformable sphere of at least `triangles`, built, checked and locked as the daemon does it. */
SnapshotMemory sphereMesh(std::uint32_t triangles) {
  std::uint32_t stacks = 3;
  while (4 * stacks * (stacks - 1) < triangles) ++stacks;
  const test::TestMesh sphere = test::sphereMesh(0.03, stacks);
  BuildMonitor monitor;
  auto built = buildSnapshot(test::upload({sphere.vertices, sphere.triangles}, HD_MESH_DEFORMABLE), monitor);
  EXPECT_TRUE(built.ok()) << toString(built.error());
  auto memory = openSnapshot(std::move(*built->memfd.share()), true);
  EXPECT_TRUE(memory.ok()) << toString(memory.error());
  return std::move(*memory);
}

AddObject meshObject(std::uint32_t id, std::uint32_t mesh) {
  AddObject object = test::solid(id, ShapeKind::kMesh, {800, 1, 0.5, 0.3}, {{0, 0, -0.01}, Quat::Identity()});
  object.shape.mesh = mesh;
  return object;
}

TEST(ServoCycle, IsCleanWhileMeshesAreLoadedSwappedAndDropped) {
  SnapshotMemory meshes[2] = {sphereMesh(2000), sphereMesh(10'000)};
  expectClean([&meshes](House& house, int i) {
    const auto mesh = static_cast<std::uint32_t>(i / 100) % 2;
    const std::uint32_t id = makeObjectId(20, static_cast<std::uint32_t>(i / 200) + 1);
    house.meshes.publish(mesh, &meshes[mesh].view);
    if (mesh == 0) {
      house.order(CommandKind::kAddObject, meshObject(id, mesh));
    } else {
      house.order(CommandKind::kSetShape, SetShape{id, 0, {static_cast<std::uint32_t>(ShapeKind::kMesh), mesh, {}}});
      for (int k = 0; k < 50; ++k) house.step();
      house.order(CommandKind::kRemoveObject, ObjectRef{id});
    }
  });
}

TEST(ServoCycle, IsCleanWhileVerticesMove) {
  SnapshotMemory mesh = sphereMesh(5000);
  bool added = false;
  expectClean([&](House& house, int i) {
    if (!added) {
      house.meshes.publish(0, &mesh.view);
      house.order(CommandKind::kAddObject, meshObject(makeObjectId(20, 1), 0));
      added = true;
    }
    hd_object_vertices vertices{};
    vertices.object = makeObjectId(20, 1);
    vertices.count = HD_VERTEX_MOVES;
    for (std::uint32_t k = 0; k < vertices.count; ++k) {
      vertices.move[k] = {(static_cast<std::uint32_t>(i) * 31 + k * 7) % 2000, {0.001f * k, 0.01f, -0.02f}};
    }
    house.push(HD_COMMAND_OBJECT_VERTICES, vertices);
  });
}

TEST(ServoCycle, IsCleanWithTexturedSurfaces) {
  SnapshotMemory mesh = sphereMesh(2000);
  const test::TestRelief relief(64, 64, [](auto x, auto y) { return 0.5 + 0.5 * std::sin(0.7 * x) * std::cos(y); });
  test::TestVibration vibration;
  vibration.models = {{0.02, 0.2, 4, {-0.9, 0.5}}, {0.3, 0.2, 9, {0.3}}, {0.02, 3, 16, {-0.2, 0.1}}};
  vibration.triangles = {{0, 1, 2}};
  vibration.finish();
  expectClean([&](House& house, int i) {
    if (i == 0) {
      house.meshes.publish(0, &mesh.view);
      house.meshes.publishTexture(0, &relief.view);
      house.meshes.publishTexture(1, &vibration.view);
      house.order(CommandKind::kAddObject, meshObject(makeObjectId(20, 1), 0));
    }
    for (const std::uint32_t slot : {1u, 2u, 3u, 4u, 5u, 20u}) {
      SetSurface order{makeObjectId(slot, 1), 0, test::ringing(20, 150, 0.01)};
      order.surface.smooth_cosine = 0.7;
      order.surface.relief = 1;
      order.surface.relief_depth = 2e-4;
      order.surface.relief_size[0] = order.surface.relief_size[1] = 0.02;
      order.surface.vibration = (i / 100) % 2 == 0 ? 2 : 0;
      order.surface.vibration_mass = 0.05;
      house.order(CommandKind::kSetSurface, order);
    }
  });
}

TEST(ServoCycle, IsCleanWithEffects) {
  SnapshotMemory mesh = sphereMesh(2000);
  bool felt = false;
  expectClean([&](House& house, int i) {
    if (i == 0) {
      house.meshes.publish(0, &mesh.view);
      house.order(CommandKind::kAddObject, meshObject(makeObjectId(20, 1), 0));
    }
    for (const std::uint32_t slot : {1u, 2u, 3u, 4u, 5u, 20u}) {
      SetEffect order{makeObjectId(slot, 1), 0, {}};
      EffectParameters& e = order.effect;
      e.kind = (slot + static_cast<std::uint32_t>(i) / 100) % 6;
      e.force = 0.5;
      e.stiffness = 100;
      e.damping = 1;
      e.reach = 0.1;
      e.frequency = 100;
      e.points = slot == 3 ? kMaxPathPoints : 0;
      for (std::uint32_t k = 0; k < e.points; ++k) e.path[k][k % 3] = 0.001f * static_cast<float>(k);
      house.order(CommandKind::kSetEffect, order);
    }
    felt = felt || house.servo->lastOutput().device[0].guard.by_source[HD_SOURCE_EFFECT].norm() > 0.1;
  });
  EXPECT_TRUE(felt);
}

TEST(ServoCycle, IsCleanWithASoftFinger) {
  int twisted = 0, turning = 0;
  expectClean(
      [&](House& house, int i) {
        const auto turn = static_cast<std::uint32_t>(i / 100);
        house.order(CommandKind::kSetFinger, SetFinger{0, 1 + turn % 5, turn / 5 % 2, 1, 5.8e-3, 6.2e-3, 0.1, 2, 2});
        house.push(HD_COMMAND_OBJECT_POSE, poseMessage(makeObjectId(1, 1), {}, {Vec3::Zero(), 3 * Vec3::UnitZ()}));
        twisted += house.servo->cycle().finger(0).twist() != 0 ? 1 : 0;
        turning += house.servo->cycle().finger(0).turning() ? 1 : 0;
      },
      "sim://default?motion=tap&centre=0,0,0.005&direction=0,0,-1&depth=0.015&period=0.5&hand_stiffness=400");
  EXPECT_GT(twisted, 10);
  EXPECT_GT(turning, 0);
}

TEST(ServoCycle, IsCleanWhileTheHandIsTakenOffItsPoint) {
  int off = 0;
  expectClean([&off](House& house, int i) {
    house.order(CommandKind::kSetClutch, SetClutch{0, static_cast<std::uint32_t>(i / 200 % 2), 0, 0, {}});
    off += house.servo->cycle().clutch(0).frozen() ? 1 : 0;
  });
  EXPECT_GT(off, 20);
}

TEST(ServoCycle, IsCleanWithLocalModels) {
  expectClean([](House& house, int i) {
    hd_local_model model{};
    model.slot = static_cast<std::uint32_t>(i) % HD_MODEL_SLOTS;
    model.kind = 1 + static_cast<std::uint32_t>(i / 100) % 4;
    model.lease_ns = 50'000'000;
    model.blend_ns = 10'000'000;
    model.material = {500, 1, 0.5, 0.3};
    model.normal[2] = 1;
    model.radius = 0.02;
    model.count = 16;
    for (auto& halfspace : model.halfspace) halfspace[2] = 1;
    house.push(HD_COMMAND_LOCAL_MODEL, model);
    hd_client_force force{};
    force.lease_ns = 20'000'000;
    force.force[0] = 0.5;
    house.push(HD_COMMAND_CLIENT_FORCE, force);
  });
}

TEST(ServoCycle, IsCleanWhileClientsAreBornAndDie) {
  expectClean([](House& house, int i) {
    switch ((i / 100) % 3) {
      case 0:
        house.attach(1);
        break;
      case 1:
        house.detach(1);
        break;
      default:
        house.order(CommandKind::kFreeSession, SessionRef{1, 0, 2});
        break;
    }
  });
}

TEST(ServoCycle, IsCleanThroughFaultAndRearm) {
  expectClean([](House& house, int i) {
    const bool stop = (i / 100) % 2 == 0;
    house.servo->stop_line.store(stop);
    if (!stop) house.order(CommandKind::kArm, DeviceRef{0});
  });
}

TEST(ServoCycle, IsCleanUnderGarbage) {
  expectClean([](House& house, int i) {
    hd_local_model model{};
    model.slot = static_cast<std::uint32_t>(i) * 77u;
    model.material.stiffness = std::numeric_limits<double>::quiet_NaN();
    house.push(HD_COMMAND_LOCAL_MODEL, model);
    hd_object_pose pose{};
    pose.object = 0xffffffffu;
    house.push(HD_COMMAND_OBJECT_POSE, pose);
    house.push(static_cast<std::uint32_t>(i), pose);
  });
}

}  // namespace
}  // namespace hapticd
