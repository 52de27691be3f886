// What the library refuses of a push is what the daemon would refuse, field by field, and it is told in words.
#include "libclient/src/session/push_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "rt/ingest/limits.h"
#include "rt/ingest/validate.h"

namespace hapticd::client {
namespace {

constexpr std::uint32_t kDevices = 2;

template <class T>
bool daemonTakes(std::uint32_t kind, const T& command) {
  hd_slot slot{};
  slot.kind = kind;
  slot.length = sizeof command;
  std::memcpy(slot.payload, &command, sizeof command);
  Command out;
  return validate(slot, kDevices, out) == ErrorCode::kOk;
}

/** Numbers at, just within and just beyond every bound. */
std::vector<double> awkward() {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInfinity = std::numeric_limits<double>::infinity();
  std::vector<double> all{kNan, kInfinity, -kInfinity, 0, -0.0, 0.5, -3};
  for (const double bound :
       {1.0, 1 - limits::kUnitTolerance, 1 + limits::kUnitTolerance, limits::kCoordinate, limits::kSpeed,
        limits::kAngularSpeed, limits::kStiffness, limits::kDamping, limits::kFriction, limits::kForce, limits::kTorque,
        limits::kGripper, limits::kRadiusMin}) {
    for (const double x : {bound, bound * (1 - 1e-6), bound * (1 + 1e-6)}) all.insert(all.end(), {x, -x});
  }
  return all;
}

/** Puts an awkward number into a place of the structure, as whatever may stand there. */
template <class T>
void spoil(T& command, std::mt19937& random) {
  static const std::vector<double> kNumbers = awkward();
  constexpr std::int64_t kTimes[] = {
      0, 1, -1, limits::kLeaseNs, limits::kLeaseNs + 1, limits::kBlendNs, limits::kBlendNs + 1};
  auto* bytes = reinterpret_cast<unsigned char*>(&command);
  const auto put = [&](auto value) {
    const std::size_t at = random() % (sizeof command / sizeof value) * sizeof value;
    std::memcpy(bytes + at, &value, sizeof value);
  };
  switch (random() % 4) {
    case 0:
      return put(kNumbers[random() % kNumbers.size()]);
    case 1:
      return put(static_cast<float>(kNumbers[random() % kNumbers.size()]));
    case 2:
      return put(kTimes[random() % std::size(kTimes)]);
    default:
      return put(static_cast<std::uint32_t>(random() % 30));
  }
}

/** Good commands, spoilt in one place or three, are judged alike here and there. */
template <class T>
void compare(std::uint32_t kind, const T& good) {
  std::mt19937 random(7);
  ASSERT_FALSE(objection(good, kDevices)) << objection(good, kDevices).where;
  ASSERT_TRUE(daemonTakes(kind, good));
  int refused = 0, taken = 0;
  for (int i = 0; i < 40000; ++i) {
    T command = good;
    for (int n = i % 4 == 0 ? 3 : 1; n > 0; --n) spoil(command, random);
    const Objection why = objection(command, kDevices);
    if (why && why.where == std::string("object")) continue;  // The cycle refuses it, who knows the scene.
    ASSERT_EQ(!why, daemonTakes(kind, command)) << "case " << i << ": " << (why ? why.where : "the library takes it");
    ++(why ? refused : taken);
    if (!why) continue;
    EXPECT_NE(*why.what, 0);
    EXPECT_NE(*why.remedy, 0) << why.where;
  }
  EXPECT_GT(std::min(refused, taken), 400);
}

haptic_local_model model(std::uint32_t kind) {
  haptic_local_model good = HAPTIC_LOCAL_MODEL_INIT;
  good.kind = kind;
  good.normal[2] = 1;
  good.radius = 0.02;
  good.count = 2;
  for (auto& plane : good.halfspace) plane[1] = -1;
  return good;
}

TEST(PushCheck, RefusesWhatTheDaemonWouldRefuse) {
  haptic_object_pose pose = HAPTIC_OBJECT_POSE_INIT;
  pose.object = 3;
  compare(HD_COMMAND_OBJECT_POSE, pose);
  compare(HD_COMMAND_OBJECT_MATERIAL, haptic_object_material{3, 0, {800, 1, 0.4, 0.3}});
  compare(HD_COMMAND_OBJECT_FLAGS, haptic_object_flags{3, 7, 1, 0});
  haptic_object_vertices vertices{3, 2, {}};
  compare(HD_COMMAND_OBJECT_VERTICES, vertices);
  for (const std::uint32_t kind :
       {HAPTIC_MODEL_PLANE, HAPTIC_MODEL_SPRING, HAPTIC_MODEL_SPHERE, HAPTIC_MODEL_HALFSPACES, HAPTIC_MODEL_CORNER}) {
    SCOPED_TRACE(kind);
    compare(HD_COMMAND_LOCAL_MODEL, model(kind));
  }
  haptic_force_field field = HAPTIC_FORCE_FIELD_INIT;
  field.radius = 0.01;
  compare(HD_COMMAND_FORCE_FIELD, field);
  compare(HD_COMMAND_CLEAR_MODEL, haptic_clear_model{1, 0, 0});
  compare(HD_COMMAND_CLIENT_FORCE, haptic_client_force HAPTIC_CLIENT_FORCE_INIT);
  compare(HD_COMMAND_INTENT, haptic_intent HAPTIC_INTENT_INIT);
  compare(HD_COMMAND_LIMITS, haptic_session_limits{3, 0.1});
}

TEST(PushCheck, NamesTheFieldAndTheEntry) {
  haptic_local_model plane{};
  plane.kind = HAPTIC_MODEL_PLANE;
  EXPECT_STREQ(objection(plane, kDevices).where, "lease_ns");
  plane.lease_ns = 1;
  EXPECT_STREQ(objection(plane, kDevices).where, "normal");
  haptic_local_model patch = model(HAPTIC_MODEL_HALFSPACES);
  patch.halfspace[1][1] = 2;
  EXPECT_STREQ(objection(patch, kDevices).where, "halfspace[%u]");
  EXPECT_EQ(objection(patch, kDevices).index, 1u);
  EXPECT_STREQ(objection(haptic_intent{}, kDevices).where, "q");
}

}  // namespace
}  // namespace hapticd::client
