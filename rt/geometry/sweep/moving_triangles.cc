#include "rt/geometry/sweep/moving_triangles.h"

#include <algorithm>
#include <cmath>

#include "rt/geometry/half_spaces.h"
#include "rt/geometry/sweep/sweep.h"
#include "rt/geometry/tree/box_queries.h"
#include "rt/geometry/tree/tree_walk.h"

namespace hapticd {
namespace {

constexpr double kFarther = 1.125;      // Than the longest way of a vertex: so far off a triangle may touch the point.
constexpr double kNoHeight = 1.0 / 16;  // Skins.
constexpr double kLow = 0.5;            // Skins: lower, the point is put back.
constexpr int kTries = 12;          // Reaches from which one is chosen that leaves no more than there is room for, each
constexpr double kNarrower = 0.25;  // of the one before.

double narrower(double reach, double skin) HD_RT { return std::max(kNarrower * reach, kLiesOn * skin); }

/** From x to the box about where the move's triangle is before it and after all of them, along the axes. */
double gapTo(const MeshView& mesh, const TriangleMove& move, const Vec3& x) HD_RT {
  const auto& corner = mesh.triangles[move.triangle];
  double gap = 0;
  for (int k = 0; k < 3; ++k) {
    const auto [low, high] =
        std::minmax({move.before[0][k], move.before[1][k], move.before[2][k], mesh.vertices[corner[0]][k],
                     mesh.vertices[corner[1]][k], mesh.vertices[corner[2]][k]});
    gap = std::max({gap, low - x[k], x[k] - high});
  }
  return gap;
}

}  // namespace

Corners MovingTriangles::Moving::corners() const HD_RT {
  const auto& v = move.before;
  return {{v[0][0], v[0][1], v[0][2]}, {v[1][0], v[1][1], v[1][2]}, {v[2][0], v[2][1], v[2][2]}};
}

MovingTriangles::Height MovingTriangles::Moving::height(const Vec3& x) const HD_RT {
  if (!(area > 0)) return {};
  return {normal / area, normal.dot(x - base) / area};
}

/** Made once a move: each push asks for the heights above all of them. */
void MovingTriangles::Moving::notePlane() HD_RT {
  const Corners v = corners();
  base = v.a;
  normal = v.normal();
  area = normal.norm();
}

MovingTriangles::MovingTriangles(const MeshView& mesh, std::span<const TriangleMove> moves, const Vec3& x,
                                 const Meeting& meeting) HD_RT : mesh_(mesh),
                                                                 meeting_(meeting) {
  double longest = 0;
  for (const TriangleMove& move : moves) {
    if (move.mesh != &mesh) continue;
    for (int k = 0; k < 3; ++k)
      longest = std::max(longest, std::abs(double{move.after[k]} - move.before[move.corner][k]));
  }
  reach_ = kFarther * longest + kLiesOn * meeting.skin;
  if (collect(moves, x, reach_, false)) return;
  narrow(moves, x, 3 * kMost);  // Of a triangle there may be three.
  if (collect(moves, x, reach_, false)) return;
  narrow(moves, x, kMost);
  (void)collect(moves, x, reach_, true);
}

/**
 * Where there is no room: takes back the reach till no more than `most` moves come so near. What jumps elsewhere in the
 * mesh must not make it so wide that what is here is left out. One look at each move.
 */
void MovingTriangles::narrow(std::span<const TriangleMove> moves, const Vec3& x, std::uint32_t most) HD_RT {
  std::uint32_t last[kTries] = {};  // How many moves come so near in a try, but not in the next one.
  for (const TriangleMove& move : moves) {
    if (move.mesh != &mesh_) continue;
    const double gap = gapTo(mesh_, move, x);
    int within = 0;
    for (double reach = reach_; within < kTries && gap <= reach; ++within) reach = narrower(reach, meeting_.skin);
    if (within > 0) ++last[within - 1];
  }
  int i = kTries - 1;
  for (std::uint32_t moved = last[i]; i > 1 && moved + last[i - 1] <= most; --i) moved += last[i - 1];
  for (int k = 0; k < i; ++k) reach_ = narrower(reach_, meeting_.skin);
}

/** False if there may be more than there is room for; then not `all` is gone through. */
bool MovingTriangles::collect(std::span<const TriangleMove> moves, const Vec3& x, double reach, bool all) HD_RT {
  count_ = turn_count_ = 0;
  std::fill(std::begin(place_), std::end(place_), std::uint8_t{0});
  for (const TriangleMove& move : moves) {
    if (move.mesh != &mesh_) continue;
    Moving* const moving = add(move, x, reach);
    if (moving == nullptr && count_ == kMost && !all) return false;
    if (moving == nullptr || moving->moves[move.corner]) continue;
    moving->moves[move.corner] = true;
    turns_[turn_count_++] = {mesh_.triangles[move.triangle][move.corner], static_cast<std::uint16_t>(moving - all_),
                             static_cast<std::uint16_t>(move.corner)};
  }
  return count_ < kMost;
}

/** The move's triangle, if it comes within reach and there is room for it. */
MovingTriangles::Moving* MovingTriangles::add(const TriangleMove& move, const Vec3& x, double reach) HD_RT {
  const auto& corner = mesh_.triangles[move.triangle];
  if (gapTo(mesh_, move, x) > reach) return nullptr;
  std::uint32_t at = move.triangle % (2 * kMost);
  for (; place_[at] != 0; at = (at + 1) % (2 * kMost))
    if (all_[place_[at] - 1].move.triangle == move.triangle) return &all_[place_[at] - 1];
  if (count_ == kMost) return nullptr;
  Moving& moving = all_[count_++];
  place_[at] = static_cast<std::uint8_t>(count_);
  moving = {};
  moving.move = move;
  std::copy_n(&move.before[0][0], 9, &moving.from[0][0]);
  for (int c = 0; c < 3; ++c) std::copy_n(&mesh_.vertices[corner[c]][0], 3, moving.to[c]);
  moving.notePlane();
  const double height = moving.height(x).above;
  if (!meeting_.two_sided) {
    moving.side = height >= -kNoHeight * meeting_.skin ? 1 : 0;
  } else if (std::abs(height) <= kLiesOn * meeting_.skin && meeting_.on != 0) {
    moving.side = meeting_.on;
  } else {
    moving.side = height < 0 ? -1 : 1;
  }
  return &moving;
}

/** What x may be pushed into. */
void MovingTriangles::addResting(const Vec3& x, std::uint32_t& work, std::uint32_t limit) HD_RT {
  const BoxTests& tests = boxTests();
  const BoxPoint point = boxPoint(x);
  const float bound = roundedUp(reach_ * reach_);
  (void)walkTree(
      mesh_, {work, limit},
      [&](const hd_bvh_node& node, float* key) { return tests.approach(node, point, bound, key); },
      [&] { return count_ < kMost ? bound : -1.0F; },
      [&](std::uint32_t first, std::uint32_t count) {
        for (std::uint32_t t = first; t < first + count; ++t) {
          TriangleMove rests{&mesh_, t, 0, {}, {}};
          for (int c = 0; c < 3; ++c) std::copy_n(&mesh_.vertices[mesh_.triangles[t][c]][0], 3, rests.before[c]);
          (void)add(rests, x, reach_);
        }
      });
}

bool MovingTriangles::push(Vec3& x, std::uint32_t& work, std::uint32_t limit) HD_RT {
  bool pushed = false;
  for (int step = 1; step <= kSteps; ++step) {
    for (std::uint32_t first = 0, end; first < turn_count_; first = end) {
      const Vec3 from = x;
      for (end = first; end < turn_count_ && turns_[end].vertex == turns_[first].vertex; ++end) {
        Moving& moving = all_[turns_[end].triangle];
        move(turns_[end], step);
        if (moving.side != 0) (void)overtakes(moving.move, moving.side, meeting_.skin, x);
        std::copy_n(moving.move.after, 3, moving.move.before[moving.move.corner]);
        moving.notePlane();
      }
      if (x == from) {
        for (std::uint32_t i = first; i < end; ++i) noteSide(all_[turns_[i].triangle], x);
        continue;
      }
      if (!pushed) addResting(from, work, limit);
      pushed = true;
      for (std::uint32_t i = 0; i < count_; ++i) noteSide(all_[i], x);
    }
    if (pushed) putBack(x);
  }
  if (pushed || !liesLow(x)) return pushed;
  addResting(x, work, limit);
  putBack(x);
  return true;
}

/**
 * The side of a triangle above which the point lies too low; 0 if there is none. So near a two-sided one its plane does
 * not tell: about a convex edge a point is behind the plane of a face, but not behind the face.
 */
int MovingTriangles::lowOn(const Moving& moving, const Height& height) const HD_RT {
  if (std::abs(height.above) > kLiesOn * meeting_.skin || height.normal == Vec3::Zero()) return 0;
  const int side = meeting_.two_sided ? meeting_.on : moving.side;
  return side * height.above < kLow * meeting_.skin ? side : 0;
}

/** Whether a triangle that has not pushed the point has come so near that it hardly holds it. */
bool MovingTriangles::liesLow(const Vec3& x) const HD_RT {
  return std::any_of(all_, all_ + count_, [&](const Moving& moving) {
    return lowOn(moving, moving.height(x)) != 0 && covers(moving.corners(), x);
  });
}

/** Says where the corner comes to in that step. */
void MovingTriangles::move(Turn turn, int step) HD_RT {
  Moving& moving = all_[turn.triangle];
  moving.move.corner = turn.corner;
  for (int k = 0; k < 3; ++k) {
    const double from = moving.from[turn.corner][k], to = moving.to[turn.corner][k];
    moving.move.after[k] = static_cast<float>(step == kSteps ? to : from + step * (to - from) / kSteps);
  }
}

/** On which side of the triangle the point is now, unless it is too near to tell. */
void MovingTriangles::noteSide(Moving& moving, const Vec3& x) const HD_RT {
  const double height = moving.height(x).above;
  if (std::abs(height) > kLiesOn * meeting_.skin) moving.side = height > 0 ? 1 : meeting_.two_sided ? -1 : 0;
}

/** A skin above all that it lies on, or is behind by a hair; nowhere, if there is no such place. */
void MovingTriangles::putBack(Vec3& x) HD_RT {
  HalfSpace planes[kMaxHalfSpaces];
  const Vec3 from = x;
  for (int count = 0, known = -1; count > known;) {
    known = count;
    for (std::uint32_t i = 0; i < count_ && count < kMaxHalfSpaces; ++i) {
      const Height height = all_[i].height(x);
      const int side = lowOn(all_[i], height);
      if (side == 0 || !covers(all_[i].corners(), x)) continue;
      const Vec3 out = side * height.normal;
      planes[count++] = {out, out.dot(all_[i].corners().a) + meeting_.skin};
    }
    Vec3 to = from;
    std::uint32_t active = 0;
    if (count == known || !nearestInside(planes, count, kNoHeight * meeting_.skin, to, active)) return;
    x = to;
    for (std::uint32_t i = 0; i < count_; ++i) noteSide(all_[i], x);
  }
}

}  // namespace hapticd
