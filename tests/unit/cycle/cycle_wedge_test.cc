// What a hand between two that meet gives to those that are free: in a narrow wedge no more than was paid for, to the
// last joule of a ledger kept from outside.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "rt/base/rotation.h"
#include "tests/support/for_seeds.h"
#include "tests/support/random.h"
#include "tests/support/stepped/stepped_cycle.h"

namespace hapticd {
namespace {

constexpr double kWedgeDt = 1e-3, kWedgeStiffness = 800;  // N/m
constexpr std::uint32_t kWedgeFloor = makeObjectId(1, 1), kWedgeLid = makeObjectId(2, 1);

/** A floor, z <= 0, and a free lid over it, which meet in the y axis: between them is air where x < 0. */
class Wedge : public test::SteppedCycle {
 public:
  Wedge(double angle, double mass, double damping = 0) : SteppedCycle(test::openConfig(100)), angle_(angle) {
    const hd_material material{kWedgeStiffness, damping, 0, 0};
    add(test::solid(kWedgeFloor, ShapeKind::kBox, material, {{0, 0, -kHalf}, Quat::Identity()}, Vec3::Constant(kHalf)));
    const Quat q = fromRotationVector(angle * Vec3::UnitY());
    lid_ = {q * Vec3(-0.02, 0, kHalf), q};
    add(test::solid(kWedgeLid, ShapeKind::kBox, material, lid_, Vec3::Constant(kHalf)));
    loosen(kWedgeLid, mass);
  }
  void loosen(std::uint32_t id, double mass) {
    const double inertia = 2e-3 * mass;
    put(CommandKind::kSetBody, SetBody{id, 0, mass, {}, {inertia, inertia, inertia, 0, 0, 0}, 0});
    body_[bodies_++] = id;
  }
  /** So far from where both meet, half-way between them: above 0 in the air. */
  Vec3 between(double far) const { return far * Vec3(-std::cos(angle_ / 2), 0, std::sin(angle_ / 2)); }
  /** Along the edge in which they meet, with that velocity. */
  void putLid(double aside, const Vec3& v) {
    put(CommandKind::kObjectPose, poseMessage(kWedgeLid, {lid_.p + aside * Vec3::UnitY(), lid_.q}, {v, Vec3::Zero()}));
  }
  /** That of a lid which comes down on what is below it. */
  Vec3 down(double speed) const { return lid_.q * Vec3(0, 0, -speed); }
  /** With the hand there until what is new is no longer taken as put there. */
  void waitFor(const Vec3& hand) {
    do go(hand);
    while (isPut());
  }
  bool isPut() const {
    bool put = false;
    for (std::uint8_t k = 0; k < bodies_; ++k) put = put || cycle->bodies().wasPut(k);
    return put;
  }
  const SurfaceContact& go(const Vec3& hand) {
    for (std::uint32_t k = 0; k < bodies_; ++k) {  // They touch nothing, which they are to be told.
      ToolContacts none{};
      none.device = kMaxDevices + k;
      none.object = body_[k];
      answer(none);
    }
    return at(hand).contact;
  }
  std::uint8_t find(std::uint32_t id) const { return cycle->bodies().find(objectSlot(id)); }
  const RigidBody& body(std::uint8_t k) const { return cycle->bodies().body(k).body; }
  double energy() const {
    double sum = 0;
    for (std::uint8_t k = 0; k < bodies_; ++k) sum += body(k).kineticEnergy();
    return sum;
  }
  /** So fast that no more is given. */
  bool isAtBound() const {
    bool fast = false;
    for (std::uint8_t k = 0; k < bodies_; ++k)
      fast = fast || body(k).twist().v.norm() > 0.99 * Tool::kMostSpeed ||
             body(k).twist().w.norm() > 0.99 * Tool::kMostTurn;
    return fast;
  }
  const SceneObject& object(std::uint32_t id) const { return *cycle->scene().find(id); }

 private:
  static constexpr double kHalf = 0.05;  ///< Of an edge of either box [m].
  double angle_;
  Pose lid_;
  std::uint32_t bodies_ = 0;
  std::array<std::uint32_t, 2> body_{};
};

/** Where parts are more than twice their sum, a hand that comes from the air gives the work that it did on the way; in
 * a wider one what the springs hold, wherever it came from. */
TEST(CycleWedge, OneBelowSixtyDegreesGivesALightBodyWhatTheHandPutIn) {
  constexpr double kFrom = 0.003, kTo = 0.002;
  for (const double degrees : {20.0, 59.0, 61.0, 90.0}) {
    Wedge wedge(degrees * std::numbers::pi / 180, 1e-4);
    wedge.waitFor(wedge.between(kFrom));
    const SurfaceContact& contact = wedge.go(wedge.between(-kTo));
    ASSERT_EQ(contact.parts, 2u) << degrees;
    const double by_hand = 0.5 * kWedgeStiffness * kTo * (kFrom + kTo), held = 0.5 * kWedgeStiffness * kTo * kTo;
    EXPECT_NEAR(wedge.energy(), degrees < 60 ? by_hand : held, 1e-9 * held) << degrees;
  }
}

/** What was paid into the springs that hold a hand, and what of it bodies got. */
class Ledger {
 public:
  explicit Ledger(const Wedge& wedge) : wedge_(wedge) {}

  /** Before a tick in which nothing that is free is touched. */
  void begin(double stored, const Vec3& felt, const Vec3& hand) {
    energy_ = stored;
    felt_ = felt;
    hand_ = hand;
    pushed_.setZero();
    bound = false;
  }
  /** What bodies may have got from a hand there: `moving` at these velocities. */
  double mayGet(const SurfaceContact& contact, const Vec3& hand, const std::array<Twist, 2>& before, bool put) {
    const Vec3 way = hand - hand_;
    const double by_hand = -std::max(contact.force.dot(way), 0.5 * (felt_ + contact.force).dot(way));
    double linear = 0, square = 0, pressing = 0;
    Vec3 rest = contact.force, sum = Vec3::Zero();
    for (std::uint32_t i = 0; i < contact.parts; ++i) rest -= contact.part[i].force;
    pushed_ = Vec3::Zero();
    for (std::uint32_t i = 0; i < std::max(contact.parts, 1u); ++i) {
      const bool several = contact.parts > 0;
      const std::uint32_t id = several ? contact.part[i].object : contact.object;
      const Vec3 force = several ? Vec3(contact.part[i].force + contact.part[i].share * rest) : contact.force;
      if (several) pressing += contact.part[i].force.norm();
      if (several) sum += contact.part[i].force;
      const std::uint8_t k = wedge_.find(id);
      if (k == FreeBodies::kNone) {
        pushed_ = force;
        continue;
      }
      const RigidBody& body = wedge_.body(k);
      // It has gone on by one tick since.
      const Vec3 r = (several ? contact.part[i].point : contact.point) - (body.com() - kWedgeDt * body.twist().v);
      const Vec3 J = -kWedgeDt * force, turns = r.cross(J);
      linear += J.dot(velocityAt(before[k], r));
      square += 0.5 * (J.squaredNorm() / body.mass() + turns.squaredNorm() / (2e-3 * body.mass()));
    }
    energy_ = put ? contact.stored : energy_ + by_hand;
    energy_ = std::clamp(energy_, 0.0, contact.stored + std::max(0.0, linear) + std::max(0.0, by_hand));
    bound = pressing > 2 * sum.norm() || (bound && energy_ < contact.stored);
    felt_ = contact.force;
    hand_ = hand;
    const double most = bound ? energy_ : contact.parts > 0 ? contact.stored : linear + square;
    less = linear + square > most;
    return std::min(linear + square, most);
  }
  /** They got that; and by the next tick what a client moves so has pressed the hand on. */
  void pay(double got) { energy_ -= got; }
  void carry(const Vec3& floor) { energy_ += kWedgeDt * pushed_.dot(floor); }

  bool bound = false;  ///< By the wedge.
  bool less = false;   ///< Got than an impulse would give.

 private:
  const Wedge& wedge_;
  double energy_ = 0;
  Vec3 felt_ = Vec3::Zero(), hand_ = Vec3::Zero(), pushed_ = Vec3::Zero();
};

void bodiesGetWhatWasPaid(unsigned seed, int& bound, int& less) {
  Random random(seed);
  const double angle = random.in(0.2, 1.4);
  Wedge wedge(angle, std::pow(10, random.in(-4, -2.5)), random.once(2) ? 0 : random.in(0, 2));
  const bool both = random.once(3);
  if (both) wedge.loosen(kWedgeFloor, std::pow(10, random.in(-4, -1)));
  const Vec3 rises(0, 0, both || random.once(2) ? 0 : random.in(-0.1, 0.3));
  Vec3 hand = wedge.between(random.in(0, 0.003));
  if (random.once(5)) {
    wedge.go(hand);
  } else {
    wedge.waitFor(hand);
  }
  Ledger ledger(wedge);
  ledger.begin(0, Vec3::Zero(), hand);
  for (int i = 0; i < 40; ++i) {
    if (i == 1 && !rises.isZero(0))
      wedge.put(CommandKind::kObjectPose, poseMessage(kWedgeFloor, {{0, 0, -0.05}, Quat::Identity()}, {rises, {}}));
    std::array<Twist, 2> before;
    for (std::uint8_t k = 0; k < (both ? 2 : 1); ++k) before[k] = wedge.body(k).twist();
    double energy = wedge.energy();
    if (!both && (i == 1 || i == 20) && random.once(2)) {
      const Vec3 v = wedge.down(random.in(0, 1));
      wedge.putLid(i == 1 ? 0 : 0.02, v);
      before[0] = {v, Vec3::Zero()};
      energy = 0.5 * wedge.body(0).mass() * v.squaredNorm();
    }
    if (i > 1 && !random.once(4)) hand += random.vector(5e-4) - wedge.between(random.in(-5e-4, 1.5e-3));
    const SurfaceContact& contact = wedge.go(hand);
    ledger.carry(wedge.object(kWedgeFloor).V_WO.v);
    const bool lid = contact.object == kWedgeLid || contact.parts > 0 || (both && contact.object != 0);
    if (!lid) {
      ledger.begin(contact.object != 0 ? contact.stored : 0, contact.force, hand);
      ASSERT_NEAR(wedge.energy(), energy, 1e-6 * energy) << i;
      continue;
    }
    const double gets = ledger.mayGet(contact, hand, before, wedge.isPut()), got = wedge.energy() - energy;
    if (wedge.isAtBound()) return;
    ASSERT_NEAR(got, gets, 1e-6 * (wedge.energy() + energy + contact.stored))
        << "tick " << i << ", " << contact.parts << " parts";
    ledger.pay(got);
    bound += ledger.bound && ledger.less;
    less += ledger.less;
  }
}

TEST(CycleWedge, EachTickBodiesGetWhatWasPaidForAndNoMore) {
  int bound = 0, less = 0;
  forSeeds(400, [&](unsigned seed) { bodiesGetWhatWasPaid(seed, bound, less); });
  EXPECT_GT(bound, drawn(100));
  EXPECT_GT(less, bound + drawn(20));
}

}  // namespace
}  // namespace hapticd
