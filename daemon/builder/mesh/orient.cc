// One winding per connected part, outward where there is an outside.
#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>
#include <optional>

#include "daemon/builder/mesh/counted.h"
#include "daemon/builder/mesh/mesh.h"
#include "daemon/builder/volume/winding.h"

namespace hapticd {
namespace {

using Double3 = std::array<double, 3>;

Double3 minus(const Float3& a, const Float3& b) {
  return {double{a[0]} - b[0], double{a[1]} - b[1], double{a[2]} - b[2]};
}
Double3 cross(const Double3& a, const Double3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Double3& a, const Double3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/** Triangles connected across edges: a range of `order`. */
struct Part {
  std::uint32_t begin = 0, end = 0;
  bool closed = true;
  bool mixed = false;   ///< Wound this way and that: its winding says nothing.
  bool turned = false;  ///< It was inside out as a whole.
  double volume = 0;    ///< Signed, as wound [m^3].
  Float3 lower{}, upper{};
  [[nodiscard]] std::uint32_t size() const { return end - begin; }
};

void flip(Mesh& mesh, std::uint32_t t) {
  std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  std::swap(mesh.neighbours[t][0], mesh.neighbours[t][2]);  // edges 01, 12, 20 become 02, 21, 10
}

std::uint32_t edgeOf(const Mesh& mesh, std::uint32_t t, std::uint32_t low, std::uint32_t high) {
  for (std::uint32_t e = 0; e < 3; ++e)
    if (std::minmax(mesh.triangles[t][e], mesh.triangles[t][(e + 1) % 3]) == std::minmax(low, high)) return e;
  return 0;
}

class Orienter {
 public:
  Orienter(Mesh& mesh, BuildMonitor& monitor) : mesh_(mesh), monitor_(monitor) {}

  void run() {
    gatherParts();
    std::uint32_t inverted = 0, first_inverted = HD_NO_INDEX;
    for (Part& part : parts_) measure(part);
    const auto turn = [&](const Part& part) {
      ++inverted;
      first_inverted = std::min(first_inverted, firstOf(part));
      for (std::uint32_t i = part.begin; i < part.end; ++i) flip(mesh_, order_[i]);
    };
    sortByPlace();
    bool any_turned = false;
    for (Part& part : parts_) {
      if (!part.closed || part.volume >= 0 || isCavity(part)) continue;
      turn(part);
      part.turned = !part.mixed;
      any_turned |= part.turned;
    }
    for (const Part& part : parts_)
      if (any_turned && part.closed && part.volume > 0 && isTurnedCavity(part)) turn(part);
    if (flipped_ != 0) {
      monitor_.notes.push_back(fmt::format("turned {} to the winding of the neighbours, the first is triangle {}",
                                           counted(flipped_, "triangle"), first_flipped_));
    }
    if (twisted_ != 0) {
      monitor_.notes.push_back(
          fmt::format("the surface about triangle {} has one side only (as a Moebius strip); {} as borders",
                      first_twisted_, counted(twisted_, "edge counts", "edges count")));
    }
    if (inverted != 0) {
      monitor_.notes.push_back(fmt::format("turned {} outside out, the first begins at triangle {}",
                                           counted(inverted, "closed part"), first_inverted));
    }
    mesh_.closed = std::all_of(parts_.begin(), parts_.end(), [](const Part& part) { return part.closed; });
  }

 private:
  enum class Mark : std::uint8_t { kNew, kSame, kTurned };

  /** Breadth first over each part, noting which triangles are wound against the first one; the fewer are flipped. */
  void gatherParts() {
    const auto count = static_cast<std::uint32_t>(mesh_.triangles.size());
    mark_.assign(count, Mark::kNew);
    order_.reserve(count);
    for (std::uint32_t seed = 0; seed < count; ++seed) {
      if (mark_[seed] != Mark::kNew) continue;
      Part part;
      part.begin = static_cast<std::uint32_t>(order_.size());
      std::uint32_t turned = 0;
      mark_[seed] = Mark::kSame;
      order_.push_back(seed);
      for (std::uint32_t i = part.begin; i < order_.size(); ++i) {
        if (i + kFetchAhead < order_.size()) fetchNeighbours(order_[i + kFetchAhead]);
        turned += spread(order_[i]);
      }
      part.end = static_cast<std::uint32_t>(order_.size());
      if (turned != 0) {
        part.mixed = 4 * std::uint64_t{std::min(turned, part.size() - turned)} > part.size();
        const Mark wrong = turned * 2 <= part.size() ? Mark::kTurned : Mark::kSame;
        for (std::uint32_t i = part.begin; i < part.end; ++i) {
          if (mark_[order_[i]] != wrong) continue;
          flip(mesh_, order_[i]);
          ++flipped_;
          first_flipped_ = std::min(first_flipped_, mesh_.source_triangle[order_[i]]);
        }
      }
      parts_.push_back(part);
    }
  }

  // Always inline: a compiler may leave out calls of what only fetches, as without effect.
  [[gnu::always_inline]] void fetchNeighbours(std::uint32_t t) const {
    for (const std::uint32_t s : mesh_.neighbours[t]) {
      if (s == HD_NO_INDEX) continue;
      __builtin_prefetch(&mesh_.triangles[s]);
      __builtin_prefetch(&mesh_.neighbours[s]);
    }
  }

  /** Marks the neighbours of t. Returns how many were newly found turned. */
  std::uint32_t spread(std::uint32_t t) {
    std::uint32_t turned = 0;
    for (std::uint32_t e = 0; e < 3; ++e) {
      const std::uint32_t s = mesh_.neighbours[t][e];
      if (s == HD_NO_INDEX) continue;
      const std::uint32_t a = mesh_.triangles[t][e], b = mesh_.triangles[t][(e + 1) % 3];
      const std::uint32_t f = edgeOf(mesh_, s, a, b);
      const bool agree = mesh_.triangles[s][f] == b;
      const Mark mark = (mark_[t] == Mark::kSame) == agree ? Mark::kSame : Mark::kTurned;
      if (mark_[s] == Mark::kNew) {
        mark_[s] = mark;
        order_.push_back(s);
        if (mark == Mark::kTurned) ++turned;
      } else if (mark_[s] != mark) {
        // No winding suits both: cut here.
        mesh_.neighbours[t][e] = HD_NO_INDEX;
        mesh_.neighbours[s][f] = HD_NO_INDEX;
        ++twisted_;
        first_twisted_ = std::min({first_twisted_, mesh_.source_triangle[t], mesh_.source_triangle[s]});
      }
    }
    return turned;
  }

  void measure(Part& part) {
    const Float3& origin = mesh_.vertices[mesh_.triangles[order_[part.begin]][0]];
    part.lower = part.upper = origin;
    for (std::uint32_t i = part.begin; i < part.end; ++i) {
      const std::uint32_t t = order_[i];
      if (i + 2 * kFetchAhead < part.end) {
        __builtin_prefetch(&mesh_.neighbours[order_[i + 2 * kFetchAhead]]);
        __builtin_prefetch(&mesh_.triangles[order_[i + 2 * kFetchAhead]]);
        for (const std::uint32_t v : mesh_.triangles[order_[i + kFetchAhead]]) __builtin_prefetch(&mesh_.vertices[v]);
      }
      for (const std::uint32_t s : mesh_.neighbours[t]) part.closed &= s != HD_NO_INDEX;
      Double3 corner[3];
      for (int c = 0; c < 3; ++c) {
        const Float3& p = mesh_.vertices[mesh_.triangles[t][c]];
        corner[c] = minus(p, origin);
        for (int k = 0; k < 3; ++k) {
          part.lower[k] = std::min(part.lower[k], p[k]);
          part.upper[k] = std::max(part.upper[k], p[k]);
        }
      }
      part.volume += dot(corner[0], cross(corner[1], corner[2])) / 6;
    }
  }

  [[nodiscard]] std::uint32_t firstOf(const Part& part) const {
    std::uint32_t first = HD_NO_INDEX;
    for (std::uint32_t i = part.begin; i < part.end; ++i) first = std::min(first, mesh_.source_triangle[order_[i]]);
    return first;
  }

  /** So that those about a part are found without a look at all the others: of a foam's pores there are many. */
  void sortByPlace() {
    by_lower_.resize(parts_.size());
    std::iota(by_lower_.begin(), by_lower_.end(), 0U);
    std::stable_sort(by_lower_.begin(), by_lower_.end(),
                     [this](std::uint32_t a, std::uint32_t b) { return parts_[a].lower[0] < parts_[b].lower[0]; });
    const std::size_t leaves = std::bit_ceil(parts_.size());
    most_upper_.assign(2 * leaves, -std::numeric_limits<float>::infinity());
    for (std::size_t i = 0; i < parts_.size(); ++i) most_upper_[leaves + i] = parts_[by_lower_[i]].upper[0];
    for (std::size_t n = leaves; n-- > 1;) most_upper_[n] = std::max(most_upper_[2 * n], most_upper_[2 * n + 1]);
  }

  static bool isBoxed(const Part& part, const Part& other) {
    bool boxed = true;
    for (int k = 0; k < 3; ++k) boxed &= other.lower[k] < part.lower[k] && part.upper[k] < other.upper[k];
    return boxed;
  }

  /** The parts that hold a part, open ones by their winding number. Nothing if there are too many to test. */
  [[nodiscard]] std::optional<std::vector<const Part*>> about(const Part& part) {
    const Float3& inner = mesh_.vertices[mesh_.triangles[order_[part.begin]][0]];
    std::vector<const Part*> outer;
    const std::size_t leaves = most_upper_.size() / 2;
    struct Branch {
      std::size_t node, first, count;
    };
    std::vector<Branch> open = {{1, 0, leaves}};
    while (!open.empty()) {
      const auto [node, first, count] = open.back();
      open.pop_back();
      if (!(most_upper_[node] > part.upper[0]) || !(parts_[by_lower_[first]].lower[0] < part.lower[0])) continue;
      if (count > 1) {
        if (first + count / 2 < by_lower_.size()) open.push_back({2 * node + 1, first + count / 2, count / 2});
        open.push_back({2 * node, first, count / 2});
        continue;
      }
      const Part& other = parts_[by_lower_[first]];
      if (&other == &part || !isBoxed(part, other)) continue;
      std::uint64_t& left = other.closed ? work_left_ : open_work_left_;
      if (left < other.size() && !other.closed) continue;  // It holds nothing for sure.
      if (left < other.size()) return {};
      left -= other.size();
      if (other.closed ? crossesOdd(other, inner) : windsAbout(other, inner)) outer.push_back(&other);
    }
    return outer;
  }

  /** A closed part wound inward is right where it bounds a hollow: inside an odd number of others. */
  [[nodiscard]] bool isCavity(const Part& part) {
    if (part.mixed) return false;
    const auto outer = about(part);
    return !outer || outer->size() % 2 == 1;  // What cannot be tested is as the file has it.
  }

  /** One wound outward bounds a hollow, too, of a solid that is inside out as a whole: if its outermost part was. */
  [[nodiscard]] bool isTurnedCavity(const Part& part) {
    if (part.mixed) return false;
    const auto outer = about(part);
    if (!outer || outer->size() % 2 == 0) return false;
    return (*std::min_element(outer->begin(), outer->end(),
                              [](const Part* a, const Part* b) { return a->lower[0] < b->lower[0]; }))
        ->turned;
  }

  /** Whether an open part is about x all but for its holes. A floor is not about what lies under it. */
  [[nodiscard]] bool windsAbout(const Part& part, const Float3& x) const {
    const auto point = [](const Float3& p) { return Vec3(p[0], p[1], p[2]); };
    double sum = 0;
    for (std::uint32_t i = part.begin; i < part.end; ++i) {
      const Index3& v = mesh_.triangles[order_[i]];
      sum += windingOfTriangle(point(mesh_.vertices[v[0]]), point(mesh_.vertices[v[1]]), point(mesh_.vertices[v[2]]),
                               point(x));
    }
    return sum > 0.75;
  }

  /** Parity of the crossings of a ray from x with the part: odd means inside. */
  [[nodiscard]] bool crossesOdd(const Part& part, const Float3& x) const {
    // A direction that no modeller aligns an edge with. Moeller and Trumbore, J. Graphics Tools 2(1), 1997.
    static constexpr Double3 kDirection = {0.5773891, 0.3127347, 0.7542153};
    bool odd = false;
    for (std::uint32_t i = part.begin; i < part.end; ++i) {
      const Index3& v = mesh_.triangles[order_[i]];
      const Double3 u = minus(mesh_.vertices[v[1]], mesh_.vertices[v[0]]);
      const Double3 w = minus(mesh_.vertices[v[2]], mesh_.vertices[v[0]]);
      const Double3 p = cross(kDirection, w);
      const double det = dot(u, p);
      if (det == 0) continue;
      const Double3 s = minus(x, mesh_.vertices[v[0]]);
      const double a = dot(s, p) / det;
      const Double3 q = cross(s, u);
      const double b = dot(kDirection, q) / det;
      if (a >= 0 && b >= 0 && a + b <= 1 && dot(w, q) / det > 0) odd = !odd;
    }
    return odd;
  }

  Mesh& mesh_;
  BuildMonitor& monitor_;
  std::vector<Mark> mark_;
  std::vector<std::uint32_t> order_;
  std::vector<Part> parts_;
  std::vector<std::uint32_t> by_lower_;       ///< Parts by where they begin along x.
  std::vector<float> most_upper_;             ///< A tree over these, its root at 1: where the farthest ends along x.
  std::uint64_t work_left_ = 50'000'000;      ///< Ray tests: half a second at most.
  std::uint64_t open_work_left_ = 5'000'000;  ///< Solid angles: as long.
  std::uint32_t flipped_ = 0, first_flipped_ = HD_NO_INDEX;
  std::uint32_t twisted_ = 0, first_twisted_ = HD_NO_INDEX;
};

}  // namespace

void orient(Mesh& mesh, BuildMonitor& monitor) { Orienter(mesh, monitor).run(); }

}  // namespace hapticd
