// Client messages of every kind: validate(), and what passes goes through a cycle. Must hold: no crash, what passed
// passes again, all its numbers are finite, and the force that leaves the cycle is finite and within the limits.
//
// The first byte chooses a well-formed message, so that every kind is reached at once; the rest is either a list of
// patches to it or a whole payload.
#include <fuzzer/FuzzedDataProvider.h>

#include <cmath>
#include <vector>

#include "rt/ingest/validate.h"
#include "tests/support/stepped/messages.h"
#include "tests/support/stepped/stepped_cycle.h"

namespace {

using namespace hapticd;  // NOLINT(google-build-using-namespace)

void require(bool holds) {
  if (!holds) __builtin_trap();
}

constexpr double kForceLimit = 3;

hd_slot slotFrom(FuzzedDataProvider& data) {
  static const std::vector<test::Message> kGood = test::goodMessages();
  hd_slot slot = kGood[data.ConsumeIntegralInRange<std::size_t>(0, kGood.size() - 1)].slot;
  if (data.ConsumeBool()) {
    const std::uint32_t kept = data.ConsumeBool() ? slot.length : data.ConsumeIntegral<std::uint32_t>();
    data.ConsumeData(slot.payload, sizeof slot.payload);
    slot.length = kept;
    return slot;
  }
  auto* bytes = reinterpret_cast<unsigned char*>(&slot);
  while (data.remaining_bytes() > 2) {
    const auto at = data.ConsumeIntegralInRange<std::size_t>(4, sizeof slot - 1) & ~std::size_t{3};
    if (data.ConsumeBool()) {
      const auto number = static_cast<float>(data.ConsumeFloatingPoint<double>());
      std::memcpy(bytes + at, &number, sizeof number);
    } else if (data.ConsumeBool() && at + 8 <= sizeof slot) {
      const double number =
          data.ConsumeBool() ? data.ConsumeFloatingPointInRange<double>(-2, 2) : data.ConsumeFloatingPoint<double>();
      std::memcpy(bytes + (at & ~std::size_t{7}), &number, sizeof number);
    } else {
      const auto word = data.ConsumeIntegral<std::uint32_t>();
      std::memcpy(bytes + at, &word, sizeof word);
    }
  }
  return slot;
}

template <class... Vectors>
bool allFinite(const Vectors&... vectors) {
  bool finite = true;
  const auto check = [&](const auto& vector) {
    for (const auto x : vector) finite = finite && std::isfinite(x);
  };
  (check(vectors), ...);
  return finite;
}

/** No number that the servo computes with may be anything but a number. */
bool finite(const Command& command) {
  switch (command.kind) {
    case CommandKind::kObjectPose: {
      const auto& x = command.as<hd_object_pose>();
      return allFinite(x.p, x.q, x.v, x.w);
    }
    case CommandKind::kObjectVertices: {
      for (const auto& move : command.as<hd_object_vertices>().move) {
        if (!allFinite(move.p)) return false;
      }
      return true;
    }
    case CommandKind::kLocalModel: {
      const auto& x = command.as<hd_local_model>();
      for (const auto& h : x.halfspace) {
        if (!allFinite(h)) return false;
      }
      return allFinite(x.origin, x.normal) && std::isfinite(x.radius) && std::isfinite(x.material.stiffness);
    }
    case CommandKind::kForceField: {
      const auto& x = command.as<hd_force_field>();
      return allFinite(x.x0, x.f0, x.jacobian) && std::isfinite(x.radius);
    }
    case CommandKind::kClientForce:
      return allFinite(command.as<hd_client_force>().force, command.as<hd_client_force>().torque);
    case CommandKind::kIntent:
      return allFinite(command.as<hd_intent>().p, command.as<hd_intent>().q);
    default:
      return true;
  }
}

/** An armed device in contact with a sphere, session 0 alive; the command comes, and the hand moves on. */
void feel(const Command& command) {
  CycleConfig config;
  config.guard[0].limits = {kForceLimit, 0.1, 1e3, 1e2, 1, 10, 10, 5};
  config.guard[0].ramp_ns = config.period_ns;
  test::SteppedCycle hand(config);
  hand.put(CommandKind::kAddSession, SessionRef{});
  hand.add(test::solid(test::goodPose().object, ShapeKind::kSphere, test::kRubber, {}, {0.05, 0, 0}));
  hand.arm();
  for (int n = 0; n < 40; ++n) {
    if (n == 10) {
      Command& sent = hand.input->command[hand.input->command_count++] = command;
      sent.session = 0;
      sent.at_tick = 0;
    }
    const DeviceCommand& out = hand.at({0.0005 * n, 0, 0.052 - 0.0001 * n}).command;
    require(isFinite(out.force) && isFinite(out.torque));
    require(out.force.norm() <= kForceLimit * (1 + 1e-12));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  FuzzedDataProvider data(bytes, size);
  const hd_slot slot = slotFrom(data);
  Command out;
  if (validate(slot, 1, out) != ErrorCode::kOk) return 0;
  require(finite(out));
  hd_slot again = slot;
  std::memcpy(again.payload, out.payload, sizeof again.payload);
  Command twice;
  require(validate(again, 1, twice) == ErrorCode::kOk);
  feel(out);
  return 0;
}
