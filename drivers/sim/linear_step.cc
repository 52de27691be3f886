#include "drivers/sim/linear_step.h"

namespace hapticd {

LinearStep LinearStep::make(double mass, double damping, double stiffness, double step_s) {
  // d/dt (x, v h, u h^2 / m) in units of the step h: dimensionless, entries of order one or the system's own rates.
  Mat3 a = Mat3::Zero();
  a(0, 1) = 1;
  a(1, 0) = -stiffness / mass * step_s * step_s;
  a(1, 1) = -damping / mass * step_s;
  a(1, 2) = 1;

  int halvings = 0;
  for (double size = a.cwiseAbs().rowwise().sum().maxCoeff(); size > 0.5 && halvings < 60; size *= 0.5) ++halvings;
  a *= std::ldexp(1.0, -halvings);
  Mat3 power = Mat3::Identity(), sum = Mat3::Identity();
  for (int n = 1; n <= 18; ++n) {  // 0.5^19 / 19! < 1e-22.
    power = (power * a / n).eval();
    sum += power;
  }
  for (int n = 0; n < halvings; ++n) sum = (sum * sum).eval();

  LinearStep step;
  step.xx = sum(0, 0);
  step.xv = sum(0, 1) * step_s;
  step.xu = sum(0, 2) * step_s * step_s / mass;
  step.vx = sum(1, 0) / step_s;
  step.vv = sum(1, 1);
  step.vu = sum(1, 2) * step_s / mass;
  return step;
}

}  // namespace hapticd
