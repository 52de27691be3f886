#include "tools/hapticctl-cut/cut.h"

#include <fmt/core.h>

#include <algorithm>

#include "tools/hapticctl-cut/mesh_distance.h"
#include "tools/mesh_file/flat.h"

namespace hapticctl_cut {
namespace {

using hapticctl_import::Double3;
using hapticctl_import::ImportError;

constexpr double kMostPoints = 2e8;  ///< 13 bytes each.
constexpr double kSheet = 0.03;      ///< Voxels: thicker than what isosurface() makes of a cut along a face.
constexpr const char* kNothing = "nothing of it lies on the fragment's side";

Surface draw(const Lattice& lattice, const std::vector<float>& solid, const std::vector<float>& side) {
  hapticctl_import::LatticeSolid both;
  for (std::size_t k = 0; k < 3; ++k) both.size[k] = static_cast<std::uint32_t>(lattice.size(k));
  both.layers = {solid, side};
  both.place = [&lattice](const Double3& at) {
    return Double3{lattice.between(0, at[0]), lattice.between(1, at[1]), lattice.between(2, at[2])};
  };
  return hapticctl_import::isosurface(both);
}

/** Whether it is no thicker than vertices stand off from lattice points on its two sides. */
bool isSheet(const Surface& surface, double voxel) {
  double area = 0;
  for (const auto& t : surface.triangles) {
    Vec3 p[3];
    for (int c = 0; c < 3; ++c) {
      const auto& v = surface.vertices[t[static_cast<std::size_t>(c)]];
      p[c] = Eigen::Vector3f(v[0], v[1], v[2]).cast<double>();
    }
    area += 0.5 * (p[1] - p[0]).cross(p[2] - p[0]).norm();
  }
  return hapticctl_import::volumeOf(surface) <= kSheet * voxel * area / 2;
}

Box boxOf(const Surface& mesh) {
  Box box;
  for (const auto& v : mesh.vertices) {
    const Vec3 x(v[0], v[1], v[2]);
    box.lower = box.lower.cwiseMin(x);
    box.upper = box.upper.cwiseMax(x);
  }
  return box;
}

void checkOptions(const CutOptions& options, const Vec3& size) {
  if (options.voxel > size.maxCoeff() / 2) {
    throw ImportError(
        "--voxel",
        fmt::format("{:.4g} is too coarse for a mesh of {:.4g} x {:.4g} x {:.4g}", options.voxel, size.x(), size.y(),
                    size.z()),
        "lengths are in the unit of the file: if that is metres, give --voxel and --wavelength in metres");
  }
  if (options.shape.noise > size.maxCoeff())
    throw ImportError("--noise", fmt::format("{:.4g} is more than the mesh", options.shape.noise), "take less");
}

/** Fine where the cut is, coarser elsewhere. Throws ImportError when that would need too many points, or misses. */
Lattice latticeFor(const Box& whole, const CutSurface& surface, const CutOptions& options) {
  const Vec3 size = whole.upper - whole.lower;
  Box detail = surface.box();
  const Vec3 beside = Vec3::Constant(options.kerf + 3 * options.voxel);
  detail.lower -= beside;
  detail.upper += beside;
  if ((detail.lower.array() > whole.upper.array()).any() || (detail.upper.array() < whole.lower.array()).any())
    throw ImportError("", kNothing, "move the cut");  // A lattice would reach all the way there.
  const double points = (size.cwiseMin(detail.upper - detail.lower) / options.voxel).prod();
  if (points > kMostPoints) {
    throw ImportError("--voxel", fmt::format("the cut would need {:.2g} points", points), "take larger voxels");
  }
  const auto requireRoom = [](double count) {
    if (count <= kMostPoints) return;
    throw ImportError("--coarse", fmt::format("the whole would need {:.2g} points", count),
                      "take larger steps away from the cut");
  };
  if (options.shape.noise > 0 && options.shape.wavelength < 2 * options.voxel) {
    throw ImportError("--wavelength", fmt::format("{:.4g} is less than two voxels", options.shape.wavelength),
                      "take smaller voxels, or longer waves");
  }
  requireRoom((size / std::max(options.coarse, options.voxel)).maxCoeff());  // Of one axis alone.
  Lattice lattice = makeLattice(whole, detail, options.voxel, std::max(options.coarse, options.voxel));
  requireRoom(static_cast<double>(lattice.count()));
  return lattice;
}

/** How far each point is on one side of the cut and out of the kerf: sign 1 for the fragment's, -1 for the body's. */
std::vector<float> sideOf(const CutSurface& surface, const Lattice& lattice, double sign, double half_kerf) {
  std::vector<float> side(lattice.count());
  for (std::size_t z = 0; z < lattice.size(2); ++z) {
    for (std::size_t y = 0; y < lattice.size(1); ++y) {
      for (std::size_t x = 0; x < lattice.size(0); ++x) {
        const double to_cut = surface.at(lattice.at(x, y, z));
        // A point in the cut is the fragment's alone, else both would have it and overlap.
        side[lattice.index(x, y, z)] = static_cast<float>(sign * (to_cut == 0 ? 1e-30 : to_cut) - half_kerf);
      }
    }
  }
  return side;
}

}  // namespace

CutParts cut(const Surface& whole_mesh, const CutOptions& options) {
  // What has no area has no side to tell.
  const Surface mesh{whole_mesh.vertices,
                     hapticd_mesh_file::withoutFlatTriangles(whole_mesh.vertices, whole_mesh.triangles)};
  if (const auto open = whyOpen(mesh)) throw ImportError("", *open, "only what is closed has an inside to be cut");
  const Box whole = boxOf(mesh);
  checkOptions(options, whole.upper - whole.lower);
  const CutSurface surface(options.shape);
  const Lattice lattice = latticeFor(whole, surface, options);

  const std::vector<float> solid = insideness(mesh, lattice);
  CutParts parts;
  parts.points = lattice.count();
  parts.fragment = draw(lattice, solid, sideOf(surface, lattice, 1, 0.5 * options.kerf));
  parts.body = draw(lattice, solid, sideOf(surface, lattice, -1, 0.5 * options.kerf));
  const char* const remedy = options.kerf > 0 ? "move the cut, or take a narrower kerf" : "move the cut";
  if (isSheet(parts.fragment, options.voxel)) throw ImportError("", kNothing, remedy);
  if (isSheet(parts.body, options.voxel)) throw ImportError("", "all of it lies on the fragment's side", remedy);
  const double all = hapticctl_import::volumeOf(parts.fragment);
  parts.crumbs = hapticctl_import::keepLargest(parts.fragment) - 1;
  parts.crumbs_volume = all - hapticctl_import::volumeOf(parts.fragment);
  return parts;
}

}  // namespace hapticctl_cut
