// haptic-bench zwidth: how stiff a wall may be before the closed loop of device, hand and cycle goes unstable.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/machine.h"
#include "tools/haptic-bench/option.h"
#include "tools/haptic-bench/result/tables.h"
#include "tools/haptic-bench/zwidth/sweep.h"

namespace haptic_bench {
namespace {

using namespace zwidth;  // NOLINT(google-build-using-namespace)

/** The columns of tableForm("zwidth"). */
void printCsv(const Row& r) {
  fmt::print("{},{},{},{},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.4g},{:.4g},{:.4g}\n", r.change.rate_hz,
             r.change.delay, r.step, r.friction, r.damping, r.colgate, r.colgate_delayed, r.friction_limit,
             r.eigenvalue, r.slowest, r.off, r.on, r.displayed, r.buzz_off, r.buzz_on);
}

void printTable(const Row& r, const Row* before) {
  const bool fresh = before == nullptr || before->change.rate_hz != r.change.rate_hz ||
                     before->change.delay != r.change.delay || before->step != r.step || before->friction != r.friction;
  if (fresh) {
    fmt::print(
        "\n{:g} Hz, {} ticks of delay, steps of {:.3g} um, friction {:g} N (steps need K <= {:.4g} N/m of friction)\n",
        r.change.rate_hz, r.change.delay, r.step * 1e6, r.friction, r.friction_limit);
    fmt::print("{:>8} {:>9} {:>9} {:>9} {:>9} {:>9} {:>6} {:>9} {:>9} {:>9}\n", "damping", "col.delay", "slowest",
               "eigenval", "off", "on", "on/off", "displayed", "buzz off", "buzz on");
  }
  fmt::print("{:>8g} {:>9.0f} {:>9.0f} {:>9.0f} {:>9.0f} {:>9.0f} {:>6.2f} {:>9.3f} {:>9.4f} {:>9.4f}\n", r.damping,
             r.colgate_delayed, r.slowest, r.eigenvalue, r.off, r.on, r.off > 0 ? r.on / r.off : 0.0, r.displayed,
             r.buzz_off, r.buzz_on);
}

/** Whether there are goals, and all are met. */
bool printGoals(const std::vector<Row>& rows, const char* prefix) {
  bool met = true, any = false;
  for (const Goal& goal : judge(rows)) {
    if (goal.rows == 0) continue;
    any = true;
    met = met && goal.missed == 0;
    fmt::print("{}{}: {} of {} rows, worst {:.3f} (asked {:g})\n", prefix, goal.name, goal.rows - goal.missed,
               goal.rows, goal.worst, goal.asked);
  }
  if (!any) fmt::print("{}no goal speaks of these walls\n", prefix);
  return met && any;
}

int run(const Options& options, bool check, const Common& common) {
  std::vector<Row> rows = plan(options);
  const double push = options.push ? *options.push : usualPush(options.uri);
  for (const std::string& line : describeMachine()) fmt::print("# {}\n", line);
  fmt::print("# {}: press of {:.9g} N, stiffness in N/m, damping in N s/m, buzz in N^2 at {} of off\n", options.uri,
             push, kBuzzAt);
  if (common.csv) {
    fmt::print("{}\n", settingsLine("zwidth", fmt::format("{}, press of {:.9g} N, slew limit of {} N/s", options.uri,
                                                          push, options.force_slew)));
    fmt::print("{}\n", tableForm("zwidth").header());
  }
  const Row* before = nullptr;
  for (Row& row : rows) {
    measure(options, row);
    if (common.csv) {
      printCsv(row);
    } else {
      printTable(row, before);
    }
    std::fflush(stdout);
    before = &row;
  }
  if (!common.csv) fmt::print("\n");
  const bool met = printGoals(rows, common.csv ? "# " : "");
  return check && !met ? 1 : 0;
}

}  // namespace

void addZwidth(CLI::App& app, Run& chosen) {
  auto options = std::make_shared<Options>();
  auto check = std::make_shared<bool>(false);
  CLI::App* sub = app.add_subcommand(
      "zwidth", "The stiffest stable wall for each damping on a simulated device with its hand, beside theory");
  sub->add_option("uri", options->uri, "Simulated device and hand")->capture_default_str();
  bounded(sub, "--rate", options->rates_hz, "Servo and device rates [Hz]", 100.0, 16000.0);
  bounded(sub, "--delay", options->delays, "Delay from a sample to its force [ticks]", 0, 16);
  bounded(sub, "--damping", options->dampings, "Damping of the wall [N s/m]", 0.0, 1000.0);
  sub->add_option("--push", options->push,
                  "Force with which the hand presses [N]; else 4, or three fifths of what a weaker device has")
      ->check(within(0.01, 100.0));
  bounded(sub, "--slew", options->force_slew, "Slew limit of the guard [N/s]; the default is out of the way", 1.0, 1e9);
  sub->add_flag("--quick", options->quick, "Leaves out the device with its encoder but without its friction");
  sub->add_flag("--check", *check, "Exit 1 if a goal is missed (docs/stability.md)");
  whenNamed(sub, chosen, [options, check](const Common& common) { return run(*options, *check, common); });
}

}  // namespace haptic_bench
