// A tool's contacts with the scene: fields where both have a volume, nearest points where not, the same answer.
#include "rt/collide/scene_contacts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>

#include "rt/body/constraint_response.h"
#include "rt/body/tool.h"
#include "tests/unit/contact/question.h"

namespace hapticd {
namespace {

using test::kPlateEntry;
using test::kToolEntry;
using test::Question;

TEST(SceneContacts, VolumesTouchByTheirFields) {
  Question q;
  const ContactModel model = q.ask({0.003, 0.001, 0.005 + 0.01 - 0.001});
  ASSERT_GT(model.count, 0u);
  EXPECT_EQ(model.point[0].body(), 7u);
  EXPECT_NEAR(q.deepest(model), 0.001, 3e-5);
  const Touch touch = model.touch(0, q.held.X_WO, q.held.X_WO.p, Pose{}, {});
  EXPECT_NEAR(touch.n.z(), 1, 1e-3);
  EXPECT_EQ(q.ask({0, 0, 0.03}).count, 0u) << "out of reach";
}

TEST(SceneContacts, AFastToolIsStoppedByAThinPlate) {
  Question q;
  test::TestVolume thin = test::boxVolume({0.02, 0.02, 0.001}, 0.0005);
  q.volumes.publish(kPlateEntry, &thin.view);
  (void)q.ask({0, 0, 0.0115});
  const ContactModel through = q.ask({0, 0, 0.0065});  // 5 mm in a question's time; the plate is 2 mm thick
  ASSERT_GT(through.count, 0u);
  const Touch touch = through.touch(0, q.held.X_WO, q.held.X_WO.p, Pose{}, {});
  EXPECT_GT(touch.n.z(), 0.9) << "pushed back to where it came from";
}

TEST(SceneContacts, AFastToolIsToldOfWhatItWillMeetBeforeItDoes) {
  // 4 mm above a plate that is thinner than the way that lies ahead, and far beyond the field's margin of a voxel.
  const double ahead = 0.003;
  const test::TestVolume thin = test::boxVolume({0.02, 0.02, 0.0005}, 0.0005);
  const Quat tilted(Eigen::AngleAxisd(0.7, Vec3(0.6, 0, 0.8)));
  for (const bool plate_moves : {false, true}) {
    Question q;
    q.volumes.publish(kPlateEntry, &thin.view);
    const Pose X_WB{{0.2, -0.1, 0.3}, tilted};
    q.held.obstacle[0].X_WO = X_WB;
    const Vec3 toward = tilted * Vec3(0, 0, -2);
    const auto ask = [&](const Vec3& v) {
      (plate_moves ? q.held.obstacle[0].V_WO.v : q.held.V_WO.v) = plate_moves ? Vec3(-v) : v;
      q.held.speed = v.norm();
      ContactModel model;
      q.held.X_WO = X_WB * Pose{{0.001, 0.002, 0.0005 + 0.01 + 0.004}, Quat::Identity()};
      q.contacts->find(q.held, ahead, {1'000'000, 0, nullptr}, model, q.report);
      EXPECT_EQ(q.report.touching, 0u) << "it does not touch yet";
      return model;
    };
    EXPECT_EQ(ask(Vec3::Zero()).count, 0u) << "it stands";
    EXPECT_EQ(ask(-toward).count, 0u) << "it goes away";
    EXPECT_EQ(ask(0.5 * toward).count, 0u) << "3 mm are not enough";
    const ContactModel model = ask(toward);
    ASSERT_GT(model.count, 0u);
    EXPECT_NEAR(q.deepest(model), -0.004, 5e-5);
    for (std::uint32_t i = 0; i < model.count; ++i) {
      const Touch touch = model.touch(i, q.held.X_WO, q.held.X_WO.p, X_WB, {});
      EXPECT_GT(touch.gap, 0.0039);
      EXPECT_GT((X_WB.q.conjugate() * touch.n).z(), 0.99) << "the face that it comes to, not the one behind";
    }
  }
}

TEST(SceneContacts, WhatIsPutElsewhereHasGoneNoWay) {
  Question q;
  const test::TestVolume thin = test::boxVolume({0.02, 0.02, 0.001}, 0.0005);
  q.volumes.publish(kPlateEntry, &thin.view);
  const Vec3 above(0.001, 0.002, 0.014);
  EXPECT_EQ(q.ask(above).count, 0u);
  EXPECT_EQ(q.ask(-above).count, 0u) << "the hand has let go and taken the tool up again beyond the plate";
  Pose& X_WB = q.held.obstacle[0].X_WO;
  X_WB.p.z() = -0.028;
  EXPECT_EQ(q.ask(-above).count, 0u) << "its client has put the plate there";
  X_WB.q = Quat(Eigen::AngleAxisd(3, Vec3::UnitX()));
  EXPECT_EQ(q.ask(-above).count, 0u) << "turned where it stands";
}

TEST(SceneContacts, AnotherObjectInTheSameSlotHasGoneNoWay) {
  const test::TestVolume pea = test::sphereVolume(0.003, 0.0005);
  const test::TestVolume thin = test::boxVolume({0.02, 0.02, 0.001}, 0.0005);
  for (const bool another : {false, true}) {
    Question q;
    q.volumes.publish(kToolEntry, &pea.view);
    q.volumes.publish(kPlateEntry, &thin.view);
    EXPECT_EQ(q.ask({0.001, 0.002, 0.006}).count, 0u);
    q.held.obstacle[0].X_WO.p.z() = 0.012;
    if (another) q.held.obstacle[0].shape.number = 7;
    EXPECT_EQ(q.ask({0.001, 0.002, 0.006}).count > 0, !another) << "the plate went through the tool, or did not";
  }
}

/** A ball of 5 mm on a coupling of 500 N/m, its hand thrown at a plate of 0.6 mm, asked as in the daemon. */
TEST(SceneContacts, NoSpeedOfAHandTakesAToolThroughAThinPlate) {
  const test::TestVolume ball = test::sphereVolume(0.005, 0.0005, 40);
  const test::TestVolume plate = test::boxVolume({0.02, 0.02, 0.0003}, 0.0005);
  ToolSetup setup;
  setup.mass = MassProperties::ofBall(0.05, 0.005);
  setup.gains = {1000, 1000, 5, 1, 1, 0.01};
  for (const double speed : {0.5, 1.0, 2.0, 4.0}) {
    for (int phase = 0; phase < 4; ++phase) {
      Question q;
      q.volumes.publish(kToolEntry, &ball.view);
      q.volumes.publish(kPlateEntry, &plate.view);
      Pose device{{0.001, 0.002, 0.03 + 0.00025 * phase * speed}, Quat::Identity()};
      Tool tool(setup);
      tool.reset(device);
      ConstraintResponse response;
      ContactModel model, answer;
      double lowest = INFINITY;
      for (int tick = 0; tick < 200; ++tick) {
        device.p.z() = std::max(-0.02, device.p.z() - speed * 1e-3);
        if (tick % 2 == 1) model = answer;  // a tick after the question
        std::array<Touch, kMaxTouches> touches;
        for (std::uint32_t i = 0; i < model.count; ++i) {
          touches[i] = model.touch(i, tool.body().pose(), tool.body().com(), Pose{}, {});
          touches[i].friction = 0.3;
        }
        ToolStep out;
        tool.step(device, {touches.data(), model.count}, 1e-3, response, out);
        lowest = std::min(lowest, tool.body().com().z());
        if (tick % 2 != 0) continue;
        q.held.X_WO = tool.body().pose();
        q.held.V_WO = tool.body().originTwist();
        q.held.speed = tool.body().twist().v.norm();
        q.contacts->find(q.held, 0.003, {400'000, 0, nullptr}, answer, q.report);
      }
      EXPECT_GT(tool.body().com().z(), 0.0052) << speed << " m/s, " << phase;
      EXPECT_GT(lowest, 0.0045) << speed << " m/s, " << phase << ": it is stopped at the plate, not beyond it";
    }
  }
}

TEST(SceneContacts, WithoutAVolumeNearestPointsAnswerTheSame) {
  Question q;
  const Vec3 p(0.003, 0.001, 0.005 + 0.01 - 0.001);
  const double by_field = q.deepest(q.ask(p));
  q.held.shape = Shape{ShapeKind::kSphere, Vec3(0.01, 0, 0)};
  q.held.obstacle[0].shape = Shape{ShapeKind::kBox, Vec3(0.02, 0.02, 0.005)};
  const ContactModel model = q.ask(p);
  ASSERT_EQ(model.count, 1u) << "a sphere is one ball";
  EXPECT_NEAR(q.deepest(model), by_field, 3e-5);
  EXPECT_NEAR(q.deepest(model), 0.001, 1e-8);
}

/** A block of 60 mm, as triangles: its middle is 30 mm deep, three times kReach. */
TEST(SceneContacts, APointThatGoesIntoAMeshIsFollowedAsDeepAsItGoes) {
  Question q;
  test::TestMesh block = test::boxMesh({0.03, 0.03, 0.03});
  MeshView* const view = block.view();
  q.held.shape = Shape{ShapeKind::kSphere, Vec3(0.002, 0, 0)};
  q.held.obstacle[0].shape = Shape{ShapeKind::kMesh, Vec3::Zero(), view, 40};
  for (double z = 0.033; z > 0.004; z -= 0.004) {
    const ContactModel model = q.ask({0, 0, z});
    if (z > 0.032) continue;
    ASSERT_EQ(model.count, 1u) << z;
    EXPECT_NEAR(q.deepest(model), 0.032 - z, 1e-6);
    EXPECT_GT(model.touch(0, q.held.X_WO, q.held.X_WO.p, Pose{}, {}).n.z(), 0.999);
  }
  // One that is there at once is beyond reach, unless the mesh has a volume.
  EXPECT_EQ(q.ask({0, 0, 0.05}).count, 0u);
  EXPECT_EQ(q.ask({0, 0, 0.012}).count, 0u);
  const test::TestVolume solid = test::boxVolume({0.03, 0.03, 0.03}, 0.001);
  q.volumes.publish(40, &solid.view);
  const ContactModel model = q.ask({0, 0, 0.012});
  ASSERT_EQ(model.count, 1u);
  EXPECT_NEAR(q.deepest(model), 0.02, 0.001);
}

TEST(SceneContacts, AToolTooLargeForItsFieldMeetsThingsByTheVerticesOfItsMesh) {
  Question q;
  test::TestMesh ball = test::sphereMesh(0.01, 40), plate = test::boxMesh({0.02, 0.02, 0.005});
  q.held.shape.mesh = ball.view();
  q.held.obstacle[0].shape.mesh = plate.view();
  q.contacts = std::make_unique<SceneContacts>(static_cast<std::uint32_t>(q.ball.view.patches.size()) - 1);
  q.contacts->setVolumes(&q.volumes);
  const ContactModel model = q.ask({0.003, 0.001, 0.005 + 0.01 - 0.001});
  ASSERT_GT(model.count, 0u);
  EXPECT_NEAR(q.deepest(model), 0.001, 5e-5);
}

TEST(SceneContacts, ASheetIsAWallFromBothSidesAndNoneBesideIt) {
  for (const double side : {1.0, -1.0}) {
    Question q;
    test::TestMesh sheet = test::heightMesh(0.05, 8, [](double, double) { return 0.0; });  // It looks up.
    q.held.shape = Shape{ShapeKind::kSphere, Vec3(0.002, 0, 0)};
    q.held.obstacle[0].shape = Shape{ShapeKind::kMesh, Vec3::Zero(), sheet.view(), 40};
    const auto ask = [&](double x, double z) { return q.ask({x, 0.001, side * z}); };
    const auto up = [&](const ContactModel& model) {
      return side * model.touch(0, q.held.X_WO, q.held.X_WO.p, Pose{}, {}).n.z();
    };
    EXPECT_EQ(ask(0.001, 0.008).count, 0u) << "6 mm away, whichever side that is";
    // It comes, presses, and goes through: the side that it came from counts until it has left.
    for (const double z : {0.003, 0.0015, 0.0002, -0.0005, -0.004}) {
      const ContactModel model = ask(0.001, z);
      ASSERT_EQ(model.count, 1u) << z;
      EXPECT_NEAR(q.deepest(model), 0.002 - z, 1e-6);
      EXPECT_GT(up(model), 0.999);
    }
    EXPECT_EQ(ask(0.001, 0.02).count, 0u);
    EXPECT_EQ(ask(0.001, -0.008).count, 0u) << "and then the other";
    // Around the rim: near it, but never inside.
    for (const auto& [x, z] :
         {std::pair{0.049, 0.003}, {0.051, 0.0025}, {0.053, 0.0}, {0.053, -0.001}, {0.051, -0.0025}, {0.049, -0.003}}) {
      const ContactModel model = ask(x, z);
      ASSERT_EQ(model.count, 1u) << x << " " << z;
      EXPECT_LT(q.deepest(model), 0) << x << " " << z;
    }
  }
}

/** Between two questions, beyond the border or hardly within it; but where two borders are a seam it is a way through.
 */
TEST(SceneContacts, AWayOverTheBorderOfASheetLeadsToItsOtherSide) {
  const auto goesThrough = [](bool seam, double x_from, double x_to) {
    Question q;
    test::TestMesh sheet;
    for (const double x : {0.0, 0.05}) {
      const auto corner = [&](double aside, double y) { return sheet.addVertex({x + aside, y, 0}); };
      const std::uint32_t first = corner(0, -0.05);
      corner(0.05, -0.05), corner(0.05, 0.05), corner(0, 0.05);
      sheet.addQuad(first, first + 1, first + 2, first + 3);
      if (!seam) break;
    }
    q.held.shape = Shape{ShapeKind::kSphere, Vec3(0.002, 0, 0)};
    q.held.obstacle[0].shape = Shape{ShapeKind::kMesh, Vec3::Zero(), sheet.view(), 40};
    (void)q.ask({x_from, 0.001, 0.0015});
    const ContactModel model = q.ask({x_to, 0.001, -0.0012});
    EXPECT_EQ(model.count, 1u);
    return model.touch(0, q.held.X_WO, q.held.X_WO.p, Pose{}, {}).n.z() > 0;
  };
  EXPECT_FALSE(goesThrough(false, 0.0507, 0.0495)) << "beyond the border";
  EXPECT_FALSE(goesThrough(false, 0.0504, 0.0494)) << "hardly within";
  EXPECT_TRUE(goesThrough(false, 0.0500, 0.0490));
  EXPECT_TRUE(goesThrough(true, 0.0507, 0.0495));
  EXPECT_TRUE(goesThrough(true, 0.0504, 0.0494));
}

TEST(SceneContacts, ARimWithoutANormalSpoilsNoAnswer) {
  // Two triangles back to back: their shared edge has no side. The servo refuses an answer with a normal that is none.
  Question q;
  test::TestMesh sheet;
  sheet.vertices = {{0, 0, 0}, {0.02F, 0, 0}, {0, 0.02F, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 1}};
  q.held.shape = Shape{ShapeKind::kSphere, Vec3(0.002, 0, 0)};
  q.held.obstacle[0].shape = Shape{ShapeKind::kMesh, Vec3::Zero(), sheet.view(), 40};
  const ContactModel model = q.ask({0.01, 0, 0});
  ASSERT_EQ(model.count, 1u);
  EXPECT_NEAR(model.touch(0, q.held.X_WO, q.held.X_WO.p, Pose{}, {}).n.norm(), 1, 1e-6);
}

}  // namespace
}  // namespace hapticd
