/** @file
 * The stuck-proxy anomaly of the thesis (figure 4.6): a ridge 5 mm high on a plane, stroked at 1 N and 1000 N/m.
 */
#include <gtest/gtest.h>

#include "rt/render/surface/shading.h"
#include "tests/support/random.h"
#include "tests/support/shape/brute_nearest.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::TestMesh;
using test::TestScene;

constexpr double kRidgeStiffness = 1000, kRidgeForce = 1, kHeight = 0.005, kHalf = 0.05;

/** Along y; the profile has `cells` facets on each flat and flank. */
TestMesh ridgeMesh(double angle, std::uint32_t cells) {
  const double foot = kHeight / std::tan(angle);
  const double x[] = {-kHalf, -foot, 0, foot, kHalf}, z[] = {0, 0, kHeight, 0, 0};
  TestMesh m;
  for (std::uint32_t i = 0; i <= 4 * cells; ++i) {
    const std::uint32_t k = std::min(i / cells, 3u);
    const double s = double(i - k * cells) / cells;
    for (const double y : {-kHalf, kHalf}) m.addVertex({x[k] + s * (x[k + 1] - x[k]), y, z[k] + s * (z[k + 1] - z[k])});
    if (i > 0) m.addQuad(2 * i - 2, 2 * i, 2 * i + 1, 2 * i - 1);
  }
  return m;
}

struct Stroke {
  Vec3 out, normal;
  bool rising = false;  ///< On the flank that goes up.
  [[nodiscard]] Vec3 hip() const { return out - kRidgeForce / kRidgeStiffness * normal; }
  [[nodiscard]] Vec3 force() const { return kRidgeForce * normal; }
};

/** By arc length at 0.02 m/s from x = -30 to 30 mm, 1 kHz. */
std::vector<Stroke> strokes(double angle) {
  const double foot = kHeight / std::tan(angle), flank = kHeight / std::sin(angle), flat = 0.03 - foot, y = 0.0123;
  const double c = std::cos(angle), s = std::sin(angle);
  std::vector<Stroke> all;
  for (double way = 1e-5; way < 2 * flat + 2 * flank; way += 2e-5) {
    double w = way;
    if (w < flat) {
      all.push_back({Vec3(w - 0.03, y, 0), Vec3::UnitZ()});
    } else if ((w -= flat) < flank) {
      all.push_back({Vec3(w * c - foot, y, w * s), Vec3(-s, 0, c), true});
    } else if ((w -= flank) < flank) {
      all.push_back({Vec3(w * c, y, kHeight - w * s), Vec3(s, 0, c)});
    } else {
      all.push_back({Vec3(foot + w - flank, y, 0), Vec3::UnitZ()});
    }
  }
  return all;
}

/** The solid below the profile, exactly: two flats and two flanks. */
struct Profile {
  double angle;

  [[nodiscard]] Vec3 nearestOnSide(const Vec3& x, double side) const {
    const Vec3 foot(side * kHeight / std::tan(angle), x.y(), 0);
    const Vec3 flank = test::nearestOnSegment(foot, Vec3(0, x.y(), kHeight), x);
    const Vec3 flat = test::nearestOnSegment(foot, Vec3(side * kHalf, x.y(), 0), x);
    return (flank - x).norm() < (flat - x).norm() ? flank : flat;
  }
  [[nodiscard]] bool freeOnSide(const Vec3& x, double side) const {
    return x.z() >= 0 && side * x.x() * std::sin(angle) + (x.z() - kHeight) * std::cos(angle) >= 0;
  }
  /** That of the nearest point, 0 outside. */
  [[nodiscard]] Vec3 nearestForce(const Vec3& x) const {
    if (freeOnSide(x, -1) || freeOnSide(x, 1)) return Vec3::Zero();
    const Vec3 l = nearestOnSide(x, -1), r = nearestOnSide(x, 1);
    return kRidgeStiffness * ((l - x).norm() < (r - x).norm() ? l - x : r - x);
  }
  /** That of the nearest point of the hand's side, 0 where it is free there. */
  [[nodiscard]] Vec3 forceOnSide(const Vec3& x, double side) const {
    if (freeOnSide(x, side)) return Vec3::Zero();
    return kRidgeStiffness * (nearestOnSide(x, side) - x);
  }
  /** The hand changes sides above the ridge and below its foot, never through it. */
  [[nodiscard]] double sideAfter(const Vec3& x, double side) const {
    return x.z() < 0 || x.z() > kHeight ? std::copysign(1.0, x.x()) : side;
  }
};

struct Scores {
  double ours = 0, nearest = 0, against_side = 0;  ///< Mean squares [N^2].
  double rising = 0;                               ///< Largest error of ours on the rising flank [N].
};

/** Edges that bend by less than `smooth` are shaded round [rad]. */
Scores stroke(double angle, std::uint32_t cells, double smooth = 0) {
  TestMesh mesh = ridgeMesh(angle, cells);
  const Profile profile{angle};
  TestScene t;
  const std::uint32_t id = t.addMesh(mesh.view(), {}, {kRidgeStiffness, 0, 0, 0});
  SurfaceParameters surface{};
  surface.smooth_cosine = std::cos(smooth);
  EXPECT_TRUE(smooth == 0 || t.setSurface(id, surface) == ErrorCode::kOk);
  Shading shading;
  Scores s;
  double side = -1;
  const auto way = strokes(angle);
  t.tick(way.front().out + Vec3(0, 0, 0.001));
  for (const Stroke& w : way) {
    t.tick(w.hip());
    if (smooth > 0) shading.step(*t.scene, t.proxy.holding(), Vec3::Zero(), t.contact);
    const Vec3 force = t.contact.force;
    side = profile.sideAfter(w.hip(), side);
    s.ours += (force - w.force()).squaredNorm() / double(way.size());
    s.nearest += (profile.nearestForce(w.hip()) - w.force()).squaredNorm() / double(way.size());
    s.against_side += (force - profile.forceOnSide(w.hip(), side)).squaredNorm() / double(way.size());
    if (w.rising) s.rising = std::max(s.rising, (force - w.force()).norm());
  }
  return s;
}

TEST(ProxyOnRidge, ItDoesNotWaitAtTheFoot) {
  // The plain god-object scores 2.8, 9.0, 62 and 135 N^2.
  struct Case {
    double degrees, nearest;
  };
  for (const auto& [degrees, nearest] : {Case{45, 0.042}, Case{60, 0.082}, Case{75, 0.18}, Case{85, 0.145}}) {
    for (const std::uint32_t cells : {1u, 20u}) {
      const Scores s = stroke(degrees * M_PI / 180, cells);
      EXPECT_NEAR(s.nearest, nearest, 0.03 * nearest) << degrees;
      EXPECT_LE(s.ours, 2 * s.nearest) << degrees << " " << cells;
    }
  }
}

TEST(ProxyOnRidge, OnSteepRidgesTheSideIsKept) {
  for (const double degrees : {75.0, 85.0}) {
    for (const std::uint32_t cells : {1u, 20u}) {
      const Scores s = stroke(degrees * M_PI / 180, cells);
      EXPECT_LT(s.rising, 1e-5) << degrees << " " << cells;
      EXPECT_LE(s.against_side, 2 * s.nearest) << degrees << " " << cells;
    }
  }
}

TEST(ProxyOnRidge, ShadingTakesNothingOfThis) {
  // Nor where it rounds the feet, too (30 degrees round no edge): their facets are small.
  for (const double smooth : {30.0, 60.0}) {
    for (const double degrees : {45.0, 60.0}) {
      const Scores s = stroke(degrees * M_PI / 180, 20, smooth * M_PI / 180);
      EXPECT_LE(s.ours, 2 * s.nearest) << degrees << " " << smooth;
    }
    for (const double degrees : {75.0, 85.0}) {
      const Scores s = stroke(degrees * M_PI / 180, 20, smooth * M_PI / 180);
      EXPECT_LT(s.rising, 1e-5) << degrees << " " << smooth;
      EXPECT_LE(s.against_side, 2 * s.nearest) << degrees << " " << smooth;
    }
  }
}

/** A ball strokes the same ridge, pressed in by 1 mm: its centre goes one radius out, as far as it fits between flat
 * and flank. */
Scores strokeByBall(double angle, std::uint32_t cells, double radius) {
  TestMesh mesh = ridgeMesh(angle, cells);
  const Profile profile{angle};
  TestScene t(radius);
  t.addMesh(mesh.view(), {}, {kRidgeStiffness, 0, 0, 0});
  Scores s;
  int count = 0;
  const auto way = strokes(angle);
  t.tick(way.front().out + Vec3(0, 0, 0.003));
  for (const Stroke& w : way) {
    const Vec3 centre = w.out + radius * w.normal;
    const double left = (profile.nearestOnSide(centre, -1) - centre).norm();
    const double right = (profile.nearestOnSide(centre, 1) - centre).norm();
    if (std::min(left, right) < radius - 1e-9) continue;
    const double error = (t.tick(w.hip() + radius * w.normal).force - w.force()).norm();
    s.ours += error * error;
    ++count;
    if (w.rising) s.rising = std::max(s.rising, error);
  }
  s.ours /= count;
  return s;
}

TEST(ProxyOnRidge, ABallDoesNotWaitAtTheFootEither) {
  // One is as large as the hand is deep, which so strokes the surface itself; with a larger one the hand is in the air.
  for (const double radius : {0.0003, 0.0008, 0.001, 0.002}) {
    for (const std::uint32_t cells : {1u, 20u}) {
      for (const auto& [degrees, nearest] : {std::pair{45, 0.042}, {60, 0.082}}) {
        const Scores s = strokeByBall(degrees * M_PI / 180, cells, radius);
        EXPECT_LE(s.ours, 2 * nearest) << degrees << " " << cells << " " << radius;
      }
      for (const int degrees : {75, 85})
        EXPECT_LT(strokeByBall(degrees * M_PI / 180, cells, radius).rising, 1e-5) << degrees;
    }
  }
}

TEST(ProxyOnRidge, FacetsOfASideNeedNotLieInOnePlane) {
  // As in a scan. Beyond the ridge the hand is pulled back by no more than it presses there: not by up to 4.5 N.
  Random random(31);
  const double angle = M_PI / 3;
  for (const double rough : {0.0, 1e-6, 1e-5}) {
    for (const double mu : {0.0, 0.1, 0.3}) {
      TestMesh mesh = ridgeMesh(angle, 20);
      for (auto& vertex : mesh.vertices) vertex[2] += static_cast<float>(random.in(-rough, rough));
      TestScene t;
      t.addMesh(mesh.view(), {}, {kRidgeStiffness, 0, mu, mu});
      double most = 0;
      for (const Stroke& w : strokes(angle)) most = std::max(most, kRidgeStiffness * t.tick(w.hip()).depth);
      EXPECT_LT(most, 1.05 * kRidgeForce) << rough << " " << mu;
    }
  }
}

}  // namespace
}  // namespace hapticd
