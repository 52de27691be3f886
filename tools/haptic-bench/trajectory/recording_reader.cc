#include "tools/haptic-bench/trajectory/recording_reader.h"

#include <fmt/format.h>

#include <fstream>
#include <memory>

#include "daemon/recording/replayer.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/model/recorded.h"

namespace haptic_bench {

bool isRecording(const std::string& path) {
  char head[8] = {};
  std::ifstream file(path, std::ios::binary);
  return file.read(head, sizeof head) && std::string(head, sizeof head) == "HRBLOCK1";
}

Trajectory readRecordedSession(const std::string& path, std::size_t device) {
  // Run again, for nothing else knows how far the arming ramp was.
  const std::unique_ptr<hapticd::Replayer> replayer = orFailIn(path, hapticd::Replayer::open(path));
  const std::size_t devices = replayer->recording().header().devices.size();
  if (device >= devices) {
    throw Failure(path, fmt::format("it has no device {}", device), fmt::format("it has {}: --device from 0", devices));
  }
  Trajectory in;
  std::int64_t first_ns = 0;
  std::uint64_t cycles = 0;
  for (; orFailIn(path, replayer->step()); ++cycles) {
    const hapticd::RecordedCycle& cycle = replayer->recorded();
    if (in.samples.empty()) first_ns = cycle.input.now_ns;
    const double t_s = 1e-9 * static_cast<double>(cycle.input.now_ns - first_ns);
    if (!in.samples.empty() && t_s <= in.samples.back().t_s) {
      throw Failure(path, fmt::format("time stands still or goes back at tick {}", cycle.input.tick),
                    "a whole recording");
    }
    if (!cycle.input.device[device].p.allFinite()) continue;  // A device that failed: the hand is nowhere.
    if (static_cast<double>(in.samples.size()) >= kMaxSamples) {
      throw Failure(path,
                    fmt::format("there are more than {:g} cycles in it, at tick {}", kMaxSamples, cycle.input.tick),
                    "a shorter recording");
    }
    const hapticd::DeviceOutput& again = replayer->output().device[device];
    const bool ramping = (again.guard.flags & HD_SAMPLE_RAMPING) != 0;
    in.samples.push_back({t_s, again.pose.p, Vec3::Zero(),
                          replayer->cycle().mount(device).toWorld(cycle.sent[device].force),
                          cycle.sent[device].enabled && !ramping});
  }
  tellWhatLacks(path, replayer->recording(), cycles);
  if (cycles == 0) throw Failure(path, "there are no cycles in it", "a longer recording");
  if (in.samples.empty()) {
    throw Failure(path, fmt::format("in no cycle of it device {} knew where it was", device),
                  "a session in which the device worked");
  }
  in.force_known = true;
  in.start = in.samples.front().hip;  // A recording begins without contacts, also within a mesh.
  return in;
}

}  // namespace haptic_bench
