// The books of each island: what a solution may keep of its velocities, so that no energy comes from nowhere.
#include <algorithm>

#include "rt/body/joint_step.h"
#include "rt/body/share_search.h"

namespace hapticd {
namespace {

constexpr double kMostSqueezed = 4;  // A wedge of 14 degrees; twice what a bat gives that nothing brakes.

}  // namespace

double JointStep::reserveOf(std::uint8_t island) const HD_RT {
  double pool = 0;
  for (std::uint32_t k = 0; k < movers_; ++k) {
    const Mover& m = mover_[k];
    if (m.island == island) pool += m.tool != nullptr ? m.tool->reserve() : m.body->reserve;
  }
  return pool;
}

/**
 * Work of what moves as told, by itself or beside its body. Between two that close no motion of a body is one that both
 * allow: impulses grow without end, and where such a press lets go it would fling the body at any speed, as if it were
 * infinitely strong. So it brings bodies to no more than kMostSqueezed times its own speed.
 */
double JointStep::givenTo(std::uint8_t island) const HD_RT {
  const auto isTool = [&](std::uint8_t mover) HD_RT { return mover != kFixed && mover_[mover].tool != nullptr; };
  double given = 0, fastest = 0;
  bool on_hand = false;
  for (std::uint32_t i = 0; i < touches_; ++i) {
    if (!joins(i, island)) continue;
    on_hand = on_hand || (lambda_[i][0] > 0 && (isTool(pair_[i].a) || isTool(pair_[i].b)));
    given += (row_[i].axes * lambda_[i]).dot(touch_[i].moving);
    fastest = std::max(fastest, touch_[i].moving.norm());
  }
  if (!(given > 0) || on_hand) return given;  // A hand takes out of the press what its tool gets.
  double mass = 0, kinetic = 0;
  for (std::uint32_t k = 0; k < movers_; ++k) {
    if (mover_[k].island != island || mover_[k].body == nullptr) continue;
    mass += mover_[k].body->body.mass();
    kinetic += mover_[k].body->body.kineticEnergy();
  }
  const double most = kMostSqueezed * fastest;
  return std::min(given, std::max(0.0, 0.5 * mass * most * most - kinetic) + mass * gravity_.norm() * most * dt_);
}

/** Moves all by that share of their velocities, into moved_. What energy grew by, without the work of weights. */
double JointStep::gained(std::uint8_t island, double share) HD_RT {
  double sum = 0;
  for (std::uint32_t k = 0; k < movers_; ++k) {
    const Mover& m = mover_[k];
    if (m.island != island) continue;
    Tool::Move& to = moved_[k];
    const Twist V{m.V.v * share, m.V.w * share};
    if (m.tool != nullptr) {
      m.tool->move(m.kick, V, to);
    } else {
      const RigidBody& from = m.body->body;
      to.body = from;
      to.body.setTwist(V);
      to.body.drift(dt_);
      to.gained =
          to.body.kineticEnergy() - from.kineticEnergy() - m.body->weightOf(gravity_).dot(to.body.com() - from.com());
    }
    sum += to.gained;
  }
  return sum;
}

bool JointStep::leavesOverlap(std::uint8_t island) const HD_RT {
  for (std::uint32_t i = 0; i < touches_; ++i) {
    if (joins(i, island) && touch_[i].separate > 0 && lambda_[i][0] > 0) return true;
  }
  return false;
}

/** False: it has waited for nothing yet, and is to wait. */
bool JointStep::settle(std::uint8_t island, bool may_wait) HD_RT {
  double scale = 1;
  std::uint32_t members = 0;
  for (std::uint32_t k = 0; k < movers_; ++k) {
    Mover& m = mover_[k];
    if (m.island != island) continue;
    ++members;
    if (!isFinite(m.V.v) || !isFinite(m.V.w)) m.V = Twist{};
    scale = std::min(scale, scaleToBound(m.V));
  }
  if (members == 0) return true;
  const double pool = reserveOf(island);
  double given = givenTo(island);
  double lost = 0;
  ShareSearch search(scale);
  do {
    scale = search.share();
    if (search.stopped()) given = 0;
    lost = given - gained(island, scale);
    if (may_wait && lost < -pool) return false;
  } while (search.next(-pool - lost));
  double held = 0;
  for (std::uint32_t i = 0; i < touches_; ++i) {
    if (!joins(i, island)) continue;
    const Vec3 u = relativeVelocity(twistOf(pair_[i].a), twistOf(pair_[i].b), touch_[i]);
    held += heldBy(touch_[i], dt_ * u.dot(touch_[i].n));
  }
  const double left = std::clamp(pool + lost, 0.0, members * Tool::kMostReserve + held) / members;
  for (std::uint32_t k = 0; k < movers_; ++k) {
    Mover& m = mover_[k];
    if (m.island != island) continue;
    m.V = {m.V.v * scale, m.V.w * scale};
    if (m.tool != nullptr) {
      m.brought = moved_[k].gained + left - m.tool->reserve();
      m.tool->accept(m.kick, moved_[k], left, *m.out);
      m.out->lost = lost;
      m.out->clamped = scale;
    } else {
      m.body->body = moved_[k].body;
      m.body->reserve = left;
    }
  }
  return true;
}

/** Of islands that wait: velocities and impulses that keep overlaps as they are. Goes on from those that leave them. */
void JointStep::solveWithoutRecovery() HD_RT {
  for (std::uint32_t k = 0; k < movers_; ++k) whole_.V[k] = mover_[k].V;
  std::copy_n(lambda_.begin(), touches_, whole_.lambda.begin());
  for (std::uint32_t i = 0; i < touches_; ++i) {
    if (mover_[pair_[i].a].waits && touch_[i].separate > 0) row_[i].target = std::min(row_[i].target, 0.0);
  }
  sweep();
  for (std::uint32_t k = 0; k < movers_; ++k) {
    Mover& m = mover_[k];
    without_.V[k] = m.V;
    if (!m.waits) m.V = whole_.V[k];
  }
  for (std::uint32_t i = 0; i < touches_; ++i) {
    without_.lambda[i] = lambda_[i];
    if (!mover_[pair_[i].a].waits) lambda_[i] = whole_.lambda[i];
  }
}

/** As much of the recovery as the books allow. Friction's cones allow a mean of impulses that they allow. */
void JointStep::mixIn(std::uint8_t island) HD_RT {
  const double pool = reserveOf(island);
  double lost = 0;
  ShareSearch search(1);
  do {
    const double share = search.share();
    for (std::uint32_t k = 0; k < movers_; ++k) {
      Mover& m = mover_[k];
      if (m.island != island) continue;
      m.V.v = without_.V[k].v + share * (whole_.V[k].v - without_.V[k].v);
      m.V.w = without_.V[k].w + share * (whole_.V[k].w - without_.V[k].w);
    }
    for (std::uint32_t i = 0; i < touches_; ++i) {
      if (joins(i, island)) lambda_[i] = without_.lambda[i] + share * (whole_.lambda[i] - without_.lambda[i]);
    }
    lost = givenTo(island) - gained(island, 1);
  } while (search.next(-pool - lost));
}

void JointStep::settleIslands() HD_RT {
  bool wait = false;
  for (std::uint32_t k = 0; k < movers_; ++k) {
    const auto island = static_cast<std::uint8_t>(k);
    const bool may_wait = work_ + touches_ <= kMaxRelaxations && leavesOverlap(island);
    mover_[k].waits = !settle(island, may_wait);
    wait = wait || mover_[k].waits;
  }
  if (!wait) return;
  for (std::uint32_t k = 0; k < movers_; ++k) mover_[k].waits = mover_[mover_[k].island].waits;
  solveWithoutRecovery();
  for (std::uint32_t k = 0; k < movers_; ++k) {
    if (!mover_[k].waits || mover_[k].island != k) continue;
    mixIn(static_cast<std::uint8_t>(k));
    (void)settle(static_cast<std::uint8_t>(k), false);
  }
}

}  // namespace hapticd
