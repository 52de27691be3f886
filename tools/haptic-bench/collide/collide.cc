/** @file
 * haptic-bench collide: our detectors and two collision libraries on the same models and poses in one run, in thread
 * CPU time, and their wrench beside an integral by brute force.
 */
#include <fmt/format.h>
#include <malloc.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <span>

#include "rt/contact/point_field.h"
#include "rt/contact/sphere_descent.h"
#include "rt/contact/voxmap.h"
#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/collide/ours.h"
#include "tools/haptic-bench/collide/pair.h"
#include "tools/haptic-bench/collide/peer.h"
#include "tools/haptic-bench/collide/timing.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/machine.h"
#include "tools/haptic-bench/option.h"
#include "tools/haptic-bench/result/results.h"
#include "tools/haptic-bench/tell.h"

namespace haptic_bench {
namespace {

constexpr double kRate = 1000;                // Poses a second [Hz].
constexpr std::uint32_t kMostPairs = 10'000;  // Records a library may write.
constexpr double kDualSeconds = 30;           // Of spheres against spheres: no pass begins after that.

struct CollideOptions {
  std::vector<std::string> pairs = {"bumpy", "peg", "frac"};
  bool quick = false;
  bool peers = true;
  int passes = 10;           // Over the 2000 poses.
  int truths = 12;           // Poses whose wrench is compared.
  double peer_seconds = 10;  // Of processor time, for each library and question.
};

/** One line of the result. */
struct Line {
  std::string pair, subject, query;
  Measures measured;
  double build_ms = 0, megabytes = 0;
  bool wrench = false;
};

void print(const Common& common, const Line& row) {
  const Measures& m = row.measured;
  const char* form = common.csv ? "{},{},{},{},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.0f},{:.0f},{:.0f},{:.1f}"
                                : "{:<5} {:<26} {:<8} {:>6} {:>8.4f} {:>8.4f} {:>8.4f} {:>8.4f} {:>8.4f} {:>8.4f} "
                                  "{:>8.0f} {:>8.0f} {:>6.0f} {:>5.1f}";
  fmt::print(fmt::runtime(form), row.pair, common.csv ? csvField(row.subject) : row.subject, row.query, m.times.count,
             m.times.mean, m.times.p50, m.times.p99, m.times.p999, m.times.steady999, m.times.max, m.touching, m.rate,
             row.build_ms, row.megabytes);
  if (row.wrench) {
    fmt::print(fmt::runtime(common.csv ? ",{:.2f},{:.2f},{:.2f}" : " {:>6.2f} {:>6.2f} {:>6.2f}"), m.error_force * 100,
               m.error_angle * 180 / EIGEN_PI, m.error_torque * 100);
  } else if (common.csv) {
    fmt::print(",,,");
  }
  fmt::print("\n");
  std::fflush(stdout);
}

/** What a figure is given for: points so dense that so many touch, or so many are in all. */
struct Density {
  const char* pair;
  const char* name;
  double spacing;  // [m]
};
constexpr Density kDensities[] = {
    {"bumpy", "278k", 0.39e-3},
    {"peg", "80k", 0.258e-3},
    {"frac", "23k touch", 0.42e-3},
    {"frac", "184k touch", 0.149e-3},
};
constexpr std::uint32_t kPatchPoints = 48;
constexpr double kSphereVoxel = 0.5e-3;  // Of both bodies, where spheres are descended [m].

/** Hot, cold, with a fifth of the work, and whether they touch at all; with each vector unit. */
void measurePoints(const Common& common, const CollideOptions& options, const CollidePair& pair,
                   const BuiltVolume& base, const TruthTable& truth) {
  const auto poses = pair.poses(kRate);
  const auto from = static_cast<std::size_t>(pair.contact_from * kRate);
  const double coarser = options.quick ? 3 : 1;
  const hapticd::PointPath best = hapticd::pointPath();
  for (const Density& density : kDensities) {
    if (density.pair != pair.name) continue;
    tellTime(fmt::format("{} {}: building the tool", pair.name, density.name));
    const BuiltVolume tool(pair.tool, coarser * pair.voxel, coarser * density.spacing, kPatchPoints);
    fmt::print("# {} {}: {} points in {} patches\n", pair.name, density.name, tool.view.point_count,
               tool.view.patches.size());
    hapticd::PointFieldDetector detector(static_cast<std::uint32_t>(tool.view.patches.size()));
    for (const hapticd::PointPath path :
         {hapticd::PointPath::kAvx512, hapticd::PointPath::kAvx2, hapticd::PointPath::kPortable}) {
      if (!hapticd::choosePointPath(path)) continue;
      tellTime(fmt::format("{} {}: {}", pair.name, density.name, hapticd::nameOf(path)));
      const std::string name = std::string(density.name) + " " + hapticd::nameOf(path);
      Subject subject{name, &base, &tool, &detector};
      TimingOptions timing;
      const bool portable = path == hapticd::PointPath::kPortable;
      timing.passes = options.quick || portable ? 1 : options.passes;
      timing.stride = options.quick ? 100 : portable ? 4 : 1;
      const auto row = [&](const char* query, std::size_t begin, const TruthTable& with) {
        const Measures measured = measure(subject, poses, begin, timing, with);
        print(common, {pair.name, name, query, measured, base.build_ms + tool.build_ms,
                       base.megabytes() + tool.megabytes(), !with.pose.empty()});
        return measured.work;
      };
      // As many poses in contact as in all.
      const int passes = timing.passes;
      if (passes > 1) timing.passes = (passes * 4 + 2) / 3;
      const double work = row("contacts", from, truth);
      if (path == best) {
        subject.units = static_cast<std::uint32_t>(work / 5);
        row("fifth", from, truth);
        subject.units = 0;
      }
      timing.passes = passes;
      subject.first_only = true;
      row("touch", 0, {});
      subject.first_only = false;
      if (path != best) continue;
      timing.cold = true;
      timing.passes = 1;
      timing.stride *= 4;
      row("cold", from, {});
    }
    hapticd::choosePointPath(best);
    if (density.spacing < 0.2e-3) continue;
    tellTime(fmt::format("{} {}: voxmap", pair.name, density.name));
    hapticd::VoxmapDetector voxmap;
    TimingOptions timing;
    timing.stride = options.quick ? 300 : 10;
    print(common, {pair.name, std::string(density.name) + " voxmap", "contacts",
                   measure({"voxmap", &base, &tool, &voxmap}, poses, from, timing, truth),
                   base.build_ms + tool.build_ms, base.megabytes() + tool.megabytes(), !truth.pose.empty()});
  }
}

/** The thesis's descent, at 0.5 mm; and one-sided, with the field that points are given. */
void measureSpheres(const Common& common, const CollideOptions& options, const CollidePair& pair,
                    const BuiltVolume& field, const TruthTable& truth) {
  const auto poses = pair.poses(kRate);
  const auto from = static_cast<std::size_t>(pair.contact_from * kRate);
  const double voxel = (options.quick ? 3 : 1) * kSphereVoxel;
  tellTime(pair.name + ": building for spheres");
  const BuiltVolume base(pair.base, voxel, 0, kPatchPoints), tool(pair.tool, voxel, 0, kPatchPoints);
  struct Kind {
    const char* name;
    hapticd::SphereLeaf leaf;
    const BuiltVolume* base;
  };
  const bool finer = pair.voxel < kSphereVoxel;
  const Kind kinds[] = {{"spheres 0.5 mm", hapticd::SphereLeaf::kSphere, &base},
                        {"spheres 0.5 mm one-sided", hapticd::SphereLeaf::kFieldValue, &base},
                        {"one-sided, finer field", hapticd::SphereLeaf::kFieldValue, &field}};
  for (const Kind& kind : std::span(kinds, finer ? 3 : 2)) {
    hapticd::SphereDescentDetector detector({.leaf = kind.leaf});
    Subject subject{"spheres", kind.base, &tool, &detector};
    const bool one_sided = kind.leaf == hapticd::SphereLeaf::kFieldValue;
    const std::string name = kind.name;
    tellTime(pair.name + ": " + name);
    TimingOptions timing;
    timing.stride = options.quick ? 200 : 1;
    timing.seconds = one_sided ? timing.seconds : kDualSeconds;
    const auto row = [&](const char* query, std::size_t begin, const TruthTable& with) {
      print(common,
            {pair.name, name, query, measure(subject, poses, begin, timing, with), kind.base->build_ms + tool.build_ms,
             kind.base->megabytes() + tool.megabytes(), !with.pose.empty()});
    };
    timing.passes = options.quick ? 1 : (options.passes * 4 + 2) / 3;
    row("contacts", from, truth);
    timing.passes = options.quick ? 1 : options.passes;
    subject.first_only = true;
    row("touch", 0, {});
    subject.first_only = false;
    timing.cold = true;
    timing.passes = 1;
    timing.stride *= one_sided ? 4 : 20;
    row("cold", from, {});
  }
}

/** What is allocated. */
double megabytesHeld() {
  const auto held = mallinfo2();
  return static_cast<double>(held.uordblks + held.hblkhd) * 1e-6;
}

/** As many poses as the seconds allow: several passes over all, or some that are spread over all. */
void measurePeer(const Common& common, const CollideOptions& options, const CollidePair& pair, const PeerKind& kind) {
  const auto poses = pair.poses(kRate);
  tellTime(fmt::format("{}: {}", pair.name, kind.name));
  const double before = processNs(), held = megabytesHeld();
  const auto peer = kind.make(pair.base, pair.tool);
  const double build_ms = (processNs() - before) * 1e-6, megabytes = megabytesHeld() - held;
  const auto from = static_cast<std::size_t>(pair.contact_from * kRate);
  const std::vector<hapticd::Pose> touching(poses.begin() + static_cast<std::ptrdiff_t>(from), poses.end());
  const auto row = [&](const char* query, bool all, bool cold) {
    const auto& asked = all ? touching : poses;
    std::size_t found = 0, records = 0;
    const auto ask = [&](std::size_t i) {
      const std::uint32_t n = all ? peer->contacts(asked[i], kMostPairs) : peer->touch(asked[i]) ? 1 : 0;
      found += n > 0 ? 1 : 0;
      records += n;
    };
    // One in 200 poses tells how many can be had.
    TimingOptions timing;
    timing.stride = options.quick ? 500 : 200;
    const auto probe = timeQueries(asked, timing, ask);
    timing.cold = cold;
    if (!options.quick) {
      const double total = summarise(probe).mean * 1e-3 * static_cast<double>(asked.size());
      timing.stride = std::max(cold ? 20 : 1, static_cast<int>(total / options.peer_seconds * (cold ? 4 : 1)) + 1);
      if (timing.stride == 1) timing.passes = all ? (options.passes * 4 + 2) / 3 : options.passes;
      timing.seconds = options.peer_seconds;
    }
    found = records = 0;
    Line line{pair.name, kind.name, query, {}, build_ms, megabytes};
    Measures& m = line.measured;
    const auto ms = timeQueries(asked, timing, ask);
    const auto stride = static_cast<std::size_t>(timing.stride);
    m.times = summarise(ms, ms.size() / ((asked.size() + stride - 1) / stride));
    m.touching = found > 0 ? static_cast<double>(records) / static_cast<double>(found) : 0;
    m.rate = static_cast<double>(records) / (m.times.mean * static_cast<double>(m.times.count));
    print(common, line);
  };
  row("touch", false, false);
  row("contacts", true, false);
  row("cold", true, true);
}

int run(const Common& common, const CollideOptions& options) {
  for (const std::string& line : describeMachine()) fmt::print("# {}\n", line);
  fmt::print(
      "# thread CPU time [ms]; steady: p99.9 over the poses of each pose's median over the passes; records: points of "
      "ours, {} of FCL, {} of Bullet; rate: records a ms; "
      "fifth: with a fifth of the work that contacts took; cold: after 96 MB were walked; build [ms of processor "
      "time]; "
      "wrench against brute force: force [% of peak], direction [deg], torque [% of peak force x {} mm]; points are to "
      "be within 5 % and 1 deg on peg, 2 % on frac, one-sided spheres within 5 %\n",
      kFclPeer.what, kBulletPeer.what, kLever * 1e3);
  if (common.csv) {
    fmt::print("{}\n",
               settingsLine("collide", fmt::format("{}{} passes, {} truths, {} s for each question to a library",
                                                   options.quick ? "quick, " : "", options.passes, options.truths,
                                                   options.peer_seconds)));
    fmt::print("{}\n", tableForm("collide").header());
  } else {
    fmt::print(
        "pair  subject                    query     poses     mean      p50      p99    p99.9   steady      max  "
        "records     rate  build    MB  force  angle torque\n");
  }
  for (const std::string& name : distinct(options.pairs)) {
    const CollidePair pair = makePair(name);
    const auto poses = pair.poses(kRate);
    tellTime(name + ": the wrench by brute force");
    const TruthTable truth = makeTruth(pair, poses, options.quick ? 0 : options.truths, name == "bumpy" ? 3 : 4);
    tellTime(name + ": building the base");
    const BuiltVolume base(pair.base, (options.quick ? 3 : 1) * pair.voxel, 0, kPatchPoints);
    measurePoints(common, options, pair, base, truth);
    measureSpheres(common, options, pair, base, truth);
    if (options.peers) {
      for (const PeerKind* kind : {&kFclPeer, &kBulletPeer}) measurePeer(common, options, pair, *kind);
    }
  }
  return 0;
}

}  // namespace

void addCollide(CLI::App& app, Run& chosen) {
  auto options = std::make_shared<CollideOptions>();
  CLI::App* collide =
      app.add_subcommand("collide", "Collision detectors on three pairs of solids, beside FCL and Bullet");
  collide->add_option("--pair", options->pairs, "bumpy, peg, frac")
      ->capture_default_str()
      ->check(CLI::IsMember({"bumpy", "peg", "frac"}));
  bounded(collide, "--peer-seconds", options->peer_seconds, "Processor time for each question to a library [s]", 0.1,
          3600.0);
  bounded(collide, "--passes", options->passes, "Passes over the 2000 poses, for each figure of ours", 1, 1000);
  bounded(collide, "--truths", options->truths, "Poses whose wrench is compared with brute force", 0, 1000);
  collide->add_flag("!--no-peers", options->peers, "Leaves FCL and Bullet out");
  collide->add_flag("--quick", options->quick, "A few poses of each: whether it runs, not how fast");
  whenNamed(collide, chosen, [options](const Common& common) { return run(common, *options); });
}

}  // namespace haptic_bench
