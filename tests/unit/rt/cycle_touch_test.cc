// What a hand touches is told in turns of a beginning and an end, both of one object.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "rt/cycle/cycle.h"
#include "tests/support/time.h"

namespace hapticd {
namespace {

TEST(CycleTouch, ATouchEndsByTheNameByWhichItBegan) {
  const auto meshes = std::make_unique<MeshTable>();
  const auto cycle = std::make_unique<Cycle>(CycleConfig{}, *meshes);
  const auto input = std::make_unique<CycleInput>();
  const auto output = std::make_unique<CycleOutput>();
  const std::uint32_t one = makeObjectId(1, 1), other = makeObjectId(2, 1);
  for (const std::uint32_t id : {one, other}) {
    AddObject tile{};
    tile.object = id;
    tile.flags = HD_OBJECT_ENABLED;
    tile.shape.kind = static_cast<std::uint32_t>(ShapeKind::kBox);
    store(Vec3(0.01, 0.01, 0.01), tile.shape.size);
    tile.material = {1000, 0, 0, 0};
    tile.p[0] = id == one ? -0.01 : 0.01;
    tile.q[0] = 1;
    Command& c = input->command[input->command_count++];
    c = Command{};
    c.kind = CommandKind::kAddObject;
    c.as<AddObject>() = tile;
  }
  std::vector<ServoEvent> told;
  const auto at = [&](const Vec3& x) {
    ++input->tick;
    input->now_ns += kMs;
    input->device[0].t_ns = input->now_ns;
    input->device[0].p = x;
    input->device[0].fresh = true;
    cycle->step(*input, *output);
    input->command_count = 0;
    for (std::uint32_t i = 0; i < output->events.count; ++i) {
      const ServoEvent& event = output->events.event[i];
      if (event.kind == ServoEventKind::kTouch || event.kind == ServoEventKind::kUntouch) told.push_back(event);
    }
    return output->device[0].contact.object;
  };
  at({-0.005, 0, 0.012});
  EXPECT_EQ(at({-0.005, 0, 0.009}), one);
  for (int i = 0; i < 100; ++i) at({-0.005 + 1e-4 * i, 0, 0.009});
  EXPECT_EQ(at({0.005, 0, 0.009}), other);
  EXPECT_EQ(at({0.005, 0, 0.012}), 0u);
  EXPECT_EQ(at({0.005, 0, 0.009}), other);
  ASSERT_EQ(told.size(), 3u);
  EXPECT_EQ(told[0].kind, ServoEventKind::kTouch);
  EXPECT_EQ(told[0].object, one);
  EXPECT_EQ(told[1].kind, ServoEventKind::kUntouch);
  EXPECT_EQ(told[1].object, one);
  EXPECT_EQ(told[2].object, other);
}

}  // namespace
}  // namespace hapticd
