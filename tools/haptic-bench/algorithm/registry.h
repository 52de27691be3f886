/** @file
 * Algorithms by the name on the command line.
 */
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rt/base/math.h"
#include "tools/haptic-bench/algorithm/plugin_watch.h"
#include "tools/haptic-bench/plugin/haptic_algorithm.h"

namespace haptic_bench {

using hapticd::Vec3;

/**
 * "NAME:OPTIONS": one in the box, or the path of a shared object (its name contains a slash). Throws Failure: unknown,
 * not loadable, of another version or incomplete. Objects stay loaded.
 */
[[nodiscard]] const haptic_algorithm& findAlgorithm(const std::string& spec);

/** Throws Failure unless the table is one of this version and whole. */
void checkAlgorithm(const haptic_algorithm* table, const std::string& where);

/** One line for each in the box, for --help. */
[[nodiscard]] std::string algorithmHelp();

/** Throws Failure for one that findAlgorithm() refuses or that is named twice: its results could not be told apart. */
void requireNames(const std::vector<std::string>& algorithms);

/** One instance. */
class Algorithm {
 public:
  /** Throws Failure with the algorithm's own sentence. */
  Algorithm(const std::string& spec, const haptic_algorithm_problem& problem);

  void start(const Vec3& hip);
  void step(const Vec3& hip, const Vec3& v, double dt_s, haptic_algorithm_contact& contact) {
    table_->step(instance_.get(), hip.data(), v.data(), dt_s, &contact);
  }
  /** 0: unknown. */
  [[nodiscard]] std::uint64_t bytes() const;

 private:
  const haptic_algorithm* table_;
  std::optional<PluginWatch> watch_;  ///< Before the instance, whose end it sees.
  std::unique_ptr<void, void (*)(void*)> instance_;
};

}  // namespace haptic_bench
