#include "drivers/did_you_mean.h"

#include <algorithm>
#include <utility>

#include "rt/base/edit_distance.h"

namespace hapticd {
namespace {

/** Not by chance: "friction" of "friction_static". */
bool partOf(std::string_view word, std::string_view longer) {
  return word.size() > 2 && longer.find(word) != std::string_view::npos;
}

}  // namespace

std::string_view nearest(std::string_view word, const std::vector<std::string_view>& candidates) {
  std::string_view best;
  std::size_t fewest = 4;  // More edits than this is another word.
  for (const std::string_view candidate : candidates) {
    std::size_t edits = editDistance(word.substr(0, 64), candidate);
    if (edits >= candidate.size()) continue;
    if (partOf(word, candidate)) edits = std::min<std::size_t>(edits, 3);
    if (edits < fewest) {
      fewest = edits;
      best = candidate;
    }
  }
  return best;
}

std::string nearestNames(std::string_view wanted, std::vector<std::string> names, std::size_t most) {
  wanted = wanted.substr(0, 64);
  if (names.size() > most) {
    std::vector<std::pair<std::size_t, std::string>> ranked;
    ranked.reserve(names.size());
    for (auto& name : names) {
      std::size_t edits = editDistance(wanted, name);
      if (partOf(wanted, name) || partOf(name, wanted)) edits = std::min<std::size_t>(edits, 3);
      ranked.emplace_back(edits, std::move(name));
    }
    std::sort(ranked.begin(), ranked.end());
    names.clear();
    for (std::size_t i = 0; i < most; ++i) names.push_back(std::move(ranked[i].second));
  }
  std::string joined;
  for (const auto& name : names) joined += (joined.empty() ? "" : ", ") + name;
  return joined;
}

}  // namespace hapticd
