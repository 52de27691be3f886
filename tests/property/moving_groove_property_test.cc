/** @file
 * A block with a groove, and a hand in it, while its vertices move as fast as they like: by many times the groove's
 * width in a tick. The block never passes itself, but it would if its vertices moved one after the other.
 */
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "tests/support/for_seeds.h"
#include "tests/support/shape/brute_distance.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::TestMesh;
using test::TestScene;

/** A block of random shape along y, its vertices and triangles in random order, and a hand for it. */
class Groove {
 public:
  static constexpr double kSize = 0.03;
  static constexpr int kTicks = 400;
  static constexpr std::uint32_t kBottom = 4, kLip = 5;  // Corners of the profile, which has
  static constexpr std::uint32_t kCorners = 7;

  Groove(unsigned seed, std::uint32_t sided) : random_(seed) {
    makeMesh();
    rest_ = mesh_.vertices;
    const double mu = random_.once(2) ? random_.in(0, 1.5) : 0;
    id_ = scene_.addMesh(mesh_.deformableView(), {}, {random_.in(100, 3000), 0, mu, mu * random_.in(0.3, 1)},
                         HD_OBJECT_ENABLED | sided);
    const double radius = random_.once(2) ? 0 : std::exp(random_.in(std::log(1e-4), std::log(5e-3)));
    scene_.proxy.setRadius(radius);
    scene_.tick(hand_);
  }

  Random& random() { return random_; }
  [[nodiscard]] Vec3 rest(std::uint32_t vertex) const { return {rest_[vertex][0], rest_[vertex][1], rest_[vertex][2]}; }
  [[nodiscard]] std::uint32_t vertexCount() const { return static_cast<std::uint32_t>(rest_.size()); }
  /** Number of the profile's corner at the near end (0) or the far one (1). */
  [[nodiscard]] std::uint32_t vertex(std::uint32_t corner, std::uint32_t end) const {
    return place_[end * kCorners + corner];
  }
  [[nodiscard]] double wide() const { return wide_; }

  void move(std::uint32_t vertex, const Vec3& x) {
    moves_.push_back({vertex, {static_cast<float>(x.x()), static_cast<float>(x.y()), static_cast<float>(x.z())}});
  }
  /** The vertices go where they were moved to, and the hand goes for a place in the groove or beside it: `X` of it. */
  void tick(const Eigen::Affine3d& X, int& contacts) {
    ASSERT_EQ(scene_.moveVertices(id_, moves_), ErrorCode::kOk);
    moves_.clear();
    if (random_.once(30))
      aim_ = Vec3{random_.in(-1.2, 1.2) * wide_, random_.in(-1, 1) * kSize, random_.in(-1.5, 0.5) * kSize};
    if (random_.once(40)) speed_ = std::pow(10, random_.in(-3, -0.3));
    hand_ += speed_ * (X * aim_ - hand_);
    const SurfaceContact& c = scene_.tick(hand_);
    contacts += c.object != 0;
    const MeshView& mesh = *scene_.scene->find(id_)->shape.mesh;
    ASSERT_FALSE(test::windingNumber(mesh, c.proxy) > 0.5 && test::distanceTo(mesh, c.proxy) > 3e-7 * kSize);
  }

 private:
  void makeMesh() {
    wide_ = random_.in(0.05, 0.9) * kSize;
    const double deep = kSize * std::pow(10, random_.in(-1, 0.25)), length = random_.in(0.3, 3) * kSize;
    const Vec3 profile[kCorners] = {
        {-kSize, 0, -2 * kSize},
        {kSize, 0, -2 * kSize},
        {kSize, 0, 0},
        {wide_, 0, 0},
        {random_.in(-0.5, 0.5) * wide_, 0, -deep},
        {-wide_, 0, 0},
        {-kSize, 0, 0},
    };
    place_.resize(2 * kCorners);
    std::iota(place_.begin(), place_.end(), 0U);
    for (std::size_t i = place_.size(); i > 1; --i) std::swap(place_[i - 1], place_[random_.below(i)]);
    mesh_.vertices.resize(place_.size());
    for (std::uint32_t i = 0; i < kCorners; ++i) {
      for (std::uint32_t end = 0; end < 2; ++end) {
        const Vec3 x = profile[i] + Vec3(0, (end - 0.5) * length, 0);
        mesh_.vertices[vertex(i, end)] = {static_cast<float>(x.x()), static_cast<float>(x.y()),
                                          static_cast<float>(x.z())};
      }
    }
    for (std::uint32_t i = 0; i < kCorners; ++i) {
      const std::uint32_t j = (i + 1) % kCorners;
      if (random_.once(2)) {
        mesh_.addQuad(vertex(i, 0), vertex(i, 1), vertex(j, 1), vertex(j, 0));
      } else {
        mesh_.addQuad(vertex(j, 0), vertex(i, 0), vertex(i, 1), vertex(j, 1));
      }
    }
    for (const auto& t : {std::array{0U, 1U, 4U}, {1U, 2U, 3U}, {1U, 3U, 4U}, {0U, 4U, 5U}, {0U, 5U, 6U}}) {
      mesh_.addTriangle(vertex(t[0], 0), vertex(t[1], 0), vertex(t[2], 0));
      mesh_.addTriangle(vertex(t[0], 1), vertex(t[2], 1), vertex(t[1], 1));
    }
  }

  Random random_;
  double wide_ = 0;
  std::vector<std::uint32_t> place_;
  TestMesh mesh_;
  std::vector<std::array<float, 3>> rest_;
  std::vector<hd_vertex_move> moves_;
  TestScene scene_;
  std::uint32_t id_ = 0;
  Vec3 hand_ = Vec3(0, 0, 2 * kSize), aim_ = Vec3(0, 0, -kSize);
  double speed_ = 0.01;
};

/** It swings, slides and is sheared. */
void aSwingingGrooveSwallowsNobody(unsigned seed, std::uint32_t sided, int& contacts) {
  Groove groove(seed, sided);
  Random& random = groove.random();
  const Vec3 swing = random.vector(0.3), slide = random.vector(0.5 * Groove::kSize);
  const Eigen::Matrix3d shear =
      (Eigen::Matrix3d() << random.vector(0.3), random.vector(0.3), random.vector(0.3)).finished();
  const double pace = std::pow(10, random.in(-3, -0.5)), shear_pace = std::pow(10, random.in(-3, -0.5));
  const int every = 1 + random.below(3);
  Eigen::Affine3d X = Eigen::Affine3d::Identity();
  for (int i = 0; i < Groove::kTicks; ++i) {
    if (i % every == 0) {
      const double s = std::sin(pace * i);
      X.linear() = Eigen::AngleAxisd(s * swing.norm(), swing.normalized()) *
                   (Eigen::Matrix3d::Identity() + std::sin(shear_pace * i) * shear);
      X.translation() = s * slide;
      for (std::uint32_t v = 0; v < groove.vertexCount(); ++v) groove.move(v, X * groove.rest(v));
    }
    ASSERT_NO_FATAL_FAILURE(groove.tick(X, contacts)) << "tick " << i;
  }
}

/** One of its walls comes near the other one, which rests, and goes back. */
void aClosingGrooveSwallowsNobody(unsigned seed, std::uint32_t sided, int& contacts) {
  Groove groove(seed, sided);
  Random& random = groove.random();
  const double pace = std::pow(10, random.in(-3, -0.5));
  const bool twists = random.once(2);
  const Vec3 base = groove.rest(groove.vertex(0, 0)), bottom = groove.rest(groove.vertex(Groove::kBottom, 0)) - base;
  for (int i = 0; i < Groove::kTicks; ++i) {
    const double by = 0.95 * groove.wide() * (1 - std::cos(pace * i)), s = std::sin(pace * i);
    for (std::uint32_t end = 0; end < 2; ++end) {
      const Vec3 lip =
          groove.rest(groove.vertex(Groove::kLip, end)) + Vec3((twists && end == 1 ? 0.3 + 0.7 * s * s : 1) * by, 0, 0);
      const Vec3 side = lip - base;
      if (bottom.x() * side.z() - bottom.z() * side.x() < 0.02 * Groove::kSize * Groove::kSize)
        continue;  // The end would fold.
      groove.move(groove.vertex(Groove::kLip, end), lip);
    }
    ASSERT_NO_FATAL_FAILURE(groove.tick(Eigen::Affine3d::Identity(), contacts)) << "tick " << i;
  }
}

TEST(MovingGrooveProperty, ASwingingOneSwallowsNobody) {
  int contacts = 0;
  forSeeds(80, [&](unsigned seed) { aSwingingGrooveSwallowsNobody(seed, 0, contacts); });
  forSeeds(80, [&](unsigned seed) { aSwingingGrooveSwallowsNobody(seed, HD_OBJECT_TWO_SIDED, contacts); });
  EXPECT_GT(contacts, 10 * Groove::kTicks);
}

/** First the seeds of a soak in which a push led into what rests. */
TEST(MovingGrooveProperty, AClosingOneSwallowsNobody) {
  int contacts = 0;
  for (const std::uint32_t flags : {0u, 0u + HD_OBJECT_TWO_SIDED}) {
    forSeeds({3126u, 8013u}, 80, [&](unsigned seed) { aClosingGrooveSwallowsNobody(seed, flags, contacts); });
  }
  EXPECT_GT(contacts, 10 * Groove::kTicks);
}

}  // namespace
}  // namespace hapticd
