// Contract 1 on the collision detectors.
#include <gtest/gtest.h>

#include <memory>

#include "rt/collide/scene_contacts.h"
#include "rt/contact/point_field.h"
#include "rt/contact/sphere_descent.h"
#include "rt/contact/voxmap.h"
#include "tests/support/detectors.h"
#include "tests/support/shape/test_volume.h"

namespace hapticd {
namespace {

/** Turns and goes up and down, near and away, with leaps: every part of a detector has its turn. */
int askOften(Detector& detector, const test::TestVolume& a, const test::TestVolume& b, int queries) {
  static ContactSet contacts;
  int touching = 0;
  DetectorQuery query;
  query.a.volume = &a.view;
  query.b.volume = &b.view;
  for (int i = 0; i < queries; ++i) {
    const double t = 0.05 * i;
    query.a.X_WO_before = query.a.X_WO;
    query.a.X_WO = {Vec3(0.001 * std::sin(t), 0, 0.019 + 0.003 * std::sin(3 * t)),
                    Quat(Eigen::AngleAxisd(t, Vec3(1, 2, 3).normalized()))};
    query.margin = i % 3 == 0 ? 0.0005 : 0;
    query.budget.units = i % 4 == 0 ? 40 : 0;
    query.first_only = i % 5 == 0;
    if (i % 50 == 49) detector.reset();
    detector.find(query, contacts);
    touching += contacts.report.touching > 0 ? 1 : 0;
  }
  return touching;
}

TEST(Detectors, AreCleanOnEveryVectorPath) {
  const test::TestVolume a = test::torusVolume(0.012, 0.004, 0.001);
  const test::TestVolume b = test::boxVolume({0.02, 0.02, 0.015}, 0.001);
  const PointPath best = pointPath();
  std::vector<std::unique_ptr<Detector>> all;
  all.push_back(std::make_unique<PointFieldDetector>(10'000));
  all.push_back(std::make_unique<SphereDescentDetector>());
  all.push_back(std::make_unique<SphereDescentDetector>(SphereDescentOptions{.leaf = SphereLeaf::kFieldValue}));
  all.push_back(std::make_unique<VoxmapDetector>());
  for (const PointPath path : {PointPath::kPortable, PointPath::kAvx2, PointPath::kAvx512}) {
    if (!choosePointPath(path)) continue;
    for (const auto& detector : all) {
      SCOPED_TRACE(detector->name() + (" " + std::string(nameOf(path))));
      int touching = 0;
      test::expectClean([&] { askOften(*detector, a, b, 60); }, [&] { touching = askOften(*detector, a, b, 200); });
      EXPECT_GT(touching, 20) << detector->name();
    }
  }
  ASSERT_TRUE(choosePointPath(best));
}

TEST(SceneContacts, AreCleanByFieldsAheadAndByPoints) {
  // A torus that turns and falls through a box with a volume, one without, and a mesh; fast and slow, with little
  // budget.
  const test::TestVolume torus = test::torusVolume(0.012, 0.004, 0.001);
  const test::TestVolume box = test::boxVolume({0.02, 0.02, 0.002}, 0.001);
  test::TestMesh tool = test::torusMesh(0.012, 0.004, 24, 12), ball = test::sphereMesh(0.01, 40);
  VolumeTable volumes;
  volumes.publish(3, &torus.view);
  volumes.publish(5, &box.view);
  auto contacts = std::make_unique<SceneContacts>();
  contacts->setVolumes(&volumes);
  auto held = std::make_unique<CollideRequest::Held>();
  held->object = makeObjectId(9, 1);
  held->shape = Shape{ShapeKind::kMesh, Vec3::Zero(), tool.view(), 3};
  held->count = 3;
  held->obstacle[0] = {1, Shape{ShapeKind::kMesh, Vec3::Zero(), ball.view(), 5}, {}, {}};
  held->obstacle[1] = {2, Shape{ShapeKind::kBox, Vec3(0.01, 0.01, 0.01)}, {{0.01, 0, 0}, Quat::Identity()}, {}};
  held->obstacle[2] = {3, Shape{ShapeKind::kMesh, Vec3::Zero(), ball.view(), 6}, {{-0.02, 0, 0}, Quat::Identity()}, {}};
  ManualClock clock;
  const auto ask = [&](int queries) {
    int touching = 0;
    for (int i = 0; i < queries; ++i) {
      const double t = 0.05 * i;
      held->X_WO = {Vec3(0.001, 0.002, 0.012 * std::sin(t)), Quat(Eigen::AngleAxisd(t, Vec3(1, 2, 3).normalized()))};
      held->V_WO.v.z() = held->speed = i % 3 * 0.5;
      held->shape.number = static_cast<std::uint64_t>(i / 60);  // Now and then another tool.
      static ContactModel model;
      DetectorReport report;
      contacts->find(*held, 0.003, {i % 4 == 0 ? 500u : 400'000u, i % 5 == 0 ? 1 : 0, &clock}, model, report);
      clock.advance(i % 7 == 0 ? 10 : 0);
      touching += model.count > 0 ? 1 : 0;
    }
    return touching;
  };
  int touching = 0;
  test::expectClean([&] { ask(60); }, [&] { touching = ask(240); });
  EXPECT_GT(touching, 100);
}

}  // namespace
}  // namespace hapticd
