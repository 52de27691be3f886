// A proxy between two that close on each other: with which of them it goes, and how far they push it, by closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/random.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::TestScene;

constexpr double kJawStiffness = 1000, kSofter = 300;  // N/m, of the floor and of the ceiling.

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
    for (Moved* m : {&floor, &ceiling})
      m->id = t.add(planes ? ShapeKind::kPlane : ShapeKind::kBox, half, m->X,
                    {m == &floor ? kJawStiffness : kSofter, 0, 0, 0});
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

/**
 * It goes with what moves least as they close, of two alike with that which it is on, and on with that, however they
 * move, until they part; the spring is that of the one on which it is pressed.
 */
TEST(ProxyPinch, ItGoesWithWhatMovesLeastAsTheyClose) {
  constexpr double kDeep = 2e-3, kGap = 1e-3, kSlow = 1e-4;
  for (const double side : {1.0, -1.0}) {  // Of the hand: below the floor, or above the ceiling.
    for (const bool planes : {false, true}) {
      for (const double radius : {0.0, 3e-3}) {
        for (const double faster : {0.3, 1.0, 1.9, 2.1, 3.0}) {  // What it is on, than the other.
          bool by_own = faster < 2;
          if (planes && !by_own) continue;
          TestScene t(radius);
          Press press(t, 2 * radius + kGap, planes);
          FarAway far(t);
          Random random(seedOf(1));
          const double stiffness = side > 0 ? kJawStiffness : kSofter, others = side > 0 ? kSofter : kJawStiffness;
          Moved &own = side > 0 ? press.floor : press.ceiling, &other = side > 0 ? press.ceiling : press.floor;
          const double on = side > 0 ? radius : radius + kGap;
          const Vec3 hand(0, 0, on - side * kDeep);
          t.tick({0, 0, radius + 0.5 * kGap});
          t.tick(hand);
          double surface = 0, proxy = 0, gap = kGap;  // Toward the other one.
          const auto go = [&](double comes, double meets) {
            own.by(t, side * comes);
            other.by(t, -side * meets);
            far.flies.by(t, random.in(-0.02, 0.02));
            gap -= comes + meets;
            surface += comes;
            proxy = gap > 0 ? surface : proxy + (by_own ? comes : -meets);
            const double deep = proxy + kDeep;  // Below 0 it is the other one that pushes.
            EXPECT_NEAR(side * t.tick(hand).force.z(), (deep > 0 ? stiffness : others) * deep, 1e-6)
                << side << ' ' << planes << ' ' << radius << ' ' << faster << ": " << comes << ", " << meets;
          };
          const auto close = [&](double comes, double meets) {
            while (gap > -3e-4) go(comes, meets);
            for (int i = 0; i < 50; ++i) {
              const double to = random.in(-2e-4, 2e-4);
              go(to, std::max(random.in(-2e-4, 2e-4), gap - to + 1e-5));
            }
            go(0, gap - 5.3e-4);
            go(1e-4, 0);
          };
          close(faster * kSlow, kSlow);
          if (planes) continue;
          by_own = !by_own;  // And when they have parted anew.
          close(by_own ? kSlow : 3 * kSlow, by_own ? 3 * kSlow : kSlow);
        }
      }
    }
  }
}

/** Nobody is held by what he could lift: it comes over the hand, which goes on with what is firm. */
TEST(ProxyPinch, AFreeBodyComesOverIt) {
  constexpr double kDeep = 2e-3, kGap = 1e-3;
  enum class Free { kCeiling, kBeside, kFarAway };
  for (const Free body : {Free::kCeiling, Free::kBeside, Free::kFarAway}) {
    const bool is_near = body == Free::kCeiling;
    for (const double rises : {0.0, 3e-4}) {
      TestScene t;
      Press press(t, kGap, false);
      FarAway far(t);
      std::uint32_t free = is_near ? press.ceiling.id : far.stands.id;
      if (body != Free::kFarAway) {  // It stands 5 mm away, and its ball is about the hand.
        const std::uint32_t large = t.add(ShapeKind::kBox, Vec3::Constant(0.3), {{0.305, 0, 0}, Quat::Identity()});
        if (!is_near) free = large;
      }
      t.scene->setLoose(objectSlot(free), true);
      t.tick({0, 0, 0.5 * kGap});
      const Vec3 hand(0, 0, -kDeep);
      t.tick(hand);
      double top = 0, proxy = 0, gap = kGap;
      for (int i = 0; i < 20; ++i) {
        press.floor.by(t, rises);
        press.ceiling.by(t, -1e-4);
        gap -= rises + 1e-4;
        top += rises;
        const bool by_floor = is_near || gap > 0 || rises == 0;
        proxy += by_floor ? rises : -1e-4;
        const SurfaceContact& c = t.tick(hand);
        EXPECT_NEAR(c.force.z(), kJawStiffness * (proxy + kDeep), 1e-6) << rises << ' ' << i;
        EXPECT_EQ(c.object, press.floor.id);
      }
      ASSERT_LT(gap, -5e-4);
      t.tick(Vec3(0, 0, top + 1e-4));
      EXPECT_EQ(t.contact.object, is_near ? 0 : press.ceiling.id) << "within what came over it";
    }
  }
}

/** Pressed on one that is free, by one that is firm, it goes with that, and the free one comes over it. */
TEST(ProxyPinch, OfTwoWithAFreeBodyTheFirmOneHoldsIt) {
  TestScene t;
  Press press(t, 1.05e-3, false);
  t.scene->setLoose(objectSlot(press.floor.id), true);
  t.tick({0, 0, 0.5e-3});
  const Vec3 hand(0, 0, -2e-3);
  for (int i = 0; i < 20; ++i) {
    press.ceiling.by(t, -1e-4);
    EXPECT_NEAR(t.tick(hand).force.z(), i < 10 ? 2 : 0, 1e-6) << i;
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
