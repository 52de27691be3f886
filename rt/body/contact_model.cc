#include "rt/body/contact_model.h"

#include <algorithm>
#include <limits>

namespace hapticd {
namespace {

/** Two contacts whose normals are at right angles count as far apart as two places this far from each other [m]. */
constexpr double kNormalLength = 0.02;

/** A contact this far from touching counts half as far from the others: what touches is chosen first [m]. */
constexpr double kGapLength = 0.0002;

double weight(const Contact& contact) HD_RT {
  const double gap = std::max(0.0, -contact.depth) / kGapLength;
  return 1 / (1 + gap * gap);
}

double apart(const Contact& x, const Contact& y) HD_RT {
  return (x.p_WA - y.p_WA).squaredNorm() + kNormalLength * kNormalLength * (x.n_W - y.n_W).squaredNorm();
}

}  // namespace

void ContactModel::build(const ContactSet& found, const Pose& X_WA, const Pose& X_WB) HD_RT {
  const std::span<const Contact> all = found.contacts();
  const std::size_t n = std::min<std::size_t>(all.size(), kMaxContacts);
  std::array<double, kMaxContacts> distance;
  distance.fill(std::numeric_limits<double>::infinity());
  std::array<double, kMaxContacts> importance;
  for (std::size_t i = 0; i < n; ++i) importance[i] = weight(all[i]);
  const Pose X_AW = X_WA.inverse();
  const Pose X_BW = X_WB.inverse();
  std::size_t next = 0;
  for (std::size_t i = 1; i < n; ++i) {
    if (all[i].depth > all[next].depth) next = i;
  }
  count = 0;
  while (count < kMaxTouches && count < n) {
    const Contact& chosen = all[next];
    Point& to = point[count++];
    to.p_A = X_AW * chosen.p_WA;
    to.p_B = X_BW * chosen.p_WB;
    to.n_B = X_BW.q * chosen.n_W;
    to.area = chosen.area;
    to.feature_a = chosen.feature_a;
    to.feature_b = chosen.feature_b;
    distance[next] = -1;
    for (std::size_t i = 0; i < n; ++i) {
      if (distance[i] >= 0) distance[i] = std::min(distance[i], apart(all[i], chosen));
    }
    next = 0;
    for (std::size_t i = 1; i < n; ++i) {
      if (distance[i] * importance[i] > distance[next] * importance[next]) next = i;
    }
    if (distance[next] < 0) break;
  }
}

std::uint32_t ContactModel::touches(const Pose& X_WA, const Vec3& com_W, const Pose& X_WB,
                                    std::span<Touch> out) const HD_RT {
  const auto n = static_cast<std::uint32_t>(std::min<std::size_t>(count, out.size()));
  for (std::uint32_t i = 0; i < n; ++i) {
    const Point& from = point[i];
    const Vec3 a = X_WA * from.p_A;
    const Vec3 b = X_WB * from.p_B;
    Touch& to = out[i];
    to = Touch{};
    to.n = X_WB.q * from.n_B;
    to.gap = to.n.dot(a - b);
    to.r_a = a - com_W;
    to.r_b = a - X_WB.p;  // where A's point is: what B's surface does there
    to.key = (std::uint64_t{from.feature_a} << 32 | from.feature_b);
  }
  return n;
}

}  // namespace hapticd
