// What the cycle tells the guard about energy: motion that clients impose is theirs, not the wall's.
#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <numbers>
#include <vector>

#include "rt/base/rotation.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/stepped_cycle.h"
#include "tests/support/time.h"

namespace hapticd {
namespace {

constexpr double kSpeed = 0.05;  ///< Of the body that pushes [m/s].

/** A hand that resists with 30 N s/m while something carries it along x; session 0 is alive. */
class CarriedHand : public test::SteppedCycle {
 public:
  CarriedHand() : SteppedCycle(config()) {
    put(CommandKind::kAddSession, SessionRef{0, 0, 1});
    arm();
  }
  const GuardOutput& tick() {
    const GuardOutput& out = at({x_, 0, z_}).guard;
    for (int i = 0; i < 20; ++i) {
      v_ += 5e-5 / 0.15 * (out.command.force.x() + push - 30 * v_);
      x_ += 5e-5 * v_;
    }
    delivered += out.command.force.x() * kSpeed * 1e-3;
    return out;
  }
  /** A plane that faces +x and travels along it from just behind the hand. */
  void addTravellingPlane(bool touchable, double speed = kSpeed) {
    const Pose X{{-0.001, 0, 0}, fromRotationVector(std::numbers::pi / 2 * Vec3::UnitY())};
    AddObject plane = test::solid(makeObjectId(1, 1), ShapeKind::kPlane, {800, 1, 0, 0}, X);
    if (!touchable) plane.flags = 0;
    add(plane);
    put(CommandKind::kObjectPose, poseMessage(plane.object, X, {{speed, 0, 0}, Vec3::Zero()}));
  }
  /** A plane at rest, a millimetre above the hand. */
  void addFloor(double stiffness) {
    add(test::solid(makeObjectId(2, 1), ShapeKind::kPlane, {stiffness, 1, 0, 0},
                    {{0, 0, z_ + 0.001}, Quat::Identity()}));
  }
  /** A sheet below the hand, which sticks to it. */
  void addBelt() {
    meshes.publish(3, belt_.deformableView());
    AddObject belt = test::solid(kBelt, ShapeKind::kMesh, {800, 1, 5, 5}, {{0, 0, z_ - 0.001}, Quat::Identity()});
    belt.shape.mesh = 3;
    add(belt);
  }
  /** Along x, by its pose or by its vertices. */
  void moveBeltTo(double x, bool by_vertices) {
    if (by_vertices) {
      hd_object_vertices order{};
      order.object = kBelt;
      for (std::uint32_t i = 0; i < belt_made_.size(); ++i) {
        const auto& v = belt_made_[i];
        order.move[order.count++] = {i, {static_cast<float>(v[0] + x), v[1], v[2]}};
      }
      put(CommandKind::kObjectVertices, order);
    } else {
      put(CommandKind::kObjectPose, poseMessage(kBelt, {{x, 0, -0.001}, Quat::Identity()}));
    }
  }
  void lowerBy(double depth) { z_ -= depth; }
  double delivered = 0;  ///< Roughly [J].
  double push = 0;       ///< Along x [N].

 private:
  static CycleConfig config() {
    CycleConfig config = test::openConfig(20);
    config.guard[0].limits.force_slew = 1e5;
    config.guard[0].limits.velocity = 3;
    config.guard[0].small_force = 100;
    return config;
  }

  static constexpr std::uint32_t kBelt = makeObjectId(3, 1);
  test::TestMesh belt_ = test::heightMesh(0.5, 1, [](double, double) { return 0.0; });
  std::vector<std::array<float, 3>> belt_made_ = belt_.vertices;
  double x_ = 0, v_ = 0, z_ = 0;
};

void expectCalm(
    CarriedHand& hand, const std::function<void(int)>& before = [](int) {}) {
  for (int i = 0; i < 8000; ++i) {
    before(i);
    const GuardOutput& out = hand.tick();
    ASSERT_EQ(out.fault, std::uint32_t{HD_FAULT_NONE}) << i;
    ASSERT_FALSE(out.flags & HD_SAMPLE_PASSIVITY) << i << ": " << out.energy;
  }
  EXPECT_GT(hand.delivered, 0.4) << "the hand was carried, far beyond what a passive source may give";
}

TEST(CycleEnergy, ASurfaceThatTravelsIsChargedToItsMotion) {
  CarriedHand hand;
  hand.addTravellingPlane(true);
  expectCalm(hand);
}

/** The floor is touched first; what carries the hand is the wall that comes. */
TEST(CycleEnergy, ASurfaceThatTravelsOverAFloorToo) {
  for (const double stiffness : {800.0, 200.0}) {
    CarriedHand hand;
    hand.lowerBy(-0.003);
    hand.addFloor(stiffness);
    hand.lowerBy(-0.002);
    hand.tick();
    for (int i = 0; i < 40; ++i) {
      hand.lowerBy(1e-4);
      hand.tick();
    }
    hand.addTravellingPlane(true);
    expectCalm(hand);
  }
}

/** What the hand sticks to carries it, told each tick or a hundred times a second. */
TEST(CycleEnergy, ABeltThatDragsTheHandAlongToo) {
  for (const bool by_vertices : {false, true}) {
    for (const int pace : {1, 10}) {
      CarriedHand hand;
      hand.addBelt();
      hand.tick();
      hand.lowerBy(0.003);
      hand.tick();
      int told = 0;
      expectCalm(hand, [&](int i) {
        if (++told % pace == 0) hand.moveBeltTo(1e-3 * kSpeed * i, by_vertices);
      });
    }
  }
}

TEST(CycleEnergy, ALocalModelThatTravelsWithItsObjectToo) {
  CarriedHand hand;
  hand.addTravellingPlane(false);
  hand.tick();
  hd_local_model m{};
  m.kind = HD_MODEL_PLANE;
  m.frame = makeObjectId(1, 1);
  m.lease_ns = 20'000 * kMs;
  m.material = {800, 1, 0, 0};
  m.normal[2] = 1;
  hand.put(CommandKind::kLocalModel, m, 0);
  expectCalm(hand);
}

TEST(CycleEnergy, AnObjectThatIsMadeStifferUnderAHandIsChargedToWhoDoesIt) {
  CarriedHand hand;
  hand.addTravellingPlane(true, 0);
  for (int i = 0; i < 20; ++i) hand.tick();
  hand.push = -3;
  for (int i = 0; i < 8000; ++i) {
    const bool stiffer = i % 400 == 0;
    if (stiffer || i % 400 == 200) {
      hand.put(CommandKind::kObjectMaterial,
               hd_object_material{makeObjectId(1, 1), 0, {stiffer ? 800.0 : 200.0, 1, 0, 0}}, 0);
    }
    const GuardOutput& out = hand.tick();
    ASSERT_EQ(out.fault, std::uint32_t{HD_FAULT_NONE}) << i;
    ASSERT_FALSE(out.flags & HD_SAMPLE_PASSIVITY) << i << ": " << out.energy;
  }
}

TEST(CycleEnergy, AnObjectThatIsGivenALargerShapeUnderAHandToo) {
  CarriedHand hand;
  constexpr double kHalf = 0.1;
  hand.add(test::solid(makeObjectId(1, 1), ShapeKind::kBox, {800, 1, 0, 0}, {{-0.001 - kHalf, 0, 0}, Quat::Identity()},
                       Vec3::Constant(kHalf)));
  for (int i = 0; i < 20; ++i) hand.tick();
  hand.push = -3;
  for (int i = 0; i < 8000; ++i) {
    const bool larger = i % 400 == 200;  // Not at first: it is not pressed yet.
    if (larger || i % 400 == 0) {
      SetShape order{makeObjectId(1, 1), 0, {}};
      order.shape.kind = static_cast<std::uint32_t>(ShapeKind::kBox);
      for (double& half : order.shape.size) half = kHalf + (larger ? 0.0015 : 0);
      hand.put(CommandKind::kSetShape, order);
    }
    const GuardOutput& out = hand.tick();
    ASSERT_EQ(out.fault, std::uint32_t{HD_FAULT_NONE}) << i;
    ASSERT_FALSE(out.flags & HD_SAMPLE_PASSIVITY) << i << ": " << out.energy;
    ASSERT_TRUE(i < 1000 || out.command.force.x() > 1) << "it goes on holding the hand";
  }
}

/** The floor was touched first; the wall behind which the hand is, or the floor, is made stiffer and softer. */
TEST(CycleEnergy, AWallThatIsMadeStifferBesideAFloorToo) {
  for (const std::uint32_t slot : {1u, 2u}) {
    CarriedHand hand;
    hand.lowerBy(-0.003);
    hand.addFloor(500);
    hand.lowerBy(-0.002);
    hand.tick();
    for (int i = 0; i < 40; ++i) {
      hand.lowerBy(1e-4);
      hand.tick();
    }
    hand.addTravellingPlane(true, 0);
    for (int i = 0; i < 20; ++i) hand.tick();
    hand.push = -3;
    for (int i = 0; i < 8000; ++i) {
      const bool stiffer = i % 400 == 0;
      if (stiffer || i % 400 == 200) {
        hand.put(CommandKind::kObjectMaterial,
                 hd_object_material{makeObjectId(slot, 1), 0, {stiffer ? 800.0 : 200.0, 1, 0, 0}}, 0);
      }
      const GuardOutput& out = hand.tick();
      ASSERT_EQ(out.fault, std::uint32_t{HD_FAULT_NONE}) << slot << " " << i;
      ASSERT_FALSE(out.flags & HD_SAMPLE_PASSIVITY) << slot << " " << i << ": " << out.energy;
    }
  }
}

TEST(CycleEnergy, ASpringThatIsDraggedAlongIsActive) {
  CarriedHand hand;
  for (int i = 0; i < 8000; ++i) {
    if (i % 16 == 0) {
      hd_local_model m{};
      m.kind = HD_MODEL_SPRING;
      m.lease_ns = 100 * kMs;
      m.blend_ns = 16 * kMs;
      m.material = {800, 0, 0, 0};
      m.origin[0] = kSpeed * i * 1e-3;
      hand.put(CommandKind::kLocalModel, m, 0);
    }
    const GuardOutput& out = hand.tick();
    ASSERT_EQ(out.fault, std::uint32_t{HD_FAULT_NONE}) << i;
    ASSERT_FALSE(out.flags & HD_SAMPLE_PASSIVITY) << i << ": " << out.energy;
  }
  EXPECT_GT(hand.delivered, 0.4);
}

}  // namespace
}  // namespace hapticd
