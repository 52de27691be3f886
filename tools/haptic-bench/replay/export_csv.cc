#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <iterator>
#include <memory>

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/replay/tape.h"

namespace haptic_bench {

void exportCsv(hapticd::Replayer& replayer, const std::string& recording, const std::string& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "we"), &std::fclose);
  if (!file) throw Failure(path, "it cannot be written", "see the path and its rights");
  std::string line = "device";
  for (const Column& column : columns()) {
    for (int i = 0; i < column.width; ++i) line += "," + columnName(column, i);
  }
  line += '\n';
  bool written = std::fputs(line.c_str(), file.get()) >= 0;
  forEachRow(replayer, recording, [&](std::uint32_t device, const Row& row) {
    std::array<double, 4> values{};
    line = std::to_string(device);
    for (const Column& column : columns()) {
      column.get(row, values.data());
      for (int i = 0; i < column.width; ++i)
        fmt::format_to(std::back_inserter(line), ",{}", values[static_cast<std::size_t>(i)]);
    }
    line += '\n';
    written = std::fputs(line.c_str(), file.get()) >= 0 && written;
  });
  if (!written || std::fflush(file.get()) != 0)
    throw Failure(path, "it could not be written whole", "make room on the disk");
}

}  // namespace haptic_bench
