/** @file
 * Points on a triangle mesh: fine samples that hold its whole area, and one point for each cell of a grid.
 */
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "daemon/builder/mesh/mesh.h"
#include "rt/base/math.h"

namespace hapticd {

/** Steps of sampleSurface() in a voxel's edge: so few voxels that the surface clips go unseen. */
inline constexpr double kSamplesPerVoxel = 3;

/** A piece of the surface by its centroid. */
struct SurfaceSample {
  Vec3 x;
  Vec3 normal;  ///< Unit, of the triangle.
  double area;  ///< [m^2]
};

/**
 * Cuts each triangle into pieces no longer and no wider than two `step`s [m], however thin it is: rows parallel to its
 * longest edge, each cut across, or of thin ones rows across. Areas and centroids are exact, so the areas sum to the
 * mesh's. Triangles without area give nothing.
 */
void sampleSurface(std::span<const Float3> vertices, std::span<const Index3> triangles, double step,
                   const std::function<void(const SurfaceSample&)>& visit);

/** No triangle with these corners gives more samples; near it for plain ones and needles. 0 without area. */
[[nodiscard]] double mostSamples(const Vec3& a, const Vec3& b, const Vec3& c, double step);

/**
 * One point for each grid cell and side of the surface in it: of the samples whose normals are within 60 degrees the
 * one nearest to their centroid, with their area and mean normal. So both sides of a thin wall stay, and the faces at a
 * sharp edge. The areas sum to those of the samples.
 */
[[nodiscard]] std::vector<SurfaceSample> thinOut(std::vector<SurfaceSample> samples, const Vec3& grid_origin,
                                                 double grid_side);

/**
 * Reorders points so that each first part of them is spread evenly: from the one nearest to the centroid on, always the
 * point farthest from those before it. Gives the greatest distance of any point from the first quarter [m]. Some
 * nanoseconds for each pair of points: `goesOn` is asked every millisecond or so; nothing once it has said no.
 */
[[nodiscard]] std::optional<double> orderByCoverage(std::span<SurfaceSample> points,
                                                    const std::function<bool()>& goesOn);

}  // namespace hapticd
