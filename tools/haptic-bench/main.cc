/** @file
 * haptic-bench: judges rendering algorithms, and measures what the daemon's parts cost against the plain thing beside
 * it in the same run.
 */
#include <hapticclient/hapticclient.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <new>

#include "drivers/did_you_mean.h"
#include "rt/base/standard_streams.h"
#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/option.h"
#include "tools/options/help.h"

namespace {

// One a line, so that neighbours add theirs without a conflict.
// clang-format off
constexpr haptic_bench::AddBenchmark kBenchmarks[] = {
    haptic_bench::addRun,
    haptic_bench::addSweep,
    haptic_bench::addTables,
    haptic_bench::addReport,
    haptic_bench::addShort,
    haptic_bench::addCompare,
    haptic_bench::addLoad,
    haptic_bench::addModels,
    haptic_bench::addReplay,
    haptic_bench::addRing,
    haptic_bench::addServo,
    haptic_bench::addDevice,
    haptic_bench::addCost,
    haptic_bench::addZwidth,
    haptic_bench::addCollide,
    haptic_bench::addSixdof,
    haptic_bench::addStability,
    haptic_bench::addGrasp,
};
// clang-format on
/** Where a word stands in a benchmark's place that is none: what it is, and what may be meant. Else empty. */
std::string unknownBenchmark(const CLI::App& app) {
  const std::vector<std::string> rest = app.remaining();
  if (!app.get_subcommands().empty() || rest.empty() || rest[0][0] == '-') return {};
  std::vector<std::string> names;
  for (const CLI::App* one : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(one->get_name());
  return rest[0] + ": there is no such benchmark (there is " + hapticd::nearestNames(rest[0], names) + ")";
}

/** "; did you mean --OPTION?" of the first word that is no option, where one of the program or benchmark is near. */
std::string meantOption(const CLI::App& app, int argc, char** argv) {
  std::vector<std::string> known;
  for (const CLI::App* at = &app; at != nullptr;
       at = at->get_subcommands().empty() ? nullptr : at->get_subcommands().front()) {
    for (const CLI::Option* option : at->get_options())
      for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  }
  for (int i = 1; i < argc && std::strcmp(argv[i], "--") != 0; ++i) {
    const std::string_view word = std::string_view(argv[i]).substr(0, std::string_view(argv[i]).find('='));
    if (!word.starts_with("--") || std::find(known.begin(), known.end(), word) != known.end()) continue;
    const std::string_view near = hapticd::nearest(word, {known.begin(), known.end()});
    return near.empty() ? std::string() : "; did you mean " + std::string(near) + "?";
  }
  return {};
}

/** The option that an empty word follows, most likely of a variable that is not set: CLI11 takes it for not given. */
const char* emptyOption(int argc, char** argv) {
  for (int i = 2; i < argc; ++i)
    if (argv[i][0] == '\0' && argv[i - 1][0] == '-') return argv[i - 1];
  return nullptr;
}

/** The file's name that stands behind --csv, which takes none; null if there is no such. */
const char* fileOfCsv(int argc, char** argv) {
  for (int i = 1; i + 1 < argc; ++i) {
    const std::string_view next = argv[i + 1];
    if (argv[i] == std::string_view("--csv") && next.find_first_of("./") != std::string_view::npos) return argv[i + 1];
  }
  return nullptr;
}

constexpr int kExitFailed = 1;  ///< Also a broken bound.
constexpr int kExitUsage = 2;

}  // namespace

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape): ends the program, as it should
  hapticd::holdStandardStreams();
  CLI::App app{
      "Judges rendering algorithms, and measures hapticd's parts against the plain thing beside them. Numbers from a "
      "busy or virtual machine\n"
      "say little; the ratios within one run say more.",
      "haptic-bench"};
  std::signal(SIGXFSZ, SIG_IGN);  // A file that may not grow is told as one that could not be written.
  haptic_bench::Common common;
  haptic_bench::Run chosen;
  app.add_flag("--csv", common.csv, "One line per round to standard output, for scripts and compare: > FILE");
  haptic_bench::bounded(&app, "--rounds", common.rounds, "Interleaved A/B rounds", 1, 10000);
  app.set_version_flag("--version", std::string("haptic-bench ") + haptic_version());
  app.require_subcommand(1);
  app.fallthrough();  // so that they may follow the subcommand's name
  for (const auto add : kBenchmarks) add(app, chosen);
  if (const char* const option = emptyOption(argc, argv); option != nullptr) {
    std::fprintf(stderr, "haptic-bench: %s: what follows it is empty (leave it out, or give it a value)\n", option);
    return kExitUsage;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // --help, --version
      std::cout << hapticd_options::helpOf(app, error);
      return std::cout.flush()
                 ? 0
                 : (std::fprintf(stderr, "haptic-bench: standard output: not all could be written\n"), kExitFailed);
    }
    if (const char* const file = fileOfCsv(argc, argv); file != nullptr) {
      std::fprintf(
          stderr, "haptic-bench: --csv: it takes no file and writes to standard output\n  put > %s at the end\n", file);
      return kExitUsage;
    }
    const std::string wrong = unknownBenchmark(app);
    const std::vector<CLI::App*> named = app.get_subcommands();
    const bool extras = error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError);
    const std::string meant = extras && wrong.empty() ? meantOption(app, argc, argv) : std::string();
    std::fprintf(stderr, "haptic-bench: %s%s\n  haptic-bench %s--help lists %soptions\n",
                 wrong.empty() ? error.what() : wrong.c_str(), meant.c_str(),
                 named.empty() ? "" : (named.front()->get_name() + ' ').c_str(),
                 named.empty() ? "benchmarks and " : "its ");
    return kExitUsage;
  }
  try {
    const int code = chosen(common);
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
    throw haptic_bench::Failure("standard output", "not all could be written", "make room where it goes");
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "haptic-bench: memory: there is not enough (a smaller model, a shorter trajectory)\n");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "haptic-bench: %s\n", error.what());
  }
  return kExitFailed;
}
