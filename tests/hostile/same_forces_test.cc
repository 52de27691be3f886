// What one client does to its own memory must not be felt by anybody else: the same forces to the bit, the same work.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <random>
#include <vector>

#include "tests/support/seeds.h"
#include "tests/support/stepped/house.h"

namespace hapticd {
namespace {

using test::House;

constexpr int kCycles = 3000;

hd_local_model honestModel(int i) {
  hd_local_model model{};
  model.kind = HD_MODEL_PLANE;
  model.lease_ns = 100'000'000;
  model.blend_ns = 10'000'000;
  model.material = {600, 1, 0.5, 0.3};
  model.origin[2] = 0.001 * (i % 5);
  model.normal[2] = 1;
  return model;
}

/** Forces of a session that pushes a model every 33 cycles while `attack` works on the other session's memory. */
std::vector<double> forces(const std::function<void(hd_region_b&, int)>& attack) {
  House house("sim://default?motion=circle&radius=0.02&centre=0,0,0.004&hand_stiffness=500");
  house.attach(1);
  std::vector<double> trace;
  for (int i = 0; i < kCycles; ++i) {
    if (i % 33 == 0) house.push(HD_COMMAND_LOCAL_MODEL, honestModel(i));
    attack(*house.region[1].b, i);
    house.step();
    EXPECT_LE(house.servo->lastInput().command_count, kMaxCommandsPerCycle);
    const Vec3& force = house.servo->lastOutput().device[0].command.force;
    trace.insert(trace.end(), {force.x(), force.y(), force.z()});
  }
  return trace;
}

void expectUnfelt(const std::function<void(hd_region_b&, int)>& attack) {
  const std::vector<double> calm = forces([](hd_region_b&, int) {});
  const std::vector<double> attacked = forces(attack);
  ASSERT_EQ(calm.size(), attacked.size());
  EXPECT_EQ(std::memcmp(calm.data(), attacked.data(), calm.size() * sizeof(double)), 0);
  EXPECT_TRUE(std::any_of(calm.begin(), calm.end(), [](double f) { return std::abs(f) > 0.1; }))
      << "nothing was felt: the test proves nothing";
}

void scribble(std::mt19937& random, void* memory, std::size_t bytes) {
  auto* out = static_cast<unsigned char*>(memory);
  for (std::size_t k = 0; k < bytes; ++k) out[k] = static_cast<unsigned char>(random());
}

TEST(SameForces, WhileIndicesAreScribbled) {
  std::mt19937 random(seedOf(1));
  expectUnfelt([&random](hd_region_b& b, int) { b.tail = static_cast<std::uint32_t>(random()); });
}

TEST(SameForces, WhileTheWholeRegionIsScribbled) {
  std::mt19937 random(seedOf(2));
  expectUnfelt([&random](hd_region_b& b, int i) {
    if (i % 50 == 0) scribble(random, &b, sizeof b);
  });
}

TEST(SameForces, WhilePlausibleTailsBringScribbledSlots) {
  std::mt19937 random(seedOf(3));
  std::uint64_t seq = 0;
  expectUnfelt([&](hd_region_b& b, int) {
    for (int k = 0; k < 20; ++k) {
      hd_slot& slot = b.ring[b.tail % HD_RING_SLOTS];
      scribble(random, &slot, sizeof slot);
      slot.kind = 1 + static_cast<std::uint32_t>(random()) % HD_COMMAND_KINDS;
      slot.length = static_cast<std::uint32_t>(random()) % 2 ? 384 : static_cast<std::uint32_t>(random()) % 600;
      slot.seq = ++seq;
      slot.at_tick = 0;
      ++b.tail;
    }
  });
}

TEST(SameForces, WhileMailboxesAreScribbled) {
  std::mt19937 random(seedOf(4));
  expectUnfelt([&random](hd_region_b& b, int) {
    for (hd_slot& mailbox : b.mailbox) {
      scribble(random, &mailbox, sizeof mailbox);
      mailbox.guard &= ~1u;
    }
  });
}

TEST(SameForces, WhileAFloodFillsTheRing) {
  std::uint64_t seq = 0;
  expectUnfelt([&seq](hd_region_b& b, int) {
    for (std::uint32_t k = 0; k < HD_RING_SLOTS / 2; ++k) {
      hd_slot& slot = b.ring[(b.tail + k) % HD_RING_SLOTS];
      slot = {};
      slot.kind = HD_COMMAND_CLEAR_MODEL;
      slot.length = sizeof(hd_clear_model);
      slot.seq = ++seq;
    }
    b.tail += 8;
  });
}

}  // namespace
}  // namespace hapticd
