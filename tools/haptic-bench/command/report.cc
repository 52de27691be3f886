// haptic-bench report: one HTML page that can be attached to a paper: tables, plots, and on what they were measured.
#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string_view>

#include "daemon/ipc/unique_fd.h"
#include "daemon/recording/recording.h"
#include "tools/haptic-bench/algorithm/registry.h"
#include "tools/haptic-bench/beside_program.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/machine.h"
#include "tools/haptic-bench/option.h"
#include "tools/haptic-bench/table/paper_table.h"
#include "tools/haptic-bench/tell.h"
#include "tools/haptic-bench/trajectory/registry.h"
#include "tools/haptic-bench/trial/trial.h"
#include "tools/haptic-bench/whole_file.h"

namespace haptic_bench {
namespace {

using nlohmann::json;

// Python looks for its modules by its own name, which so has to be the whole path: another python3 may stand in PATH.
constexpr const char* kPython = "/usr/bin/python3";

json tablesAsJson(const std::vector<PaperTable>& tables) {
  json all = json::array();
  for (const PaperTable& t : tables) {
    json cells = json::array();
    for (const PaperCell& cell : t.cells) {
      json series = json::array();
      for (const Series& s : cell.series) {
        const Estimate e = estimate(s.rounds);
        series.push_back({{"name", s.name}, {"unit", s.unit}, {"median", e.median}, {"low", e.low}, {"high", e.high}});
      }
      cells.push_back({{"model", cell.model},
                       {"triangles", cell.triangles},
                       {"algorithm", cell.algorithm},
                       {"series", std::move(series)}});
    }
    all.push_back(
        {{"title", t.title}, {"settings", t.settings}, {"columns", t.columns}, {"rows", t.rows}, {"cells", cells}});
  }
  return all;
}

/** The way over the ridges as each algorithm has it: x and z of its proxy, and the force's error over time. */
json ridgesAsJson(const std::vector<std::string>& more) {
  json all = json::array();
  const Surface surface{1000, 0, 0, 0};
  for (const int degrees : {45, 60, 75, 85}) {
    const Model model = makeModel(fmt::format("ridge:degrees={}", degrees));
    const Trajectory way = makeTrajectory("profile", model, surface);
    json ridge{{"degrees", degrees}, {"algorithms", json::object()}};
    for (const Sample& s : way.samples) {
      ridge["t"].push_back(s.t_s);
      ridge["truth"].push_back({s.proxy.x(), s.proxy.z()});
      ridge["hand"].push_back({s.hip.x(), s.hip.z()});
    }
    for (const std::string& algorithm : withMore({"ours", "god-object", "nearest"}, more)) {
      if (!refusal(algorithm, model, way, surface).empty()) continue;
      const Outcome outcome = runTrial(algorithm, model, way, surface, 1);
      json& one = ridge["algorithms"][algorithm];
      for (std::size_t i = 0; i < way.samples.size(); ++i) {
        one["proxy"].push_back({outcome.answers[i].proxy.x(), outcome.answers[i].proxy.z()});
        one["error"].push_back((outcome.answers[i].force - way.samples[i].force).norm());
      }
    }
    all.push_back(std::move(ridge));
  }
  return all;
}

/**
 * Force error on a sphere over stiffness, of ours, the yardstick and slow clients: against the smooth sphere, and
 * against the mesh as it is, which is the yardstick's answer.
 */
json sweepAsJson(const std::vector<std::string>& more) {
  json all{{"model", "sphere:radius=0.05,stacks=32"}, {"trajectory", "spiral:turns=2"}, {"stiffness", json::array()}};
  const Model model = makeModel(all["model"]);
  for (const double k : {100.0, 200.0, 500.0, 1000.0, 2000.0, 5000.0}) {
    const Surface surface{k, 0, 0, 0};
    const Trajectory spiral = makeTrajectory(all["trajectory"], model, surface);
    all["stiffness"].push_back(k);
    Trajectory mesh = spiral;
    const Outcome exact = runTrial("nearest", model, spiral, surface, 1);
    for (std::size_t i = 0; i < mesh.samples.size(); ++i) mesh.samples[i].force = exact.answers[i].force;
    for (const std::string& algorithm : withMore({"nearest", "ours", "local:rate=30", "local:rate=300"}, more)) {
      json error, off_mesh;  // Null where it refuses.
      if (refusal(algorithm, model, spiral, surface).empty()) {
        const Outcome outcome = algorithm == "nearest" ? exact : runTrial(algorithm, model, spiral, surface, 1);
        error = judge(spiral, outcome.answers, 0.001).force_mse;
        off_mesh = judge(mesh, outcome.answers, 0.001).force_mse;
      }
      all["mse"][algorithm].push_back(error);
      if (algorithm != "nearest") all["mesh"][algorithm].push_back(off_mesh);
    }
  }
  return all;
}

/**
 * Has the script draw the page to `output`, with what is in `results` at its end; or, with "--check" for `output`, only
 * see whether it could. Throws Failure when it fails.
 */
void draw(const json& data, const std::string& output, const std::vector<std::string>& results) {
  const hapticd::UniqueFd file(memfd_create("haptic-bench-report", MFD_CLOEXEC));
  std::ofstream text(fmt::format("/proc/self/fd/{}", file.get()));
  text << data;
  if (!text.flush()) throw Failure("report", "its numbers find no room", "more memory");
  const std::string script = ownFile("report/report.py");
  // The page is opened here: once this program is killed and its name is gone, the script writes into nothing.
  const bool check = output == "--check";
  const hapticd::UniqueFd page(check ? -1 : open(output.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  if (!check && !page.valid()) throw Failure(output, "it cannot be written", "see the path and its rights");
  // -B: what root's Python would write beside the scripts, no package removes.
  std::vector<const char*> arguments = {kPython, "-B", script.c_str(), check ? output.c_str() : "/dev/stdout"};
  for (const std::string& one : results) arguments.push_back(one.c_str());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, file.get(), STDIN_FILENO);
  if (!check) posix_spawn_file_actions_adddup2(&actions, page.get(), STDOUT_FILENO);
  pid_t child = 0;
  int status = -1;
  const int error = posix_spawn(&child, kPython, &actions, nullptr, const_cast<char**>(arguments.data()), environ);
  posix_spawn_file_actions_destroy(&actions);
  while (error == 0 && waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (error != 0 || status != 0) {
    constexpr int kRefused = 3;  // As in the script.
    if (error == 0 && WIFEXITED(status) && WEXITSTATUS(status) == kRefused)
      throw Failure("report", "no page is drawn with that file", "see above");
    throw Failure(script, "it could not draw the page", "install python3 and python3-matplotlib");
  }
}

/** What else the numbers hang on. Not among the machine's lines, by which results of two versions are compared. */
std::vector<std::string> versions() {
  return {fmt::format("measured: {:%Y-%m-%d %H:%M} UTC", fmt::gmtime(std::time(nullptr))),
          fmt::format("real-time library: {}, {}", hapticd::realtimeBuild().substr(0, 16), hapticd::instructionSet()),
          fmt::format("Eigen: {}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)};
}

/** Throws Failure for a file that is no page: results, as a rule, that were meant to be shown on one. */
void requirePage(const std::string& path) {
  constexpr std::string_view kPage = "<!doctype html>";  // As report.py begins it.
  std::string head(kPage.size(), '\0');
  std::error_code none;
  if (!std::filesystem::is_regular_file(path, none) || std::filesystem::file_size(path, none) == 0) return;
  std::ifstream file(path, std::ios::binary);
  if (file.read(head.data(), static_cast<std::streamsize>(head.size())) && head == kPage) return;
  throw Failure(path, "it is there and is no page", "another name; --with shows results");
}

struct ReportOptions {
  std::string output = "haptic-bench.html";
  std::vector<std::string> results, algorithms;
};

/** Throws Failure for an algorithm that takes none of the page's kinds of models: before minutes, not after. */
void requireSomeModel(const std::vector<std::string>& algorithms) {
  const Surface surface{1000, 0, 0, 0};
  constexpr std::pair<const char*, const char*> kKinds[] = {
      {"sphere:stacks=4", "spiral"}, {"plane", "lissajous"}, {"ridge:degrees=45", "profile"}};
  for (const std::string& one : algorithms) {
    std::string reason;
    const bool some = std::any_of(std::begin(kKinds), std::end(kKinds), [&](const auto& kind) {
      const Model model = makeModel(kind.first);
      reason = refusal(one, model, makeTrajectory(kind.second, model, surface), surface);
      return reason.empty();
    });
    if (!some) throw Failure(reason);
  }
}

/** What the page says of algorithms that it does not know. */
json moreAsJson(const std::vector<std::string>& algorithms) {
  json all = json::array();
  for (const std::string& one : algorithms) {
    const char* summary = findAlgorithm(one).summary;
    all.push_back({{"name", one}, {"summary", summary == nullptr ? "" : summary}});
  }
  return all;
}

int run(const ReportOptions& options, const Common& common) {
  requireNames(options.algorithms);
  requireSomeModel(options.algorithms);
  requirePage(options.output);
  WholeFile page(options.output);
  draw({}, "--check", options.results);  // Before minutes of measurements, not after.
  json data;
  data["version"] = HAPTICD_VERSION;
  data["machine"] = describeMachine();
  data["versions"] = versions();
  data["rounds"] = common.rounds;
  data["more"] = moreAsJson(options.algorithms);
  data["tables"] = tablesAsJson(paperTables(common.rounds, options.algorithms));
  tellTime("plots");
  data["ridges"] = ridgesAsJson(options.algorithms);
  data["sweep"] = sweepAsJson(options.algorithms);
  draw(data, page.part(), options.results);
  page.keep();
  fmt::print("{}\n", options.output);
  return 0;
}

}  // namespace

void addReport(CLI::App& app, Run& chosen) {
  auto options = std::make_shared<ReportOptions>();
  CLI::App* sub = app.add_subcommand("report", "One HTML page with tables and plots, for a paper");
  sub->add_option("FILE", options->output, "The page")->capture_default_str();
  sub->footer(algorithmHelp());
  sub->add_option("-a,--algorithm", options->algorithms,
                  "More algorithms for its tables and plots, as for run; after FILE");
  sub->add_option("--with", options->results, "Results of other subcommands to show on it: files that --csv wrote")
      ->check(CLI::ExistingFile)
      ->check([](const std::string& path) {
        std::error_code none;
        return std::filesystem::is_character_file(path, none) ? path + " is a device, without an end" : std::string();
      });
  whenNamed(sub, chosen, [options](const Common& common) { return run(*options, common); });
}

}  // namespace haptic_bench
