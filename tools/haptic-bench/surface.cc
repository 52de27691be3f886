#include "tools/haptic-bench/surface.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/option.h"

namespace haptic_bench {

void addSurface(CLI::App& sub, Surface& surface) {
  const auto add = [&](const char* name, double& value, double high, const char* text) {
    sub.add_option(name, value, text)->capture_default_str()->check(within(0.0, high));
  };
  sub.add_option("--stiffness", surface.stiffness, "Stiffness of the surface [N/m]")
      ->capture_default_str()
      ->check(within(1e-3, 1e5));
  add("--damping", surface.damping, 1e3, "Damping of the surface along its normal [N s/m]");
  add("--friction-static", surface.friction_static, 10, "Coefficient of friction at rest");
  add("--radius", surface.radius, 1, "Radius of the ball that touches [m]; 0 is a point");
  add("--friction-dynamic", surface.friction_dynamic, 10, "Coefficient of friction while sliding");
}

void checkSurface(const Surface& surface) {
  if (surface.friction_static >= surface.friction_dynamic) return;
  throw Failure("--friction-static", fmt::format("{} is less than --friction-dynamic", surface.friction_static),
                fmt::format("at least {}", surface.friction_dynamic));
}

}  // namespace haptic_bench
