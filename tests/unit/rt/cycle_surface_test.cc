// Every newton has an owner: what surfaces add is told apart in the published force.
#include <gtest/gtest.h>

#include <memory>

#include "rt/cycle/cycle_start.h"
#include "tests/support/test_mesh.h"
#include "tests/support/test_surface.h"
#include "tests/support/time.h"

namespace hapticd {
namespace {

TEST(CycleSurface, TexturesAndTransientsHaveTheirOwnShare) {
  const auto meshes = std::make_unique<MeshTable>();
  const test::TestRelief relief(16, 16, [](auto x, auto) { return x % 2; });
  meshes->publishTexture(3, &relief.view);
  CycleConfig config;
  config.guard[0].limits = {20, 1, 1e6, 1e3, 1, 10, 50, 50};
  config.guard[0].ramp_ns = kMs;
  const auto cycle = std::make_unique<Cycle>(config, *meshes);
  const auto input = std::make_unique<CycleInput>();
  const auto output = std::make_unique<CycleOutput>();
  const auto put = [&](CommandKind kind, const auto& payload) {
    Command& c = input->command[input->command_count++];
    c = Command{};
    c.kind = kind;
    c.as<std::decay_t<decltype(payload)>>() = payload;
  };
  AddObject plane{};
  plane.object = makeObjectId(1, 1);
  plane.flags = HD_OBJECT_ENABLED;
  plane.shape.kind = static_cast<std::uint32_t>(ShapeKind::kPlane);
  plane.material = {1000, 0, 0, 0};
  plane.q[0] = 1;
  put(CommandKind::kAddObject, plane);
  SetSurface surface{plane.object, 0, test::ringing(10, 150, 0.01)};
  surface.surface.relief = 4;
  surface.surface.relief_depth = 1e-3;
  surface.surface.relief_size[0] = surface.surface.relief_size[1] = 0.02;
  put(CommandKind::kSetSurface, surface);
  put(CommandKind::kArm, DeviceRef{0});

  double texture = 0, transient = 0, contact = 0;
  for (int i = 0; i < 400; ++i) {
    ++input->tick;
    input->now_ns += kMs;
    DeviceSample& sample = input->device[0];
    sample.t_ns = input->now_ns;
    sample.p = {1e-4 * i, 0, std::max(-0.003, 0.01 - 1e-4 * i)};
    sample.fresh = true;
    cycle->step(*input, *output);
    input->command_count = 0;
    const GuardOutput& guard = output->device[0].guard;
    Vec3 sum = Vec3::Zero();
    for (const Vec3& part : guard.by_source) sum += part;
    ASSERT_EQ(sum, guard.command.force) << "the shares sum to the force";
    texture = std::max(texture, guard.by_source[HD_SOURCE_TEXTURE].norm());
    transient = std::max(transient, guard.by_source[HD_SOURCE_TRANSIENT].norm());
    contact = std::max(contact, guard.by_source[HD_SOURCE_SURFACE].norm());
    ASSERT_NEAR(guard.by_source[HD_SOURCE_SURFACE].norm(), std::max(0.0, -1000 * sample.p.z()), 1e-6)
        << "what the material makes stays its own";
  }
  EXPECT_NEAR(contact, 3, 1e-6);
  EXPECT_GT(texture, 0.1);
  EXPECT_GT(transient, 0.3) << "the hand came at 0.1 m/s";
}

/** Sheets in a cycle each; their vertices are moved and the hand lies on them. */
struct OnSheet {
  test::TestMesh sheet;
  MeshView* view;
  MeshTable meshes;
  std::unique_ptr<Cycle> cycle;
  std::unique_ptr<CycleInput> input = std::make_unique<CycleInput>();
  std::unique_ptr<CycleOutput> output = std::make_unique<CycleOutput>();

  explicit OnSheet(const test::TestMesh& like) : sheet(like), view(sheet.deformableView()) { meshes.publish(0, view); }
  /** A cycle made anew, as where a recording begins and where it is replayed. */
  void begin() {
    AddObject add{};
    add.object = makeObjectId(1, 1);
    add.flags = HD_OBJECT_ENABLED;
    add.shape.kind = static_cast<std::uint32_t>(ShapeKind::kMesh);
    add.material = {1000, 1, 0.5, 0.4};
    add.q[0] = 1;
    CycleStart start;
    start.orders.emplace_back();
    start.orders.back().kind = CommandKind::kAddObject;
    start.orders.back().as<AddObject>() = add;
    cycle = makeCycle(start, meshes);
  }
  const SurfaceContact& tick(double x, double z, bool told, const Vec3& hand, std::uint32_t missed = 0) {
    for (std::uint32_t v = 0; told && v < sheet.vertices.size();) {
      Command& c = input->command[input->command_count++] = Command{};
      c.kind = CommandKind::kObjectVertices;
      auto& moves = c.as<hd_object_vertices>();
      moves.object = makeObjectId(1, 1);
      for (; v < sheet.vertices.size() && moves.count < HD_VERTEX_MOVES; ++v) {
        const auto& at = sheet.vertices[v];
        moves.move[moves.count++] = {v, {at[0] + static_cast<float>(x), at[1], static_cast<float>(z)}};
      }
    }
    input->missed = missed;
    input->tick += 1 + missed;
    input->now_ns += (1 + missed) * kMs;
    DeviceSample& sample = input->device[0];
    sample.t_ns = input->now_ns;
    sample.p = hand;
    sample.fresh = true;
    cycle->step(*input, *output);
    input->command_count = 0;
    return output->device[0].contact;
  }
};

/** What vertices did before a cycle was made anew is none of its motion: a replay has not seen it. */
TEST(CycleSurface, ACycleMadeAnewKnowsNoMotionOfVerticesBefore) {
  OnSheet live(test::heightMesh(0.05, 4, [](double, double) { return 0.0; }));
  live.begin();
  for (int i = 1; i <= 300; ++i) live.tick(0, 1e-4 * (i % 20), i % 3 == 0, {1e-3, 2e-3, 0.02});
  OnSheet replay(live.sheet);
  for (OnSheet* each : {&live, &replay}) each->begin();
  int felt = 0;
  for (int i = 1; i <= 500; ++i) {
    const bool told = i < 60 && i % 7 == 0;
    const Vec3 hand(1e-3, 2e-3, i < 5 ? 0.02 : 2e-4);
    const SurfaceContact& one = live.tick(2e-4, 1e-3 + 1e-5 * i, told, hand);
    const SurfaceContact& other = replay.tick(2e-4, 1e-3 + 1e-5 * i, told, hand);
    ASSERT_EQ(one.force, other.force) << i;
    ASSERT_EQ(one.velocity, other.velocity) << i;
    felt += one.object != 0 ? 1 : 0;
  }
  EXPECT_GT(felt, 400);
}

/** A sheet that rises steadily by its vertices goes on doing so through periods that are missed. */
TEST(CycleSurface, ASheetGoesOnRisingThroughMissedPeriods) {
  constexpr double kSpeed = 0.2;
  for (const int pace : {1, 3}) {
    OnSheet rising(test::heightMesh(0.05, 4, [](double, double) { return 0.0; }));
    rising.begin();
    std::int64_t ms = 0;
    for (int i = 0; i < 120; ++i) {
      const std::uint32_t missed = i % 15 == 0 ? static_cast<std::uint32_t>(i / 15) : 0;
      ms += 1 + missed;
      const double z = kSpeed * 1e-3 * static_cast<double>(ms);
      const Vec3 hand(1e-3, 2e-3, z - (i < 5 ? -1e-3 : 1e-3));
      const SurfaceContact& contact = rising.tick(0, z, i > 0 && i % pace == 0, hand, missed);
      if (i < 10) continue;
      ASSERT_EQ(contact.object, makeObjectId(1, 1)) << i;
      ASSERT_NEAR(contact.velocity.z(), kSpeed, 1e-4) << "told each " << pace << ", tick " << i;
    }
  }
}

}  // namespace
}  // namespace hapticd
