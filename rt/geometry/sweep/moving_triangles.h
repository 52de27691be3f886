/** @file
 * What moves of a mesh about a point in one tick, and takes the point along.
 */
#pragma once

#include <cstdint>
#include <span>

#include "rt/geometry/triangle.h"
#include "rt/scene/scene.h"

namespace hapticd {

/** How a mesh meets a point. */
struct Meeting {
  bool two_sided = false;  ///< From where it is, else from the front alone.
  int on = 0;              ///< The side of the mesh on which the point lies, 1 the front or -1; 0 if that is not known.
  double skin = 0;         ///< How high above a surface a point lies that touches it [m].
};

/**
 * The triangles about a point that a tick moves, and once they push it those that rest. They go from where they were to
 * where they are in a few steps, and in a step vertex after vertex: with one corner on a straight way it is exact when
 * a triangle passes the point. In one step only, a mesh that moves by more than a gap of it is wide would pass through
 * itself between two vertices, and take in who is in the gap. On which side of a triangle the point is, is remembered
 * where it lies too near to tell, and after each step it is put a skin above all on which it lies: what one face leaves
 * of a skin, another one would. All in the mesh's frame. Servo-safe; 30 kB.
 */
class MovingTriangles {
 public:
  static constexpr std::uint32_t kMost = 128;  ///< What is farther from the point moves unnoticed.
  static constexpr int kSteps = 8;

  /** Of `moves` those of the mesh, which is as it is after all of them, that may come to touch x. */
  MovingTriangles(const MeshView& mesh, std::span<const TriangleMove> moves, const Vec3& x,
                  const Meeting& meeting) HD_RT;

  /**
   * Takes along the point, which is the one that was given. What is visited of the mesh's tree counts as `work`.
   * Whether it has been pushed.
   */
  [[nodiscard]] bool push(Vec3& x, std::uint32_t& work, std::uint32_t limit) HD_RT;

 private:
  struct Height {
    Vec3 normal = Vec3::Zero();  ///< None of a triangle without area, and no height above it.
    double above = 0;
  };
  struct Moving {
    TriangleMove move;  ///< As it is in this step, and what comes next of it.
    float from[3][3] = {}, to[3][3] = {};
    bool moves[3] = {};
    int side = 0;  ///< Of its plane, on which the point is: 1, -1, or 0 where it does not meet the point.
    Vec3 base = Vec3::Zero(), normal = Vec3::Zero();  ///< Of its plane as it is; twice the area long,
    double area = 0;                                  ///< as this says.

    [[nodiscard]] Corners corners() const HD_RT;
    [[nodiscard]] Height height(const Vec3& x) const HD_RT;
    void notePlane() HD_RT;
  };
  struct Turn {
    std::uint32_t vertex;
    std::uint16_t triangle, corner;
  };

  [[nodiscard]] bool collect(std::span<const TriangleMove> moves, const Vec3& x, double reach, bool all) HD_RT;
  void narrow(std::span<const TriangleMove> moves, const Vec3& x, std::uint32_t most) HD_RT;
  void addResting(const Vec3& x, std::uint32_t& work, std::uint32_t limit) HD_RT;
  [[nodiscard]] Moving* add(const TriangleMove& move, const Vec3& x, double reach) HD_RT;
  void move(Turn turn, int step) HD_RT;
  void noteSide(Moving& moving, const Vec3& x) const HD_RT;
  [[nodiscard]] int lowOn(const Moving& moving, const Height& height) const HD_RT;
  [[nodiscard]] bool liesLow(const Vec3& x) const HD_RT;
  void putBack(Vec3& x) HD_RT;

  const MeshView& mesh_;
  Meeting meeting_;
  double reach_ = 0;  ///< Within it something may touch the point.
  std::uint32_t count_ = 0, turn_count_ = 0;
  Moving all_[kMost];
  static_assert(kMost <= 255);
  std::uint8_t place_[2 * kMost];  ///< Of a triangle in all_, and one; 0: free. By its number, or the next free one.
  Turn turns_[3 * kMost];          ///< Which corners move, one vertex after the other.
};

}  // namespace hapticd
