/** @file
 * haptic-bench models: what a hand feels of a mesh by local models and by a client's own forces, at the client's rate
 * and latency, against the native scene (flat and shaded), the nearest point of the mesh and the smooth surface that
 * the mesh stands for, at the same places. Stepped by hand: exact, on any machine and under any load.
 */
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>

#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/load/built_surface.h"
#include "tools/haptic-bench/load/stepped.h"
#include "tools/haptic-bench/machine.h"
#include "tools/haptic-bench/option.h"

namespace haptic_bench {
namespace {

struct ModelsOptions {
  std::vector<double> rates_hz{10, 30, 100, 300, 1000};
  std::vector<double> stiffness{300, 1000};
  double latency_ms = 5;
  double seconds = 3;
  std::uint32_t triangles = 16128;
  double radius = 0.05;
  double bumps = 0;
};

constexpr const char* kReferences[] = {"native", "shaded", "nearest", "smooth"};

/** What one source's forces are off each of kReferences, in percent; not a number: it is that one. */
struct FromReferences {
  std::string name;
  double rms[std::size(kReferences)], change[std::size(kReferences)];
};

void printTable(const std::string& title, const std::vector<FromReferences>& rows) {
  std::size_t names = title.size();
  for (const FromReferences& row : rows) names = std::max(names, row.name.size());
  fmt::print("\n{:<{}} | {:^35} | {}\n{:{}} |", title, names, "difference, RMS [% of mean force]",
             "most change of it in a tick", "", names);
  for (const char* half : {" |", "\n"}) {
    for (const char* reference : kReferences) fmt::print("{:>9}", reference);
    fmt::print("{}", half);
  }
  const auto half = [](const double(&values)[std::size(kReferences)]) {
    std::string text;
    for (const double x : values) text += std::isnan(x) ? fmt::format("{:>9}", "-") : fmt::format("{:>9.3g}", x);
    return text;
  };
  for (const FromReferences& row : rows)
    fmt::print("{:<{}} |{} |{}\n", row.name, names, half(row.rms), half(row.change));
}

int runModels(const Common& common, const ModelsOptions& options) {
  const BumpySphere shape{options.radius, options.bumps};
  const double latency_s = steppedLatency_s(options.latency_ms * 1e-3);
  for (const double k : options.stiffness) {
    const double depth = Stroke{}.force / k;
    if (depth < options.radius * (1 - options.bumps)) continue;
    throw Failure("--stiffness",
                  fmt::format("at {:g} N/m the hand is pressed {:g} m in, to the mesh's middle", k, depth),
                  "stiffer, or a larger --radius");
  }
  const Model model = tessellate(shape, options.triangles);
  const BuiltSurface surface(model);
  std::vector<Series> all;
  std::vector<std::pair<std::string, std::vector<FromReferences>>> tables;  // For each stiffness.
  const auto add = [&](const std::string& name, double fraction) {
    all.push_back({name, kForceErrorUnit, {100 * fraction}});
  };
  for (const double k : distinct(options.stiffness)) {
    const Stroked stroke = strokeOver(shape, {.stiffness = k}, options.seconds);
    const auto settled = [](const std::vector<Vec3>& forces) { return std::span(forces).subspan(kSettled); };
    const std::vector<Vec3> native = nativeForces(surface.meshes(), k, stroke.hips);
    const std::vector<Vec3> shaded = nativeForces(surface.meshes(), k, stroke.hips, Facets::kShaded);
    const std::vector<Vec3> nearest = nearestForces(surface.client(), k, stroke.hips);
    for (const auto* touched : {&native, &shaded, &nearest}) {
      const auto forces = settled(*touched);
      if (std::any_of(forces.begin(), forces.end(), [](const Vec3& f) { return f.norm() > 0; })) continue;
      throw Failure("--triangles",
                    fmt::format("the hand, {:g} m deep at {:g} N/m, stays above {} flat faces", Stroke{}.force / k, k,
                                model.triangles.size()),
                    "more of them, a smaller --radius, or softer");
    }
    tables.push_back({fmt::format("{:g} N/m", k), {}});
    const auto judge = [&](const std::string& name, const std::vector<Vec3>& forces) {
      const std::vector<Vec3>* const truths[] = {&native, &shaded, &nearest, &stroke.forces};  // Of kReferences.
      FromReferences row{name, {}, {}};
      for (std::size_t i = 0; i < std::size(kReferences); ++i) {
        row.rms[i] = row.change[i] = std::numeric_limits<double>::quiet_NaN();
        if (truths[i] == &forces) continue;
        const ForceError e = compareForces(settled(forces), settled(*truths[i]));
        add(fmt::format("{:g} N/m {} - {}: rms", k, name, kReferences[i]), e.rms);
        add(fmt::format("{:g} N/m {} - {}: change a tick", k, name, kReferences[i]), e.change_max);
        row.rms[i] = 100 * e.rms;
        row.change[i] = 100 * e.change_max;
      }
      tables.back().second.push_back(row);
    };
    judge("native", native);
    for (const Source source : {Source::kPlane, Source::kPatch, Source::kForce}) {
      for (const double rate : distinct(options.rates_hz)) {
        const ClientTiming timing{1 / rate, latency_s, k};
        judge(fmt::format("{} at {:g} Hz", nameOf(source), rate),
              clientForces(source, surface.client(), timing, stroke.hips));
      }
    }
  }
  const std::string what = fmt::format("models, {} triangles", model.triangles.size());
  const std::string settings = fmt::format("radius {} m, bumps {}, {:g} ms late, {} s", options.radius, options.bumps,
                                           1e3 * latency_s, options.seconds);
  if (common.csv) {
    print(common, what, all, settings);
    return 0;
  }
  for (const std::string& line : describeMachine()) fmt::print("# {}\n", line);
  fmt::print("\n{}: {}\n", what, settings);
  for (const auto& [title, rows] : tables) printTable(title, rows);
  return 0;
}

}  // namespace

void addModels(CLI::App& app, Run& chosen) {
  auto options = std::make_shared<ModelsOptions>();
  CLI::App* models = app.add_subcommand(
      "models", "Force of local models and of client forces against the native scene, by the client's rate");
  bounded(models, "--rates", options->rates_hz, "Client's rates [Hz]", 1.0, 1000.0);
  bounded(models, "--stiffness", options->stiffness, "[N/m]", 1.0, 1e5);
  bounded(models, "--latency", options->latency_ms,
          "Whole ticks from the client's sample to the force, one at least [ms]", 0.0, 1000.0);
  bounded(models, "--seconds", options->seconds,
          "Length of the stroke at 0.1 m/s and 1 N [s]; 0.3 of it are not judged", 0.5, 100.0);
  bounded(models, "--triangles", options->triangles, "Triangles of the mesh", 100, 8'000'000);
  bounded(models, "--radius", options->radius, "Radius of the mesh [m]", 0.001, 10.0);
  bounded(models, "--bumps", options->bumps, "Height of its bumps, of the radius; 0: a sphere", 0.0, 0.3);
  whenNamed(models, chosen, [options](const Common& common) { return runModels(common, *options); });
}

}  // namespace haptic_bench
