// Results of haptic-bench: refused with a place, or compared with themselves without a change, and with others.
// What follows a zero byte is the other file.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/result/results.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace haptic_bench;
  try {
    const std::string_view all(reinterpret_cast<const char*>(data), size);
    const std::size_t parted = std::min(all.find('\0'), size);
    const Results results = Results::parse(all.substr(0, parted), "fuzz");
    for (const Change& change : compare(results, results, {true, true})) {
      if (change.kind != Change::Kind::kUnknown) std::abort();  // Times of too few rounds are not judged.
    }
    if (!otherSettings(results, results).empty()) std::abort();
    if (parted == size) return 0;
    const Results other = Results::parse(all.substr(parted + 1), "fuzz");
    for (const Change& change : compare(results, other, {true, true})) {
      const bool there = other.find(change.benchmark, change.quantity) != nullptr;
      if (change.kind == Change::Kind::kUnknown && !there) std::abort();
    }
  } catch (const Failure& failure) {
    if (std::string_view(failure.what()).substr(0, 4) != "fuzz") std::abort();
  }
  return 0;
}
