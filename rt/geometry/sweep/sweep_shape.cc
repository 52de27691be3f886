#include "rt/geometry/sweep/sweep.h"

namespace hapticd {
namespace {

bool sweepPrimitive(const Shape& shape, const Sweep& sweep, SweepHit& hit) HD_RT {
  const double grown = shape.size.x() + sweep.radius;
  switch (shape.kind) {
    case ShapeKind::kPlane: {
      Sweep lowered = sweep;
      lowered.a.z() -= sweep.radius;
      if (!sweepPlane(lowered, hit)) return false;
      hit.offset = sweep.radius;
      return true;
    }
    case ShapeKind::kSphere:
      return sweepSphere(grown, sweep, hit);
    case ShapeKind::kBox:
      return sweep.radius > 0 ? sweepRoundBox(shape.size, sweep, hit) : sweepBox(shape.size, sweep, hit);
    case ShapeKind::kCapsule:
      return sweepCapsule(grown, shape.size.y(), sweep, hit);
    case ShapeKind::kCylinder:
      return sweep.radius > 0 ? sweepRoundCylinder(shape.size.x(), shape.size.y(), sweep, hit)
                              : sweepCylinder(shape.size.x(), shape.size.y(), sweep, hit);
    case ShapeKind::kGroup:
    case ShapeKind::kMesh:
      break;
  }
  return false;
}

}  // namespace

SweepResult sweepShape(const Shape& shape, Sweep& sweep, SweepHit& hit) HD_RT {
  SweepResult result = SweepResult::kNone;
  if (shape.kind == ShapeKind::kMesh) {
    if (shape.mesh) result = sweepMesh(*shape.mesh, sweep, hit);
  } else {
    if (++sweep.work > sweep.limit) return SweepResult::kExhausted;
    if (sweepPrimitive(shape, sweep, hit)) result = SweepResult::kHit;
  }
  if (result == SweepResult::kHit) hit.point = sweep.a + hit.t * sweep.d - sweep.radius * hit.normal;
  return result;
}

}  // namespace hapticd
