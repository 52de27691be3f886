#include <gtest/gtest.h>

#include "daemon/scene/scene_model.h"
#include "rt/body/rigid_body.h"
#include "tests/unit/daemon/fake_sink.h"

namespace hapticd::test {
namespace {

TEST(SceneBody, HasTheInertiaOfItsShape) {
  constexpr double kR = 0.01, kL = 0.03, kMass = 0.2;
  MeshStore meshes;
  SceneModel scene{meshes};
  FakeSink sink;
  scene.attach(sink);
  const auto made = [&](ShapeKind kind) {
    ObjectSpec spec;
    spec.name = shapeName(kind);
    spec.material = kDefaultMaterial;
    spec.shape = {kind, {kR, kind == ShapeKind::kBox ? kR : kL, kL}, 0};
    EXPECT_TRUE(scene.create(spec, Client{}).ok() && scene.setBody(spec.name, {.mass = kMass}).ok());
    EXPECT_EQ(sink.orders.back().kind, CommandKind::kSetBody);
    const double(&I)[6] = sink.orders.back().as<SetBody>().inertia;
    EXPECT_TRUE(I[3] == 0 && I[4] == 0 && I[5] == 0);
    return Vec3(I[0], I[1], I[2]);
  };
  const MassProperties wanted[] = {MassProperties::ofBall(kMass, kR),
                                   MassProperties::ofBox(kMass, {2 * kR, 2 * kR, 2 * kL}),
                                   MassProperties::ofCapsule(kMass, kR, kL), MassProperties::ofCylinder(kMass, kR, kL)};
  constexpr ShapeKind kKinds[] = {ShapeKind::kSphere, ShapeKind::kBox, ShapeKind::kCapsule, ShapeKind::kCylinder};
  for (int i = 0; i < 4; ++i) {
    const Vec3 I = made(kKinds[i]);
    EXPECT_TRUE(I.isApprox(wanted[i].inertia_O.diagonal())) << shapeName(kKinds[i]) << ": " << I.transpose();
  }
}

}  // namespace
}  // namespace hapticd::test
