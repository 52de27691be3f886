/** @file
 * What a benchmark touches: triangles, and what is known of the surface they stand for.
 */
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "rt/base/math.h"

namespace haptic_bench {

using hapticd::Vec3;

/** Triangles, counter-clockwise seen from outside [m]. */
struct Model {
  std::string name;
  std::string kind;  ///< sphere, plane, ridge, bowl, file or recorded; moved, if it stands elsewhere.
  std::vector<std::array<float, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  double radius = 0;  ///< Of the sphere or bowl that the triangles stand for [m].
  double height = 0;  ///< Of the ridge [m].
  double angle = 0;   ///< Of the ridge's flanks against the plane [rad].
  double half = 0;    ///< Half the extent in x and y of plane, ridge and bowl [m].

  [[nodiscard]] Vec3 vertex(std::uint32_t v) const { return {vertices[v][0], vertices[v][1], vertices[v][2]}; }
  [[nodiscard]] Vec3 corner(std::uint32_t t, int c) const { return vertex(triangles[t][static_cast<std::size_t>(c)]); }
  /** Rounds to float and answers the number of the new vertex. */
  std::uint32_t addVertex(const Vec3& x);
  void addQuad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d);
};

/**
 * The model named on the command line: a shape of shapes.h, a mesh file, or a recording. Throws Failure that lists what
 * there is.
 */
[[nodiscard]] Model makeModel(const std::string& spec);

/** One line for each shape and its settings, for --help. */
[[nodiscard]] std::string modelHelp();

/** As a client fills an upload (proto/snapshot.h). */
[[nodiscard]] std::vector<std::byte> upload(const Model& model);

}  // namespace haptic_bench
