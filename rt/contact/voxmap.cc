#include "rt/contact/voxmap.h"

#include <cmath>

#include "rt/volume/distance.h"
#include "rt/volume/octahedral.h"

namespace hapticd {
namespace {

constexpr double kHalfVoxel = 0.8660254037844386;  // sqrt(3) / 2

}  // namespace

VoxmapDetector::VoxmapDetector() : groups_(kMaxTouchGroups) {}

void VoxmapDetector::find(const DetectorQuery& query, ContactSet& contacts) HD_RT {
  contacts.report = DetectorReport{};
  DetectorReport& report = contacts.report;
  const VolumeView& a = *query.a.volume;
  const VolumeView& b = *query.b.volume;
  map_.build(a);
  const Pose X_BA = query.b.X_WO.inverse() * query.a.X_WO;
  const double deepest = kHalfVoxel * b.voxel;
  const bool timed = query.budget.clock != nullptr && query.budget.deadline_ns != 0;
  bool late = timed && query.budget.clock->now() >= query.budget.deadline_ns;
  std::uint64_t tests = 0;
  std::uint32_t count = 0;
  const auto hasRoom = [&](std::uint64_t more)
                           HD_RT { return query.budget.units == 0 || (tests + more + 15) / 16 <= query.budget.units; };
  const auto drop = [&](const hd_volume_patch& patch) HD_RT {
    report.exhausted = true;
    ++report.dropped;
    report.dropped_area += patch.area;
  };
  for (std::uint32_t g = 0; g < map_.count(); ++g) {
    TouchGroup group;
    group.part = g;
    for (std::uint32_t i = map_.first(g); i < map_.first(g + 1); ++i) {
      const hd_volume_patch& patch = a.patches[i];
      if (patch.count == 0) continue;
      late = late || (timed && i % 16 == 0 && query.budget.clock->now() >= query.budget.deadline_ns);
      if (late || !hasRoom(1)) {
        drop(patch);
        continue;
      }
      ++tests;
      // The patches stand for the hierarchy that later versions have: what is far away is not walked.
      const DistanceSample far = distanceAt(b, X_BA * Vec3(patch.center[0], patch.center[1], patch.center[2]));
      if (far.value - far.error - patch.radius > 2 * b.voxel) continue;
      if (!hasRoom(patch.count)) {
        drop(patch);
        continue;
      }
      tests += patch.count;
      for (std::uint32_t p = patch.first; p < patch.first + patch.count; ++p) {
        const Vec3 x = X_BA * a.pointAt(p);
        const Vec3 u = (x - b.originPoint()) / b.voxel;
        const Vec3 voxel = u.array().floor();
        const VoxelState state = voxelState(b.octree, static_cast<std::int32_t>(voxel.x()),
                                            static_cast<std::int32_t>(voxel.y()), static_cast<std::int32_t>(voxel.z()));
        if (state != VoxelState::kSurface && state != VoxelState::kFull) continue;
        const Vec3 in = -(X_BA.q * octahedralNormal(a.normal[p]));
        const Vec3 centre = b.originPoint() + b.voxel * (voxel + Vec3::Constant(0.5));
        const double depth = state == VoxelState::kFull ? deepest : (centre - x).dot(in);
        if (depth <= 0) continue;
        ++report.touching;
        const double area = a.area_step * a.area[p];
        group.deepest = std::max(group.deepest, depth);
        group.area += area;
        group.weight += area * depth;
        group.mean += area * depth * x;
        group.normal += area * depth * in;
        group.integral.torque += area * depth * x.cross(in);
      }
    }
    if (group.weight <= 0) continue;
    group.integral.force = group.normal;
    group.mean /= group.weight;
    group.face = faceOf(X_BA.q.conjugate() * group.normal);
    groups_[count++] = group;
  }
  report.work = static_cast<std::uint32_t>((tests + 15) / 16);
  answer(query, map_, groups_, count, Clustering::kOctree, contacts);
  ages_.follow(contacts);
}

}  // namespace hapticd
