#include "daemon/builder/volume/surface_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace hapticd {
namespace {

constexpr double kSameSide = 0.5;    // Cosine of 60 degrees.
constexpr double kLeastCell = 1e-9;  // Of smaller ones whole numbers cannot count all that a mesh may have [m].

Vec3 point(const Float3& p) { return {p[0], p[1], p[2]}; }

double partsOf(double length, double step) { return std::max(1.0, std::ceil(length / step)); }

/** Pieces of one triangle: rows from the apex to the edge b-c, t from 0 to 1, cut by lines from the apex. */
void cut(const Vec3& apex, const Vec3& b, const Vec3& c, double step,
         const std::function<void(const SurfaceSample&)>& visit) {
  const Vec3 cross = (b - apex).cross(c - apex);
  const double twice = cross.norm(), base = (c - b).norm();
  if (!(twice > 0) || !(base > 0)) return;
  const Vec3 normal = cross / twice;
  const double rows = partsOf(twice / base, step);
  for (double row = 0; row < rows; ++row) {
    const double t0 = row / rows, t1 = (row + 1) / rows, squares = t1 * t1 - t0 * t0;
    const double t = 2.0 / 3.0 * (t1 * t1 * t1 - t0 * t0 * t0) / squares;
    const double columns = partsOf(base * t1, step);
    for (double column = 0; column < columns; ++column) {
      const double u = (column + 0.5) / columns;
      visit({apex + t * ((b - apex) + u * (c - b)), normal, 0.5 * twice * squares / columns});
    }
  }
}

}  // namespace

void sampleSurface(std::span<const Float3> vertices, std::span<const Index3> triangles, double step,
                   const std::function<void(const SurfaceSample&)>& visit) {
  for (const Index3& t : triangles) {
    const Vec3 v[3] = {point(vertices[t[0]]), point(vertices[t[1]]), point(vertices[t[2]])};
    int longest = 0;
    for (int e = 1; e < 3; ++e)
      if ((v[(e + 1) % 3] - v[e]).norm() > (v[(longest + 1) % 3] - v[longest]).norm()) longest = e;
    const Vec3 &apex = v[(longest + 2) % 3], &b = v[longest], &c = v[(longest + 1) % 3];
    const Vec3 along = c - b;
    const double share = along.squaredNorm() > 0 ? along.dot(apex - b) / along.squaredNorm() : 0;
    const Vec3 foot = b + std::clamp(share, 0.0, 1.0) * along;
    const double height = (apex - foot).norm(), to_b = (b - foot).norm(), to_c = (c - foot).norm();
    if (std::max(to_b, to_c) <= step * partsOf(height, step)) {
      cut(apex, b, c, step, visit);
      continue;
    }
    // In a thin triangle the fan's pieces would lean from the apex to the far end. Its altitude cuts it into two with a
    // right angle, whose rows along the longer leg lean by a step at most.
    if (to_b > height) {
      cut(b, foot, apex, step, visit);
    } else {
      cut(apex, b, foot, step, visit);
    }
    if (to_c > height) {
      cut(c, apex, foot, step, visit);
    } else {
      cut(apex, foot, c, step, visit);
    }
  }
}

/**
 * Rows of a fan over a base, one more than its height has steps, are half the base long on average, and each has one
 * piece more than steps: height base / 2 + base + height + 1, in steps. The two halves of a thin triangle have its
 * height h for a base, and their own heights are parts of its longest edge l: together l h / 2 + 2 h + l + 2.
 */
double mostSamples(const Vec3& a, const Vec3& b, const Vec3& c, double step) {
  const double twice = (b - a).cross(c - a).norm();
  if (!(twice > 0)) return 0;
  const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  return twice / 2 / (step * step) + (longest + 2 * twice / longest) / step + 2;
}

namespace {

struct Placed {
  std::array<std::int64_t, 3> cell;
  std::uint32_t sample;
  bool operator<(const Placed& other) const { return cell != other.cell ? cell < other.cell : sample < other.sample; }
};

/** Samples of one cell that look the same way. */
struct Cluster {
  Vec3 normal, centroid;  // Weighted by area, not yet divided.
  double area;
  std::vector<std::uint32_t> members;
};

}  // namespace

std::vector<SurfaceSample> thinOut(std::vector<SurfaceSample> samples, const Vec3& grid_origin, double grid_side) {
  grid_side = std::max(grid_side, kLeastCell);
  std::vector<Placed> placed(samples.size());
  for (std::uint32_t i = 0; i < samples.size(); ++i) {
    const Vec3 u = (samples[i].x - grid_origin) / grid_side;
    for (std::size_t k = 0; k < 3; ++k)
      placed[i].cell[k] = static_cast<std::int64_t>(std::floor(u[static_cast<Eigen::Index>(k)]));
    placed[i].sample = i;
  }
  std::sort(placed.begin(), placed.end());
  std::vector<SurfaceSample> out;
  std::vector<Cluster> clusters;
  for (std::size_t begin = 0, end; begin < placed.size(); begin = end) {
    for (end = begin; end < placed.size() && placed[end].cell == placed[begin].cell;) ++end;
    clusters.clear();
    for (std::size_t i = begin; i < end; ++i) {
      const SurfaceSample& s = samples[placed[i].sample];
      auto c = std::find_if(clusters.begin(), clusters.end(), [&](const Cluster& cluster) {
        return cluster.normal.dot(s.normal) > kSameSide * cluster.normal.norm();
      });
      if (c == clusters.end()) c = clusters.insert(c, Cluster{Vec3::Zero(), Vec3::Zero(), 0, {}});
      c->normal += s.area * s.normal;
      c->centroid += s.area * s.x;
      c->area += s.area;
      c->members.push_back(placed[i].sample);
    }
    for (const Cluster& c : clusters) {
      const Vec3 middle = c.centroid / c.area;
      const auto nearer = [&](std::uint32_t a, std::uint32_t b) {
        return (samples[a].x - middle).squaredNorm() < (samples[b].x - middle).squaredNorm();
      };
      const std::uint32_t kept = *std::min_element(c.members.begin(), c.members.end(), nearer);
      out.push_back({samples[kept].x, c.normal.normalized(), c.area});
    }
  }
  return out;
}

std::optional<double> orderByCoverage(std::span<SurfaceSample> points, const std::function<bool()>& goesOn) {
  constexpr std::size_t kPairsUnasked = 500'000;
  if (points.empty()) return 0;
  Vec3 middle = Vec3::Zero();
  for (const SurfaceSample& p : points) middle += p.x / static_cast<double>(points.size());
  std::vector<double> away(points.size(), std::numeric_limits<double>::infinity());  // Squared, from those chosen.
  std::size_t next = 0;
  for (std::size_t i = 1; i < points.size(); ++i)
    if ((points[i].x - middle).squaredNorm() < (points[next].x - middle).squaredNorm()) next = i;
  const std::size_t quarter = (points.size() + 3) / 4;
  double spread = 0;
  std::size_t pairs = 0;
  for (std::size_t chosen = 0; chosen < points.size(); ++chosen) {
    pairs += points.size() - chosen;
    if (pairs >= kPairsUnasked) {
      if (!goesOn()) return std::nullopt;
      pairs = 0;
    }
    std::swap(points[chosen], points[next]);
    std::swap(away[chosen], away[next]);
    next = chosen + 1;
    for (std::size_t i = chosen + 1; i < points.size(); ++i) {
      away[i] = std::min(away[i], (points[i].x - points[chosen].x).squaredNorm());
      if (away[i] > away[next]) next = i;
    }
    if (chosen + 1 == quarter && next < points.size()) spread = std::sqrt(away[next]);
  }
  return spread;
}

}  // namespace hapticd
