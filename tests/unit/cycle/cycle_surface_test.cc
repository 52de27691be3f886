// Every newton has an owner: what surfaces add is told apart in the published force.
#include <gtest/gtest.h>

#include "rt/cycle/cycle_start.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/shape/test_surface.h"
#include "tests/support/stepped/stepped_cycle.h"
#include "tests/support/time.h"

namespace hapticd {
namespace {

TEST(CycleSurface, TexturesAndTransientsHaveTheirOwnShare) {
  test::SteppedCycle hand(test::openConfig(20));
  const test::TestRelief relief(16, 16, [](auto x, auto) { return x % 2; });
  hand.meshes.publishTexture(3, &relief.view);
  const std::uint32_t plane = makeObjectId(1, 1);
  hand.add(test::solid(plane, ShapeKind::kPlane, {1000, 0, 0, 0}));
  SetSurface surface{plane, 0, test::ringing(10, 150, 0.01)};
  surface.surface.relief = 4;
  surface.surface.relief_depth = 1e-3;
  surface.surface.relief_size[0] = surface.surface.relief_size[1] = 0.02;
  hand.put(CommandKind::kSetSurface, surface);
  hand.arm();

  double texture = 0, transient = 0, contact = 0;
  for (int i = 0; i < 400; ++i) {
    const double z = std::max(-0.003, 0.01 - 1e-4 * i);
    const GuardOutput& guard = hand.at({1e-4 * i, 0, z}).guard;
    Vec3 sum = Vec3::Zero();
    for (const Vec3& part : guard.by_source) sum += part;
    ASSERT_EQ(sum, guard.command.force) << "the shares sum to the force";
    texture = std::max(texture, guard.by_source[HD_SOURCE_TEXTURE].norm());
    transient = std::max(transient, guard.by_source[HD_SOURCE_TRANSIENT].norm());
    contact = std::max(contact, guard.by_source[HD_SOURCE_SURFACE].norm());
    ASSERT_NEAR(guard.by_source[HD_SOURCE_SURFACE].norm(), std::max(0.0, -1000 * z), 1e-6)
        << "what the material makes stays its own";
  }
  EXPECT_NEAR(contact, 3, 1e-6);
  EXPECT_GT(texture, 0.1);
  EXPECT_GT(transient, 0.3) << "the hand came at 0.1 m/s";
}

/** Sheets in a cycle each; their vertices are moved and the hand lies on them. */
struct OnSheet : test::SteppedCycle {
  test::TestMesh sheet;

  explicit OnSheet(const test::TestMesh& like) : sheet(like) { meshes.publish(0, sheet.deformableView()); }
  /** A cycle made anew, as where a recording begins and where it is replayed. */
  void begin() {
    CycleStart start;
    start.orders = {
        makeCommand(CommandKind::kAddObject, test::solid(makeObjectId(1, 1), ShapeKind::kMesh, {1000, 1, 0.5, 0.4}))};
    cycle = makeCycle(start, meshes);
  }
  const SurfaceContact& tick(double x, double z, bool told, const Vec3& hand, std::uint32_t missed = 0) {
    for (std::uint32_t v = 0; told && v < sheet.vertices.size();) {
      auto& moves = put(CommandKind::kObjectVertices, hd_object_vertices{}).as<hd_object_vertices>();
      moves.object = makeObjectId(1, 1);
      for (; v < sheet.vertices.size() && moves.count < HD_VERTEX_MOVES; ++v) {
        const auto& at = sheet.vertices[v];
        moves.move[moves.count++] = {v, {at[0] + static_cast<float>(x), at[1], static_cast<float>(z)}};
      }
    }
    input->missed = missed;
    input->tick += missed;
    input->now_ns += missed * kMs;
    return at(hand).contact;
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
