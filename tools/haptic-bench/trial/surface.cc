#include "tools/haptic-bench/trial/surface.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/option.h"

namespace haptic_bench {

void addSurface(CLI::App& sub, Surface& surface) {
  bounded(&sub, "--stiffness", surface.stiffness, "Stiffness of the surface [N/m]", 1e-3, 1e5);
  bounded(&sub, "--damping", surface.damping, "Damping of the surface along its normal [N s/m]", 0.0, 1e3);
  bounded(&sub, "--friction-static", surface.friction_static, "Coefficient of friction at rest", 0.0, 10.0);
  bounded(&sub, "--friction-dynamic", surface.friction_dynamic, "Coefficient of friction while sliding", 0.0, 10.0);
  bounded(&sub, "--radius", surface.radius, "Radius of the ball that touches [m]; 0 is a point", 0.0, 1.0);
}

void checkSurface(const Surface& surface) {
  if (surface.friction_static >= surface.friction_dynamic) return;
  throw Failure("--friction-static", fmt::format("{} is less than --friction-dynamic", surface.friction_static),
                fmt::format("at least {}", surface.friction_dynamic));
}

void addThreshold(CLI::App& sub, double& threshold) {
  sub.add_option("--threshold", threshold, "Position error above which samples are counted [m]")
      ->capture_default_str()
      ->check(positive());
}

}  // namespace haptic_bench
