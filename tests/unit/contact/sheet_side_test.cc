// Which side of an open mesh a tool is on, once one of them has been put elsewhere.
#include <gtest/gtest.h>

#include <memory>

#include "rt/collide/scene_contacts.h"
#include "tests/support/shape/test_mesh.h"

namespace hapticd {
namespace {

/** A ball of 2 mm radius that came from above, and hangs 1 mm below a sheet that it was pressed through. */
struct PressedThrough {
  PressedThrough() {
    held.object = makeObjectId(9, 1);
    held.shape = Shape{ShapeKind::kSphere, Vec3(0.002, 0, 0)};
    held.count = 1;
    held.obstacle[0].slot = 7;
    held.obstacle[0].shape = Shape{ShapeKind::kMesh, Vec3::Zero(), sheet.view(), 40};
    for (const double z : {0.003, 0.001, -0.0002}) (void)up({0.001, 0.001, z});
    EXPECT_GT(up({0.001, 0.001, -0.001}), 0.99) << "the side that it came from counts";
  }
  /** Which way the ball is pushed, there; 0: none. */
  double up(const Vec3& p) {
    held.X_WO.p = p;
    ContactModel model;
    DetectorReport report;
    contacts->find(held, 0, {1'000'000, 0, nullptr}, model, report);
    const Pose& X_WB = held.obstacle[0].X_WO;
    return model.count == 0 ? 0 : model.touch(0, held.X_WO, held.X_WO.p, X_WB, {}).n.z();
  }

  test::TestMesh sheet = test::heightMesh(0.05, 8, [](double, double) { return 0.0; });
  CollideRequest::Held held;
  std::unique_ptr<SceneContacts> contacts = std::make_unique<SceneContacts>();
};

TEST(SheetSide, AToolThatIsPutElsewhereIsOnTheSideWhereItWasPut) {
  PressedThrough stays;
  EXPECT_GT(stays.up({0.002, 0.001, -0.001}), 0.99) << "moved";
  PressedThrough jumps;
  jumps.held.arrived = 12;
  EXPECT_LT(jumps.up({0.002, 0.001, -0.001}), -0.99);
  PressedThrough fast;
  EXPECT_GT(fast.up({0.031, 0.001, -0.001}), 0.99) << "moved as well, for nobody has put it there";
}

TEST(SheetSide, ASheetThatIsPutElsewhereHasTheToolOnTheSideWhereThatIs) {
  PressedThrough jumps;
  jumps.held.obstacle[0].arrived = 12;
  EXPECT_LT(jumps.up({0.001, 0.001, -0.001}), -0.99);
  PressedThrough fast;
  fast.held.obstacle[0].X_WO.p.x() = 0.03;
  EXPECT_GT(fast.up({0.001, 0.001, -0.001}), 0.99);
}

TEST(SheetSide, AnotherSheetInTheSamePlaceHasNotBeenGoneThrough) {
  PressedThrough other;
  other.held.obstacle[0].shape.number = 3;
  EXPECT_LT(other.up({0.001, 0.001, -0.001}), -0.99);
}

}  // namespace
}  // namespace hapticd
