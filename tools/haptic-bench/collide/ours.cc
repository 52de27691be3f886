#include "tools/haptic-bench/collide/ours.h"

#include <algorithm>
#include <atomic>
#include <thread>

#include "tools/haptic-bench/failure.h"

namespace haptic_bench {
namespace {

constexpr double kDeepest = 0.015;  // Of the truth's search [m].

hapticd::DetectorQuery queryAt(const Subject& subject, const std::vector<hapticd::Pose>& poses, std::size_t i) {
  hapticd::DetectorQuery query;
  query.a.volume = &subject.tool->view;
  query.b.volume = &subject.base->view;
  query.a.X_WO = poses[i];
  query.a.X_WO_before = poses[i > 0 ? i - 1 : 0];
  query.first_only = subject.first_only;
  query.budget.units = subject.units;
  return query;
}

}  // namespace

BuiltVolume::BuiltVolume(const Model& model, double voxel, double point_spacing, std::uint32_t patch_points) {
  hapticd::VolumeOptions options;
  options.point_spacing_m = point_spacing;
  options.patch_points = patch_points;
  hapticd::BuildMonitor monitor;
  const double before = processNs();
  image = orFail(hapticd::buildMeshVolume(model.vertices, model.triangles, voxel, options, monitor));
  build_ms = (processNs() - before) * 1e-6;
  view = orFail(hapticd::validateVolume(hapticd::bytesOf(image)));
}

TruthTable makeTruth(const CollidePair& pair, const std::vector<hapticd::Pose>& poses, int count, int split) {
  TruthTable table;
  if (count <= 0) return table;
  const Truth truth(pair.base, pair.tool, split);
  const auto from = static_cast<std::size_t>(pair.contact_from / pair.duration * static_cast<double>(poses.size()));
  for (int i = 0; i < count; ++i) {
    const std::size_t at = from + (poses.size() - 1 - from) * static_cast<std::size_t>(i) /
                                      static_cast<std::size_t>(std::max(1, count - 1));
    table.pose.push_back(at);
  }
  table.penalty.resize(table.pose.size());
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < table.pose.size(); i = next++)
      table.penalty[i] = truth.at(poses[table.pose[i]], kDeepest);
  };
  std::vector<std::jthread> helpers;
  for (unsigned i = 1; i < std::thread::hardware_concurrency(); ++i) helpers.emplace_back(work);
  work();
  helpers.clear();
  for (const Penalty& p : table.penalty) table.peak = std::max(table.peak, p.integral.force.norm());
  return table;
}

Measures measure(const Subject& subject, const std::vector<hapticd::Pose>& poses, std::size_t from,
                 const TimingOptions& timing, const TruthTable& truth) {
  const std::vector<hapticd::Pose> asked(poses.begin() + static_cast<std::ptrdiff_t>(from), poses.end());
  auto contacts = std::make_unique<hapticd::ContactSet>();
  Measures measured;
  double touching = 0, work = 0;
  subject.detector->reset();
  const auto ms = timeQueries(asked, timing, [&](std::size_t i) {
    subject.detector->find(queryAt(subject, asked, i), *contacts);
    if (contacts->report.touching == 0) return;
    ++measured.hits;
    touching += contacts->report.touching;
    work += contacts->report.work;
  });
  const auto stride = static_cast<std::size_t>(timing.stride);
  measured.times = summarise(ms, ms.size() / ((asked.size() + stride - 1) / stride));
  if (measured.hits == 0) throw Failure(subject.name, "touched nothing in all poses", "");
  measured.touching = touching / static_cast<double>(measured.hits);
  measured.work = work / static_cast<double>(measured.hits);
  measured.rate = touching / (measured.times.mean * static_cast<double>(measured.times.count));
  for (std::size_t i = 0; i < truth.pose.size(); ++i) {
    const std::vector<hapticd::Pose> there{poses[truth.pose[i]]};
    subject.detector->find(queryAt(subject, there, 0), *contacts);
    const Penalty& p = truth.penalty[i];
    const WrenchError e = compare(contacts->integral, p.integral, truth.peak, kLever);
    measured.error_force = std::max(measured.error_force, e.force);
    measured.error_torque = std::max(measured.error_torque, e.torque);
    if (p.integral.force.norm() > 0.05 * truth.peak) measured.error_angle = std::max(measured.error_angle, e.direction);
  }
  return measured;
}

}  // namespace haptic_bench
