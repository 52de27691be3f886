// Of touches between two faces those are left out of a step that the others imply. Where boxes lie on boxes each finds
// up to fourteen, and the corners of what they cover are enough: with all of them the sweeps that a tick has did not do
// for six boxes.
#include <algorithm>
#include <cmath>

#include "rt/body/joint_step.h"

namespace hapticd {
namespace {

constexpr double kSameNormal = 1e-6;  ///< One minus the cosine: 1.4 mrad.
constexpr std::uint32_t kLeast = 4;   ///< Of a group: a triangle implies nothing of its corners.
constexpr double kSameGap = 1e-6;     ///< A gap may be so much narrower than the others imply [m].
constexpr double kSameSpeed = 1e-9;   ///< What is moved beside its body faster than that moves by itself [m/s].

/** A touch in the plane that a group of them shares. */
struct Spot {
  double x = 0, y = 0;
  double gap = 0;  ///< By which the step may close it against what stands: below zero it must open.
  std::uint32_t touch = 0;
};

/** The slot of what does not move by being touched: ContactModel::Point::body(). */
std::uint64_t slotOf(const Touch& touch) HD_RT { return touch.key >> 24 & 0xff; }

/** Twice the area of a triangle, positive where it turns left. */
double area(const Spot& a, const Spot& b, const Spot& c) HD_RT {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/** Their convex hull by a monotone chain (Andrew 1979), with what lies along its sides left out; sorts `spots`. */
std::uint32_t hullOf(std::span<Spot> spots, std::span<Spot> hull) HD_RT {
  std::sort(spots.begin(), spots.end(),
            [](const Spot& a, const Spot& b) HD_RT { return a.x < b.x || (a.x == b.x && a.y < b.y); });
  std::uint32_t n = 0;
  const auto chain = [&](const Spot& spot, std::uint32_t begun) HD_RT {
    while (n >= begun + 2 && !(area(hull[n - 2], hull[n - 1], spot) > 0)) --n;
    hull[n++] = spot;
  };
  for (const Spot& spot : spots) chain(spot, 0);
  const std::uint32_t upper = n - 1;
  for (std::size_t i = spots.size() - 1; i-- > 0;) chain(spots[i], upper);
  return n - 1;
}

/** Whether what the corners may close implies what this one may: how far two planes near each other is linear. */
bool isImplied(const Spot& spot, std::span<const Spot> hull) HD_RT {
  for (std::size_t i = 1; i + 1 < hull.size(); ++i) {
    const double whole = area(hull[0], hull[i], hull[i + 1]);
    const double a = area(spot, hull[i], hull[i + 1]), b = area(hull[0], spot, hull[i + 1]);
    const double c = whole - a - b;
    if (std::min({a, b, c}) < -1e-9 * whole) continue;
    return spot.gap > (a * hull[0].gap + b * hull[i].gap + c * hull[i + 1].gap) / whole - kSameGap;
  }
  return false;
}

}  // namespace

/** Whether both are between the same two things, which meet face to face there. */
bool JointStep::isOfSameFaces(std::uint32_t i, std::uint32_t j) const HD_RT {
  const Pair p = pair_[i], q = pair_[j];
  const bool same = p.a == q.a && p.b == q.b;
  if (!same && !(p.a == q.b && p.b == q.a)) return false;
  if (p.b == kFixed && slotOf(touch_[i]) != slotOf(touch_[j])) return false;
  const Vec3 moving = same ? touch_[j].moving : Vec3(-touch_[j].moving);
  if (p.b != kFixed && !(same && slotOf(touch_[i]) == slotOf(touch_[j])) &&
      (touch_[i].moving - moving).norm() > kSameSpeed) {
    return false;  // Parts of one body, moved differently.
  }
  if (touch_[i].friction != touch_[j].friction || touch_[j].give > 0) return false;
  const double along = touch_[i].n.dot(touch_[j].n);
  return 1 - (same ? along : -along) < kSameNormal;
}

void JointStep::leaveOutImplied() HD_RT {
  const auto placeOf = [this](std::uint32_t i) HD_RT {
    const Mover& a = mover_[pair_[i].a];
    return Vec3(touch_[i].r_a + (a.tool != nullptr ? a.tool->body().com() : a.body->body.com()));
  };
  std::array<bool, kMaxJointTouches> seen{}, out{};
  std::array<Spot, kMaxJointTouches> spot;
  std::array<Spot, kMaxJointTouches + 1> hull;
  for (std::uint32_t i = 0; i < touches_; ++i) {
    if (seen[i] || touch_[i].give > 0) continue;
    const Vec3 x = touch_[i].n.unitOrthogonal(), y = touch_[i].n.cross(x);
    std::uint32_t n = 0;
    for (std::uint32_t j = i; j < touches_; ++j) {
      if (seen[j] || !isOfSameFaces(i, j)) continue;
      seen[j] = true;
      const Vec3 at = placeOf(j);
      const double closes = std::max(touch_[j].gap, -dt_ * touch_[j].separate);  // By no more than that.
      const double gap = closes - dt_ * touch_[j].moving.dot(touch_[j].n);
      if (isFinite(at) && std::isfinite(gap)) spot[n++] = {x.dot(at), y.dot(at), gap, j};
    }
    if (n < kLeast) continue;
    const std::uint32_t corners = hullOf({spot.data(), n}, hull);
    for (const Spot& s : std::span(spot).first(n)) out[s.touch] = isImplied(s, {hull.data(), corners});
    for (const Spot& s : std::span(hull).first(corners)) out[s.touch] = false;
  }
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < touches_; ++i) {
    if (out[i]) continue;
    touch_[kept] = touch_[i];
    pair_[kept++] = pair_[i];
  }
  touches_ = kept;
}

}  // namespace hapticd
