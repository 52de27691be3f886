/** @file
 * The stability limit of the linear part of the loop, exactly.
 */
#pragma once

#include <cstdint>

#include "tools/haptic-bench/zwidth/loop.h"

namespace haptic_bench::zwidth {

/**
 * Largest modulus of the eigenvalues of the loop in steady contact; below 1 it is stable. Mass, viscous friction and
 * hand are discretised by the simulator's own exact step over a tick; the force -K x[n] - B (x[n] - x[n-m]) / (m T) is
 * held for a tick and `delay` ticks late. m, `window`, is that of the cycle's velocity estimator: 1 in motion that is
 * large against an encoder step, up to VelocityEstimator::kWindow - 1 near rest. Encoder steps, dry friction and the
 * loss of contact are left out.
 */
[[nodiscard]] double spectralRadius(const Loop& loop, double stiffness, double damping, std::uint32_t window = 1);

/** Upper end of the highest interval of stable stiffness [N/m], to 1e-6 of it; 0 when no stiffness is stable. */
[[nodiscard]] double eigenvalueLimit(const Loop& loop, double damping, std::uint32_t window = 1);

/** The least of the limits over all windows: what small motion, at which the estimator averages, must do with [N/m]. */
[[nodiscard]] double slowestLimit(const Loop& loop, double damping);

}  // namespace haptic_bench::zwidth
