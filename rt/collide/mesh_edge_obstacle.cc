// Ridges and peaks of the scene's meshes against a tool's surface, which they may meet between two of the tool's
// points.
#include <algorithm>
#include <array>
#include <cmath>

#include "rt/collide/edge_search.h"
#include "rt/collide/feature.h"
#include "rt/collide/mantle.h"
#include "rt/collide/purse.h"
#include "rt/collide/round.h"
#include "rt/geometry/nearest/fan.h"
#include "rt/geometry/nearest/pseudo_normal.h"
#include "rt/geometry/triangle.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kQueue = 1024;    ///< Parts of the tree that wait,
constexpr std::uint32_t kWork = 40000;    ///< and units for them: of one mesh.
constexpr std::uint32_t kMostFound = 16;  ///< Places.
constexpr std::uint32_t kLook = 7;        ///< Units that a place costs beside what its query counts.
constexpr double kNearby = 5e-4;          ///< Beyond what may close before the next answer [m].
constexpr double kRidge = 1e-3;           ///< Sine of the least angle between the faces of a ridge.
constexpr double kAcross = 0.02;          ///< Sine of the angle from a right one with a ridge within which edges cross.
constexpr double kUp = 1e-3;              ///< So far along an edge it is asked for the tool [m].
constexpr double kApart = 1.0 / 8;        ///< Of the tool: so near to a contact nothing new is told.
constexpr double kBrief = 1.0 / 8;        ///< Of that: a ridge this short is one place.
constexpr std::uint32_t kRidges = kFirstPeak - kFirstRidge;

/** What waits, its gap no less than `key`: a node (count 0), a leaf, or a ridge. */
struct Part {
  static constexpr std::uint32_t kRidgePart = 0x100;
  float key;
  std::uint32_t child, count;
  [[nodiscard]] bool operator<(const Part& other) const HD_RT { return key > other.key; }  // The least comes first.
};

/** Of at most so many parts the one of least key; of more the one that came last is forgotten. */
class Queue {
 public:
  void push(double key, std::uint32_t child, std::uint32_t count) HD_RT {
    if (size_ == kQueue) return;
    part_[size_++] = {static_cast<float>(key), child, count};
    std::push_heap(part_.begin(), part_.begin() + size_);
  }
  [[nodiscard]] bool pop(Part& part) HD_RT {
    if (size_ == 0) return false;
    std::pop_heap(part_.begin(), part_.begin() + size_);
    part = part_[--size_];
    return true;
  }

 private:
  std::array<Part, kQueue> part_;
  std::uint32_t size_ = 0;
};

/** A plane through `on` with all of a convex tool on one side; `in` leads there. Unit. */
struct Tangent {
  Vec3 on, in;
};

/** Of a primitive: near to x, the one of its face where that is flat. */
Tangent tangentNear(const Shape& shape, const Vec3& x) HD_RT {
  if (shape.kind == ShapeKind::kBox) {
    Eigen::Index axis = 0;
    (x.cwiseAbs() - shape.size).maxCoeff(&axis);
    Vec3 out = Vec3::Zero(), on = x;
    out[axis] = x[axis] < 0 ? -1 : 1;
    on[axis] = out[axis] * shape.size[axis];
    return {on, -out};
  }
  const bool flat = shape.kind == ShapeKind::kCylinder;
  const double end = shape.kind == ShapeKind::kSphere ? 0 : shape.size.y(), radius = shape.size.x();
  const double side = x.z() < 0 ? -1 : 1;
  if (flat && std::abs(x.z()) - end > x.head<2>().norm() - radius)
    return {Vec3(x.x(), x.y(), side * end), Vec3(0, 0, -side)};
  const Vec3 middle(0, 0, flat ? x.z() : std::clamp(x.z(), -end, end));
  const Vec3 way = x - middle;
  const double length = way.norm();
  const Vec3 out = length > 0 ? Vec3(way / length) : Vec3(Vec3::UnitX());
  return {middle + radius * out, -out};
}

/** An edge of a mesh where the surface is ridged, seen from the side that `facing` tells: 1 or, of a sheet, -1. The
 * border of a sheet is one, too, with both sides of its face. */
struct Ridge {
  Vec3 from, to;
  Vec3 out;                   ///< Unit, away from both faces.
  Vec3 one, other;            ///< Outward, unit, of its faces,
  Vec3 down_one, down_other;  ///< and in them away from it.

  [[nodiscard]] Vec3 at(double t) const HD_RT { return from + t * (to - from); }
  [[nodiscard]] double length() const HD_RT { return (to - from).norm(); }

  /** Whether what touches it along n, in its frame, has both faces behind it. */
  [[nodiscard]] bool leansOut(const Vec3& n) const HD_RT {
    return n.dot(down_one) <= kAside && n.dot(down_other) <= kAside;
  }
};

/** False: triangle t has no ridge there, or its neighbour of a lower number has it; or a border that is no sheet's. */
bool ridgeOf(const MeshView& mesh, std::uint32_t t, std::uint32_t k, double facing, bool sheet, Ridge& ridge) HD_RT {
  const std::uint32_t across = mesh.neighbours[t][k];
  const bool border = across == HD_NO_INDEX;
  if (border ? !sheet : across < t) return false;
  ridge.one = facing * faceNormal(mesh, t);
  ridge.other = border ? Vec3(-ridge.one) : Vec3(facing * faceNormal(mesh, across));
  if (ridge.one.isZero(0) || ridge.other.isZero(0)) return false;
  const int corner = static_cast<int>(k);
  ridge.from = mesh.vertex(t, corner);
  ridge.to = mesh.vertex(t, (corner + 1) % 3);
  const Vec3 along = (ridge.to - ridge.from).normalized();
  ridge.down_one = facing * ridge.one.cross(along);
  ridge.down_other = facing * along.cross(ridge.other);
  ridge.out = border ? Vec3(-ridge.down_one) : (ridge.one + ridge.other).normalized();
  if (border) return true;
  return facing * ridge.one.cross(ridge.other).dot(along) > kRidge;
}

/**
 * Whether no edge leads up along n from a corner of triangle t. What touches a ridge's end with another normal crosses
 * the ridge that goes on there: it would be caught as on a notch. In a hollow what leads up may be beside the tool, or
 * along another side of it: there one that isMet() counts.
 */
template <class IsMet>
bool isPeak(const MeshView& mesh, std::uint32_t t, std::uint32_t corner, const Vec3& n, std::uint32_t& work,
            const IsMet& isMet) HD_RT {
  const std::uint32_t vertex = mesh.triangles[t][corner];
  const Vec3 x = mesh.vertex(t, static_cast<int>(corner));
  const auto way = [&](std::uint32_t at, std::uint32_t from)
                       HD_RT { return Vec3(mesh.vertex(at, static_cast<int>(from % 3)) - x); };
  const auto leadsUp = [&](const Vec3& edge) HD_RT { return n.dot(edge) > kAlong * edge.norm(); };
  const auto leads = [&](std::uint32_t at, std::uint32_t here) HD_RT {
    ++work;
    return leadsUp(way(at, here + 1)) || leadsUp(way(at, here + 2));
  };
  const auto isHollow = [&](std::uint32_t at, std::uint32_t here) HD_RT {
    const std::uint32_t across = mesh.neighbours[at][here];
    if (across == HD_NO_INDEX) return false;
    const Vec3 beyond = way(across, cornerOf(mesh, across, vertex) + 1);
    return faceNormal(mesh, at).dot(beyond) > kRidge * beyond.norm();
  };
  const auto isMetAlong = [&](std::uint32_t at, std::uint32_t here) HD_RT {
    for (const std::uint32_t other : {here + 1, here + 2}) {
      const Vec3 edge = way(at, other);
      if (leadsUp(edge) && isMet(edge)) return true;
    }
    return false;
  };
  return !anyAbout(mesh, t, vertex, leads) ||
         (anyAbout(mesh, t, vertex, isHollow) && !anyAbout(mesh, t, vertex, isMetAlong));
}

}  // namespace

/** Of one mesh's ridges against one tool, in the frames of both: A's and B's. */
struct SceneContacts::RidgeSearch {
  SceneContacts& own;
  const CollideRequest::Held& held;
  const std::uint32_t k;  ///< Which obstacle.
  Purse& purse;
  const CollideRequest::Obstacle& obstacle = held.obstacle[k];
  const MeshView& mesh = *obstacle.shape.mesh;
  const bool made_of_mesh = held.shape.kind == ShapeKind::kMesh, sheet = own.isSheet(obstacle.shape);
  const Pose X_AB = held.X_WO.inverse() * obstacle.X_WO;
  const double margin = own.reach_ + kNearby, apart = kApart * own.points_.reach();
  const double facing = sheet && own.isBehind(obstacle) ? -1 : 1;
  NearestQuery query;
  Nearest nearest;
  std::uint32_t many = 0;  ///< Places found.
  Queue queue;

  double gapAt(const Vec3& x_B, double reach) HD_RT;
  /** From the obstacle to the tool, where it was asked last. */
  [[nodiscard]] Vec3 normal(double gap) const HD_RT {
    return std::abs(gap) > 1e-7 ? Vec3((nearest.point - query.x) / gap) : Vec3(-nearest.pseudo_normal);
  }
  /** Whether a contact near to all within `radius` of x_B is as deep as what is there, no nearer than `least`. */
  [[nodiscard]] bool isTold(const Vec3& x_B, double radius, double least, const Vec3& n_A) const HD_RT;
  /** Along n_A from x_B to p_A on the tool. */
  bool keep(const Vec3& x_B, const Vec3& p_A, const Vec3& n_A, double gap, std::uint32_t feature) HD_RT;
  /** What else of a hollow tool is about a place of a ridge, seen from `within`: both sides of its corner. */
  void addFurther(const Ridge& ridge, const Vec3& x_B, const Vec3& within, const Vec3& first,
                  std::uint32_t feature) HD_RT;
  /** Whether it touches there, with a normal of that edge or, at its end, of a peak. */
  bool add(const Ridge& ridge, std::uint32_t triangle, std::uint32_t corner, double t, std::uint32_t j) HD_RT;
  /** The mantle of a cylinder meets the ridge in one place, or its ends, where they are peaks. */
  void addMantle(const Ridge& ridge, std::uint32_t triangle, std::uint32_t corner) HD_RT;
  /** One of the parts of a ridge. */
  void searchPart(const Ridge& ridge, std::uint32_t t, std::uint32_t corner, std::uint32_t part,
                  std::uint32_t parts) HD_RT;
  /** A ridge, its gap no less than `least`. */
  void search(std::uint32_t t, std::uint32_t corner, double least) HD_RT;
  /** A part of the tree, or a ridge, in that box comes in its turn, if the tool may be near to it. */
  void wait(const Vec3& middle, const Vec3& half, std::uint32_t child, std::uint32_t count) HD_RT;
  void lookInto(const Part& part) HD_RT;
  void run() HD_RT;
};

double SceneContacts::RidgeSearch::gapAt(const Vec3& x_B, double reach) HD_RT {
  query = {};
  query.x = X_AB * x_B;
  if (made_of_mesh) query.reach = reach;
  query.limit = purse.left();
  const bool found = nearestOnShape(held.shape, query, nearest) == NearestResult::kFound;
  purse.report.work += query.work;
  if (!found) return static_cast<double>(INFINITY);
  const double gap = std::sqrt(nearest.squared_distance);
  return nearest.isInside(query.x) ? -gap : gap;
}

bool SceneContacts::RidgeSearch::isTold(const Vec3& x_B, double radius, double least, const Vec3& n_A) const HD_RT {
  if (!(radius < apart)) return false;
  const Vec3 x_W = obstacle.X_WO * x_B, n_W = held.X_WO.q * n_A;
  for (std::uint32_t i = 0; i < own.found_.count; ++i) {
    const Contact& contact = own.found_.contact[i];
    if (own.body_of_[i] == k && -contact.depth <= least + ContactModel::kLeastReach &&
        contact.n_W.dot(n_W) > kSameWay && (contact.p_WB - x_W).norm() + radius < apart)
      return true;
  }
  return false;
}

bool SceneContacts::RidgeSearch::keep(const Vec3& x_B, const Vec3& p_A, const Vec3& n_A, double gap,
                                      std::uint32_t feature) HD_RT {
  Contact contact;
  contact.n_W = held.X_WO.q * n_A;
  contact.p_WA = held.X_WO * p_A;
  contact.p_WB = obstacle.X_WO * x_B;
  contact.depth = -gap;
  contact.feature_a = feature;
  if (!isFinite(contact.n_W) || !isFinite(contact.p_WA)) return false;
  own.keep(contact, held, k);
  ++many;
  purse.report.touching += gap <= 0 ? 1 : 0;
  return true;
}

void SceneContacts::RidgeSearch::addFurther(const Ridge& ridge, const Vec3& x_B, const Vec3& within, const Vec3& first,
                                            std::uint32_t feature) HD_RT {
  Walls walls;
  const Vec3 x_A = X_AB * x_B;
  const std::uint32_t count = furtherWalls(held.shape, X_AB * within, -first, 1, margin + 2 * kInset, purse, walls);
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3 n_A = -walls[i].out;
    const double gap = n_A.dot(walls[i].surface - x_A);
    if (!(gap <= margin) || !ridge.leansOut(X_AB.q.conjugate() * n_A) || isTold(x_B, 0, gap, n_A)) continue;
    (void)keep(x_B, walls[i].surface, n_A, gap,
               kFirstRidge + (feature - kFirstRidge + (i + 1) * kRidges / 3) % kRidges);
  }
}

bool SceneContacts::RidgeSearch::add(const Ridge& ridge, std::uint32_t triangle, std::uint32_t corner, double t,
                                     std::uint32_t j) HD_RT {
  const double length = ridge.length(), reach = std::max(kReach, margin);
  double inset = std::min(kInset, 0.25 * length), gap_inset = gapAt(ridge.at(t) - inset * ridge.out, reach);
  if (gap_inset < 0 && gap_inset > -2 * kToSide) {  // Barely inside, the normal is unreliable: look from farther out.
    inset *= 1.25;
    if (t > 0 && t < 1)
      t = nearestBeside(t, length, [&](double at) HD_RT { return gapAt(ridge.at(at) - inset * ridge.out, reach); });
    gap_inset = gapAt(ridge.at(t) - inset * ridge.out, reach);
  }
  const Vec3 x_B = ridge.at(t);
  if (!(gap_inset <= margin + 2 * inset)) return false;
  Vec3 n_A = normal(gap_inset), p_A = nearest.point;
  if (nearest.kind == FeatureKind::kVertex && own.isToldAsPoint(p_A, held, obstacle, purse)) return false;
  double gap = n_A.dot(p_A - X_AB * x_B);
  if (!(gap <= margin)) return false;
  if (t == 0 || t == 1) {
    const std::uint32_t end = t > 0 ? (corner + 1) % 3 : corner;
    const auto isMet = [&](const Vec3& edge) HD_RT {
      const double up = gapAt(x_B + std::min(1.0, kUp / edge.norm()) * edge, reach);
      return up < gap && normal(up).dot(n_A) > kSameWay;
    };
    if (!isPeak(mesh, triangle, end, X_AB.q.conjugate() * n_A, purse.report.work, isMet)) return false;
  } else if (const Vec3 along = X_AB.q * (ridge.to - ridge.from); std::abs(n_A.dot(along)) > kAlong * length) {
    const auto look = [&](double shift, Vec3& n, Vec3& p) HD_RT {
      const double beside = gapAt(ridge.at(t + shift / length) - inset * ridge.out, kReach);
      n = normal(beside);
      p = nearest.point;
      return beside;
    };
    const Crossing crossing = crossingAt(X_AB * x_B, along / length, look);
    if (!crossing.found) return false;
    n_A = crossing.n_A;
    gap = crossing.gap;
    p_A = X_AB * x_B + gap * n_A;
  }
  if (isAboutAxis(held.shape) && isOnMantle(held.shape, p_A, n_A) &&
      isMantles(held.shape, {ridge.from, ridge.to, 0, true}, X_AB, Vec3::Zero()))
    return false;
  const Vec3 n_B = X_AB.q.conjugate() * n_A;
  if (!ridge.leansOut(n_B)) return false;
  if (isTold(x_B, 0, gap, n_A)) return true;
  const std::uint32_t feature = kFirstRidge + (9 * triangle + 3 * corner + j) % kRidges;
  if (!keep(x_B, p_A, n_A, gap, feature)) return false;
  if (!own.points_.isConvex() && gap_inset > 0) addFurther(ridge, x_B, x_B - inset * ridge.out, n_A, feature);
  return true;
}

void SceneContacts::RidgeSearch::addMantle(const Ridge& ridge, std::uint32_t triangle, std::uint32_t corner) HD_RT {
  const std::uint32_t next = (corner + 1) % 3;
  const std::uint32_t from = mesh.triangles[triangle][corner], to = mesh.triangles[triangle][next];
  for (const std::uint32_t feature : {meshEdgeFeature(triangle, corner), peakFeature(from), peakFeature(to)}) {
    Contact contact;
    if (feature == 0 || own.isFound(k, feature, own.found_.count)) continue;
    if (!meetsMantle(held, obstacle, feature, Vec3::Zero(), margin, contact)) continue;
    const Vec3 n_B = obstacle.X_WO.q.conjugate() * contact.n_W;
    if (!ridge.leansOut(n_B)) continue;
    if (feature < kFirstMeshEdge) {
      const std::uint32_t end = feature == peakFeature(to) ? next : corner;
      const auto isMet = [](const Vec3&) HD_RT { return true; };
      if (!isPeak(mesh, triangle, end, n_B, purse.report.work, isMet)) continue;
    }
    own.keep(contact, held, k);
    ++many;
    purse.report.touching += contact.depth >= 0 ? 1 : 0;
  }
}

void SceneContacts::RidgeSearch::searchPart(const Ridge& ridge, std::uint32_t t, std::uint32_t corner,
                                            std::uint32_t part, std::uint32_t parts) HD_RT {
  const double length = ridge.length() / parts, inset = std::min(kInset, 0.25 * ridge.length());
  const double reach = 0.5 * length + std::max(kReach, margin), aside = inset / ridge.length();
  const Vec3 within = inset * ridge.out;
  const auto along = [&](double at) HD_RT { return gapAt(ridge.at((part + at) / parts) - within, reach); };
  const auto normalHere = [&](double gap) HD_RT { return normal(gap); };
  const EdgeSpan span =
      touchingSpan(margin + 2 * inset, std::max(kAslant, own.reach_), length, X_AB.q * -within, along, normalHere);
  for (int j = 0; j < 3; ++j) {
    const double at = (part + span.place[j]) / parts;
    const double snapped = at < aside ? 0 : (1 - at < aside ? 1 : at);
    const auto number = static_cast<std::uint32_t>(j) + 9 * mesh.triangle_count * part;
    if (!span.has(j)) continue;
    const bool crosses =
        snapped != at && at > 0 && at < 1 &&
        std::abs(normal(along(span.place[j])).dot(X_AB.q * (ridge.to - ridge.from))) < kAcross * ridge.length();
    if (crosses && add(ridge, t, corner, at, number)) continue;
    if (!add(ridge, t, corner, snapped, number) && snapped != at && !crosses) add(ridge, t, corner, at, number);
  }
}

void SceneContacts::RidgeSearch::search(std::uint32_t t, std::uint32_t corner, double least) HD_RT {
  Ridge ridge;
  (void)ridgeOf(mesh, t, corner, facing, sheet, ridge);
  const double length = ridge.length();
  const double gap = gapAt(ridge.at(0.5), 0.5 * length + std::max(kReach, margin));
  const bool brief = length < kBrief * apart;
  if (isTold(ridge.at(0.5), brief ? 0 : 0.5 * length, least, normal(gap))) return;  // By what was found meanwhile.
  if (isAboutAxis(held.shape)) addMantle(ridge, t, corner);
  const std::uint32_t parts = partsFor(own.points_, length);
  for (std::uint32_t part = 0; part < parts && !purse.empty(); ++part) searchPart(ridge, t, corner, part, parts);
}

void SceneContacts::RidgeSearch::wait(const Vec3& middle, const Vec3& half, std::uint32_t child,
                                      std::uint32_t count) HD_RT {
  purse.report.work += kLook;
  const double radius = half.norm();
  Tangent tangent;
  double least = 0;
  if (made_of_mesh) {
    const double gap = gapAt(middle, radius + std::max(kReach, margin));
    least = gap - radius;
    tangent = {nearest.point, normal(gap)};
  } else {
    tangent = tangentNear(held.shape, X_AB * middle);
  }
  if (own.points_.isConvex() && least <= margin) {  // None of its points is beyond the plane,
    const Vec3 n_B = X_AB.q.conjugate() * tangent.in;
    double highest = n_B.dot(middle) + half.dot(n_B.cwiseAbs());
    if (count > 0 && count != Part::kRidgePart) {  // and none of a leaf beyond its corners.
      highest = -INFINITY;
      for (std::uint32_t t = child; t < child + count; ++t) {
        for (int c = 0; c < 3; ++c) highest = std::max(highest, n_B.dot(mesh.vertex(t, c)));
      }
    }
    const double under = tangent.in.dot(tangent.on - X_AB.p) - highest;
    least = made_of_mesh ? std::max(least, under) : under;
  }
  if (least <= margin && !isTold(middle, radius, least, tangent.in)) queue.push(least, child, count);
}

void SceneContacts::RidgeSearch::lookInto(const Part& part) HD_RT {
  if (part.count == Part::kRidgePart) {
    search(part.child / 3, part.child % 3, static_cast<double>(part.key));
  } else if (part.count == 0) {
    const hd_bvh_node& node = mesh.nodes[part.child];
    ++purse.report.work;
    for (std::uint32_t i = 0; i < node.used; ++i) {
      const Vec3 lower(node.lower[0][i], node.lower[1][i], node.lower[2][i]);
      const Vec3 upper(node.upper[0][i], node.upper[1][i], node.upper[2][i]);
      wait(0.5 * (lower + upper), 0.5 * (upper - lower), node.child[i], node.count[i]);
    }
  } else {
    for (std::uint32_t t = part.child; t < part.child + part.count; ++t) {
      ++purse.report.work;
      Ridge ridge;
      for (std::uint32_t corner = 0; corner < 3; ++corner) {
        if (ridgeOf(mesh, t, corner, facing, sheet, ridge))
          wait(ridge.at(0.5), 0.5 * (ridge.to - ridge.from).cwiseAbs(), 3 * t + corner, Part::kRidgePart);
      }
    }
  }
}

/**
 * The tree's parts come in the order of how near to the tool they may be, so the deepest ridge is found first; what is
 * near to a contact that says the same, a point's of the tool or a ridge's, is passed over.
 */
void SceneContacts::RidgeSearch::run() HD_RT {
  queue.push(-INFINITY, 0, 0);
  const std::uint32_t end = purse.report.work + kWork;
  for (Part part; many < kMostFound && purse.report.work < end && !purse.empty() && queue.pop(part);) lookInto(part);
}

bool SceneContacts::isBehind(const CollideRequest::Obstacle& sheet) const HD_RT {
  const auto isIt = [&](const Sided& at) HD_RT { return at.slot == sheet.slot && at.side < 0; };
  return std::any_of(side_.begin(), side_.begin() + points_.count(), isIt);
}

void SceneContacts::tryRidges(std::uint32_t k, const CollideRequest::Held& held, Purse& purse) HD_RT {
  const Shape& obstacle = held.obstacle[k].shape;
  if (obstacle.kind != ShapeKind::kMesh || !isFirm(obstacle) || (whole_ >> k & 1) != 0) return;
  if (held.shape.kind == ShapeKind::kMesh && (held.shape.mesh->flags & HD_MESH_CLOSED) == 0) return;
  if (held.shape.kind == ShapeKind::kSphere) return;  // Its one point tells what is nearest, and further walls.
  if (obstacle.mesh->neighbours == nullptr || obstacle.mesh->node_count == 0) return;
  RidgeSearch{.own = *this, .held = held, .k = k, .purse = purse}.run();
}

}  // namespace hapticd
