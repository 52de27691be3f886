// Results of haptic-bench: refused with a place, or compared with themselves without a change.
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/result/results.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace haptic_bench;
  try {
    const Results results = Results::parse({reinterpret_cast<const char*>(data), size}, "fuzz");
    for (const Change& change : compare(results, results, {true, true})) {
      if (change.kind != Change::Kind::kUnknown) std::abort();  // Times of too few rounds are not judged.
    }
  } catch (const Failure& failure) {
    if (std::string_view(failure.what()).substr(0, 4) != "fuzz") std::abort();
  }
  return 0;
}
