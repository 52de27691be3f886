#include "rt/body/contact_model.h"

#include <algorithm>
#include <limits>

namespace hapticd {
namespace {

/** Two contacts whose normals are at right angles count as far apart as two places this far from each other [m]. */
constexpr double kNormalLength = 0.02;

double weight(const Contact& contact, double reach) HD_RT {
  const double gap = std::max(0.0, -contact.depth) / reach;
  return 1 / (1 + gap * gap * gap * gap);
}

/** How much farther from the others a contact counts that was among them before, squared: what rests keeps its set. */
constexpr double kStay = 4;

/** What is deeper than a contact chosen, by more than what rests may be, counts as so much farther from it: that one
 * does not stand for it. */
constexpr double kDeeperApart = 100;

/** How little y, which was chosen, stands for x; squared [m^2]. */
double apart(const Contact& x, const Contact& y) HD_RT {
  const double deeper = kDeeperApart * std::max(0.0, x.depth - y.depth - ContactModel::kLeastReach);
  return (x.p_WA - y.p_WA).squaredNorm() + kNormalLength * kNormalLength * (x.n_W - y.n_W).squaredNorm() +
         deeper * deeper;
}

void toFloats(const Vec3& x, float (&out)[3]) HD_RT {
  for (int i = 0; i < 3; ++i) out[i] = static_cast<float>(x[i]);
}

Vec3 fromFloats(const float (&x)[3]) HD_RT { return {x[0], x[1], x[2]}; }

std::uint32_t keyOf(std::uint32_t body, std::uint32_t feature) HD_RT {
  return (body << 24) | ((feature + 1) & 0xffffffu);
}

}  // namespace

bool ContactModel::has(std::uint32_t key) const HD_RT {
  return std::any_of(point.begin(), point.begin() + count, [key](const Point& p) { return p.key == key; });
}

void ContactModel::build(const ContactSet& found, const Pose& X_WA, std::span<const ContactBody> bodies, double reach,
                         std::span<const std::uint8_t> body_of, std::span<const double> reach_of,
                         std::uint32_t always) HD_RT {
  const std::span<const Contact> all = found.contacts();
  const std::size_t n = std::min<std::size_t>(all.size(), kMaxContacts);
  std::array<double, kMaxContacts> distance;
  distance.fill(std::numeric_limits<double>::infinity());
  std::array<double, kMaxContacts> importance;
  std::array<std::uint32_t, kMaxContacts> key;
  const Pose X_AW = X_WA.inverse();
  std::size_t next = 0;
  double deepest = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t b = i < body_of.size() ? body_of[i] : 0;
    key[i] = b < bodies.size() ? keyOf(bodies[b].number, all[i].feature_a) : 0;
    const bool stays = has(key[i]);
    importance[i] =
        weight(all[i], std::max(i < reach_of.size() ? reach_of[i] : reach, kLeastReach)) * (stays ? kStay : 1);
    const double depth = all[i].depth + (stays ? kLeastReach : 0);
    if (depth > deepest) {
      deepest = depth;
      next = i;
    }
  }
  count = 0;
  while (count < kMaxTouches && count < n) {
    const Contact& chosen = all[next];
    const std::size_t b = next < body_of.size() ? body_of[next] : 0;
    if (b >= bodies.size()) break;
    const Pose X_BW = bodies[b].X_WB.inverse();
    Point& to = point[count++];
    const Vec3 n_B = X_BW.q * chosen.n_W;
    toFloats(X_AW * chosen.p_WA, to.p_A);
    toFloats(n_B, to.n_B);
    to.offset = static_cast<float>(n_B.dot(X_BW * chosen.p_WB));
    to.key = key[next];
    distance[next] = -1;
    for (std::size_t i = 0; i < n; ++i) {
      if (distance[i] >= 0) distance[i] = std::min(distance[i], apart(all[i], chosen));
    }
    const auto worth = [&](std::size_t i) HD_RT {
      const bool stays = distance[i] >= 0 && all[i].feature_a == always;
      return stays ? std::numeric_limits<double>::infinity() : distance[i] * importance[i];
    };
    next = 0;
    for (std::size_t i = 1; i < n; ++i) {
      if (worth(i) > worth(next)) next = i;
    }
    if (distance[next] < 0) break;
  }
}

Touch ContactModel::touch(std::uint32_t i, const Pose& X_WA, const Vec3& com_W, const Pose& X_WB,
                          const Twist& V_WB) const HD_RT {
  const Point& from = point[i];
  const Vec3 a = X_WA * fromFloats(from.p_A);
  const Vec3 n_B = fromFloats(from.n_B).normalized();
  Touch to;
  to.n = X_WB.q * n_B;
  to.gap = to.n.dot(a - X_WB.p) - from.offset;
  to.r_a = a - com_W;
  to.moving = V_WB.v + V_WB.w.cross(a - X_WB.p);  // velocity of B's surface at A's point
  to.key = from.key;
  return to;
}

}  // namespace hapticd
