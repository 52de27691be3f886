/** @file
 * What theory says about the stiffness of a virtual wall. K stiffness [N/m], B virtual damping, b that of the device
 * [N s/m], T the tick [s].
 */
#pragma once

#include <cstdint>

namespace haptic_bench::zwidth {

/**
 * Colgate and Schenkel, Passivity of a class of sampled-data systems (J. Robotic Systems 14(1), 1997; American Control
 * Conference 1994): b > K T / 2 + |B|, for any hand that is passive. The largest such K; 0 where there is none.
 */
[[nodiscard]] double colgate(double device_damping, double damping, double tick_s);

/**
 * The same paper's general condition for a wall H(z) = (K + B (1 - 1/z) / T) z^-delay:
 * b > T/2 Re{(1 - e^-jwT) H(e^jwT)} / (1 - cos wT) for 0 <= w <= pi/T. For delay 0 it is the above.
 */
[[nodiscard]] double colgateDelayed(double device_damping, double damping, double tick_s, std::uint32_t delay);

/**
 * Diolaiti, Niemeyer, Barbagli, Salisbury (IEEE Trans. Robotics 22(2), 2006; with Abbott and Okamura, IEEE Trans.
 * Robotics 21(5), 2005): an encoder step gives energy that dry friction c must take, c >= K step / 2. The largest such
 * K, whatever the rate; infinite for a step of 0. Beyond it, but within the limit for linear motion, the wall hunts.
 */
[[nodiscard]] double frictionLimit(double friction, double step);

}  // namespace haptic_bench::zwidth
