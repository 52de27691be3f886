/** @file
 * Solids side by side, and hands that are read exactly in the plane between them.
 */
#include <gtest/gtest.h>

#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::TestMesh;
using test::TestScene;

const Vec3 kBlock(0x1p-6, 0x1p-6, 0x1p-7);  // Exact in single precision: meshes leave no crack.
constexpr double kExactly[] = {0, 1e-18, -1e-18};

/** Two boxes, primitives or meshes, that meet in x = 0; `side` is that of the second one. */
struct Neighbours {
  Neighbours(bool mesh_one, bool mesh_other, int side, double top_one, double top_other)
      : mesh{test::boxMesh(kBlock), test::boxMesh(kBlock)} {
    for (int i = 0; i < 2; ++i) {
      const double top = i == 0 ? top_one : top_other;
      const Pose X{Vec3((i == 0 ? -side : side) * kBlock.x(), 0, top - kBlock.z()), Quat::Identity()};
      if (i == 0 ? mesh_one : mesh_other) {
        t.addMesh(mesh[i].view(), X);
      } else {
        t.add(ShapeKind::kBox, kBlock, X);
      }
    }
  }
  void slide(const Vec3& from, const Vec3& to, int ticks) {
    for (int i = 0; i <= ticks; ++i) t.tick(from + static_cast<double>(i) / ticks * (to - from));
  }

  TestMesh mesh[2];
  TestScene t;
};

TEST(ProxySeam, WhoComesToAStepStaysOnTheLowerBox) {
  for (const int kind : {0, 1, 2, 3}) {
    for (const int side : {1, -1}) {
      for (const double x : kExactly) {
        Neighbours n((kind & 1) != 0, (kind & 2) != 0, side, 0, 0.005);
        n.t.tick(Vec3(-side * 0.01, 0, 0.003));
        n.slide(Vec3(-side * 0.01, 0, -0.001), Vec3(x, 0, -0.001), 100);
        n.slide(Vec3(x, 0, -0.001), Vec3(x, 0, -0.004), 20);
        ASSERT_NEAR(n.t.contact.force.z(), 4.0, 1e-9) << kind << " " << side << " " << x;
        ASSERT_LT(n.t.contact.force.head<2>().norm(), 1e-9);
      }
    }
  }
}

TEST(ProxySeam, WhoComesDownBetweenBoxesIsHeld) {
  for (const int kind : {0, 1, 2, 3}) {
    for (const double x : kExactly) {
      Neighbours n((kind & 1) != 0, (kind & 2) != 0, 1, 0, 0);
      n.slide(Vec3(x, 0, 0.003), Vec3(x, 0, -0.003), 30);
      ASSERT_NEAR(n.t.contact.force.z(), 3.0, 1e-9) << kind << " " << x;
    }
  }
}

/** The wall inside two boxes of one height stops nobody who slides deep; nor, of primitives, in their upper plane. */
TEST(ProxySeam, WhoSlidesOverBoxesOfOneHeightIsNotStopped) {
  for (const int kind : {0, 1, 2, 3}) {
    for (const double z : {0.0, -1e-18, -0.002}) {
      if (kind != 0 && z > -1e-9) continue;
      for (const int side : {1, -1}) {
        Neighbours n((kind & 1) != 0, (kind & 2) != 0, side, 0, 0);
        n.t.tick(Vec3(-0.01, 0, 0.003));
        for (int i = 0; i <= 200; ++i) {
          const double x = -0.01 + 1e-4 * i;
          n.t.tick(Vec3(x, 0, z));
          ASSERT_NEAR(n.t.contact.proxy.x(), x, 1e-9) << kind << " " << z << " " << side;
          ASSERT_NEAR(n.t.contact.force.z(), -1000 * z, 1e-9);
        }
      }
    }
  }
}

TEST(ProxySeam, ABoxEndsAtAWallWithoutACrack) {
  for (const bool mesh : {false, true}) {
    TestMesh box = test::boxMesh(kBlock);
    TestScene t;
    const Pose X{Vec3(-kBlock.x(), 0, -kBlock.z()), Quat::Identity()};
    if (mesh) {
      t.addMesh(box.view(), X);
    } else {
      t.add(ShapeKind::kBox, kBlock, X);
    }
    t.add(ShapeKind::kPlane, Vec3::Zero(),
          {Vec3::Zero(), Quat::FromTwoVectors(Vec3::UnitZ(), Vec3(-1, 0, 0))});  // The air is where x < 0.
    t.tick(Vec3(-0.01, 0, 0.003));
    for (int i = 0; i <= 100; ++i) t.tick(Vec3(-1e-4 * (100 - i), 0, -0.001));
    for (int i = 0; i <= 20; ++i) t.tick(Vec3(0, 0, -0.001 - 1e-4 * i));
    EXPECT_NEAR(t.contact.force.z(), 3.0, 1e-6) << mesh;
  }
}

}  // namespace
}  // namespace hapticd
