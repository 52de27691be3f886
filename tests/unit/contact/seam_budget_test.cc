// What it may cost to look for seams among the contacts of a tool.
#include <gtest/gtest.h>

#include <array>
#include <memory>

#include "rt/base/rotation.h"
#include "rt/collide/scene_contacts.h"
#include "tests/support/random.h"
#include "tests/support/shape/test_mesh.h"

namespace hapticd {
namespace {

/** Runs as the work is done, a nanosecond a unit. */
struct WorkClock final : Clock {
  explicit WorkClock(const DetectorReport& of) : report(of) {}
  std::int64_t now() HD_RT override { return 1 + report.work; }
  void sleepUntil(std::int64_t) HD_RT override {}
  const DetectorReport& report;
};

/** A box on a floor of 16 tiles, each a mesh: its face's points touch one of them, its edges are over the seams. */
struct Tiled {
  Tiled() {
    held.object = makeObjectId(9, 1);
    held.shape = Shape{ShapeKind::kBox, Vec3(0.02, 0.02, 0.005)};
    held.X_WO.p = Vec3(0.0003, 0.0004, 0.005 - 5e-5);
    held.count = CollideRequest::kMostObstacles;
    for (std::uint32_t k = 0; k < held.count; ++k) {
      held.obstacle[k].slot = 7 + k;
      held.obstacle[k].shape = Shape{ShapeKind::kMesh, Vec3::Zero(), tile.view(), 40};
      held.obstacle[k].X_WO.p = Vec3(0.01 * (k % 4) - 0.015, 0.01 * (k / 4) - 0.015, -0.005);
    }
  }
  std::uint32_t ask(const WorkBudget& budget) {
    contacts->find(held, 0, budget, model, report);
    return model.count;
  }
  test::TestMesh tile = test::boxMesh({0.005, 0.005, 0.005});
  CollideRequest::Held held;
  ContactModel model;
  DetectorReport report;
  std::unique_ptr<SceneContacts> contacts = std::make_unique<SceneContacts>();
};

TEST(SeamBudget, ManyContactsWithManyObstaclesEndWithTheTimeToo) {
  Tiled whole;
  ASSERT_GT(whole.ask({1 << 30, 0, nullptr}), 3u);
  const std::uint32_t all = whole.report.work;
  for (std::uint32_t part = 1; part < 20; ++part) {
    Tiled q;
    WorkClock clock(q.report);
    const std::uint32_t end = all / 20 * part;
    (void)q.ask({1 << 30, end, &clock});
    EXPECT_LE(q.report.work, end + 2 * 256) << part << " twentieths of " << all;
  }
}

/** Contacts of a plug on a floor of nine tiles that lead aside, for 40 of its poses. */
int seamsFeltWith(std::uint32_t units) {
  Random random(1);
  int aside = 0;
  for (int i = 0; i < 40; ++i) {
    CollideRequest::Held held;
    held.object = makeObjectId(9, 1);
    held.shape = {ShapeKind::kBox, {0.01, 0.01, 0.03}};
    held.X_WO = {Vec3::Zero(), fromRotationVector(random.vector(0.2))};
    held.count = 9;
    for (std::uint32_t k = 0; k < held.count; ++k) {
      held.obstacle[k].slot = 7 + k;
      held.obstacle[k].shape = {ShapeKind::kBox, {0.01, 0.01, 0.01}};
      held.obstacle[k].X_WO.p = Vec3(0.02 * (k % 3) - 0.02, 0.02 * (k / 3) - 0.02, -0.01);
    }
    held.X_WO.p = random.vector(0.01);
    held.X_WO.p.z() = held.X_WO.q.toRotationMatrix().row(2).cwiseAbs().dot(held.shape.size) - 5e-5;  // It has sunk in.
    SceneContacts contacts;
    ContactModel model;
    DetectorReport report;
    contacts.find(held, 0, {units, 0, nullptr}, model, report);
    EXPECT_EQ(report.exhausted, units > 0);
    EXPECT_GT(model.count, 0u);
    for (std::uint32_t k = 0; k < model.count; ++k) aside += model.touch(k, held.X_WO, held.X_WO.p, {}, {}).n.z() < 0.9;
  }
  return aside;
}

/** Which have been met, all the same: those of an answer that ends among the edges lead aside 22 times as they are. */
TEST(SeamBudget, TilesWhoseEdgesHadNoTimeHideSeams) {
  EXPECT_EQ(seamsFeltWith(0), 0);
  EXPECT_LT(seamsFeltWith(1000), 11);
}

}  // namespace
}  // namespace hapticd
