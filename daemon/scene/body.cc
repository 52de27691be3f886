#include "daemon/scene/body.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "daemon/scene/invalid.h"
#include "rt/volume/volume_view.h"

namespace hapticd {
namespace {

constexpr double kThinnest = 1e-3;      ///< Of what an object's inertia is that of, along each axis [m].
constexpr double kFewestOfAPatch = 24;  ///< Points, in the mean: VolumeOptions::patch_points within a factor of two.

}  // namespace

Result<void> checkMovable(const ObjectSpec& spec, const MeshStore& meshes, const std::string& where) {
  const ShapeSpec& shape = spec.shape;
  if (!spec.parent.empty()) {
    return invalid(where, fmt::format("'{}' is part of '{}'", spec.name, spec.parent),
                   "take an object directly below the root");
  }
  if (shape.kind == ShapeKind::kGroup || shape.kind == ShapeKind::kPlane) {
    return invalid(where, fmt::format("'{}' is a {}", spec.name, shapeName(shape.kind)),
                   "take one whose surface has an end");
  }
  const MeshInfo* mesh = shape.kind == ShapeKind::kMesh ? meshes.find(shape.mesh) : nullptr;
  if (shape.kind == ShapeKind::kMesh && (mesh == nullptr || mesh->deformable)) {
    return invalid(where, fmt::format("the mesh of '{}' is deformable", spec.name), "take a rigid one");
  }
  return {};
}

Result<void> checkBody(const BodySpec& body, const std::string& where) {
  const bool weighs = body.mass >= kLightestBody && body.mass <= kHeaviestBody;
  if (body.mass != 0 && !weighs) {
    return invalid(where + ".mass",
                   fmt::format("{} is not between {} and {} kg", body.mass, kLightestBody, kHeaviestBody),
                   "0 holds the object where it is put");
  }
  if (body.damping >= 0 && body.damping <= kMostBodyDamping) return {};
  return invalid(where + ".damping", fmt::format("{} is not between 0 and {} 1/s", body.damping, kMostBodyDamping),
                 "1 takes away half of a motion in 0.7 s");
}

const VolumeView* volumeOf(const ShapeSpec& shape, const MeshStore& meshes) {
  return shape.kind == ShapeKind::kMesh ? meshes.volumes().get(meshes.entryOf(shape.mesh)) : nullptr;
}

std::string withoutField(const std::string& name, const ShapeSpec& shape, const MeshStore& meshes,
                         std::uint32_t most_patches) {
  if (shape.kind != ShapeKind::kMesh) return {};
  const VolumeView* volume = volumeOf(shape, meshes);
  if (volume == nullptr) {
    return fmt::format("'{}' has no volume: its vertices alone touch; load it with one (--voxel)", name);
  }
  if (volume->patches.size() <= most_patches) return {};
  // The number of points goes with 1 / voxel^2; a tenth is added for what does not scale so.
  const double points = volume->point_count / kFewestOfAPatch / most_patches;
  const double voxel_mm = 1.1e3 * double{volume->voxel} * std::sqrt(std::max(1.0, points));
  return fmt::format(
      "'{}' is too large for its field: {} patches of points are more than {}, and its vertices alone touch; load it "
      "with voxels of {:.2f} mm (--voxel)",
      name, volume->patches.size(), most_patches, std::ceil(voxel_mm * 100) / 100);
}

MassProperties massOf(const ShapeSpec& shape, const MeshStore& meshes, double mass) {
  if (const VolumeView* volume = volumeOf(shape, meshes); volume != nullptr && volume->mass.volume > 0) {
    const hd_volume_mass& solid = volume->mass;
    const double density = mass / solid.volume;
    const double(&i)[6] = solid.inertia;  // xx yy zz xy yz zx
    MassProperties out;
    out.mass = mass;
    out.com_O = vec3(solid.centroid);
    out.inertia_O << i[0], i[3], i[5], i[3], i[1], i[4], i[5], i[4], i[2];
    out.inertia_O *= density;
    if (out.valid()) return out;
  }
  Vec3 half = shape.size;
  Vec3 center = Vec3::Zero();
  switch (shape.kind) {
    case ShapeKind::kSphere:
      return MassProperties::ofBall(mass, std::max(kThinnest, shape.size.x()));
    case ShapeKind::kCapsule:
      return MassProperties::ofCapsule(mass, std::max(kThinnest / 2, shape.size.x()), shape.size.y());
    case ShapeKind::kCylinder:
      return MassProperties::ofCylinder(mass, std::max(kThinnest / 2, shape.size.x()),
                                        std::max(kThinnest / 2, shape.size.y()));
    case ShapeKind::kMesh:
      if (const MeshInfo* mesh = meshes.find(shape.mesh)) {
        half = 0.5 * (mesh->upper - mesh->lower);
        center = 0.5 * (mesh->upper + mesh->lower);
      }
      break;
    default:
      break;
  }
  MassProperties out = MassProperties::ofBox(mass, (2 * half).cwiseMax(kThinnest));
  out.com_O = center;
  return out;
}

void storeInertia(const Mat3& I, double (&out)[6]) {
  const double six[] = {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)};
  std::copy(std::begin(six), std::end(six), out);
}

}  // namespace hapticd
