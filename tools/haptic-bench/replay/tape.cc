#include "tools/haptic-bench/replay/tape.h"

#include <algorithm>

#include "proto/shm_layout.h"
#include "tools/haptic-bench/failure.h"

namespace haptic_bench {
namespace {

using hapticd::Quat;
using hapticd::Vec3;
using hapticd::Wrench;

void put(const Vec3& x, double* out) { std::copy_n(x.data(), 3, out); }
void put(const Quat& q, double* out) {
  const double values[] = {q.w(), q.x(), q.y(), q.z()};
  std::copy_n(values, 4, out);
}

}  // namespace

const std::vector<Column>& columns() {
  static const std::vector<Column> kAll = {
      {"tick", "", 1, [](const Row& r, double* out) { *out = static_cast<double>(r.tick); }},
      {"t", "s", 1, [](const Row& r, double* out) { *out = r.t_s; }},
      {"fresh", "", 1, [](const Row& r, double* out) { *out = r.sample->fresh ? 1 : 0; }},
      {"p", "m", 3, [](const Row& r, double* out) { put(r.replayed->pose.p, out); }},
      {"q", "", 4, [](const Row& r, double* out) { put(r.replayed->pose.q, out); }},
      {"v", "m/s", 3, [](const Row& r, double* out) { put(r.replayed->velocity.v, out); }},
      {"w", "rad/s", 3, [](const Row& r, double* out) { put(r.replayed->velocity.w, out); }},
      {"gripper", "rad", 1, [](const Row& r, double* out) { *out = r.sample->gripper_rad; }},
      {"buttons", "", 1, [](const Row& r, double* out) { *out = r.sample->buttons; }},
      {"status", "", 1, [](const Row& r, double* out) { *out = r.sample->status; }},
      {"enabled", "", 1, [](const Row& r, double* out) { *out = r.sent->enabled ? 1 : 0; }},
      {"ramping", "", 1,
       [](const Row& r, double* out) { *out = (r.replayed->guard.flags & HD_SAMPLE_RAMPING) != 0 ? 1 : 0; }},
      {"f", "N", 3, [](const Row& r, double* out) { put(r.mount->toWorld(r.sent->force), out); }},
      {"t", "N m", 3,
       [](const Row& r, double* out) {
         put(r.mount->toWorld(Wrench{{}, r.sent->torque}).torque, out);
       }},
      {"gripper_force", "N", 1, [](const Row& r, double* out) { *out = r.sent->gripper_force; }},
      {"proxy", "m", 3,
       [](const Row& r, double* out) {
         put(r.replayed->contact.object != 0 ? r.replayed->contact.proxy : r.replayed->pose.p, out);
       }},
      {"depth", "m", 1, [](const Row& r, double* out) { *out = r.replayed->contact.depth; }},
      {"object", "", 1, [](const Row& r, double* out) { *out = r.replayed->contact.object; }},
      {"fault", "", 1, [](const Row& r, double* out) { *out = r.replayed->guard.fault; }},
      {"energy", "J", 1, [](const Row& r, double* out) { *out = r.replayed->guard.energy; }},
  };
  return kAll;
}

std::string columnName(const Column& column, int i) {
  std::string name = column.name;
  if (column.width == 1) return name;
  if (name.size() > 2) name += '_';
  return name + "wxyz"[column.width == 4 ? i : i + 1];
}

void forEachRow(hapticd::Replayer& replayer, const std::string& recording,
                const std::function<void(std::uint32_t device, const Row& row)>& take) {
  const std::uint32_t devices = replayer.recording().header().start.config.device_count;
  std::int64_t first_ns = 0;
  bool first = true;
  while (orFailIn(recording, replayer.step())) {
    const hapticd::RecordedCycle& cycle = replayer.recorded();
    if (first) first_ns = cycle.input.now_ns;
    first = false;
    for (std::uint32_t d = 0; d < devices; ++d) {
      take(d, {cycle.input.tick, static_cast<double>(cycle.input.now_ns - first_ns) * 1e-9, &cycle.input.device[d],
               &cycle.sent[d], &replayer.output().device[d], &replayer.cycle().mount(d)});
    }
  }
}

}  // namespace haptic_bench
