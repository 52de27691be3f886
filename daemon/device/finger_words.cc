#include "daemon/device/finger_words.h"

#include <fmt/format.h>

#include <array>

#include "daemon/resource/resource_name.h"
#include "rt/finger/soft_finger.h"

namespace hapticd {
namespace {

// By PadLaw.
constexpr std::array<std::string_view, 6> kLaws = {"", "soft", "hertz", "modified-hertz", "viscous-sphere", "membrane"};

constexpr std::string_view kNoFinger = "none";

struct Number {
  std::string_view name;
  double SetFinger::*value;
  double most;
  bool positive;
  const char* unit;
};
constexpr Number kNumbers[] = {{"arm", &SetFinger::arm, SoftFinger::kMostArm, false, "m"},
                               {"radius", &SetFinger::radius, SoftFinger::kMostArm, true, "m"},
                               {"stiffness", &SetFinger::stiffness, SoftFinger::kMostStiffness, true, "N m/rad"},
                               {"damping", &SetFinger::damping, SoftFinger::kMostDamping, false, "N s/m"},
                               {"cue", &SetFinger::cue, SoftFinger::kMostCue, false, "N s/m"}};

/** What a fingertip is if nothing else is said. */
SetFinger usual() {
  SetFinger finger{};
  finger.radius = FingertipConstants::kRadius;
  finger.arm = FingertipConstants::kArm;
  finger.stiffness = 0.1;
  finger.damping = 2;
  return finger;
}

Error refusal(const std::string& where, std::string_view word, std::string remedy) {
  return Error{ErrorCode::kInvalidArgument, where, fmt::format("'{}' says nothing of a finger", word.substr(0, 40)),
               std::move(remedy)};
}

Result<void> take(std::string_view word, const std::string& where, SetFinger& finger) {
  if (word == "uncoupled") {
    finger.flags |= kFingerUncoupled;
    return {};
  }
  const std::size_t equals = word.find('=');
  for (const Number& number : kNumbers) {
    if (equals == std::string_view::npos || word.substr(0, equals) != number.name) continue;
    const auto n = parseNumbers(word.substr(equals + 1), 1, where);
    if (!n) return Error{n.error().code, where, fmt::format("{}: {}", number.name, n.error().what), n.error().remedy};
    const double x = n->front();
    if (!(x >= 0 && x <= number.most) || (number.positive && x == 0)) {
      return Error{ErrorCode::kInvalidArgument, where, fmt::format("{} = {:g} is out of range", number.name, x),
                   fmt::format("{} to {:g} {}", number.positive ? "above 0" : "0", number.most, number.unit)};
    }
    finger.*number.value = x;
    return {};
  }
  return refusal(where, word, "arm=, radius=, stiffness=, damping=, cue= or uncoupled: soft,arm=0.0062,cue=2");
}

}  // namespace

Result<SetFinger> parseFinger(std::string_view words, const std::string& where) {
  SetFinger finger = usual();
  if (words.empty() || words == kNoFinger) return finger;
  const std::string_view law = words.substr(0, words.find(','));
  while (finger.law < kLaws.size() && (finger.law == 0 || kLaws[finger.law] != law)) ++finger.law;
  if (finger.law == kLaws.size())
    return refusal(where, law, "begin with soft, hertz, modified-hertz, viscous-sphere or membrane; none takes it off");
  for (std::string_view rest = words.substr(law.size()); !rest.empty();) {
    const std::string_view word = rest.substr(1, rest.find(',', 1) - 1);
    rest.remove_prefix(1 + word.size());
    if (auto r = take(word, where, finger); !r) return r.error();
  }
  return finger;
}

std::string_view fingerLaw(const SetFinger& finger) {
  return finger.law < kLaws.size() ? kLaws[finger.law] : std::string_view();
}

}  // namespace hapticd
