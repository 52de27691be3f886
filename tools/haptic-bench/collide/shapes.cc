#include "tools/haptic-bench/collide/shapes.h"

#include <cmath>
#include <map>

#include "tools/haptic-bench/collide/pair.h"

namespace haptic_bench {
namespace {

constexpr double kMillimetre = 1e-3;
constexpr double kFullTurn = 2 * EIGEN_PI;

std::uint32_t addMm(Model& model, double x, double y, double z) { return model.addVertex(kMillimetre * Vec3(x, y, z)); }

/** Of the bumpy ball in a direction [mm]. */
double bumps(const Vec3& d) {
  return 50 + 3 * std::sin(7 * d.x() + 0.3) * std::sin(6 * d.y() + 1.1) +
         1.5 * std::sin(13 * d.z() + 0.7) * std::cos(11 * d.x() - 0.2) +
         0.4 * std::sin(37 * d.x() + 23 * d.y()) * std::sin(29 * d.z());
}

/** The icosahedron's 20 faces, counter-clockwise seen from outside. */
void icosahedron(std::vector<Vec3>& corner, std::vector<std::array<int, 3>>& face) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  for (const double s : {-1.0, 1.0}) {
    for (const double t : {-g, g}) {
      corner.push_back(Vec3(0, s, t).normalized());
      corner.push_back(Vec3(s, t, 0).normalized());
      corner.push_back(Vec3(t, 0, s).normalized());
    }
  }
  const double edge = 2 / std::sqrt(1 + g * g);
  const auto near = [&](int i, int j) { return std::abs((corner[i] - corner[j]).norm() - edge) < 1e-9; };
  for (int i = 0; i < 12; ++i) {
    for (int j = i + 1; j < 12; ++j) {
      for (int k = j + 1; k < 12; ++k) {
        if (!near(i, j) || !near(j, k) || !near(i, k)) continue;
        const bool outward = corner[i].dot(corner[j].cross(corner[k])) > 0;
        face.push_back({i, outward ? j : k, outward ? k : j});
      }
    }
  }
}

/** Welds vertices that are equal to a nanometre. */
class Welder {
 public:
  explicit Welder(Model& model) : model_(model) {}
  std::uint32_t add(const Vec3& x) {
    const auto key = [](double v) { return std::llround(v * 1e9); };
    const auto [place, fresh] = seen_.try_emplace({key(x.x()), key(x.y()), key(x.z())}, 0);
    if (fresh) place->second = model_.addVertex(x);
    return place->second;
  }

 private:
  Model& model_;
  std::map<std::array<long long, 3>, std::uint32_t> seen_;
};

std::uint32_t hashed(std::int32_t x, std::int32_t y, std::int32_t octave) {
  auto h = static_cast<std::uint32_t>(x) * 0x8da6b343u ^ static_cast<std::uint32_t>(y) * 0xd8163841u ^
           static_cast<std::uint32_t>(octave) * 0xcb1ab31fu;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return h ^ (h >> 15);
}

/** Value noise in [-1, 1] with a quintic between the lattice's values. */
double noise(double x, double y, int octave) {
  const double fx = std::floor(x), fy = std::floor(y);
  const auto fade = [](double t) { return t * t * t * (t * (t * 6 - 15) + 10); };
  const double u = fade(x - fx), v = fade(y - fy);
  const auto at = [&](int i, int j) {
    return hashed(static_cast<std::int32_t>(fx) + i, static_cast<std::int32_t>(fy) + j, octave) / 2147483647.5 - 1;
  };
  return (1 - v) * ((1 - u) * at(0, 0) + u * at(1, 0)) + v * ((1 - u) * at(0, 1) + u * at(1, 1));
}

}  // namespace

double fractureHeight(double x, double y) {
  double z = 4 * std::sin(kFullTurn * x / 47 + 0.3) * std::cos(kFullTurn * y / 39);
  for (int o = 0; o < 6; ++o) {
    const double scale = 1 << o;
    z += 2.5 / scale * noise(x * scale / 15 + 100, y * scale / 15 + 100, o);
  }
  return z;
}

Model bumpyBall() {
  constexpr int kFrequency = 59;
  Model model;
  model.name = "bumpy";
  Welder weld(model);
  std::vector<Vec3> corner;
  std::vector<std::array<int, 3>> faces;
  icosahedron(corner, faces);
  for (const auto& f : faces) {
    std::vector<std::vector<std::uint32_t>> row(kFrequency + 1);
    for (int i = 0; i <= kFrequency; ++i) {
      for (int j = 0; i + j <= kFrequency; ++j) {
        const Vec3 d = ((kFrequency - i - j) * corner[f[0]] + i * corner[f[1]] + j * corner[f[2]]).normalized();
        row[i].push_back(weld.add(kMillimetre * bumps(d) * d));
      }
    }
    for (int i = 0; i < kFrequency; ++i) {
      for (int j = 0; i + j < kFrequency; ++j) {
        model.triangles.push_back({row[i][j], row[i + 1][j], row[i][j + 1]});
        if (i + j + 2 <= kFrequency) model.triangles.push_back({row[i + 1][j], row[i + 1][j + 1], row[i][j + 1]});
      }
    }
  }
  return model;
}

Model peg() {
  constexpr std::uint32_t kSlices = 200, kRows = 49;
  Model model;
  model.name = "peg";
  for (std::uint32_t r = 0; r <= kRows; ++r) {
    for (std::uint32_t s = 0; s < kSlices; ++s)
      addMm(model, 10 * std::cos(kFullTurn * s / kSlices), 10 * std::sin(kFullTurn * s / kSlices), 60.0 * r / kRows);
  }
  const std::uint32_t tip = addMm(model, 0, 0, 0), top = addMm(model, 0, 0, 60);
  for (std::uint32_t s = 0; s < kSlices; ++s) {
    const std::uint32_t next = (s + 1) % kSlices, last = kRows * kSlices;
    for (std::uint32_t r = 0; r < kRows; ++r)
      model.addQuad(r * kSlices + s, r * kSlices + next, (r + 1) * kSlices + next, (r + 1) * kSlices + s);
    model.triangles.push_back({tip, next, s});
    model.triangles.push_back({top, last + s, last + next});
  }
  return model;
}

Model plateWithHole() {
  // A closed band of rings about the hole's axis: down the hole, out below, up the sides, in above.
  constexpr std::uint32_t kSlices = 200, kInHole = 20, kAcross = 10, kUpSides = 4;
  constexpr std::uint32_t kRings = kInHole + 2 * kAcross + kUpSides;
  Model model;
  model.name = "plate";
  const auto ring = [&](double out, double z) {
    for (std::uint32_t s = 0; s < kSlices; ++s) {
      const double c = std::cos(kFullTurn * s / kSlices), d = std::sin(kFullTurn * s / kSlices);
      const double square = 40 / std::max(std::abs(c), std::abs(d));
      const double r = 10.1 + out * (square - 10.1);
      addMm(model, r * c, r * d, z);
    }
  };
  for (std::uint32_t i = 0; i < kInHole; ++i) ring(0, -20.0 * i / kInHole);
  for (std::uint32_t i = 0; i < kAcross; ++i) ring(static_cast<double>(i) / kAcross, -20);
  for (std::uint32_t i = 0; i < kUpSides; ++i) ring(1, -20 + 20.0 * i / kUpSides);
  for (std::uint32_t i = 0; i < kAcross; ++i) ring(1 - static_cast<double>(i) / kAcross, 0);
  for (std::uint32_t r = 0; r < kRings; ++r) {
    const std::uint32_t here = r * kSlices, below = (r + 1) % kRings * kSlices;
    for (std::uint32_t s = 0; s < kSlices; ++s) {
      const std::uint32_t next = (s + 1) % kSlices;
      model.addQuad(here + s, here + next, below + next, below + s);
    }
  }
  return model;
}

Model fractureHalf(bool upper) {
  constexpr std::uint32_t kCells = 180;
  Model model;
  model.name = upper ? "frac_tool" : "frac_base";
  const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    upper ? model.addQuad(d, c, b, a) : model.addQuad(a, b, c, d);
  };
  const auto at = [](std::uint32_t i) { return 60.0 * i / kCells - 30; };
  for (std::uint32_t i = 0; i <= kCells; ++i) {
    for (std::uint32_t j = 0; j <= kCells; ++j) addMm(model, at(i), at(j), fractureHeight(at(i), at(j)));
  }
  const auto place = [](std::uint32_t i, std::uint32_t j) { return i * (kCells + 1) + j; };
  for (std::uint32_t i = 0; i < kCells; ++i) {
    for (std::uint32_t j = 0; j < kCells; ++j) quad(place(i, j), place(i + 1, j), place(i + 1, j + 1), place(i, j + 1));
  }
  // The sides, along the rim counter-clockwise seen from above, and the flat far side as a fan.
  std::vector<std::uint32_t> rim;
  for (std::uint32_t i = 0; i < kCells; ++i) rim.push_back(place(i, 0));
  for (std::uint32_t i = 0; i < kCells; ++i) rim.push_back(place(kCells, i));
  for (std::uint32_t i = kCells; i > 0; --i) rim.push_back(place(i, kCells));
  for (std::uint32_t i = kCells; i > 0; --i) rim.push_back(place(0, i));
  const double far = upper ? 20 : -20;
  std::vector<std::uint32_t> flat;
  flat.reserve(rim.size());
  for (const std::uint32_t v : rim)
    flat.push_back(model.addVertex({model.vertex(v).x(), model.vertex(v).y(), kMillimetre * far}));
  const std::uint32_t middle = addMm(model, 0, 0, far);
  for (std::size_t i = 0; i < rim.size(); ++i) {
    const std::size_t next = (i + 1) % rim.size();
    quad(flat[i], flat[next], rim[next], rim[i]);
    upper ? model.triangles.push_back({middle, flat[i], flat[next]})
          : model.triangles.push_back({middle, flat[next], flat[i]});
  }
  return model;
}

}  // namespace haptic_bench
