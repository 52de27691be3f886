// Trajectory files of haptic-bench: refused with a place, or finite and rising.
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/trajectory/file_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace haptic_bench;
  static const Model model = [] {
    Model square;
    square.vertices = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    square.triangles = {{0, 1, 2}, {0, 2, 3}};
    return square;
  }();
  if (size == 0) return 0;
  FileOptions options;
  options.out = (data[0] & 1) != 0;
  if ((data[0] & 2) != 0) options.columns = "t,x,y,z,fn";
  try {
    const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
    const Trajectory in = readColumns(Table::parse(text, "fuzz", options.columns), options, model, {1000});
    for (std::size_t i = 0; i < in.samples.size(); ++i) {
      if (!in.samples[i].hip.allFinite() || !in.samples[i].force.allFinite()) std::abort();
      if (i > 0 && !(in.samples[i].t_s > in.samples[i - 1].t_s)) std::abort();
    }
  } catch (const Failure& failure) {
    if (std::string_view(failure.what()).substr(0, 4) != "fuzz") std::abort();
  }
  return 0;
}
