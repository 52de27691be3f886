/** @file
 * haptic-bench collide: our detectors and two collision libraries on the same models and poses in one run, in thread
 * CPU time, and their wrench beside an integral by brute force.
 */
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/collide/pair.h"
#include "tools/haptic-bench/collide/peer.h"
#include "tools/haptic-bench/collide/timing.h"
#include "tools/haptic-bench/collide/truth.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/machine.h"

namespace haptic_bench {
namespace {

constexpr double kRate = 1000;                // Poses a second [Hz].
constexpr std::uint32_t kMostPairs = 10'000;  // Records a library may write.

struct Options {
  std::vector<std::string> pairs = {"bumpy", "peg", "frac"};
  bool quick = false;
  bool peers = true;
  double peer_seconds = 20;  // Of processor time, for each library and question.
};

/** One line of the result. */
struct Row {
  std::string pair, subject, query;
  Times times;
  double records = 0;  // Mean of those that touch.
  double build_ms = 0;
};

void print(const Common& common, const Row& row) {
  const char* form = common.csv
                         ? "{},{},{},{},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.0f},{:.0f}\n"
                         : "{:<6} {:<16} {:<9} {:>6} {:>9.4f} {:>9.4f} {:>9.4f} {:>9.4f} {:>9.4f} {:>8.0f} {:>8.0f}\n";
  fmt::print(fmt::runtime(form), row.pair, row.subject, row.query, row.times.count, row.times.mean, row.times.p50,
             row.times.p99, row.times.p999, row.times.max, row.records, row.build_ms);
  std::fflush(stdout);
}

/** A library is far too slow for every pose: as many as its seconds allow, spread over all. */
void measurePeer(const Common& common, const Options& options, const CollidePair& pair, const PeerKind& kind) {
  const auto poses = pair.poses(kRate);
  const double before = threadNs();
  const auto peer = kind.make(pair.base, pair.tool);
  const double build_ms = (threadNs() - before) * 1e-6;
  const auto from = static_cast<std::size_t>(pair.contact_from * kRate);
  const std::vector<hapticd::Pose> touching(poses.begin() + static_cast<std::ptrdiff_t>(from), poses.end());
  for (const bool all : {false, true}) {
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
    if (!options.quick) {
      const double total = summarise(probe).mean * 1e-3 * static_cast<double>(asked.size());
      timing.stride = std::max(1, static_cast<int>(total / options.peer_seconds) + 1);
    }
    found = records = 0;
    Row row{pair.name, kind.name, all ? "contacts" : "touch", summarise(timeQueries(asked, timing, ask)), 0, build_ms};
    row.records = found > 0 ? static_cast<double>(records) / static_cast<double>(found) : 0;
    print(common, row);
  }
}

int run(const Common& common, const Options& options) {
  for (const std::string& line : describeMachine()) fmt::print("# {}\n", line);
  fmt::print("# thread CPU time [ms]; records: {} of FCL, {} of Bullet\n", kFclPeer.what, kBulletPeer.what);
  fmt::print("{}\n", common.csv ? "pair,subject,query,poses,mean,p50,p99,p99.9,max,records,build"
                                : "pair   subject          query      poses      mean       p50       p99     p99.9   "
                                  "    max  records    build");
  for (const std::string& name : options.pairs) {
    const CollidePair pair = makePair(name);
    if (options.peers) {
      for (const PeerKind* kind : {&kFclPeer, &kBulletPeer}) measurePeer(common, options, pair, *kind);
    }
  }
  return 0;
}

}  // namespace

void addCollide(CLI::App& app, Run& chosen) {
  auto options = std::make_shared<Options>();
  CLI::App* collide =
      app.add_subcommand("collide", "Collision detectors on three pairs of solids, beside FCL and Bullet");
  collide->add_option("--pair", options->pairs, "bumpy, peg, frac")->capture_default_str();
  collide->add_option("--peer-seconds", options->peer_seconds, "Of processor time for each question to a library")
      ->capture_default_str()
      ->check(CLI::Range(0.1, 3600.0));
  collide->add_flag("!--no-peers", options->peers, "Leaves FCL and Bullet out");
  collide->add_flag("--quick", options->quick, "A few poses of each: whether it runs, not how fast");
  collide->callback([&chosen, options] { chosen = [options](const Common& common) { return run(common, *options); }; });
}

}  // namespace haptic_bench
