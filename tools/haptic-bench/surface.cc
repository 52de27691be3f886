#include "tools/haptic-bench/surface.h"

#include <CLI/CLI.hpp>

namespace haptic_bench {

void addSurface(CLI::App& sub, Surface& surface) {
  const auto add = [&](const char* name, double& value, double high, const char* text) {
    sub.add_option(name, value, text)->capture_default_str()->check(CLI::Range(0.0, high));
  };
  add("--stiffness", surface.stiffness, 1e5, "Of the surface, N/m");
  add("--damping", surface.damping, 1e3, "Of the surface along its normal, N s/m");
  add("--friction-static", surface.friction_static, 10, "Coefficient of friction at rest");
  add("--radius", surface.radius, 1, "Of the ball that touches, m; 0 is a point");
  add("--friction-dynamic", surface.friction_dynamic, 10, "Coefficient of friction while sliding");
}

}  // namespace haptic_bench
