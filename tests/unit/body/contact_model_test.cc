/** @file
 * Which of many contacts the local model keeps.
 */
#include "rt/body/contact_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "tests/support/seeds.h"

namespace hapticd {
namespace {

/** Sixty points of a peg in its hole: on rings of twelve, each 20 to 180 um off the wall; features count from 0. */
ContactSet nearPeg(std::mt19937_64& dice) {
  ContactSet found;
  std::uniform_real_distribution<double> gap(20e-6, 180e-6);
  for (std::uint32_t i = 0; i < 60; ++i) {
    const double angle = 2 * EIGEN_PI * (i % 12) / 12;
    Contact& c = found.contact[found.count++];
    c.n_W = -Vec3(std::cos(angle), std::sin(angle), 0);
    c.p_WA = -0.005 * c.n_W + Vec3(0, 0, 0.01 * (i / 12) - 0.02);
    c.depth = -gap(dice);
    c.p_WB = c.p_WA + c.depth * c.n_W;
    c.feature_a = i;
  }
  return found;
}

std::set<std::uint32_t> kept(const ContactSet& found, double reach) {
  ContactModel model;
  const ContactBody body;
  model.build(found, Pose{}, {&body, 1}, reach);
  std::set<std::uint32_t> out;
  for (std::uint32_t i = 0; i < model.count; ++i) out.insert((model.point[i].key & 0xffffffu) - 1);
  return out;
}

TEST(ContactModel, KeepsAllThatCarriesAToolThoughMuchMoreIsNear) {
  std::mt19937_64 dice(seedOf(11));
  for (int trial = 0; trial < 200; ++trial) {
    ContactSet found = nearPeg(dice);
    // Neighbours about both ends touch, as where a tilted peg jams; now and then one of them is the deepest.
    std::set<std::uint32_t> touching;
    const std::uint32_t around = static_cast<std::uint32_t>(dice() % 12);
    for (const std::uint32_t i : {around, (around + 1) % 12, 48 + (around + 6) % 12, 48 + (around + 7) % 12}) {
      found.contact[i].depth = 1e-6 * static_cast<double>(dice() % 30);
      touching.insert(i);
    }
    const std::set<std::uint32_t> at_rest = kept(found, 0);
    EXPECT_EQ(at_rest.size(), kMaxTouches);
    EXPECT_TRUE(std::includes(at_rest.begin(), at_rest.end(), touching.begin(), touching.end()));
  }
}

/** What closes before the next answer stays, however much lies elsewhere and in other directions that cannot. */
TEST(ContactModel, KeepsWhatWillTouchRatherThanWhatIsFarApart) {
  constexpr double kReach = 2e-4;
  std::mt19937_64 dice(seedOf(12));
  ContactSet found = nearPeg(dice);
  for (std::uint32_t i = 0; i < found.count; ++i) found.contact[i].depth -= 4e-4;
  found.contact[30].depth = 1e-5;  // The deepest,
  Contact& close = found.contact[found.count];
  close = found.contact[30];  // and 3 mm beside it what will touch, its normal 6 degrees off.
  close.p_WA.z() += 0.003;
  close.n_W = (close.n_W + Vec3(0, 0, 0.1)).normalized();
  close.depth = -0.3 * kReach;
  close.feature_a = found.count++;
  EXPECT_TRUE(kept(found, kReach).contains(60));
}

/** Of more than fit, what touches is not left out for what is apart close beside it, though that was there before. */
TEST(ContactModel, KeepsTheDeeperOfTwoThatAreNear) {
  constexpr double kReach = 3e-4;
  std::mt19937_64 dice(seedOf(13));
  ContactSet found = nearPeg(dice);
  found.count = kMaxTouches;
  found.contact[0].depth = 1e-4;  // The deepest.
  Contact& touches = found.contact[found.count];
  touches = found.contact[5];
  touches.p_WA.z() += 0.0015;
  touches.depth = 5e-5;
  touches.feature_a = 60;
  found.contact[5].depth = -2e-4;
  ++found.count;
  ContactSet before;
  before.contact[before.count++] = found.contact[5];
  ContactModel model;
  const ContactBody body;
  model.build(before, Pose{}, {&body, 1}, kReach);
  model.build(found, Pose{}, {&body, 1}, kReach);
  EXPECT_TRUE(model.has(60 + 1));
}

TEST(ContactModel, WhatRestsOnManyKeepsItsSet) {
  // A rough face of 64 points, all within some micrometres, of which now one and now another is the deepest.
  std::mt19937_64 dice(seedOf(5));
  std::uniform_real_distribution<double> depth(-4e-6, 4e-6);
  ContactModel model;
  const ContactBody body;
  std::set<std::uint32_t> first;
  for (int answer = 0; answer < 200; ++answer) {
    ContactSet found;
    for (std::uint32_t i = 0; i < 64; ++i) {
      Contact& c = found.contact[found.count++];
      c.p_WA = Vec3(0.005 * (i % 8), 0.005 * (i / 8), 0);
      c.n_W = Vec3::UnitZ();
      c.depth = depth(dice);
      c.p_WB = c.p_WA + c.depth * c.n_W;
      c.feature_a = i;
    }
    model.build(found, Pose{}, {&body, 1}, 0);
    std::set<std::uint32_t> keys;
    for (std::uint32_t i = 0; i < model.count; ++i) keys.insert(model.point[i].key);
    if (answer == 0) first = keys;
    EXPECT_EQ(keys, first) << answer;
  }
}

TEST(ContactModel, OfWhatAFastToolMayReachItKeepsTheOutermost) {
  // A plate comes down tilted, so that one edge is 0.1 mm nearer than the other; all may land before the next answer.
  ContactSet found;
  for (std::uint32_t i = 0; i < 64; ++i) {
    Contact& c = found.contact[found.count++];
    c.p_WA = Vec3(0.005 * (i % 8), 0.005 * (i / 8), 0);
    c.n_W = Vec3::UnitZ();
    c.depth = -1e-6 - 100e-6 * (i % 8) / 7;
    c.p_WB = c.p_WA + c.depth * c.n_W;
    c.feature_a = i;
  }
  const std::set<std::uint32_t> fast = kept(found, 1e-3);
  for (const std::uint32_t corner : {0u, 7u, 56u, 63u}) EXPECT_TRUE(fast.count(corner)) << corner;
}

}  // namespace
}  // namespace hapticd
