/** @file
 * Two bodies of several parts that are made in each other come apart, as slowly as any: each part of one that the
 * other's own shape is in is left by its own way.
 */
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "tests/support/for_seeds.h"
#include "tests/support/shape/overlap.h"
#include "tests/support/stepped/wandering_tool.h"

namespace hapticd {
namespace {

constexpr double kTickOfParts = 1e-3;  ///< [s]

class BodiesOfParts {
 public:
  explicit BodiesOfParts(unsigned seed) : random_(seed), house_(test::houseWithoutFloor()) {
    house_->aim({0.5, 0.5, 0.3});
    house_->run(5);
    for (std::size_t b = 0; b < 2; ++b) {
      const auto more = b == 0 ? kMostMore : random_.below(kMostMore + 1);
      part_[b].push_back({anyShape(0.02), {}});
      for (std::uint32_t i = 0; i < more; ++i) {
        const Shape shape = anyShape(0.012);
        part_[b].push_back({shape, random_.pose(0.025)});
      }
      add(b, random_.pose(0.02));
    }
    house_->run(1);
  }
  void run() { house_->run(1); }
  [[nodiscard]] const RigidBody& body(std::size_t b) const {
    return house_->servo->cycle().bodies().body(static_cast<std::uint8_t>(b)).body;
  }
  /** Of a body's own shape with any part of the other. */
  [[nodiscard]] double overlap() const {
    double most = -1;
    for (std::size_t i = 0; i < part_[0].size(); ++i) {
      for (std::size_t j = 0; j < part_[1].size(); ++j) {
        if (i > 0 && j > 0) continue;
        const test::Placed &a = part_[0][i], &b = part_[1][j];
        most = std::max(most, test::overlapOf(a.shape, body(0).pose() * a.X_WP, b.shape, body(1).pose() * b.X_WP));
      }
    }
    return most;
  }

 private:
  static constexpr std::uint32_t kMostMore = 3, kRoom = 10;

  Shape anyShape(double most) {
    constexpr ShapeKind kKinds[] = {ShapeKind::kBox, ShapeKind::kCylinder, ShapeKind::kCapsule, ShapeKind::kSphere};
    Shape shape{kKinds[random_.below(4)]};
    for (double& size : shape.size) size = random_.in(0.004, most);
    return shape;
  }
  void add(std::size_t b, const Pose& X) {
    const auto first = static_cast<std::uint32_t>(20 + kRoom * b);
    for (std::uint32_t i = 0; i < part_[b].size(); ++i) {
      const Pose at = i == 0 ? X : part_[b][i].X_WP;
      AddObject order = test::object(makeObjectId(first + i, 1), part_[b][i].shape.kind, part_[b][i].shape.size, at.p);
      store(at.q, order.q);
      order.parent = i == 0 ? 0 : makeObjectId(first, 1);
      house_->send(CommandKind::kAddObject, order);
    }
    SetBody order{};
    order.object = makeObjectId(first, 1);
    order.mass = 0.1;
    for (int i = 0; i < 3; ++i) order.inertia[i] = 2e-5;
    house_->send(CommandKind::kSetBody, order);
  }

  Random random_;
  std::unique_ptr<test::ToolHouse> house_;
  std::array<std::vector<test::Placed>, 2> part_;  ///< In the body.
};

/** Between parts that lead to and fro some stay: 5 of 160. */
TEST(PutPartsProperty, TwoBodiesOfSeveralPartsComeApart) {
  int inside = 0, stayed = 0;
  forSeeds({13, 56, 57, 125, 131}, 24, [&](unsigned seed) {
    BodiesOfParts scene(seed);
    if (scene.overlap() < 5e-4) return;
    ++inside;
    int i = 0;
    for (; i < 1500 && (i % 100 > 0 || scene.overlap() > 3e-4); ++i) {
      const std::array<Vec3, 2> was{scene.body(0).com(), scene.body(1).com()};
      scene.run();
      for (std::size_t b = 0; b < 2; ++b) {
        ASSERT_LE((scene.body(b).com() - was[b]).norm(), 1.01 * Tool::kRecoverSpeed * kTickOfParts) << "tick " << i;
        ASSERT_LT(scene.body(b).twist().v.norm(), 1e-6) << "tick " << i;
      }
    }
    stayed += scene.overlap() > 3e-4;
  });
  EXPECT_GT(inside, drawn(24) / 2);
  EXPECT_LE(stayed, 2);
}

}  // namespace
}  // namespace hapticd
