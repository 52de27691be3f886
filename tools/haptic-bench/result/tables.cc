#include "tools/haptic-bench/result/tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/haptic-bench/spec.h"

namespace haptic_bench {
namespace {

constexpr auto kKey = TableColumn::Role::kKey;
constexpr auto kGroup = TableColumn::Role::kGroup;
constexpr auto kRepeats = TableColumn::Role::kRepeats;
constexpr auto kMemory = TableColumn::Role::kMemory;
constexpr auto kTimed = TableColumn::Role::kTimed;
constexpr auto kAside = TableColumn::Role::kAside;

constexpr Rule less(double absolute, double relative) { return {Rule::Better::kLess, absolute, relative}; }
constexpr Rule more(double absolute, double relative) { return {Rule::Better::kMore, absolute, relative}; }

// Six digits are printed.
constexpr double kDigits = 1e-5;
// Bisection ends within a hundredth below the limit: two that differ by less may have found the same (kPrecision).
constexpr double kBisected = 0.01 + kDigits;
// Between encoder steps a wall's hunting hangs on the last bit: a millionth more push moved limits by up to 35 %, and
// buzz from nothing to 0.3 N^2 (docs/benchmark.md).
constexpr Rule kLimit{Rule::Better::kMore, 0, 0.5, kBisected};
constexpr Rule kBuzz{Rule::Better::kLess, 1, 1, 0.01};
// With an ideal encoder these pushes moved nothing without the controller, 2 % with it.
constexpr Rule kIdealBuzz = less(1e-3, 0.1);
constexpr TableColumn kZwidth[] = {
    {"rate_hz", kKey, "Hz"},
    {"delay_ticks", kKey, "ticks"},
    {"step_m", kGroup, "m"},
    {"friction_n", kGroup, "N"},
    {"damping", kKey, "N s/m"},
    {"colgate", kRepeats, "N/m", more(0, kDigits)},
    {"colgate_delayed", kRepeats, "N/m", more(0, kDigits)},
    {"friction_limit", kRepeats, "N/m", more(0, kDigits)},
    {"eigenvalue", kRepeats, "N/m", more(0, kDigits)},
    {"slowest", kRepeats, "N/m", more(0, kDigits)},
    {"off", kRepeats, "N/m", kLimit, more(0, kBisected)},
    {"on", kRepeats, "N/m", kLimit, more(0, 0.03)},
    {"displayed", kRepeats, "", {Rule::Better::kNearOne, 0.05, 0}},
    {"buzz_off", kRepeats, "N^2", kBuzz, kIdealBuzz},
    {"buzz_on", kRepeats, "N^2", kBuzz, kIdealBuzz},
};

constexpr double kPart = 1e-3;  // Of an error.
constexpr TableColumn kSixdof[] = {
    {"case", kKey, ""},
    {"response", kKey, ""},
    {"rate_hz", kKey, "Hz"},
    {"force_rms_n", kRepeats, "N", less(1e-6, kPart)},
    {"force_relative", kRepeats, "", less(1e-6, kPart)},
    {"force_worst_n", kRepeats, "N", less(1e-6, kPart)},
    {"force_angle_deg", kRepeats, "deg", less(1e-4, kPart)},
    {"torque_rms_nm", kRepeats, "N m", less(1e-8, kPart)},
    {"torque_relative", kRepeats, "", less(1e-6, kPart)},
    {"torque_angle_deg", kRepeats, "deg", less(1e-4, kPart)},
    {"overlap_m", kRepeats, "m", less(1e-7, kPart)},
};

// What comes to rest does so at nanometres or less, in which any other rounding makes another order of magnitude: told
// from a tenth of an encoder step, or of what is allowed, on.
constexpr TableColumn kStability[] = {
    {"pair", kKey, ""},
    {"excitation", kKey, ""},
    {"response", kKey, ""},
    {"runs", kKey, "runs"},
    {"at_rest", kRepeats, "runs", more(0, 0)},
    {"patience_s", kRepeats, "s", less(0.1, 0.01)},
    {"unrest_m", kRepeats, "m", less(1e-6, 0.01)},
    {"created_j", kRepeats, "J", less(1e-9, 0.01)},
    {"strongest_n", kRepeats, "N", less(0.01, 0.1)},
    {"creep_m", kRepeats, "m", less(1e-6, 0.01)},
    {"creep_rad", kRepeats, "rad", less(1e-4, 0.01)},
    {"finite", kRepeats, "", more(0, 0)},
};

// Wrenches and memory to the last digit that is printed.
constexpr TableColumn kCollide[] = {
    {"pair", kKey, ""},
    {"subject", kKey, ""},
    {"query", kKey, ""},
    {"poses", kAside, "poses"},  // As many as there was time for.
    {"mean", kTimed, "ms"},
    {"p50", kTimed, "ms"},
    {"p99", kTimed, "ms"},
    {"p99.9", kTimed, "ms"},
    {"steady", kTimed, "ms"},
    {"max", kTimed, "ms"},
    {"records", kRepeats, "records", more(1.01, 0.05)},  // A library's are of as many poses as there was time for.
    {"rate", kTimed, "1/ms"},
    {"build", kTimed, "ms"},
    {"MB", kMemory, "MB", less(0.11, 0.02)},
    {"force", kRepeats, "%", less(0.011, 0)},
    {"angle", kRepeats, "deg", less(0.011, 0)},
    {"torque", kRepeats, "%", less(0.011, 0)},
};

// A last bit moves what is told by steps of a person: where a cube is still held, when a bar is stopped.
constexpr TableColumn kGraspCubes[] = {
    {"mass_kg", kKey, "kg"},
    {"friction", kKey, ""},
    {"stiffness", kKey, "N/m"},
    {"hold", kKey, ""},
    {"slips_n", kRepeats, "N", less(0, kDigits)},
    {"fell", kRepeats, "", {Rule::Better::kNearOne, 0.05, 0}},
    {"held_n", kRepeats, "N", less(0.1, 0.2)},
};
constexpr TableColumn kGraspRelease[] = {
    {"condition", kKey, ""},
    {"arm_m", kKey, "m"},
    {"lever_m", kKey, "m"},
    {"closed_n", kRepeats, "N", less(0, kPart)},
    {"yields", kRepeats, "", {Rule::Better::kNearOne, 0.01, 0}},
    {"slid_10_m", kRepeats, "m", less(1e-4, 0.1)},
    {"slid_30_m", kRepeats, "m", less(1e-4, 0.1)},
    {"turned_5_rad", kRepeats, "rad", more(0.01, 0.1)},
};
constexpr TableColumn kGraspAlign[] = {
    {"condition", kKey, ""},
    {"lever_m", kKey, "m"},
    {"wanted_deg", kKey, "deg"},
    {"mass_kg", kKey, "kg"},
    {"person", kKey, ""},
    {"off_deg", kAside, "deg"},
    {"error_deg", kRepeats, "deg", less(10, 0)},
    {"slid_m", kRepeats, "m", less(2e-3, 0.5)},
    {"lost", kRepeats, "", less(0.5, 0)},
};

constexpr TableForm kForms[] = {{"zwidth", kZwidth, "step_m", 1e-9}, {"sixdof", kSixdof},
                                {"stability", kStability},           {"collide", kCollide},
                                {"grasp-cubes", kGraspCubes},        {"grasp-release", kGraspRelease},
                                {"grasp-align", kGraspAlign}};

constexpr const char* kFormerCost[] = {"triangles", "what", "mean", "median", "p99", "p99.9", "max", "chase"};

bool holds(const TableForm& form, const std::string& name) {
  return std::any_of(form.columns.begin(), form.columns.end(), [&](const TableColumn& c) { return name == c.name; });
}

}  // namespace

std::string TableForm::header() const {
  std::string line;
  for (const TableColumn& column : columns) line += (line.empty() ? "" : ",") + std::string(column.name);
  return line;
}

std::span<const TableForm> tableForms() { return kForms; }

const TableForm& tableForm(std::string_view benchmark) {
  return *std::find_if(std::begin(kForms), std::end(kForms),
                       [&](const TableForm& f) { return benchmark == f.benchmark; });
}

const TableForm* formOfHeader(std::string_view line) {
  for (const TableForm& form : kForms) {
    if (line == form.header()) return &form;
  }
  return nullptr;
}

std::string faultOfHeader(const std::vector<std::string>& fields) {
  if (std::equal(fields.begin(), fields.end(), std::begin(kFormerCost), std::end(kFormerCost)))
    return "an older version of haptic-bench cost has written it";
  for (const TableForm& form : kForms) {
    const auto known = std::count_if(fields.begin(), fields.end(), [&](const auto& f) { return holds(form, f); });
    if (known < 3 || 2 * known <= static_cast<std::ptrdiff_t>(fields.size())) continue;
    for (const std::string& field : fields) {
      if (!holds(form, field)) return fmt::format("{} of this version has no column \"{}\"", form.benchmark, field);
      if (std::count(fields.begin(), fields.end(), field) > 1) return fmt::format("column {} stands twice", field);
    }
    for (const TableColumn& column : form.columns) {
      if (std::find(fields.begin(), fields.end(), column.name) == fields.end())
        return fmt::format("{}'s column {} is missing", form.benchmark, column.name);
    }
    return fmt::format("{}'s columns are in another order", form.benchmark);
  }
  return {};
}

bool readCell(std::string_view cell, double& value) {
  const double infinite = std::numeric_limits<double>::infinity();
  const std::pair<std::string_view, double> words[] = {
      {"", std::nan("")}, {"-", std::nan("")}, {"nan", std::nan("")}, {"-nan", std::nan("")},
      {"inf", infinite},  {"-inf", -infinite}, {"true", 1},           {"false", 0}};
  for (const auto& [word, meaning] : words) {
    if (cell == word) return value = meaning, true;
  }
  return parseNumber(cell, value);
}

int judgeByRule(const Rule& rule, double before, double after) {
  if (std::isnan(before) || std::isnan(after))
    return static_cast<int>(std::isnan(after)) - static_cast<int>(std::isnan(before));
  const auto badness = [&](double x) {
    switch (rule.better) {
      case Rule::Better::kMore:
        return -x;
      case Rule::Better::kNearOne:
        return std::abs(x - 1);
      case Rule::Better::kLess:
        break;
    }
    return std::max(x, 0.0);
  };
  const double a = badness(before), b = badness(after);
  if (a == b) return 0;
  if (std::isfinite(a) && std::isfinite(b) &&
      std::abs(b - a) <= std::max(rule.absolute, rule.relative * std::min(std::abs(a), std::abs(b))))
    return 0;
  return b > a ? 1 : -1;
}

}  // namespace haptic_bench
