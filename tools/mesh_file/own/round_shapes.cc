#include "tools/mesh_file/own/round_shapes.h"

#include <cmath>
#include <numbers>

namespace hapticd_mesh_file {
namespace {

constexpr unsigned kAround = 128;  // Flat faces lie 0.0003 of the radius below a round one.

/** A ring about y; of no radius one corner. Returns the number of its first. */
unsigned addRing(Polygons& out, double radius, double y) {
  const auto first = static_cast<unsigned>(out.vertices.size());
  for (unsigned i = 0; i < (radius > 0 ? kAround : 1); ++i) {
    const double a = 2 * std::numbers::pi * i / kAround;
    out.vertices.push_back(
        {static_cast<float>(radius * std::sin(a)), static_cast<float>(y), static_cast<float>(radius * std::cos(a))});
  }
  return first;
}

/** Faces between two rings, the upper after the lower; `tip`: which of them is one corner. */
void addBand(Polygons& out, unsigned lower, bool lower_tip, unsigned upper, bool upper_tip) {
  for (unsigned i = 0; i < kAround; ++i) {
    const unsigned next = (i + 1) % kAround;
    if (lower_tip) {
      out.add({lower, upper + next, upper + i});
    } else if (upper_tip) {
      out.add({lower + i, lower + next, upper});
    } else {
      out.add({lower + i, lower + next, upper + next, upper + i});
    }
  }
}

/** One face of a ring's corners. */
void addLid(Polygons& out, unsigned ring, bool up) {
  for (unsigned i = 0; i < kAround; ++i) out.corners.push_back(ring + (up ? i : kAround - 1 - i));
  out.sizes.push_back(kAround);
}

}  // namespace

Polygons boxFaces(const std::array<double, 3>& size) {
  Polygons out;
  for (unsigned i = 0; i < 8; ++i) {
    std::array<float, 3> corner{};
    for (unsigned k = 0; k < 3; ++k) corner[k] = static_cast<float>((i >> k & 1u) != 0 ? size[k] / 2 : -size[k] / 2);
    out.vertices.push_back(corner);
  }
  out.add({0, 4, 6, 2});
  out.add({1, 3, 7, 5});
  out.add({0, 1, 5, 4});
  out.add({2, 6, 7, 3});
  out.add({0, 2, 3, 1});
  out.add({4, 5, 7, 6});
  return out;
}

Polygons ballFaces(double radius) {
  constexpr unsigned kBands = kAround / 2;
  Polygons out;
  unsigned lower = addRing(out, 0, -radius);
  for (unsigned i = 1; i <= kBands; ++i) {
    const double a = std::numbers::pi * i / kBands;
    const bool tip = i == kBands;
    const unsigned upper = addRing(out, tip ? 0 : radius * std::sin(a), -radius * std::cos(a));
    addBand(out, lower, i == 1, upper, tip);
    lower = upper;
  }
  return out;
}

Polygons frustumFaces(const Frustum& shape) {
  Polygons out;
  const bool bottom_tip = !(shape.bottom_radius > 0), top_tip = !(shape.top_radius > 0);
  const unsigned lower = addRing(out, shape.bottom_radius, -shape.height / 2);
  const unsigned upper = addRing(out, shape.top_radius, shape.height / 2);
  if (shape.side && !(bottom_tip && top_tip)) addBand(out, lower, bottom_tip, upper, top_tip);
  if (shape.bottom && !bottom_tip) addLid(out, lower, false);
  if (shape.top && !top_tip) addLid(out, upper, true);
  return out;
}

}  // namespace hapticd_mesh_file
