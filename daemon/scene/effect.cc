#include "daemon/scene/effect.h"

#include <fmt/format.h>

#include <iterator>

#include "daemon/scene/invalid.h"
#include "rt/ingest/limits.h"

namespace hapticd {
namespace {

constexpr double kLeastReach = 1e-3;   ///< Shorter ones a hand passes within a tick or two [m].
constexpr double kFastestSwing = 400;  ///< As of impacts: well below half of a servo's rate.
constexpr double kMostSeconds = 3600;

constexpr const char* kEffectNames[] = {"none", "force", "viscous", "friction", "vibration", "guide"};

}  // namespace

Result<void> checkEffect(const EffectSpec& e, const std::string& where) {
  const struct {
    const char* name;
    double value, lower, upper;
    const char *unit, *remedy;
  } numbers[] = {
      {".force", e.force, 0, limits::kForce, "N", "one or a few are felt well"},
      {".stiffness", e.stiffness, 0, limits::kStiffness, "N/m", "a guide has some hundred"},
      {".damping", e.damping, 0, limits::kDamping, "N s/m", "one or a few are felt well"},
      {".reach", e.reach, kLeastReach, limits::kCoordinate, "m", "0.02 is two centimetres"},
      {".hz", e.hz, 0, kFastestSwing, "Hz", "a hand feels 50 to 300 best"},
      {".durationS", e.duration_s, 0, kMostSeconds, "s", "0 is without end"},
  };
  for (const auto& n : numbers) {
    if (auto r = inRange(n.value, n.lower, n.upper, where + n.name, n.unit, n.remedy); !r) return r;
  }
  if (e.path.size() == 1 || e.path.size() > kMaxPathPoints) {
    return invalid(
        where + ".path",
        fmt::format("{} point{}; a path has 2 to {}", e.path.size(), e.path.size() == 1 ? "" : "s", kMaxPathPoints),
        "a longer one is made of several objects; without points the object itself guides");
  }
  for (std::size_t i = 0; i < e.path.size(); ++i) {
    if (isFinite(e.path[i]) && e.path[i].cwiseAbs().maxCoeff() <= limits::kCoordinate) continue;
    return invalid(where + ".path", fmt::format("point {} is not within {} m", i + 1, limits::kCoordinate),
                   "points are in metres");
  }
  return {};
}

const char* effectName(EffectKind kind) noexcept {
  const auto i = static_cast<std::size_t>(kind);
  return i < std::size(kEffectNames) ? kEffectNames[i] : "unknown";
}

Result<EffectKind> parseEffect(std::string_view word, const std::string& where) {
  for (std::size_t i = 0; i < std::size(kEffectNames); ++i) {
    if (word == kEffectNames[i]) return static_cast<EffectKind>(i);
  }
  return invalid(where, fmt::format("'{}' is no effect", word.substr(0, 40)),
                 "none, force, viscous, friction, vibration or guide");
}

EffectParameters effectParameters(const EffectSpec& e, std::int64_t until_ns) {
  EffectParameters out{};
  out.kind = static_cast<std::uint32_t>(e.kind);
  out.points = static_cast<std::uint32_t>(e.path.size());
  out.force = e.force;
  out.stiffness = e.stiffness;
  out.damping = e.damping;
  out.reach = e.reach;
  out.frequency = e.hz;
  out.until_ns = until_ns;
  for (std::size_t i = 0; i < e.path.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) out.path[i][axis] = static_cast<float>(e.path[i][axis]);
  }
  return out;
}

}  // namespace hapticd
