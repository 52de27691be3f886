// The models, the brute force and the peers of haptic-bench collide.
#include <gtest/gtest.h>

#include <map>

#include "tools/haptic-bench/collide/pair.h"
#include "tools/haptic-bench/collide/peer.h"
#include "tools/haptic-bench/collide/shapes.h"
#include "tools/haptic-bench/collide/timing.h"
#include "tools/haptic-bench/collide/truth.h"

namespace haptic_bench {
namespace {

using hapticd::Pose;

/** Every edge once in each direction. */
bool isClosed(const Model& model) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : model.triangles) {
    for (std::size_t i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
  }
  for (const auto& [edge, count] : edges) {
    const auto back = edges.find({edge.second, edge.first});
    if (count != 1 || back == edges.end()) return false;
  }
  return true;
}

double volume(const Model& model) {
  double sum = 0;
  for (std::uint32_t t = 0; t < model.triangles.size(); ++t)
    sum += model.corner(t, 0).dot(model.corner(t, 1).cross(model.corner(t, 2))) / 6;
  return sum;
}

/** A closed box, outward. */
Model box(const Vec3& low, const Vec3& high) {
  Model m;
  for (int i = 0; i < 8; ++i)
    m.addVertex({i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z()});
  const std::uint32_t q[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& f : q) m.addQuad(f[0], f[1], f[2], f[3]);
  return m;
}

TEST(CollidePair, ModelsAreClosedAndAsLargeAsTheirFormulas) {
  const double mm3 = 1e-9;
  const Model ball = bumpyBall(), rod = peg(), plate = plateWithHole(), lower = fractureHalf(false),
              upper = fractureHalf(true);
  EXPECT_EQ(ball.triangles.size(), 69'620u);
  EXPECT_EQ(ball.vertices.size(), 34'812u);
  EXPECT_EQ(rod.triangles.size(), 20'000u);
  EXPECT_EQ(plate.triangles.size(), 17'600u);
  EXPECT_EQ(lower.triangles.size(), 66'960u);
  EXPECT_EQ(upper.triangles.size(), 66'960u);
  for (const Model* m : {&ball, &rod, &plate, &lower, &upper}) EXPECT_TRUE(isClosed(*m)) << m->name;
  const double polygon = 200 / 2.0 * std::sin(2 * EIGEN_PI / 200);  // Of a circle of radius 1.
  EXPECT_NEAR(volume(rod), 60 * 100 * polygon * mm3, 1e-3 * mm3);
  EXPECT_NEAR(volume(plate), 20 * (6400 - 10.1 * 10.1 * polygon) * mm3, 1e-2 * mm3);
  EXPECT_NEAR(volume(lower) + volume(upper), 60 * 60 * 40 * mm3, 1e-1 * mm3);  // They fit without a gap.
  EXPECT_NEAR(volume(ball), 4.0 / 3 * EIGEN_PI * 50 * 50 * 50 * mm3, 0.05 * 523'599 * mm3);
  EXPECT_GT(volume(ball), 0);
}

TEST(CollidePair, FractureHasTheDepthThatItsPoseSays) {
  const Pose start = makePair("frac").pose(0);
  EXPECT_NEAR(start.p.z(), 0.02, 1e-6);
  EXPECT_NEAR(makePair("frac").pose(0.5).p.z(), -0.05e-3, 1e-9);
  EXPECT_THROW((void)makePair("other"), std::exception);
}

TEST(CollideTruth, OfABoxOnABoxIsAreaTimesDepth) {
  const Model base = box({-0.05, -0.05, -0.02}, {0.05, 0.05, 0});
  const Model tool = box({-0.01, -0.005, 0}, {0.01, 0.005, 0.02});
  const Truth truth(base, tool, 40);
  const Pose pose{{0.01, 0, -0.0001}, hapticd::Quat::Identity()};
  const Penalty p = truth.at(pose, 0.01);
  // The sides touch too, but are flat: their samples reach 0.1 mm deep over 60 mm of edge.
  EXPECT_NEAR(p.integral.force.z(), 2e-4 * 1e-4, 0.02 * 2e-8);
  EXPECT_NEAR(p.integral.force.x(), 0, 1e-12);
  EXPECT_NEAR(p.integral.torque.norm(), 0, 1e-11);
  EXPECT_NEAR(p.deepest, 1e-4, 1e-9);
  const Penalty away = truth.at({{0, 0, 1e-6}, hapticd::Quat::Identity()}, 0.01);
  EXPECT_EQ(away.volume, 0);
}

TEST(CollidePeer, FclAndBulletTellWhetherBoxesTouch) {
  const Model base = box({-0.05, -0.05, -0.02}, {0.05, 0.05, 0});
  const Model tool = box({-0.01, -0.005, 0}, {0.01, 0.005, 0.02});
  for (const PeerKind* kind : {&kFclPeer, &kBulletPeer}) {
    const auto peer = kind->make(base, tool);
    EXPECT_FALSE(peer->touch({{0, 0, 1e-3}, hapticd::Quat::Identity()})) << kind->name;
    EXPECT_TRUE(peer->touch({{0, 0, -1e-3}, hapticd::Quat::Identity()})) << kind->name;
    EXPECT_GT(peer->contacts({{0, 0, -1e-3}, hapticd::Quat::Identity()}, 1000), 1u) << kind->name;
  }
}

TEST(CollideTiming, SummaryIsByRank) {
  std::vector<double> ms;
  for (int i = 1000; i > 0; --i) ms.push_back(i);
  const Times t = summarise(ms);
  EXPECT_EQ(t.p50, 500);
  EXPECT_EQ(t.p99, 990);
  EXPECT_EQ(t.p999, 999);
  EXPECT_EQ(t.count, 1000u);
  // Two poses in five passes, one of which was disturbed.
  const Times steady = summarise({1, 2, 1, 2, 50, 60, 1, 2, 1, 2}, 5);
  EXPECT_EQ(steady.steady999, 2);
  EXPECT_EQ(steady.max, 60);
  EXPECT_EQ(summarise({1, 2, 3, 6}, 2).steady999, 4) << "of two passes the middle, not the slower";
}

}  // namespace
}  // namespace haptic_bench
