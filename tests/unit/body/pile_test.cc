// Piles of boxes: they lie as high as the boxes are, and still, also where upper ones weigh much more than those below.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ostream>
#include <vector>

#include "tests/support/stepped/tool_house.h"

namespace hapticd {
namespace {

using test::object;
using House = test::ToolHouse;

const Vec3 kHalf(0.03, 0.03, 0.02);

std::uint32_t boxId(std::size_t k) { return makeObjectId(10 + static_cast<std::uint32_t>(k), 1); }

void addBox(House& house, std::size_t k, const Vec3& half, double mass, const Vec3& at, double turn) {
  AddObject box = object(boxId(k), ShapeKind::kBox, half, at);
  store(fromRotationVector({0, 0, turn}), box.q);
  house.send(CommandKind::kAddObject, box);
  SetBody order{};
  order.object = boxId(k);
  order.falls = 1;
  order.mass = mass;
  const Mat3 inertia = MassProperties::ofBox(mass, 2 * half).inertia_O;
  for (int i = 0; i < 3; ++i) order.inertia[i] = inertia(i, i);
  house.send(CommandKind::kSetBody, order);
}

const FreeBody& body(const House& house, std::size_t k) {
  return house.servo->cycle().bodies().body(static_cast<std::uint8_t>(k));
}

/** From the lowest up. */
struct Pile {
  friend void PrintTo(const Pile& pile, std::ostream* out) {
    *out << "size " << pile.size << ":";
    for (const double mass : pile.masses) *out << " " << mass;
  }

  double size;  ///< Of kHalf.
  std::vector<double> masses;
};

class Piles : public ::testing::TestWithParam<Pile> {};

TEST_P(Piles, LieAsHighAsTheirBoxesAndStill) {
  const Pile& pile = GetParam();
  const std::size_t many = pile.masses.size();
  const Vec3 half = pile.size * kHalf;
  House house;
  for (std::size_t k = 0; k < many; ++k) {
    const double n = static_cast<double>(k);
    addBox(house, k, half, pile.masses[k], {0.3 + 1e-3 * pile.size * n, 0, (2 * n + 1) * half.z()}, 0.2 * n);
  }
  house.run(20);  // What touches is known when weight comes.
  house.send(CommandKind::kSetGravity, SetGravity{{0, 0, -9.81}});
  const auto energy = [&] {
    double sum = 0;
    for (std::size_t k = 0; k < many; ++k) {
      const FreeBody& b = body(house, k);
      sum += b.body.kineticEnergy() + b.reserve + b.body.mass() * 9.81 * b.body.com().z();
    }
    return sum;
  };
  const double had = energy();
  const Vec3 stood = body(house, 0).body.com();
  std::vector<double> sunk(many, 0.0);
  double most = -1, aside = 0, fastest = 0;
  for (int i = 0; i < 2000; ++i) {
    house.run(1);
    most = std::max(most, energy() - had);
    aside = std::max(aside, (body(house, 0).body.com() - stood).head<2>().norm());
    for (std::size_t k = 0; k < many; ++k) {
      sunk[k] = std::max(sunk[k], (2 * static_cast<double>(k) + 1) * half.z() - body(house, k).body.com().z());
      if (i > 1000) fastest = std::max(fastest, body(house, k).body.twist().v.norm());
    }
  }
  if (std::getenv("HAPTICD_SHOW")) {
    std::printf("size %.1f, %zu boxes up to %g kg: sunk %.2f um, aside %.2f um, %.1g m/s\n", pile.size, many,
                pile.masses.back(), 1e6 * sunk.back(), 1e6 * aside, fastest);
  }
  for (std::size_t k = 0; k < many; ++k) {
    EXPECT_LT(sunk[k], 1.1 * Tool::kSlop * static_cast<double>(k + 1)) << k;
    EXPECT_TRUE(body(house, k).asleep()) << k;
  }
  EXPECT_LT(aside, 20e-6) << "the lowest is not squeezed out";
  EXPECT_EQ(fastest, 0);
  EXPECT_LE(most, 1e-12 * had);
}

/** Up to as many as can move: their touches were more than the sweeps could do, and they buzzed at 1 mm/s for ever. */
TEST(FreeBodies, EqualBoxesStraightOnEachOtherFallAsleep) {
  const Vec3 half(0.02, 0.02, 0.01);
  for (const double aside : {0.0, 0.5e-3}) {
    for (std::size_t many = 6; many <= kMaxBodies; ++many) {
      House house;
      for (std::size_t k = 0; k < many; ++k) {
        const double n = static_cast<double>(k);
        addBox(house, k, half, 0.1, {0.3 + aside * static_cast<double>(k % 2), 0, (2 * n + 1) * half.z()}, 0);
      }
      house.run(20);
      house.send(CommandKind::kSetGravity, SetGravity{{0, 0, -9.81}});
      house.run(1000);
      const Vec3 top = body(house, many - 1).body.com();
      for (std::size_t k = 0; k < many; ++k) EXPECT_TRUE(body(house, k).asleep()) << k << " of " << many;
      EXPECT_NEAR(top.z(), (2 * static_cast<double>(many) - 1) * half.z(), Tool::kSlop) << many;
      EXPECT_NEAR(top.x(), 0.3 + aside * static_cast<double>((many - 1) % 2), Tool::kSlop) << many;
    }
  }
}

/** The hand's whole force goes through a body that weighs a hundredth of the tool. */
TEST(FreeBodies, ALightOnePressedHardOnTheFloorStays) {
  for (const double mass : {1e-3, 1e-2}) {
    House house;
    addBox(house, 0, {0.03, 0.03, 0.01}, mass, {0, 0, 0.01}, 0);
    house.send(CommandKind::kSetGravity, SetGravity{{0, 0, -9.81}});
    house.run(5);
    house.hold();
    house.aim({0.005, 0, -0.02}, Vec3(0.1, 0.05, 0));
    double sunk = 0;
    for (int i = 0; i < 2000; ++i) {
      house.run(1);
      sunk = std::max(sunk, 0.01 - body(house, 0).body.com().z());
    }
    const double force = house.out().command.force.z();
    EXPECT_GT(force, 8) << mass;
    const Vec3 lies = body(house, 0).body.com();
    double most = 0;
    for (int i = 0; i < 2000; ++i) {
      house.run(1);
      most = std::max(most, std::abs(house.out().command.force.z() - force));
      sunk = std::max(sunk, 0.01 - body(house, 0).body.com().z());
    }
    if (std::getenv("HAPTICD_SHOW"))
      std::printf("%g kg: sunk %.2f um, %.3g N of %.2f\n", mass, 1e6 * sunk, most, force);
    EXPECT_LT(sunk, 2 * Tool::kSlop) << mass;
    EXPECT_LT((body(house, 0).body.com() - lies).norm(), 1e-6) << mass;
    EXPECT_LT(most, 1e-3 * force) << mass;
  }
}

INSTANTIATE_TEST_SUITE_P(HeavyOnLight, Piles,
                         ::testing::Values(Pile{1, {0.02, 0.2}}, Pile{1, {0.02, 2}}, Pile{0.1, {1e-4, 1e-3}},
                                           Pile{0.1, {1e-4, 1e-2}}, Pile{1, {0.01, 0.1, 1}}, Pile{1, {0.1, 1, 10}},
                                           Pile{0.1, {1e-5, 1e-4, 1e-3}}, Pile{0.1, {1e-4, 1e-3, 1e-2}},
                                           Pile{1, {0.1, 0.1, 0.1, 0.1}}));

}  // namespace
}  // namespace hapticd
