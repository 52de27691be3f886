#include "rt/body/joint_step.h"

#include <algorithm>
#include <limits>

#include "rt/body/constraint_response.h"

namespace hapticd {
namespace {

constexpr double kRoundingOff = 1e-12;  ///< [J]

}  // namespace

void JointStep::begin(double dt, const Vec3& gravity) HD_RT {
  dt_ = dt;
  gravity_ = gravity;
  movers_ = touches_ = rounds_ = work_ = dropped_ = 0;
  joined_ = false;
  residual_ = 0;
}

std::uint8_t JointStep::add(Tool& tool, const Pose& device, ToolStep& out) HD_RT {
  Mover& m = mover_[movers_];
  m.tool = &tool;
  m.body = nullptr;
  m.out = &out;
  tool.kick(device, dt_, m.kick);
  m.mobility = m.kick.mobility;
  m.V = m.kick.free;
  return static_cast<std::uint8_t>(movers_++);
}

std::uint8_t JointStep::add(FreeBody& body) HD_RT {
  Mover& m = mover_[movers_];
  m.tool = nullptr;
  m.body = &body;
  m.out = nullptr;
  m.mobility = Mobility::free(body.body.mass(), body.body.inertia());
  m.V = body.freeTwist(gravity_, dt_);
  return static_cast<std::uint8_t>(movers_++);
}

bool JointStep::add(Touch touch, std::uint8_t a, std::uint8_t b) HD_RT {
  if (touches_ == kMaxJointTouches) {
    ++dropped_;
    return false;
  }
  settleTouches({&touch, 1}, dt_);
  touch_[touches_] = touch;
  pair_[touches_++] = {a, b};
  joined_ = joined_ || b != kFixed;
  return true;
}

void JointStep::startRows() HD_RT {
  for (std::uint32_t i = 0; i < touches_; ++i) {
    const Touch& touch = touch_[i];
    const Pair p = pair_[i];
    prepareRow(mobilityOf(p.a), mobilityOf(p.b), touch, dt_, row_[i]);
    lambda_[i].setZero();
    for (std::uint32_t m = 0; m < remembered_ && touch.key != 0; ++m) {
      if (memory_[m].key != touch.key) continue;
      lambda_[i] = startRow(row_[i], touch, memory_[m].impulse);
      applyPair(mobilityOf(p.a), mobilityOf(p.b), touch, row_[i].axes * lambda_[i], twistOf(p.a), twistOf(p.b));
      break;
    }
  }
}

void JointStep::sweep() HD_RT {
  const std::uint32_t leap_cost = JointLeap::costOf(movers_, touches_);
  std::uint32_t rounds = 0, next_leap = kFirstLeap;
  double changed = 0, at_leap = std::numeric_limits<double>::infinity();
  do {
    changed = 0;
    for (std::uint32_t i = 0; i < touches_; ++i) {
      const Pair p = pair_[i];
      changed = std::max(changed, relaxRow(mobilityOf(p.a), mobilityOf(p.b), touch_[i], row_[i], lambda_[i],
                                           twistOf(p.a), twistOf(p.b)));
    }
    ++rounds;
    work_ += touches_;
    if (!(changed > ConstraintResponse::kTolerance)) break;
    // Leap only while leaps help: where touches jam, so that no impulses solve them, plain sweeps go on.
    if (joined_ && rounds == next_leap && changed < at_leap &&
        work_ + leap_cost + kNextLeap * touches_ <= kMaxRelaxations) {
      leap(rounds == kFirstLeap);
      work_ += leap_cost;
      at_leap = changed;
      next_leap += kNextLeap;
    }
  } while (rounds < kMaxSweeps && work_ + touches_ <= kMaxRelaxations);
  rounds_ += rounds;
}

void JointStep::leap(bool first) HD_RT {
  for (std::uint32_t k = 0; k < movers_ && first; ++k) leap_.setMover(k, mover_[k].mobility);
  std::array<Vec3, kMaxJointTouches> lacks, next;
  for (std::uint32_t i = 0; i < touches_; ++i) {
    const Pair p = pair_[i];
    if (first) leap_.setTouch(i, touch_[i], row_[i], p.a, p.b);
    lacks[i] = -row_[i].axes.transpose() * relativeVelocity(twistOf(p.a), twistOf(p.b), touch_[i]);
    lacks[i][0] += row_[i].target - row_[i].give * lambda_[i][0];
    next[i] = lambda_[i];
  }
  leap_.solve(movers_, {touch_.data(), touches_}, {row_.data(), touches_}, {lacks.data(), touches_},
              {next.data(), touches_});
  for (std::uint32_t i = 0; i < touches_; ++i) {
    const Pair p = pair_[i];
    applyPair(mobilityOf(p.a), mobilityOf(p.b), touch_[i], row_[i].axes * (next[i] - lambda_[i]), twistOf(p.a),
              twistOf(p.b));
    lambda_[i] = next[i];
  }
}

/** Bodies that touches join get the least number among them. */
void JointStep::findIslands() HD_RT {
  for (std::uint32_t i = 0; i < movers_; ++i) mover_[i].island = static_cast<std::uint8_t>(i);
  for (std::uint32_t i = 0; i < touches_; ++i) {
    if (pair_[i].b == kFixed) continue;
    const std::uint8_t x = mover_[pair_[i].a].island;
    const std::uint8_t y = mover_[pair_[i].b].island;
    for (std::uint32_t k = 0; k < movers_; ++k) {
      if (mover_[k].island == std::max(x, y)) mover_[k].island = std::min(x, y);
    }
  }
}

/** What a tool's touches came to. What a body does to it counts as the work of something that moves. */
void JointStep::tell() HD_RT {
  for (std::uint32_t k = 0; k < movers_; ++k) {
    if (mover_[k].tool == nullptr) continue;
    ToolStep& out = *mover_[k].out;
    out.contact = Wrench{};
    out.obstacle_work.setZero();
    out.touching = 0;
    out.residual = residual_;
    out.rounds = rounds_;
  }
  for (std::uint32_t i = 0; i < touches_; ++i) {
    const Mover& a = mover_[pair_[i].a];
    if (a.tool == nullptr || lambda_[i].isZero(0)) continue;
    const Vec3 j = row_[i].axes * lambda_[i];
    const Vec3 moving = touch_[i].moving + velocityAt(twistOf(pair_[i].b), touch_[i].r_b);
    ++a.out->touching;
    a.out->contact.force += j / dt_;
    a.out->contact.torque += touch_[i].r_a.cross(j) / dt_;
    if (a.out->clamped > 0) a.out->obstacle_work += j.cwiseProduct(moving);  // What was stopped was not moved.
  }
  // Velocities that the books have scaled are none of those impulses, and the reserve is shared. What the tool has of
  // either others have brought: the guard would take it for more than the hand gave.
  for (std::uint32_t k = 0; k < movers_; ++k) {
    if (mover_[k].tool == nullptr) continue;
    ToolStep& out = *mover_[k].out;
    const double lacks = mover_[k].brought - out.obstacle_work.sum();
    if (lacks > kRoundingOff) out.obstacle_work += byAxis(lacks, out.contact.force);
  }
}

void JointStep::solve() HD_RT {
  still_ = Twist{};
  leaveOutImplied();
  startRows();
  sweep();
  remembered_ = touches_;
  for (std::uint32_t i = 0; i < touches_; ++i) {
    const Pair p = pair_[i];
    residual_ = std::max(residual_, lacking(row_[i], touch_[i], lambda_[i], twistOf(p.a), twistOf(p.b)));
    memory_[i] = {touch_[i].key, row_[i].axes * lambda_[i]};
  }
  findIslands();
  settleIslands();
  tell();
}

}  // namespace hapticd
