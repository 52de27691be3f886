#include "tools/haptic-bench/spec.h"

#include <fmt/format.h>

#include <cmath>

#include "tools/haptic-bench/failure.h"

namespace haptic_bench {

Spec::Spec(std::string_view text) : text_(text) {
  const std::size_t colon = text.find(':');
  name_ = text.substr(0, colon);
  if (colon == std::string_view::npos) return;
  settings_ = text.substr(colon + 1);
  std::string_view rest = settings_;
  while (!rest.empty()) {
    const std::string_view item = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), item.size() + 1));
    const std::size_t equals = item.find('=');
    if (equals == 0 || equals == std::string_view::npos) {
      throw Failure(text_, fmt::format("\"{}\" is no setting", item), "name:key=value,key=value");
    }
    if (!values_.emplace(item.substr(0, equals), item.substr(equals + 1)).second) {
      throw Failure(text_, fmt::format("{} is set twice", item.substr(0, equals)), "leave one");
    }
  }
}

double Spec::number(const std::string& key, double otherwise, double low, double high) {
  known_.insert(key);
  const auto found = values_.find(key);
  if (found == values_.end()) return otherwise;
  double value = 0;
  if (!parseNumber(found->second, value)) {
    throw Failure(where(key), fmt::format("\"{}\" is not a number", found->second), "SI units");
  }
  if (value < low || value > high) {
    throw Failure(where(key), fmt::format("{} is out of range", value), fmt::format("from {} to {}", low, high));
  }
  return value;
}

int Spec::count(const std::string& key, int otherwise, int low, int high) {
  const double value = number(key, otherwise, low, high);
  if (value != std::floor(value)) throw Failure(where(key), "is not a whole number", "for example " + key + "=4");
  return static_cast<int>(value);
}

std::string Spec::word(const std::string& key, const std::string& otherwise) {
  known_.insert(key);
  const auto found = values_.find(key);
  return found == values_.end() ? otherwise : found->second;
}

void Spec::finish() const {
  for (const auto& [key, value] : values_) {
    if (known_.count(key) != 0) continue;
    std::string all;
    for (const std::string& name : known_) all += (all.empty() ? "" : ", ") + name;
    throw Failure(where(key), name_ + " has no such setting", all.empty() ? "it has none" : "it has " + all);
  }
}

hapticd::Pose placement(Spec& spec) {
  constexpr double kFarthest = 100, kTurn = 4;
  const auto three = [&](const std::string& prefix, double most) -> hapticd::Vec3 {
    return {spec.number(prefix + "x", 0, -most, most), spec.number(prefix + "y", 0, -most, most),
            spec.number(prefix + "z", 0, -most, most)};
  };
  hapticd::Pose pose;
  pose.p = three("", kFarthest);
  const hapticd::Vec3 turn = three("turn_", kTurn);
  if (turn.norm() > 0) pose.q = Eigen::AngleAxisd(turn.norm(), turn.normalized());
  return pose;
}

}  // namespace haptic_bench
