#include "tools/haptic-bench/trajectory/recording_reader.h"

#include <fmt/format.h>

#include <fstream>
#include <memory>

#include "daemon/recording/reader.h"
#include "tools/haptic-bench/failure.h"

namespace haptic_bench {

bool isRecording(const std::string& path) {
  char head[8] = {};
  std::ifstream file(path, std::ios::binary);
  return file.read(head, sizeof head) && std::string(head, sizeof head) == "HRBLOCK1";
}

Trajectory readRecordedSession(const std::string& path, std::size_t device) {
  hapticd::RecordingReader reader = orFailIn(path, hapticd::RecordingReader::open(path));
  const std::size_t devices = reader.header().devices.size();
  if (device >= devices) {
    throw Failure(path, fmt::format("it has no device {}", device), fmt::format("it has {}: --device from 0", devices));
  }
  Trajectory in;
  in.name = path;
  in.force_known = true;
  const auto cycle = std::make_unique<hapticd::RecordedCycle>();
  std::int64_t first_ns = 0;
  while (orFailIn(path, reader.next(*cycle))) {
    if (in.samples.empty()) first_ns = cycle->input.now_ns;
    const double t_s = 1e-9 * static_cast<double>(cycle->input.now_ns - first_ns);
    if (!in.samples.empty() && t_s <= in.samples.back().t_s) {
      throw Failure(path, fmt::format("time stands still or goes back at tick {}", cycle->input.tick),
                    "a whole recording");
    }
    if (!cycle->input.device[device].p.allFinite()) continue;  // A device that failed: the hand is nowhere.
    if (static_cast<double>(in.samples.size()) >= kMaxSamples) {
      throw Failure(path,
                    fmt::format("there are more than {:g} cycles in it, at tick {}", kMaxSamples, cycle->input.tick),
                    "a shorter recording");
    }
    in.samples.push_back({t_s, cycle->input.device[device].p, Vec3::Zero(), cycle->sent[device].force});
  }
  if (in.samples.empty()) throw Failure(path, "there are no cycles in it", "a longer recording");
  return in;
}

}  // namespace haptic_bench
