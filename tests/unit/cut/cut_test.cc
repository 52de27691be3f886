/** @file
 * hapticctl cut: two closed parts that fit together, drawn where distance and cut say.
 */
#include "tools/hapticctl-cut/cut.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <set>

#include "tools/hapticctl-cut/mesh_distance.h"

namespace hapticctl_cut {
namespace {

using hapticctl_import::Image;
using hapticctl_import::ImportError;
using hapticctl_import::isosurface;
using hapticctl_import::volumeOf;
using ::testing::HasSubstr;

constexpr double kPi = std::numbers::pi;

/** A ball of 20 mm, 3 mm thick if hollow, of triangles a millimetre wide. */
Surface ball(bool hollow = false) {
  Image image;
  image.size = {45, 45, 45};
  image.origin = {-22, -22, -22};
  for (int z = -22; z <= 22; ++z) {
    for (int y = -22; y <= 22; ++y) {
      for (int x = -22; x <= 22; ++x) {
        const double r = std::sqrt(x * x + y * y + z * z);
        image.values.push_back(static_cast<float>(hollow ? std::min(20 - r, r - 17) : 20 - r));
      }
    }
  }
  return isosurface(image, 0);
}

Surface box(const Vec3& half) {
  Surface out;
  for (int i = 0; i < 8; ++i) {
    out.vertices.push_back({static_cast<float>((i & 1) != 0 ? half.x() : -half.x()),
                            static_cast<float>((i & 2) != 0 ? half.y() : -half.y()),
                            static_cast<float>((i & 4) != 0 ? half.z() : -half.z())});
  }
  out.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return out;
}

void expectClosed(const Surface& surface) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& t : surface.triangles) {
    for (std::size_t e = 0; e < 3; ++e) {
      const bool once = edges.emplace(t[e], t[(e + 1) % 3]).second;
      ASSERT_TRUE(once) << "an edge is used twice in one direction";
    }
  }
  for (const auto& [a, b] : edges) ASSERT_EQ(edges.count({b, a}), 1u);
}

Vec3 place(const Surface& surface, std::uint32_t vertex) {
  const auto& v = surface.vertices[vertex];
  return {v[0], v[1], v[2]};
}

double areaOf(const Surface& surface) {
  double sum = 0;
  for (const auto& t : surface.triangles) {
    const Vec3 a = place(surface, t[0]);
    sum += 0.5 * (place(surface, t[1]) - a).cross(place(surface, t[2]) - a).norm();
  }
  return sum;
}

CutOptions roughPlane() {
  CutOptions o;
  o.shape.at = {1, 2, 3};
  o.shape.pull = {0.2, -0.3, 1};
  o.shape.noise = 0.7;
  o.shape.wavelength = 8;
  o.voxel = 0.5;
  return o;
}

/** A plug of 12 mm in the upper half of the hollow ball; the ball's middle lies above its crust. */
CutOptions roughShell() {
  CutOptions o;
  o.shape.shell = true;
  o.shape.at = {0, 0, 24};
  o.shape.radius = 14;
  o.shape.noise = 0.4;
  o.shape.wavelength = 6;
  o.voxel = 0.5;
  o.coarse = 1;
  return o;
}

TEST(Cut, partsAreClosedAndAddUp) {
  const struct {
    Surface whole;
    CutOptions options;
  } cases[] = {{ball(), roughPlane()}, {ball(true), roughShell()}};
  for (const auto& [whole, options] : cases) {
    const CutParts parts = cut(whole, options);
    expectClosed(parts.body);
    expectClosed(parts.fragment);
    EXPECT_EQ(parts.crumbs, 0u);
    const double sum = volumeOf(parts.body) + volumeOf(parts.fragment);
    EXPECT_NEAR(sum, volumeOf(whole), 0.01 * options.voxel * areaOf(whole)) << "a hundredth of a layer of voxels";
    EXPECT_GT(volumeOf(parts.fragment), 0.02 * volumeOf(whole));
  }
}

TEST(Cut, noPartReachesBeyondTheWholeOrTheCut) {
  const CutOptions o = roughPlane();
  const CutParts parts = cut(ball(), o);
  const CutSurface surface(o.shape);
  const auto check = [&](const Surface& part, double side) {
    for (std::uint32_t i = 0; i < part.vertices.size(); ++i) {
      const Vec3 x = place(part, i);
      ASSERT_LT(x.norm(), 20.02);
      ASSERT_GT(side * surface.at(x), -0.06) << "more than the cut bends within a cell";
    }
  };
  check(parts.fragment, 1);
  check(parts.body, -1);
}

/** A triangle by the places of its corners, the least first. */
using Corners = std::array<std::array<float, 3>, 3>;
Corners cornersOf(const Surface& surface, const std::array<std::uint32_t, 3>& t, bool turned) {
  Corners c{surface.vertices[t[0]], surface.vertices[t[turned ? 2 : 1]], surface.vertices[t[turned ? 1 : 2]]};
  std::rotate(c.begin(), std::min_element(c.begin(), c.end()), c.end());
  return c;
}

/** Area of the triangles that both parts have, looking opposite ways. */
double sharedArea(const CutParts& parts) {
  std::set<Corners> of_body;
  for (const auto& t : parts.body.triangles) of_body.insert(cornersOf(parts.body, t, true));
  Surface shared{parts.fragment.vertices, {}};
  for (const auto& t : parts.fragment.triangles)
    if (of_body.count(cornersOf(parts.fragment, t, false)) != 0) shared.triangles.push_back(t);
  return areaOf(shared);
}

TEST(Cut, withoutAKerfTheFacesAreTheSameToTheBit) {
  CutOptions flat = roughPlane();
  flat.shape.noise = 0;
  const double from_middle = flat.shape.pull.normalized().dot(flat.shape.at);
  const double disc = kPi * (400 - from_middle * from_middle);
  const CutParts parts = cut(ball(), flat);
  const double shared = sharedArea(parts);
  EXPECT_LT(shared, disc);
  EXPECT_GT(shared, disc - 2 * kPi * 20 * 2 * flat.voxel) << "all but the cells at the rim";
  EXPECT_GT(sharedArea(cut(ball(), roughPlane())), 1.02 * shared) << "a rough face is larger";
}

// Of a plane through lattice points both parts had these, and overlapped by a fiftieth of a voxel.
TEST(Cut, aPlaneThroughLatticePointsIsOneFaceToo) {
  CutOptions o;
  o.shape.at = {0, 0, 5};
  o.voxel = 1;
  const CutParts parts = cut(box({10, 15, 25}), o);
  EXPECT_GT(sharedArea(parts), 18 * 28) << "all but the cells at the rim";
  EXPECT_NEAR(volumeOf(parts.fragment) / volumeOf(parts.body), 20.0 / 30, 1e-3);
  EXPECT_NEAR(volumeOf(parts.fragment) + volumeOf(parts.body), 30000, 0.01 * areaOf(box({10, 15, 25})));
}

// The other part was a sheet of a fiftieth of a voxel.
TEST(Cut, aPlaneInAFaceCutsNothingOff) {
  for (const double z : {-25.0, 25.0}) {
    CutOptions o;
    o.shape.at = {0, 0, z};
    o.voxel = 1;
    try {
      (void)cut(box({10, 15, 25}), o);
      ADD_FAILURE() << z;
    } catch (const ImportError& error) {
      EXPECT_THAT(error.what(), HasSubstr(z > 0 ? "nothing of it lies" : "all of it lies"));
      EXPECT_EQ(error.remedy, "move the cut");
    }
    o.kerf = 49;
    o.shape.at = {0, 0, 0};
    EXPECT_NEAR(volumeOf(cut(box({10, 15, 25}), o).fragment), 300, 20) << "half a voxel thick";
    o.kerf = 51;
    try {
      (void)cut(box({10, 15, 25}), o);
      ADD_FAILURE() << z;
    } catch (const ImportError& error) {
      EXPECT_THAT(error.remedy, HasSubstr("a narrower kerf"));
    }
  }
}

TEST(Cut, aKerfIsAsWideAsAsked) {
  CutOptions o = roughPlane();
  o.kerf = 0.8;
  const CutParts parts = cut(ball(), o);
  const CutSurface surface(o.shape);
  // Of the faces, well within the ball; the gap measured from vertex to vertex, nearest first.
  std::vector<Vec3> upper, lower;
  for (std::uint32_t i = 0; i < parts.fragment.vertices.size(); ++i)
    if (place(parts.fragment, i).norm() < 15) upper.push_back(place(parts.fragment, i));
  for (std::uint32_t i = 0; i < parts.body.vertices.size(); ++i)
    if (place(parts.body, i).norm() < 15) lower.push_back(place(parts.body, i));
  ASSERT_GT(upper.size(), 500u);
  double sum = 0;
  for (std::size_t i = 0; i < upper.size(); i += 7) {
    double nearest = 1e9;
    for (const Vec3& x : lower) nearest = std::min(nearest, (x - upper[i]).norm());
    EXPECT_GT(nearest, 0.85 * o.kerf);
    EXPECT_LT(nearest, o.kerf + o.voxel);
    sum += surface.at(upper[i]);
  }
  const double count = std::ceil(static_cast<double>(upper.size()) / 7);
  EXPECT_NEAR(sum / count, o.kerf / 2, 0.02 * o.kerf) << "half of it on each side";
}

TEST(Cut, theFragmentComesOutWithoutCatching) {
  const CutOptions o = roughShell();
  const CutParts parts = cut(ball(true), o);
  const CutSurface surface(o.shape);
  const double crease = o.voxel;
  int on_the_cut = 0;
  for (std::uint32_t i = 0; i < parts.fragment.vertices.size(); ++i) {
    const Vec3 x = place(parts.fragment, i);
    if (std::abs(surface.at(x)) > 0.05 * crease) continue;
    ++on_the_cut;
    for (double way = 0; way < 5; way += 0.25) {
      if ((x + way * o.shape.pull).z() > o.shape.at.z()) break;  // beyond the equator nothing of the crust is left
      EXPECT_GT(surface.at(x + way * o.shape.pull), -0.1 * crease);
    }
  }
  EXPECT_GT(on_the_cut, 1000);
}

TEST(CutSurface, isAsRoughAsAskedWithinItsBand) {
  CutShape shape;
  shape.noise = 0.5;
  shape.wavelength = 10;
  const CutSurface surface(shape);
  CutShape other = shape;
  other.seed = 2;
  double squares = 0, slopes = 0, differs = 0;
  int samples = 0;
  const auto height = [](const CutSurface& s, double x, double y) {
    // Where the value is 0: by bisection, from below to above.
    double low = -20, high = 20;
    while (high - low > 1e-9) {
      const double middle = 0.5 * (low + high);
      (s.at({x, y, middle}) > 0 ? high : low) = middle;
    }
    return low;
  };
  for (int i = 0; i < 60; ++i) {
    for (int j = 0; j < 60; ++j) {
      const double x = 3.1 * i, y = 2.7 * j, h = height(surface, x, y);
      squares += h * h;
      const double e = 1e-3;
      slopes += (std::pow(height(surface, x + e, y) - h, 2) + std::pow(height(surface, x, y + e) - h, 2)) / (e * e);
      differs = std::max(differs, std::abs(h - height(CutSurface(other), x, y)));
      EXPECT_LE(std::abs(h), surface.reach());
      ++samples;
    }
  }
  const double rms = std::sqrt(squares / samples), slope = std::sqrt(slopes / samples);
  EXPECT_NEAR(rms, shape.noise, 0.1 * shape.noise);
  EXPECT_GT(slope / rms, 2 * kPi / (2 * shape.wavelength));
  EXPECT_LT(slope / rms, 2 * kPi / shape.wavelength);
  EXPECT_GT(differs, shape.noise);
}

TEST(Lattice, holdsTheWholeAndIsFineWhereAsked) {
  for (const auto& [lower, upper] : {std::pair<double, double>(-INFINITY, INFINITY), {-5, 4}, {25, 30}}) {
    const Box whole{Vec3(-20, -10, -4), Vec3(20, 10, 6)};
    const Lattice lattice = makeLattice(whole, {Vec3::Constant(lower), Vec3::Constant(upper)}, 0.5, 2);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& planes = lattice.plane[k];
      const double most = whole.upper[static_cast<Eigen::Index>(k)];
      const double least = whole.lower[static_cast<Eigen::Index>(k)];
      EXPECT_LT(planes[2], least) << "three planes beyond";
      EXPECT_GT(planes[planes.size() - 3], most);
      for (std::size_t i = 1; i < planes.size(); ++i) {
        const double step = planes[i] - planes[i - 1];
        EXPECT_GT(step, 0);
        EXPECT_LE(step, 2 + 1e-9);
        if (i > 1) {
          EXPECT_LT(step, 1.21 * (planes[i - 1] - planes[i - 2]) + 1e-9);
        }
        if (planes[i] > lower && planes[i] < upper && planes[i - 1] > least && planes[i] < most) {
          EXPECT_LE(step, 0.5 + 1e-9);
        }
      }
    }
  }
}

TEST(MeshDistance, isThatOfABoxInClosedForm) {
  const Vec3 half(5, 7, 3);  // whose triangles are far larger than a cell
  const Lattice lattice = makeLattice({-half, half}, {Vec3(-2, 1, 0), Vec3(6, 4, 9)}, 0.37, 1.4);
  const std::vector<float> found = insideness(box(half), lattice);
  const std::array<std::vector<double>, 3> width = {lattice.widths(0), lattice.widths(1), lattice.widths(2)};
  int near = 0;
  for (std::size_t z = 0; z < lattice.size(2); ++z) {
    for (std::size_t y = 0; y < lattice.size(1); ++y) {
      for (std::size_t x = 0; x < lattice.size(0); ++x) {
        const Vec3 over = lattice.at(x, y, z).cwiseAbs() - half;
        const double distance = over.cwiseMax(0).norm() + std::min(over.maxCoeff(), 0.0);
        const double value = found[lattice.index(x, y, z)];
        if (distance != 0) {
          ASSERT_EQ(value > 0, distance < 0) << lattice.at(x, y, z).transpose();
        }
        const double reach = Vec3(width[0][x], width[1][y], width[2][z]).norm();
        if (std::abs(distance) > reach) continue;
        EXPECT_NEAR(value, -distance, 1e-5);
        ++near;
      }
    }
  }
  EXPECT_GT(near, 5000);
}

TEST(MeshDistance, knowsTheSideAtSharpEdges) {
  // Two flat pyramids base to base, 0.8 mm from tip to tip: at its rim and tips no single face tells the side.
  Surface lens;
  lens.vertices = {{6, 0, 0}, {0, 5, 0}, {-6, 0, 0}, {0, -5, 0}, {0, 0, 0.4f}, {0, 0, -0.4f}};
  lens.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}, {1, 0, 5}, {2, 1, 5}, {3, 2, 5}, {0, 3, 5}};
  const Lattice lattice = makeLattice({Vec3(-6, -5, -0.4), Vec3(6, 5, 0.4)},
                                      {Vec3::Constant(-INFINITY), Vec3::Constant(INFINITY)}, 0.23, 0.23);
  const std::vector<float> found = insideness(lens, lattice);
  int within = 0;
  for (std::size_t z = 0; z < lattice.size(2); ++z) {
    for (std::size_t y = 0; y < lattice.size(1); ++y) {
      for (std::size_t x = 0; x < lattice.size(0); ++x) {
        const Vec3 p = lattice.at(x, y, z).cwiseAbs();
        const double inside = 1 - p.x() / 6 - p.y() / 5 - p.z() / 0.4;
        if (std::abs(inside) < 1e-5) continue;
        ASSERT_EQ(found[lattice.index(x, y, z)] > 0, inside > 0) << lattice.at(x, y, z).transpose();
        within += inside > 0 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(within, 1000);
}

TEST(MeshDistance, ofTwoWallsCloseTogetherEachKeepsItsSide) {
  // Walls of 3 mm seen by a lattice that grows from half a millimetre to two.
  const Surface crust = ball(true);
  const Lattice lattice =
      makeLattice({Vec3::Constant(-20), Vec3::Constant(20)}, {Vec3(5, 5, 5), Vec3(20, 20, 20)}, 0.5, 2);
  const std::vector<float> found = insideness(crust, lattice);
  for (std::size_t z = 0; z < lattice.size(2); ++z) {
    for (std::size_t y = 0; y < lattice.size(1); ++y) {
      for (std::size_t x = 0; x < lattice.size(0); ++x) {
        const double r = lattice.at(x, y, z).norm(), depth = std::min(20 - r, r - 17);
        if (std::abs(depth) < 0.05) continue;  // less than how far the triangles are off the ball
        ASSERT_EQ(found[lattice.index(x, y, z)] > 0, depth > 0) << lattice.at(x, y, z).transpose();
      }
    }
  }
}

/** A box with a vertex in the middle of the edge from 0 to 4, for the triangle on one side alone; a needle fills the
 * gap. */
Surface boxWithANeedle(const Vec3& half) {
  Surface out = box(half);
  const Vec3 middle = 0.5 * (place(out, 0) + place(out, 4));
  out.vertices.push_back(
      {static_cast<float>(middle.x()), static_cast<float>(middle.y()), static_cast<float>(middle.z())});
  out.triangles[4] = {0, 1, 8};  // of {0, 1, 4}
  out.triangles.push_back({8, 1, 4});
  out.triangles.push_back({4, 0, 8});
  return out;
}

TEST(Cut, whatHasNoAreaIsNeitherAHoleNorASpike) {
  const Vec3 half(5, 7, 3);
  Surface twice = box(half);
  twice.triangles.insert(twice.triangles.begin(), {0, 0, 1});
  Surface several = boxWithANeedle(half);  // and the needle in three, one across another
  several.vertices.push_back({-5, -7, -1.5f});
  several.triangles.pop_back();
  several.triangles.insert(several.triangles.end(), {{4, 0, 9}, {4, 9, 8}, {9, 0, 8}});
  CutOptions o;
  o.shape.at = {0.1, 0, 0};
  o.shape.pull = {1, 0, 0};
  o.voxel = 0.37;
  for (const Surface& whole : {twice, boxWithANeedle(half), several}) {
    const CutParts parts = cut(whole, o), plain = cut(box(half), o);
    EXPECT_EQ(parts.body.triangles.size(), plain.body.triangles.size());
    EXPECT_NEAR(volumeOf(parts.body), volumeOf(plain.body), 1e-3);
    for (const auto& v : parts.body.vertices)
      for (int k = 0; k < 3; ++k) EXPECT_LT(std::abs(v[static_cast<std::size_t>(k)]), half[k] + 0.01);
  }
}

std::string placeInWords(const std::array<float, 3>& x) {
  char text[64];
  std::snprintf(text, sizeof text, "%.4g, %.4g, %.4g", static_cast<double>(x[0]), static_cast<double>(x[1]),
                static_cast<double>(x[2]));
  return text;
}

TEST(Cut, whatCannotBeCutIsRefusedInWords) {
  const auto refusal = [](const Surface& mesh, const CutOptions& options) {
    try {
      (void)cut(mesh, options);
    } catch (const ImportError& error) {
      return error.where + ": " + error.what();
    }
    return std::string("not refused");
  };
  Surface open = ball();
  const auto gone = open.triangles.back();
  open.triangles.pop_back();
  EXPECT_THAT(refusal(open, roughPlane()), HasSubstr("hole at "));
  bool named = false;
  for (const std::uint32_t v : gone) {
    const auto& x = open.vertices[v];
    named = named || refusal(open, roughPlane()).find(placeInWords(x)) != std::string::npos;
  }
  EXPECT_TRUE(named) << refusal(open, roughPlane());
  Surface inward = ball();
  for (auto& t : inward.triangles) std::swap(t[0], t[1]);
  EXPECT_THAT(refusal(inward, roughPlane()), HasSubstr("inside out"));
  CutOptions away = roughPlane();
  away.shape.at = {0, 0, 50};
  EXPECT_THAT(refusal(ball(), away), HasSubstr("nothing of it"));
  away.shape.at = {0, 0, -50};
  EXPECT_THAT(refusal(ball(), away), HasSubstr("all of it"));
  CutOptions fine = roughPlane();
  fine.voxel = 0.01;
  EXPECT_THAT(refusal(ball(), fine), HasSubstr("points"));
  // In metres, with the voxels of millimetres: it said that nothing lies on the fragment's side.
  EXPECT_THAT(refusal(box({0.02, 0.03, 0.05}), roughPlane()),
              HasSubstr("--voxel: 0.5 is too coarse for a mesh of 0.04 x 0.06 x 0.1"));
  // Far from all of it: a lattice that reached there was too large, and the advice to make it coarser no help.
  CutOptions far = roughPlane();
  far.shape.shell = true;
  far.shape.radius = 5;
  far.shape.at = {1e6, 0, 0};
  EXPECT_THAT(refusal(ball(), far), HasSubstr("nothing of it"));
  CutOptions wild = roughPlane();
  wild.shape.noise = 1e300;
  EXPECT_THAT(refusal(ball(), wild), HasSubstr("--noise: 1e+300 is more than the mesh"));
  CutOptions steep = roughPlane();
  steep.shape.wavelength = 1e-300;  // Both parts had what lies between the highest and the lowest wave.
  EXPECT_THAT(refusal(ball(), steep), HasSubstr("--wavelength: 1e-300 is less than two voxels"));
}

TEST(Cut, aPullIsADirectionHoweverLong) {
  const CutParts as_usual = cut(ball(), roughPlane());
  for (const double length : {1e200, 1e-200}) {
    CutOptions options = roughPlane();
    options.shape.pull *= length;
    const CutParts parts = cut(ball(), options);
    EXPECT_NEAR(volumeOf(parts.fragment), volumeOf(as_usual.fragment), 1e-3 * volumeOf(as_usual.fragment)) << length;
  }
}

}  // namespace
}  // namespace hapticctl_cut
