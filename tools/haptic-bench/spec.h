/** @file
 * What is named on the command line with its settings: "sphere:radius=0.05,stacks=16".
 */
#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>

#include "rt/base/math.h"
#include "tools/options/parse_number.h"

namespace haptic_bench {

/** A name and key=value settings. Ask for each setting that is known, then call finish(). */
class Spec {
 public:
  /** Throws Failure where a setting is not key=value or comes twice. */
  explicit Spec(std::string_view text);

  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] const std::string& name() const { return name_; }
  /** What stands behind the colon. */
  [[nodiscard]] const std::string& settings() const { return settings_; }
  [[nodiscard]] bool has(const std::string& key) const { return values_.count(key) != 0; }

  /** The number of a setting, `otherwise` where it is not given. Throws Failure outside [low, high]. */
  [[nodiscard]] double number(const std::string& key, double otherwise, double low, double high);
  [[nodiscard]] int count(const std::string& key, int otherwise, int low, int high);
  [[nodiscard]] std::string word(const std::string& key, const std::string& otherwise);

  /** Throws Failure for a setting that nobody asked for. */
  void finish() const;

 private:
  [[nodiscard]] std::string where(const std::string& key) const { return text_ + ", " + key; }

  std::string text_, name_, settings_;
  std::map<std::string, std::string> values_;
  std::set<std::string> known_;
};

/** Settings x, y, z [m] and the rotation vector turn_x, turn_y, turn_z [rad]; nothing where none is given. */
[[nodiscard]] hapticd::Pose placement(Spec& spec);

using hapticd_options::parseNumber;

}  // namespace haptic_bench
