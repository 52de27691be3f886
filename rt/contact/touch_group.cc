#include "rt/contact/touch_group.h"

#include <algorithm>

#include "rt/contact/detector.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kFaces = 6;

/** One contact in the making. */
struct Cluster {
  std::uint32_t key = 0;
  double area = 0, weight = 0, deepest = 0;
  Vec3 mean = Vec3::Zero(), normal = Vec3::Zero();  // Sums.

  void add(const TouchGroup& g) HD_RT {
    deepest = weight > 0 || area > 0 ? std::max(deepest, g.deepest) : g.deepest;
    area += g.area;
    weight += g.weight;
    mean += g.weight * g.mean;
    normal += g.normal;
  }
  [[nodiscard]] Vec3 place() const HD_RT { return weight > 0 ? Vec3(mean / weight) : mean; }
  [[nodiscard]] Vec3 direction() const HD_RT {
    const double n = normal.norm();
    return n > 0 ? Vec3(normal / n) : Vec3::UnitZ();
  }
};

std::uint32_t keyOf(const GroupMap& map, const TouchGroup& g, std::uint32_t up) HD_RT {
  return (map.levels() - up) << 16 | map.ancestor(g.part, up) << 3 | g.face;
}

/** Clusters at a level, 0 if they are more than `room`. Groups of a node follow one another. */
std::uint32_t byCell(const GroupMap& map, const std::vector<TouchGroup>& groups, std::uint32_t count, std::uint32_t up,
                     Cluster* out, std::uint32_t room) HD_RT {
  std::uint32_t made = 0, from = 0;  // Clusters of the node at hand begin at `from`.
  std::uint32_t node = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const TouchGroup& g = groups[i];
    const std::uint32_t here = map.ancestor(g.part, up);
    if (i == 0 || here != node) from = made;
    node = here;
    const std::uint32_t key = keyOf(map, g, up);
    std::uint32_t at = from;
    while (at < made && out[at].key != key) ++at;
    if (at == made) {
      if (made == room) return 0;
      out[made] = Cluster{};
      out[made++].key = key;
    }
    out[at].add(g);
  }
  return made;
}

}  // namespace

void GroupMap::build(const VolumeView& volume) HD_RT {
  const OctreeView& tree = volume.octree;
  std::uint32_t level = 0;
  while (level < volume.patch_level && tree.level[level + 1].node_count <= kMaxTouchGroups) ++level;
  levels_ = level + 1;
  count_ = tree.level[level].node_count;
  for (std::uint32_t i = 0; i < count_; ++i) ancestor_[level][i] = static_cast<std::uint16_t>(i);
  for (std::uint32_t l = level; l-- > 0;) {
    // The parent of a node is the last whose first child is not behind it.
    const OctreeLevel& above = tree.level[l];
    std::array<std::uint16_t, kMaxTouchGroups> parent{};
    std::uint32_t p = 0;
    for (std::uint32_t n = 0; n < tree.level[l + 1].node_count; ++n) {
      while (p + 1 < above.node_count && above.first[p + 1] <= n) ++p;
      parent[n] = static_cast<std::uint16_t>(p);
    }
    for (std::uint32_t i = 0; i < count_; ++i) ancestor_[l][i] = parent[ancestor_[l + 1][i]];
  }
  for (std::uint32_t i = 0; i < count_; ++i) {
    std::uint32_t n = i;
    for (std::uint32_t l = level; l < volume.patch_level; ++l) n = tree.level[l].first[n];
    first_[i] = n;
  }
  first_[count_] = static_cast<std::uint32_t>(volume.patches.size());
}

void cluster(const GroupMap& map, const std::vector<TouchGroup>& groups, std::uint32_t count, std::uint32_t most,
             const Pose& X_WB, ContactSet& contacts) HD_RT {
  contacts.count = 0;
  if (count == 0) return;
  constexpr std::uint32_t kRoom = kMostClusters > kFaces ? kMostClusters : kFaces;
  Cluster made[kRoom];
  std::uint32_t n = 0;
  most = std::min(most, kMostClusters);
  for (std::uint32_t up = 0; up < map.levels() && n == 0; ++up) {
    const bool top = up + 1 == map.levels();
    n = byCell(map, groups, count, up, made, top ? kRoom : std::max(most, 1u));
  }
  if (n > most) {
    std::sort(made, made + n, [](const Cluster& a, const Cluster& b) { return a.deepest > b.deepest; });
    n = most;
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    if (made[i].area == 0 && made[i].weight == 0) continue;  // Points that stand for no surface.
    Contact& c = contacts.contact[contacts.count++];
    c = Contact{};
    c.n_W = X_WB.q * made[i].direction();
    c.p_WA = X_WB * made[i].place();
    c.depth = made[i].deepest;
    c.p_WB = c.p_WA + c.depth * c.n_W;
    c.area = made[i].area;
    c.feature_a = made[i].key;
  }
}

void answer(const DetectorQuery& query, const GroupMap& map, std::vector<TouchGroup>& groups, std::uint32_t count,
            ContactSet& contacts) HD_RT {
  Wrench about_B;
  contacts.touching_area = contacts.deepest = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    about_B.force += groups[i].integral.force;
    about_B.torque += groups[i].integral.torque;
    contacts.touching_area += groups[i].area;
    contacts.deepest = i == 0 ? groups[i].deepest : std::max(contacts.deepest, groups[i].deepest);
  }
  const Pose& X_WB = query.b.X_WO;
  const Pose X_BW = X_WB.inverse();
  contacts.integral.force = X_WB.q * about_B.force;
  contacts.integral.torque = X_WB.q * Vec3(about_B.torque - (X_BW * query.a.X_WO.p).cross(about_B.force));
  cluster(map, groups, count, query.max_contacts, X_WB, contacts);
  const VolumeView& b = *query.b.volume;
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < contacts.count; ++i) {
    Contact c = contacts.contact[i];
    const auto speed = [&](const BodyState& body)
                           HD_RT { return Vec3(body.V_WO.v + body.V_WO.w.cross(c.p_WA - body.X_WO.p)); };
    const double parting = c.n_W.dot(speed(query.a) - speed(query.b));
    if (parting > 0 && parting * query.period > c.depth) continue;
    const Vec3 u = (X_BW * c.p_WB - b.originPoint()) / (b.voxel * HD_BRICK_EDGE);
    c.feature_b = 0;
    for (std::size_t k = 3; k-- > 0;) {
      const auto cell = static_cast<std::uint32_t>(std::clamp(u[static_cast<Eigen::Index>(k)], 0.0, b.cells[k] - 0.5));
      c.feature_b = c.feature_b * b.cells[k] + cell;
    }
    contacts.contact[kept++] = c;
  }
  contacts.count = kept;
}

void ContactAges::follow(ContactSet& contacts) HD_RT {
  for (std::uint32_t i = 0; i < contacts.count; ++i) {
    Contact& c = contacts.contact[i];
    for (std::uint32_t j = 0; j < count_; ++j) {
      if (feature_[j] == c.feature_a) c.age = age_[j] + 1;
    }
  }
  count_ = contacts.count;
  for (std::uint32_t i = 0; i < count_; ++i) {
    feature_[i] = contacts.contact[i].feature_a;
    age_[i] = contacts.contact[i].age;
  }
}

}  // namespace hapticd
