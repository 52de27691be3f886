/** @file
 * What the subcommands of haptic-bench share: options, estimates and output.
 */
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
}

namespace haptic_bench {

/** Options of every subcommand. */
struct Common {
  bool csv = false;
  int rounds = 15;  ///< A/B rounds, interleaved.
};

/** What to run once the command line is read; the value is the exit code. */
using Run = std::function<int(const Common&)>;

/** Adds one subcommand to `app`; it sets `chosen` when it is called for. One per file; the table is in main.cc. */
using AddBenchmark = void (*)(CLI::App& app, Run& chosen);

void addRun(CLI::App& app, Run& chosen);
void addSweep(CLI::App& app, Run& chosen);
void addTables(CLI::App& app, Run& chosen);
void addReport(CLI::App& app, Run& chosen);
void addShort(CLI::App& app, Run& chosen);
void addCompare(CLI::App& app, Run& chosen);
void addLoad(CLI::App& app, Run& chosen);
void addModels(CLI::App& app, Run& chosen);
void addReplay(CLI::App& app, Run& chosen);
void addRing(CLI::App& app, Run& chosen);
void addServo(CLI::App& app, Run& chosen);
void addDevice(CLI::App& app, Run& chosen);
void addCost(CLI::App& app, Run& chosen);
void addZwidth(CLI::App& app, Run& chosen);
void addCollide(CLI::App& app, Run& chosen);
void addSixdof(CLI::App& app, Run& chosen);
void addStability(CLI::App& app, Run& chosen);
void addGrasp(CLI::App& app, Run& chosen);

/** Rounds below which the interval of a median is no more than their range. */
inline constexpr std::size_t kRoundsOfAnInterval = 6;

/** Median of some rounds and its interval. */
struct Estimate {
  double median = 0, low = 0, high = 0;
};

/**
 * Median with an interval that holds the true one with at least 95 % (by order statistics, whatever the distribution;
 * Conover, Practical Nonparametric Statistics, 3.2). With fewer than 6 samples the interval is their range and holds
 * less.
 */
[[nodiscard]] Estimate estimate(std::vector<double> samples);

/** One measured quantity, a value for each round. */
struct Series {
  std::string name;
  std::string unit;
  std::vector<double> rounds;
};

/** What is counted in each tick of a fixed course: the same on every machine. */
inline constexpr const char* kCountedUnit = "a tick";

/** What a driver's protocol takes in virtual time: the same in every run. */
inline constexpr const char* kVirtualTimeUnit = "us of virtual time";

/** How names end of what was taken from all slices of a run together, and of the ends of its interval if it has one. */
inline constexpr std::string_view kPooled = ", all slices", kPooledLow = ", 95 % low", kPooledHigh = ", 95 % high";

/** An error as a part of the force that was to be felt: the same on every machine. */
inline constexpr const char* kForceErrorUnit = "% of the force";

/** A quantity of the machine, beside which others are seen; not compared. */
inline constexpr const char* kMachineLatency = "pointer chase";

/** The columns of --csv: one line for each round. */
inline constexpr std::string_view kResultsHeader = "benchmark,quantity,unit,round,value";

/** A value as text: `digits` of it, all of a hash. */
[[nodiscard]] std::string valueText(const std::string& unit, double value, int digits);

/** a / b, round by round. */
[[nodiscard]] Series ratio(std::string name, const Series& a, const Series& b);

/** Prints the lines of a CSV under kResultsHeader. */
void printRounds(const std::string& benchmark, const std::vector<Series>& all);

/** The comment line of --csv that tells what the numbers hang on and no name says; compare refuses two that differ. */
[[nodiscard]] std::string settingsLine(std::string_view benchmark, std::string_view settings);

/**
 * Prints series. As a table: machine, then median and interval of each. As CSV: the machine and the settings, if there
 * are any, as comment lines, then benchmark,quantity,unit,round,value with one line per round.
 */
void print(const Common& common, const std::string& benchmark, const std::vector<Series>& all,
           const std::string& settings = {});

}  // namespace haptic_bench
