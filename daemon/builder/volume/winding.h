/** @file
 * How many times a surface winds about a point: 1 inside a closed outward one, 0 outside, in between near its holes.
 */
#pragma once

#include <cstdint>
#include <vector>

#include "rt/scene/mesh_view.h"

namespace hapticd {

/**
 * The share of the directions from x that meet the triangle, positive if they meet it from behind (x inside), at most
 * 1/2: van Oosterom and Strackee, "The solid angle of a plane triangle", IEEE Trans. Biomed. Eng. 30(2), 1983, over
 * 4 pi. In the triangle's plane 0.
 */
[[nodiscard]] double windingOfTriangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& x);

/**
 * The sum over a mesh by its tree: what is near triangle by triangle, what is farther than twice its radius by its
 * moments to the second order (Barill, Dickson, Schmidt, Levin, Jacobson, "Fast winding numbers for soups and clouds",
 * SIGGRAPH 2018, eq. 14 to 17). Off by about 1e-3. The mesh may be any soup of triangles, each wound outward; it must
 * outlive this. Some 4 us a value.
 */
class WindingTree {
 public:
  explicit WindingTree(const MeshView& mesh);
  [[nodiscard]] double at(const Vec3& x) const;
  /** Whether x is inside, where the surface alone decides: more than half. */
  [[nodiscard]] bool isInside(const Vec3& x) const { return at(x) > 0.5; }

 private:
  /** Of the triangles under one place of the tree, about their centre. A is the area's vector. */
  struct Moments {
    Vec3 center = Vec3::Zero();
    double far2 = 0;             ///< Beyond this from the centre they are taken together [m^2].
    Vec3 area = Vec3::Zero();    ///< Sum of A.
    Mat3 first = Mat3::Zero();   ///< Sum of A d^T, d from the centre; made symmetric.
    Vec3 second = Vec3::Zero();  ///< What of A d d^T is contracted with one direction.
    double cubic[10] = {};       ///< A d d^T made symmetric: xxx, yyy, zzz, xxy, xxz, xyy, yyz, xzz, yzz, xyz.
  };

  void gather(const std::vector<std::uint32_t>& parents);
  void add(Moments& m, std::uint32_t triangle) const;
  [[nodiscard]] static double farField(const Moments& m, const Vec3& r, double r2);

  const MeshView& mesh_;
  std::vector<Moments> moments_;  ///< Of place HD_BVH_WIDTH * node + child.
};

}  // namespace hapticd
