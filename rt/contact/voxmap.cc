#include "rt/contact/voxmap.h"

#include <algorithm>

#include "rt/volume/distance.h"
#include "rt/volume/octahedral.h"

namespace hapticd {
namespace {

constexpr double kHalfVoxel = 0.8660254037844386;  // sqrt(3) / 2

/** One search: A's points against B's voxels. */
struct Search {
  explicit Search(const DetectorQuery& query, DetectorReport& to) HD_RT : a(*query.a.volume),
                                                                          b(*query.b.volume),
                                                                          X_BA(query.b.X_WO.inverse() * query.a.X_WO),
                                                                          budget(query.budget),
                                                                          report(to),
                                                                          late(deadlinePassed()) {}

  void walk(std::uint32_t patch, TouchGroup& group) HD_RT;
  void meet(std::uint32_t point, TouchGroup& group) HD_RT;
  /** Of work: sixteen points each. */
  [[nodiscard]] std::uint64_t units(std::uint64_t more = 0) const HD_RT { return (tests + more + 15) / 16; }
  [[nodiscard]] bool hasRoom(std::uint64_t more) const HD_RT {
    return budget.units == 0 || units(more) <= budget.units;
  }
  [[nodiscard]] bool deadlinePassed() const HD_RT {
    return budget.clock != nullptr && budget.deadline_ns != 0 && budget.clock->now() >= budget.deadline_ns;
  }
  void drop(const hd_volume_patch& patch) HD_RT {
    report.exhausted = true;
    ++report.dropped;
    report.dropped_area += patch.area;
  }

  const VolumeView& a;
  const VolumeView& b;
  const Pose X_BA;
  const WorkBudget& budget;
  DetectorReport& report;
  bool late;
  std::uint64_t tests = 0;
};

void Search::walk(std::uint32_t i, TouchGroup& group) HD_RT {
  const hd_volume_patch& patch = a.patches[i];
  if (patch.count == 0) return;
  late = late || (i % 16 == 0 && deadlinePassed());
  if (late || !hasRoom(1)) return drop(patch);
  ++tests;
  // The patches stand for the hierarchy that later versions have: what is far away is not walked.
  const DistanceSample far = distanceAt(b, X_BA * Vec3(patch.center[0], patch.center[1], patch.center[2]));
  if (far.value - far.error - patch.radius > 2 * b.voxel) return;
  if (!hasRoom(patch.count)) return drop(patch);
  tests += patch.count;
  for (std::uint32_t p = patch.first; p < patch.first + patch.count; ++p) meet(p, group);
}

void Search::meet(std::uint32_t p, TouchGroup& group) HD_RT {
  const Vec3 x = X_BA * a.pointAt(p);
  const Vec3 voxel = ((x - b.originPoint()) / b.voxel).array().floor();
  const VoxelState state = voxelState(b.octree, static_cast<std::int32_t>(voxel.x()),
                                      static_cast<std::int32_t>(voxel.y()), static_cast<std::int32_t>(voxel.z()));
  if (state != VoxelState::kSurface && state != VoxelState::kFull) return;
  const Vec3 in = -(X_BA.q * octahedralNormal(a.normal[p]));
  const Vec3 centre = b.originPoint() + b.voxel * (voxel + Vec3::Constant(0.5));
  const double depth = state == VoxelState::kFull ? kHalfVoxel * b.voxel : (centre - x).dot(in);
  if (depth <= 0) return;
  ++report.touching;
  const double area = a.area_step * a.area[p];
  group.deepest = std::max(group.deepest, depth);
  group.area += area;
  group.weight += area * depth;
  group.mean += area * depth * x;
  group.normal += area * depth * in;
  group.integral.torque += area * depth * x.cross(in);
}

}  // namespace

VoxmapDetector::VoxmapDetector() : groups_(kMaxTouchGroups) {}

void VoxmapDetector::find(const DetectorQuery& query, ContactSet& contacts) HD_RT {
  contacts.report = DetectorReport{};
  map_.build(*query.a.volume);
  Search search(query, contacts.report);
  std::uint32_t count = 0;
  for (std::uint32_t g = 0; g < map_.count(); ++g) {
    TouchGroup group;
    group.part = g;
    for (std::uint32_t i = map_.first(g); i < map_.first(g + 1); ++i) search.walk(i, group);
    if (group.weight <= 0) continue;
    group.integral.force = group.normal;
    group.mean /= group.weight;
    group.face = faceOf(search.X_BA.q.conjugate() * group.normal);
    groups_[count++] = group;
  }
  contacts.report.work = static_cast<std::uint32_t>(search.units());
  answer(query, map_, groups_, count, contacts);
  ages_.follow(contacts);
}

}  // namespace hapticd
