// A reading that is not to be used makes the tool forget: it starts anew where the hand next is.
#include <gtest/gtest.h>

#include <limits>
#include <memory>

#include "tests/support/stepped/tool_house.h"

namespace hapticd {
namespace {

using test::kFloor;

/** The box pressed on the floor; its inputs go on in a cycle of the test's own. */
class ToolReading : public testing::Test {
 protected:
  ToolReading() {
    house_.hold();
    house_.aim({0, 0, -0.015});
    house_.run(1000);
    EXPECT_EQ(house_.out().contact.object, kFloor);
    EXPECT_GT(house_.out().command.force.z(), 1);
    cycle_ = test::expectTheSameForces(house_);
    input_ = house_.inputs.back().whole();
    input_.command_count = 0;
  }
  const DeviceOutput& read(const Vec3& p) {
    ++input_.tick;
    input_.now_ns += test::kPeriodNs;
    input_.device[0].t_ns = input_.now_ns;
    input_.device[0].p = p;
    cycle_->step(input_, *output_);
    return output_->device[0];
  }
  [[nodiscard]] const HeldTool& tool() const { return cycle_->tool(0); }

  test::ToolHouse house_;
  std::unique_ptr<Cycle> cycle_;
  CycleInput input_;
  std::unique_ptr<CycleOutput> output_ = std::make_unique<CycleOutput>();
};

TEST_F(ToolReading, AfterOneThatIsNotToBeUsedTheToolIsWhereTheHandIs) {
  const Vec3 bad = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  ASSERT_EQ(read(bad).guard.fault, HD_FAULT_NOT_FINITE);
  // As far below the floor as the hand was, with the contacts of before it would be pushed out.
  for (const Vec3& next : {Vec3(0.05, 0.02, 0.06), Vec3(0.05, 0.02, -0.015)}) {
    read(bad);
    const DeviceOutput& out = read(next);
    EXPECT_LT((tool().tool().body().pose().p - next).norm(), 1e-12) << "nothing drags it there";
    EXPECT_LT(tool().last().on_device.force.norm(), 1e-9);
    EXPECT_EQ(out.contact.object, 0u);
  }
}

/** Else it would go on with the speed that it had, for as long as nothing is read. */
TEST_F(ToolReading, WithoutOneThatIsToBeUsedTheToolStands) {
  const Vec3 bad = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  for (int i = 0; i < 100; ++i) read({2e-4 * i, 0, 0.04});
  const SceneObject& object = *cycle_->scene().find(test::kTool);
  ASSERT_GT(object.V_WO.v.x(), 0.1);
  const Vec3 last = object.X_WO.p;
  for (int i = 0; i < 100; ++i) read(bad);
  EXPECT_LT((object.X_WO.p - last).norm(), 1e-3);
}

}  // namespace
}  // namespace hapticd
