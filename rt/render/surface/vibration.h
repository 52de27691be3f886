/** @file
 * Vibration of a tool that is drawn over a textured surface, synthesised from models of recorded acceleration
 * (Culbertson, Lopez Delgado, Kuchenbecker, "One hundred data-driven haptic texture models", IEEE Haptics Symposium
 * 2014).
 */
#pragma once

#include <array>
#include <cstdint>

#include "rt/base/contract.h"
#include "rt/scene/texture.h"

namespace hapticd {

/**
 * The filter of one device point. Servo thread only; bounded, and the same seed and inputs give the same bits.
 *
 * Between three models their reflection coefficients are interpolated where the paper interpolates line spectral
 * frequencies: both keep every mean stable, and these need no roots in the servo. The lattice is the normalised one of
 * Gray and Markel ("A normalized digital filter structure", IEEE Trans. ASSP 23(3), 1975): its output has unit
 * variance, and its energy grows by that of the noise at most, however the models change. The interpolated power scales
 * it outside, so that silence is silent at once.
 */
class Vibration {
 public:
  explicit Vibration(std::uint64_t seed = 0) noexcept : seed_(seed) { reset(); }

  /** The next acceleration [m/s^2] at a speed [m/s] and normal force [N]; zero where one of them is. */
  [[nodiscard]] double step(const VibrationView& view, double speed, double force) HD_RT;

  /** Contact was lost: silence. The noise goes on where it was. */
  void rest() HD_RT {
    state_.fill(0);
    triangle_ = 0;
  }
  void reset() HD_RT {
    rest();
    noise_ = seed_;
  }

 private:
  /** Three models and their weights. */
  struct Mix {
    std::array<const VibrationModel*, 3> model;
    std::array<double, 3> weight;
  };
  [[nodiscard]] Mix mixAt(const VibrationView& view, double speed, double force) HD_RT;
  [[nodiscard]] double whiteNoise() HD_RT;

  std::uint64_t seed_;
  std::uint64_t noise_ = 0;
  std::uint32_t triangle_ = 0;                     ///< Where the last tick was.
  std::array<double, kVibrationOrder + 1> state_;  ///< Backward prediction errors of the last tick.
};

}  // namespace hapticd
