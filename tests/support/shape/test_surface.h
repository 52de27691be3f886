/** @file
 * Surfaces and textures made by their formulas, for tests.
 */
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <vector>

#include "rt/scene/scene.h"

namespace hapticd::test {

/** Of a servo at 1 kHz, or with another period. */
inline SurfaceParameters ringing(double gain, double hz, double decay_s, double period_s = 1e-3) {
  const double r = std::exp(-period_s / decay_s), theta = 2 * std::numbers::pi * hz * period_s;
  SurfaceParameters s{};
  s.transient_gain = gain;
  s.transient_first = r * std::sin(theta);
  s.transient_turn = 2 * r * std::cos(theta);
  s.transient_decay = r * r;
  return s;
}

/** Pixels in memory; grey(column, row) from 0 to 1. */
struct TestRelief {
  std::vector<std::uint16_t> pixels;
  TextureView view;

  TestRelief(std::uint32_t width, std::uint32_t height,
             const std::function<double(std::uint32_t, std::uint32_t)>& grey) {
    for (std::uint32_t y = 0; y < height; ++y) {
      for (std::uint32_t x = 0; x < width; ++x)
        pixels.push_back(static_cast<std::uint16_t>(std::lround(65535 * grey(x, y))));
    }
    view.relief = {pixels.data(), width, height};
  }
};

/** Models at 1 kHz; the triangles are yours. */
struct TestVibration {
  std::vector<VibrationModel> models;
  std::vector<VibrationView::Corners> triangles;
  TextureView view;

  void finish() {
    VibrationView& v = view.vibration;
    v = {models.data(), triangles.data(), static_cast<std::uint32_t>(triangles.size()), 1e9, 0, 1e9, 0};
    for (const VibrationModel& m : models) {
      v.least_speed = std::min(v.least_speed, m.speed);
      v.most_speed = std::max(v.most_speed, m.speed);
      v.least_force = std::min(v.least_force, m.force);
      v.most_force = std::max(v.most_force, m.force);
    }
  }
};

}  // namespace hapticd::test
