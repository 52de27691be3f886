// haptic-bench replay: what a recording holds, whether it replays, and its numbers for other programs.
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/option.h"
#include "tools/haptic-bench/replay/tape.h"
#include "tools/haptic-bench/whole_file.h"

namespace haptic_bench {
namespace {

using hapticd::Replayer;
using hapticd::Verdict;

struct ReplayOptions {
  std::string file, output;
  bool verify = false;
};

bool endsIn(const std::string& path, std::string_view suffix) {
  return path.size() >= suffix.size() && path.compare(path.size() - suffix.size(), suffix.size(), suffix) == 0;
}

void describe(const hapticd::RecordingHeader& header) {
  const std::time_t started = header.started_ns / 1'000'000'000;
  fmt::print("recorded   {:%Y-%m-%d %H:%M:%S} UTC by hapticd {}\n", fmt::gmtime(started), header.program);
  fmt::print("build      {} on {}{}\n", header.build.substr(0, 16), header.instructions,
             header.flush_denormals ? ", denormals as zero" : "");
  fmt::print("group      {}, {:g} Hz\n", header.group, 1e9 / static_cast<double>(header.start.config.period_ns));
  for (std::size_t d = 0; d < header.devices.size(); ++d) {
    fmt::print("device {}   {} ({})\n", d, header.devices[d].name, header.devices[d].uri);
  }
  const std::size_t orders = header.start.orders.size();
  fmt::print("start      {} order{}, {} mesh{}\n", orders, orders == 1 ? "" : "s", header.meshes,
             header.meshes == 1 ? "" : "es");
}

void describeEnd(const Replayer& replayer, std::uint64_t cycles) {
  const auto& end = replayer.recording().end();
  const double seconds =
      static_cast<double>(cycles) * static_cast<double>(replayer.recording().header().start.config.period_ns) * 1e-9;
  fmt::print("cycles     {} ({:.3f} s)\n", cycles, seconds);
  if (!end) {
    fmt::print("end        cut off: what was written until then is whole\n");
  } else if (end->lost != 0) {
    fmt::print("end        {}; {} cycles lost after the last one here\n", end->reason, end->lost);
  } else {
    fmt::print("end        {}\n", end->reason);
  }
}

int judge(const Verdict& verdict) {
  if (!verdict.same_program) {
    fmt::print("replay     another program ({} on {}): compared to {:g} N, N m\n",
               hapticd::realtimeBuild().substr(0, 16), hapticd::instructionSet(), Verdict::kTolerance);
  }
  if (verdict.cycles == 0) {
    fmt::print("replay     nothing to compare: there is no cycle\n");
    return 1;
  }
  if (verdict.differing == 0) {
    fmt::print("replay     {}\n", verdict.same_program
                                      ? "every force the same, bit for bit"
                                      : fmt::format("every force the same; largest difference {:g}", verdict.largest));
    return 0;
  }
  fmt::print("replay     {} of {} cycles differ, by {:g} at most; the first: {}\n", verdict.differing, verdict.cycles,
             verdict.largest, verdict.first);
  if (verdict.same_program)
    fmt::print("           a difference between equal programs is a defect; please report it\n");
  return 1;
}

int replay(const ReplayOptions& options) {
  if (!options.output.empty()) {
    const bool csv = endsIn(options.output, ".csv");
    if (!csv && !endsIn(options.output, ".h5") && !endsIn(options.output, ".hdf5")) {
      throw Failure(options.output, "its kind is not known", "end the name in .csv, .h5 or .hdf5");
    }
    refuseToReplace(options.file, options.output);
    const auto replayer = orFailIn(options.file, Replayer::open(options.file));
    WholeFile output(options.output);
    (csv ? exportCsv : exportHdf5)(*replayer, options.file, output.part());
    output.keep();
    fmt::print("wrote      {}\n", options.output);
  }
  const auto replayer = orFailIn(options.file, Replayer::open(options.file));
  const hapticd::RecordingHeader& header = replayer->recording().header();
  describe(header);
  const Verdict verdict = orFailIn(options.file, hapticd::verify(*replayer));
  describeEnd(*replayer, verdict.cycles);
  return options.verify ? judge(verdict) : 0;
}

}  // namespace

void addReplay(CLI::App& app, Run& chosen) {
  CLI::App* sub = app.add_subcommand("replay", "Run a recording again: check it, export it");
  auto options = std::make_shared<ReplayOptions>();
  sub->add_option("FILE", options->file, "Made by hapticctl record")->required();
  sub->add_flag("--verify", options->verify, "Compare every force with what was sent; 1 if any differs");
  sub->add_option("--export", options->output, "Write every cycle to a .csv, .h5 or .hdf5 file")->type_name("OUT");
  whenNamed(sub, chosen, [options](const Common&) { return replay(*options); });
}

}  // namespace haptic_bench
