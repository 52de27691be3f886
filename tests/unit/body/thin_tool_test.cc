// A plate thinner than a tick's way in the hand: from outside it stays outside; taken up through a block it feels
// nothing of that, for no side of it is the one that it came from, and is held by it once it is out.
#include <gtest/gtest.h>

#include "tests/support/stepped/wandering_tool.h"

namespace hapticd {
namespace {

const Shape kPost{ShapeKind::kBox, {0.01, 0.01, 0.02}};
constexpr double kHandsRoom = 0.05;  ///< [m]

struct PlateInHand {
  PlateInHand(double thick, const Vec3& from) : plate{ShapeKind::kBox, {0.04, 0.04, thick / 2}} {
    house->reshape(plate.kind, plate.size);
    house->aim(from);
    house->run(600);
    house->send(CommandKind::kAddObject, test::object(test::kWall, kPost.kind, kPost.size, Vec3::Zero()));
    house->hold();
  }
  /** Moves the hand evenly; the greatest force on it. */
  double move(const Vec3& from, const Vec3& to, int ticks) {
    double most = 0;
    for (int i = 1; i <= ticks; ++i) {
      house->aim(from + (to - from) * i / ticks);
      house->run(1);
      most = std::max(most, house->out().command.force.norm());
    }
    return most;
  }
  [[nodiscard]] double depth() const { return test::depthOf(plate, kPost, house->place().inverse()); }

  Shape plate;
  std::unique_ptr<test::ToolHouse> house = test::houseWithoutFloor();
};

TEST(ThinTool, StaysOutsideHoweverItIsPressed) {
  const struct {
    Vec3 from, to;
    int ticks;
  } ways[] = {{{0, 0, kHandsRoom}, {0, 0, -0.02}, 700},  // Flat, at 0.1 m/s,
              {{0, 0, kHandsRoom}, {0, 0, -0.02}, 70},   // and at 1 m/s;
              {{0.07, 0, 0}, {0, 0, 0}, 700},            // its edge ahead.
              {{0.07, 0, 0}, {0, 0, 0}, 70}};
  for (const double thick : {2e-4, 1e-3}) {
    for (const auto& way : ways) {
      PlateInHand scene(thick, way.from);
      scene.move(way.from, way.to, way.ticks);
      scene.move(way.to, way.to, 500);
      const double felt = scene.house->out().command.force.dot((way.from - way.to).normalized());
      EXPECT_GT(felt, 5) << thick << ", in " << way.ticks;
      EXPECT_LT(scene.depth(), 1e-4) << thick << ", in " << way.ticks;
    }
  }
}

TEST(ThinTool, TakenUpThroughABlockFeelsNothingOfItUntilItIsOut) {
  for (const double thick : {2e-4, 1e-3}) {
    PlateInHand scene(thick, Vec3::Zero());
    const Vec3 aside(0.07, 0, 0);
    EXPECT_LT(scene.move(Vec3::Zero(), {0, 0, 0.005}, 500), 0.1) << thick;
    EXPECT_LT(scene.move({0, 0, 0.005}, Vec3::Zero(), 500), 0.1) << thick;
    EXPECT_LT(scene.move(Vec3::Zero(), aside, 1000), 1) << thick << ": it goes out by the side";
    scene.move(aside, Vec3::Zero(), 700);
    scene.move(Vec3::Zero(), Vec3::Zero(), 500);
    EXPECT_GT(scene.house->out().command.force.x(), 5) << thick << ": and not in again";
    EXPECT_LT(scene.depth(), 1e-4) << thick;
  }
}

}  // namespace
}  // namespace hapticd
