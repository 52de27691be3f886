// haptic-bench short: a deterministic set of a few seconds, for continuous integration: no times.
#include <CLI/CLI.hpp>
#include <string_view>

#include "rt/geometry/tree/boxes.h"
#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/option.h"
#include "tools/haptic-bench/trajectory/registry.h"
#include "tools/haptic-bench/trial/trial.h"

namespace haptic_bench {
namespace {

struct Case {
  const char* model;
  const char* trajectory;
  Surface surface;
};

constexpr double kTouchingBall = 0.001;  // [m]

constexpr Case kCases[] = {
    {"plane:cells=7", "reach:seconds=4", {1000, 0, 0, 0}},
    {"plane:cells=7", "lissajous:seconds=4", {1000, 1, 0.6, 0.4}},
    {"sphere:radius=0.001,stacks=8", "spiral:seconds=4", {2000, 0, 0, 0}},
    {"sphere:radius=0.05,stacks=16", "spiral:seconds=4", {1000, 0, 0.5, 0.3}},
    {"ridge:degrees=45", "profile", {1000, 0, 0, 0}},
    {"ridge:degrees=85", "profile", {1000, 0, 0, 0}},
    {"bowl:edge=0.0005", "swing:seconds=2", {1000, 0, 0, 0}},
    {"bowl:edge=0.0005", "swing:seconds=2", {1000, 0, 0, 0, kTouchingBall}},
    {"ridge:degrees=60", "profile", {1000, 0, 0.5, 0.3, kTouchingBall}},
};

int run(const std::string& path, const Common& common) {
  const auto wanted = path == "portable" ? hapticd::VectorPath::kPortable : hapticd::VectorPath::kAvx2;
  if (path != "best" && !hapticd::choosePath(wanted)) {
    throw Failure("short, --path", "this processor has no " + path, "portable, or leave it out");
  }
  std::vector<Series> all;
  for (const Case& c : kCases) {
    const Model model = makeModel(c.model);
    const Trajectory trajectory = makeTrajectory(c.trajectory, model, c.surface);
    const bool ball = c.surface.radius > 0;
    const std::string what = model.name + " " + trajectory.name + (ball ? " ball " : " ");
    for (const char* const algorithm : {"ours", "god-object", "nearest"}) {
      if (ball && std::string_view(algorithm) == "god-object") continue;  // It touches with a point only.
      const Outcome outcome = runTrial(algorithm, model, trajectory, c.surface, 1);
      for (Series& s : describe(what + algorithm, trajectory, outcome, 0.0005)) {
        if (s.unit != "ns" && s.unit != "s" && s.unit != "byte") all.push_back(std::move(s));
      }
    }
  }
  print(common, "short", all);
  return 0;
}

}  // namespace

void addShort(CLI::App& app, Run& chosen) {
  CLI::App* sub = app.add_subcommand("short", "A deterministic set of a few seconds: errors and hashes, no times");
  auto path = std::make_shared<std::string>("portable");
  sub->add_option("--path", *path, "Vector instructions of the tree: all give the same forces")
      ->capture_default_str()
      ->check(CLI::IsMember({"portable", "avx2", "best"}));
  whenNamed(sub, chosen, [path](const Common& common) { return run(*path, common); });
}

}  // namespace haptic_bench
