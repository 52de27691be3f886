// A proxy between two that close on each other: with which of them it goes, and how far they push it, by closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/random.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::TestScene;

constexpr double kJawStiffness = 1000;  // N/m

/** A thing that is moved along z. */
struct Moved {
  std::uint32_t id = 0;
  Pose X;

  void by(TestScene& t, double way) {
    X.p.z() += way;
    t.pose(id, X);
  }
};

Quat upsideDown() { return Quat(Eigen::AngleAxisd(M_PI, Vec3::UnitX())); }

/** The floor's top is z = 0, the ceiling is `gap` above; as boxes or as planes. */
struct Press {
  Press(TestScene& t, double gap, bool planes) {
    const Vec3 half(0.05, 0.05, 0.02);
    floor.X = planes ? Pose{} : Pose{{0, 0, -half.z()}, Quat::Identity()};
    ceiling.X = {{0, 0, gap + (planes ? 0 : half.z())}, upsideDown()};
    for (Moved* m : {&floor, &ceiling}) m->id = t.add(planes ? ShapeKind::kPlane : ShapeKind::kBox, half, m->X);
  }
  Moved floor, ceiling;
};

/** Of one that stands far away and one that moves there fast nothing is felt. */
struct FarAway {
  explicit FarAway(TestScene& t) {
    stands.X.p = {0.3, 0, 0};
    flies.X.p = {0, 0.5, 0};
    for (Moved* m : {&stands, &flies}) m->id = t.add(ShapeKind::kBox, Vec3::Constant(0.01), m->X);
    below.X.p = {0, 0, -0.2};
    below.id = t.add(ShapeKind::kPlane, Vec3::Zero(), below.X);
  }
  Moved stands, flies, below;
};

/** It goes with what moves least as they close, and on with that, however they move, until they part. */
TEST(ProxyPinch, ItGoesWithWhatMovesLeastAsTheyClose) {
  constexpr double kDeep = 2e-3, kGap = 1e-3;
  for (const bool planes : {false, true}) {
    for (const double radius : {0.0, 3e-3}) {
      for (const bool by_floor : {true, false}) {
        if (planes && !by_floor) continue;
        TestScene t(radius);
        Press press(t, 2 * radius + kGap, planes);
        FarAway far(t);
        Random random(seedOf(1));
        const Vec3 hand(0, 0, radius - kDeep);
        t.tick({0, 0, radius + 0.5 * kGap});
        t.tick(hand);
        double top = 0, proxy = 0, gap = kGap;
        const auto go = [&](double rises, double sinks) {
          press.floor.by(t, rises);
          press.ceiling.by(t, -sinks);
          far.flies.by(t, random.in(-0.02, 0.02));
          gap -= rises + sinks;
          top += rises;
          proxy = gap > 0 ? top : proxy + (by_floor ? rises : -sinks);
          EXPECT_NEAR(t.tick(hand).force.z(), kJawStiffness * (proxy + kDeep), 1e-6)
              << planes << ' ' << radius << ' ' << by_floor << " rises " << rises << " sinks " << sinks;
        };
        while (gap > -5e-4) go(by_floor ? 1e-4 : 3e-4, by_floor ? 3e-4 : 1e-4);
        for (int i = 0; i < 50 || gap > 0; ++i) {
          const double rises = random.in(-2e-4, 2e-4);
          go(rises, std::max(random.in(-2e-4, 2e-4), gap - rises + 1e-5));
        }
        go(0, gap - 5e-4);
        go(1e-4, 0);
      }
    }
  }
}

/** A wedge that closes takes it farther from the hand by 8 times its own way at most, and by 3 times that and half of
 * how far it is already; else it stays where it is. */
TEST(ProxyPinch, AWedgePushesItOutSoFarAndNoFarther) {
  constexpr double kWay = 1e-4;
  for (const double behind : {1e-5, 4e-4, 2e-3}) {
    const double taken = std::hypot(behind, kWay);  // How far behind the hand is of where the press alone takes it.
    const double most = (taken - behind) / kWay + std::min(8.0, 3 + 0.5 * taken / kWay);
    for (const double out : {0.97 * most, 1.03 * most}) {  // Of the line in which both meet, for each metre it sinks.
      for (const double radius : {0.0, 3e-3}) {
        TestScene t(radius);
        FarAway far(t);
        const double angle = std::atan(1 / out);
        t.add(ShapeKind::kPlane, Vec3::Zero());
        Moved press;
        press.X.q = Quat::FromTwoVectors(Vec3::UnitZ(), Vec3(std::sin(angle), 0, -std::cos(angle)));
        press.id = t.add(ShapeKind::kPlane, Vec3::Zero(), press.X);
        const Vec3 between(radius / std::tan(0.5 * angle), 0, radius), hand = between - Vec3(behind, 0, 0);
        t.tick(between + Vec3(0.01, 0, 0.003 / out));
        for (int i = 0; i < 5; ++i) t.tick(hand);
        ASSERT_LT((t.contact.proxy - between).norm(), 1e-9);
        press.by(t, -kWay);
        far.flies.by(t, 0.02);
        t.tick(hand);
        const double goes = out < most ? out * kWay : 0;
        EXPECT_LT((t.contact.proxy - between - Vec3(goes, 0, 0)).norm(), 1e-8) << behind << ' ' << out << ' ' << radius;
        EXPECT_NEAR(t.contact.force.norm(), kJawStiffness * (behind + goes), 1e-4);
      }
    }
  }
}

}  // namespace
}  // namespace hapticd
