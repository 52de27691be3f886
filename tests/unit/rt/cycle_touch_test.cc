// Of each object that a hand touches beginning and end are told in turns.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "rt/cycle/cycle.h"
#include "tests/support/time.h"

namespace hapticd {
namespace {

const std::uint32_t kOne = makeObjectId(1, 1), kOther = makeObjectId(2, 1);

/** A touch of that object, or its end. */
struct Told {
  bool begins;
  std::uint32_t object;
  double force;

  bool operator==(const Told& other) const { return begins == other.begins && object == other.object; }
};

Told begin(std::uint32_t object) { return {true, object, 0}; }
Told end(std::uint32_t object) { return {false, object, 0}; }

/** Two boxes of 20 mm side by side, of which the other one is so much higher [m]. */
class CycleTouch : public ::testing::Test {
 protected:
  void build(double higher) {
    for (const std::uint32_t id : {kOne, kOther}) {
      AddObject tile{};
      tile.object = id;
      tile.flags = HD_OBJECT_ENABLED;
      tile.shape.kind = static_cast<std::uint32_t>(ShapeKind::kBox);
      store(Vec3(0.01, 0.01, 0.01), tile.shape.size);
      tile.material = {1000, 0, 0, 0};
      tile.p[0] = id == kOne ? -0.01 : 0.01;
      tile.p[2] = id == kOne ? 0 : higher;
      tile.q[0] = 1;
      Command& c = input_->command[input_->command_count++];
      c = Command{};
      c.kind = CommandKind::kAddObject;
      c.as<AddObject>() = tile;
    }
  }
  std::uint32_t at(const Vec3& x) {
    ++input_->tick;
    input_->now_ns += kMs;
    input_->device[0].t_ns = input_->now_ns;
    input_->device[0].p = x;
    input_->device[0].fresh = true;
    cycle_->step(*input_, *output_);
    input_->command_count = 0;
    for (std::uint32_t i = 0; i < output_->events.count; ++i) {
      const ServoEvent& event = output_->events.event[i];
      if (event.kind == ServoEventKind::kTouch) told_.push_back({true, event.object, event.force});
      if (event.kind == ServoEventKind::kUntouch) told_.push_back({false, event.object, event.force});
    }
    return output_->device[0].contact.object;
  }

  std::unique_ptr<MeshTable> meshes_ = std::make_unique<MeshTable>();
  std::unique_ptr<Cycle> cycle_ = std::make_unique<Cycle>(CycleConfig{}, *meshes_);
  std::unique_ptr<CycleInput> input_ = std::make_unique<CycleInput>();
  std::unique_ptr<CycleOutput> output_ = std::make_unique<CycleOutput>();
  std::vector<Told> told_;
};

TEST_F(CycleTouch, WhoGoesOnToAnotherObjectTouchesThatOne) {
  build(0);
  at({-0.005, 0, 0.012});
  EXPECT_EQ(at({-0.005, 0, 0.009}), kOne);
  for (int i = 0; i < 100; ++i) at({-0.005 + 1e-4 * i, 0, 0.009});
  EXPECT_EQ(at({0.005, 0, 0.009}), kOther);
  EXPECT_EQ(at({0.005, 0, 0.012}), 0u);
  EXPECT_EQ(at({0.005, 0, 0.009}), kOther);
  EXPECT_EQ(told_, (std::vector{begin(kOne), end(kOne), begin(kOther), end(kOther), begin(kOther)}));
}

/** A hand on the low one comes to the side of the high one, leaves the low one upward, and the other sideways. */
TEST_F(CycleTouch, OfTwoAtOnceEachIsTold) {
  build(0.01);
  at({-0.005, 0, 0.012});
  at({-0.005, 0, 0.009});
  for (int i = 1; i <= 70; ++i) at({-0.00503 + 1e-4 * i, 0, 0.009});
  EXPECT_EQ(told_, (std::vector{begin(kOne), begin(kOther)}));
  EXPECT_NEAR(told_[1].force, 0.1, 0.1) << "its own, not that of both";
  for (int i = 1; i <= 30; ++i) at({0.00197, 0, 0.009 + 1e-4 * i});
  EXPECT_EQ(told_.back(), end(kOne));
  for (int i = 1; i <= 30; ++i) at({0.00197 - 1e-4 * i, 0, 0.012});
  EXPECT_EQ(told_, (std::vector{begin(kOne), begin(kOther), end(kOne), end(kOther)}));
}

}  // namespace
}  // namespace hapticd
