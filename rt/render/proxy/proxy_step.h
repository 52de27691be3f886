/** @file
 * What the parts of the proxy share while one step lasts. Of proxy*.cc only.
 */
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "rt/geometry/nearest/nearest.h"
#include "rt/render/proxy/proxy.h"

namespace hapticd {

inline constexpr double kSkin = 0x1p-40;               // Of the coordinates involved.
inline constexpr double kClearlyNearer = 1 - 0x1p-20;  // Of the present distance: ties keep the side.
inline constexpr double kNear = 1.0 / 16;              // Of the skin: differences that are rounding.
inline constexpr double kAt = 64;                      // Skins: so near, a proxy is on a surface.
inline constexpr double kDirected = 16;                // Skins from a surface: the way from it tells a direction.
inline constexpr double kMaxTurnCosine = 0.5;          // A surface's normal turns at most 60 degrees in one plan.
inline constexpr double kSettled = 0x1p-30;            // Of the depth: a smaller move is not worth another look,
inline constexpr double kSettledLate = 0x1p-20;  // and this is not, late in a step that comes nearer by ever less.

inline constexpr double kAnyLength = std::numeric_limits<double>::infinity();  // Of a way.

inline double extent(const Vec3& x) HD_RT { return x.cwiseAbs().maxCoeff(); }

/** Whether `end` is clearly farther from the goal than `at`: the spring would gain what nobody gave. */
inline bool leadsAway(const Vec3& at, const Vec3& end, const Vec3& goal) HD_RT {
  return kClearlyNearer * (end - goal).squaredNorm() > (at - goal).squaredNorm();
}

/**
 * The face of a mesh that a ball comes to which rolls toward x over the edge of a triangle that begins at `corner`, and
 * its normal. HD_NO_INDEX if it stays on the edge.
 */
std::uint32_t faceBeyondEdge(const MeshView& mesh, std::uint32_t triangle, std::uint32_t corner, const Vec3& x,
                             Vec3& normal) HD_RT;

/** The point of the object nearest to x, in its frame, within `reach`. What is visited counts as `work` of the step. */
[[nodiscard]] NearestResult nearestWithin(const SceneObject& object, const Vec3& x, double reach, Vicinity* vicinity,
                                          std::uint32_t& work, Nearest& near) HD_RT;

/** What one step works with. */
struct ProxyRenderer::Step {
  static_assert(2 * kMaxInGroove >= kMaxHalfSpaces);
  const Scene* scene = nullptr;
  Vec3 goal = Vec3::Zero();  ///< The hip,
  Vec3 v_W = Vec3::Zero();   ///< and its velocity [m/s].
  Vec3 end = Vec3::Zero();   ///< Where the proxy is thought to come to; where it is, if nothing is known.
  double scale = 0;          ///< Of the coordinates in W.
  bool together = true;      ///< The proxy is at one place in W, proxy_; else start_ holds one per object.
  bool carried = false;      ///< An object has moved since the last tick, or its vertices have moved the proxy.
  bool settled = false;      ///< The proxy is where what holds it lets it be,
  bool real = false;         ///< and each of several faces that hold it is there, not just its plane drawn out.
  bool again = false;        ///< It has not moved yet, and what held it when the last tick ended holds it.
  bool slip = false;
  bool slipped = false;  ///< Before it came to where it is.
  bool asked = false;    ///< What held the proxy where the tick began has been asked whether slip ends,
  bool judged = false;   ///< and that has been decided: the proxy has gone on.
  bool shares = false;   ///< A twist has its part of friction, and leaves these of the coefficients.
  Friction part{1, 1};
  std::uint32_t work = 0;
  std::uint32_t sweeps = 0;
  std::uint32_t turns = 0;     ///< Of the tangent planes of grooves and corners.
  bool plain = false;          ///< No ways of several parts: one has led away.
  std::uint32_t walked = 0;    ///< Faces looked at by walks from face to face, wherever these led.
  int leads = 0;               ///< Plans that led over edges of a mesh.
  int broken = 0;              ///< Ways above grooves that something stood in.
  std::uint32_t met = 0;       ///< Slot of the last surface met in this step, 0 for none.
  std::uint32_t unfelt = 0;    ///< Slot of a solid about the proxy that is swept past; 0 for none.
  std::uint32_t carrier = 0;   ///< Slot of what held the proxy in the last tick, if any object has moved; 0: none.
  std::uint32_t gathered = 0;  ///< Visited for the surroundings: counted apart, they decide nothing.
  struct {
    std::uint32_t slot = 0;
    Vicinity* vicinity = nullptr;
  } near[Surroundings::kMeshes];  ///< Asked for in this step.
  int near_count = 0;
  Vec3 hip = Vec3::Zero();            ///< The goal in the frame of the object
  std::uint32_t hip_slot = 0;         ///< in this slot, 0 for none.
  Constraint held[2 * kMaxInGroove];  ///< Behind those that hold the proxy stands what a plan has noted.
  int count = 0;
  MeshPlane sought[2];  ///< Faces on which the proxy was thought to come to lie, and something stood in its way;
  std::uint32_t sought_slot = 0;
  int sought_count = 0;       ///< or in whose hollow, which has ended.
  Support support;            ///< Of the proxy where it is,
  bool supported = false;     ///< if that has been looked at.
  Vec3 began = Vec3::Zero();  ///< Where the proxy was when the tick began.
  bool behind = false;        ///< It was not at one place then, or vertices have moved since.
  bool back = false;          ///< On the way back to a place where it was relative to one object.

  [[nodiscard]] bool isHeldBy(std::uint32_t slot) const HD_RT {
    for (int i = 0; i < count; ++i)
      if (held[i].slot == slot) return true;
    return false;
  }
  [[nodiscard]] bool passes(std::uint32_t slot, Beside beside) const HD_RT {
    const bool holds = isHeldBy(slot), has_faces = scene->slot(slot).shape.kind == ShapeKind::kMesh;
    return beside == Beside::kAllButFaces ? !(holds && has_faces) : holds && !(has_faces && beside == Beside::kHolding);
  }
  /** Whether active surfaces are of more than one object. */
  [[nodiscard]] bool isHeldBySeveral(std::uint32_t active) const HD_RT {
    if ((active & (active - 1)) == 0) return false;
    const std::uint32_t first = held[std::countr_zero(active)].slot;
    for (active &= active - 1; active != 0; active &= active - 1)
      if (held[std::countr_zero(active)].slot != first) return true;
    return false;
  }
  /** One or two faces that were sought in vain: for the groove or corner that they make with what is met. */
  void seek(std::uint32_t slot, const MeshPlane& face, const MeshPlane& other, int faces = 2) HD_RT {
    sought_slot = slot;
    sought[0] = face;
    sought[1] = other;
    sought_count = faces;
  }
  /** Whether x is, seen from the object, where the proxy was when the tick began: to go back there passes none of it.
   */
  [[nodiscard]] bool wasAt(const SceneObject& object, const Vec3& x) const HD_RT {
    const Vec3 then = object.X_WO_before.q.conjugate() * (began - object.X_WO_before.p);
    const double near = kNear * skin(object);
    return !behind && (object.toLocal(x) - then).squaredNorm() <= near * near;
  }
  /** All of them faces of meshes. */
  [[nodiscard]] bool isHeldByFaces() const HD_RT;
  void noteGone() HD_RT {
    again = false;
    slipped = slip;
    judged = asked;
  }
  /** The hip in the frame of that object: asked for several times of the same one. */
  const Vec3& hipIn(std::uint32_t slot) HD_RT {
    if (hip_slot != slot) {
      hip = scene->slot(slot).toLocal(goal);
      hip_slot = slot;
    }
    return hip;
  }
  /** Asked for before in this step; null if none is kept. */
  Vicinity* vicinity(std::uint32_t slot) const HD_RT {
    for (int i = 0; i < near_count; ++i) {
      if (near[i].slot == slot) return near[i].vicinity;
    }
    return nullptr;
  }
  double skin(const SceneObject& object) const HD_RT {
    const double size = std::isfinite(object.radius) ? object.radius : 0;
    return kSkin * (scale + extent(object.X_WO.p) + size);
  }
};

}  // namespace hapticd
