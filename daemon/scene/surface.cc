#include "daemon/scene/surface.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "daemon/scene/invalid.h"
#include "daemon/scene/texture/texture_store.h"

namespace hapticd {
namespace {

constexpr double kMostSmooth = 90;                         // [degree]
constexpr double kMostGain = 1000;                         // [N s/m]
constexpr double kLeastHz = 10, kMostHz = 400;             // Below half the slowest servo's rate.
constexpr double kLeastDecay = 1e-3, kMostDecay = 0.2;     // [s]
constexpr double kMostReliefDepth = 0.02;                  // [m]
constexpr double kLeastPicture = 1e-4, kMostPicture = 10;  // [m]
constexpr double kMostMass = 1;                            // [kg]

Result<const TextureInfo*> find(std::uint64_t id, bool relief, const TextureStore& textures, const std::string& where) {
  const TextureInfo* texture = textures.find(id);
  if (texture == nullptr) {
    return Error{ErrorCode::kNotFound, where, fmt::format("there is no texture {}", id), "upload it first"};
  }
  if (texture->is_relief == relief) return texture;
  return invalid(where, fmt::format("texture {} is a {}", id, relief ? "vibration" : "relief"),
                 fmt::format("choose a {}", relief ? "relief" : "vibration"));
}

/** With three digits, downward: what is advised is taken. */
double shortened(double x) {
  const double digit = std::pow(10, std::floor(std::log10(x)) - 2);
  return std::floor((1 - 1e-9) * x / digit) * digit;
}

/** Neighbours along one side of the picture. */
struct Direction {
  const SteepestStep& steepest;
  double pixel;  ///< [m]
  const char* name;
  /** Along this side no slope is beyond that of the steepest step between two pixels; for each metre of depth. */
  [[nodiscard]] double steepness() const { return steepest.grey / pixel; }
};

Result<void> checkRelief(const SurfaceSpec& s, const TextureStore& textures, const std::string& where) {
  auto texture = find(s.relief, true, textures, where + ".relief");
  if (!texture) return texture.error();
  const Direction across{(*texture)->across, s.relief_width / (*texture)->width, "right"};
  const Direction down{(*texture)->down, s.relief_height / (*texture)->height, "below"};
  const Direction& worst = across.steepness() >= down.steepness() ? across : down;
  std::string place = fmt::format("the step {} of pixel {},{}", worst.name, worst.steepest.column, worst.steepest.row);
  double steepness = worst.steepness();
  for (const ReliefSlope& slope : (*texture)->slopes) {  // Aslant it may be steeper than along either side.
    const double aslant = std::hypot(slope.across / across.pixel, slope.down / down.pixel);
    if (aslant <= steepness * (1 + 1e-6)) continue;
    steepness = aslant;
    place = fmt::format("the surface at pixel {},{}", slope.column, slope.row);
  }
  const double slope = s.relief_depth * steepness;
  if (slope <= kMostSlope) return {};
  return invalid(where + ".reliefDepth",
                 fmt::format("{} has a slope of {:.3g}; {} is the most", place, slope, kMostSlope),
                 fmt::format("make the depth at most {:.3g} m, the picture larger, or blur it",
                             shortened(kMostSlope / steepness)));
}

}  // namespace

Result<void> checkSurface(const SurfaceSpec& s, const TextureStore& textures, const std::string& where) {
  const struct {
    const char* name;
    double value, lower, upper;
    const char *unit, *remedy;
  } numbers[] = {
      {".smoothDeg", s.smooth_deg, 0, kMostSmooth, "degrees", "30 rounds facets and leaves right angles sharp"},
      {".transientGain", s.transient_gain, 0, kMostGain, "N s/m", "5 is soft wood, 30 stone"},
      {".transientHz", s.transient_hz, kLeastHz, kMostHz, "Hz", "low is wood, high is metal"},
      {".transientDecay", s.transient_decay_s, kLeastDecay, kMostDecay, "s", "it rings so long, to 1/e: 0.01"},
      {".reliefDepth", s.relief_depth, 0, kMostReliefDepth, "m", "0.0002 is a fifth of a millimetre"},
      {".reliefWidth", s.relief_width, kLeastPicture, kMostPicture, "m", "0.1 is ten centimetres"},
      {".reliefHeight", s.relief_height, kLeastPicture, kMostPicture, "m", "0.1 is ten centimetres"},
      {".vibrationMass", s.vibration_mass, 0, kMostMass, "kg", "0.05 is felt as recorded"},
  };
  for (const auto& n : numbers) {
    if (auto r = inRange(n.value, n.lower, n.upper, where + n.name, n.unit, n.remedy); !r) return r;
  }
  if (s.relief != 0) {
    if (auto r = checkRelief(s, textures, where); !r) return r;
  }
  if (s.vibration != 0) {
    if (auto texture = find(s.vibration, false, textures, where + ".vibration"); !texture) return texture.error();
  }
  return {};
}

SurfaceParameters surfaceParameters(const SurfaceSpec& s, const TextureStore& textures, std::int64_t period_ns) {
  SurfaceParameters out{};
  if (s.smooth_deg > 0) out.smooth_cosine = std::cos(s.smooth_deg * std::numbers::pi / 180);
  const double period = static_cast<double>(period_ns) * 1e-9;
  const double r = std::exp(-period / s.transient_decay_s), theta = 2 * std::numbers::pi * s.transient_hz * period;
  out.transient_gain = s.transient_gain;
  out.transient_first = r * std::sin(theta);
  out.transient_turn = 2 * r * std::cos(theta);
  out.transient_decay = r * r;
  out.relief = textures.referenceTo(s.relief);
  out.relief_depth = s.relief_depth;
  out.relief_size[0] = s.relief_width;
  out.relief_size[1] = s.relief_height;
  out.vibration = textures.referenceTo(s.vibration);
  out.vibration_mass = s.vibration_mass;
  return out;
}

}  // namespace hapticd
