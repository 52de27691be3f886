/** @file
 * The triangles about a proxy, kept from tick to tick: where, how far, and when they are gathered anew.
 */
#pragma once

#include <array>
#include <cstdint>

#include "rt/geometry/tree/vicinity.h"
#include "rt/scene/scene.h"

namespace hapticd {

/** Where a proxy is about to ask its questions, in the frame of the object asked. */
struct ProxyPlace {
  Vec3 proxy = Vec3::Zero();  ///< Centre of the ball,
  Vec3 end = Vec3::Zero();    ///< and where it is thought to come to in this tick.
  Vec3 hip = Vec3::Zero();
  double radius = 0;  ///< Of the ball [m].
};

/**
 * Of one proxy. What it gives is only asked instead of a tree, as far as it reaches, and changes no answer: how much is
 * kept is a matter of time alone. Servo thread; deterministic.
 *
 * A vicinity holds the ball that the sweeps and the look for a nearer surface need now, a margin about it, and the way
 * that this ball will go with the hand, some margins long. The margin grows while the vicinity holds few triangles and
 * shrinks where it holds many, down to an eighth of the ball or what a fast hand needs: coarse meshes are seldom
 * gathered, nor is what a slow hand feels, and fine ones not beyond what a vicinity takes. While one is asked the next
 * one is gathered, where the hand will be if it goes on as it does, a few nodes and triangles a tick: no tick waits for
 * all of it, and what a tick looks into has been asked for from memory in the tick before.
 */
class Surroundings {
 public:
  /** Meshes kept at a time. */
  static constexpr int kMeshes = 2;

  /** Begins a tick: what was not asked for in the one before has no speed. */
  void tick() HD_RT { ++tick_; }
  /**
   * The vicinity of the place on that object, gathered now if need be; null if there is none. Once a tick and object;
   * it holds to the end of the tick. `work` grows by what was visited.
   */
  Vicinity* about(std::uint32_t slot, const Shape& shape, const ProxyPlace& place, std::uint32_t& work) HD_RT;
  /** Vicinities gathered at once, because what was kept did not reach, and ahead. */
  [[nodiscard]] std::uint64_t gatheredAtOnce() const HD_RT { return at_once_; }
  [[nodiscard]] std::uint64_t gatheredAhead() const HD_RT { return ahead_; }

 private:
  struct Kept {
    std::uint32_t slot = 0;
    std::uint64_t number = 0;  ///< Shape::number; 0: nothing is kept.
    std::uint64_t moves = 0;   ///< Of the mesh's vertices, when it was gathered.
    std::uint64_t used = 0;    ///< In which tick.
    Vec3 hip = Vec3::Zero();   ///< In the tick before.
    double margin = 0;         ///< Of the last vicinity begun [m].
    double deepest = 0;        ///< Depth to which the look for a nearer surface is kept too [m].
    std::uint32_t rest = 0;    ///< Ticks without, after one that did not fit.
    std::uint32_t wait = 0;    ///< Ticks until the next one may be begun ahead.
    int now = 0;               ///< Which vicinity is asked; the other one is gathered ahead.
    Vicinity vicinity[2];

    void clear() HD_RT {
      for (Vicinity& each : vicinity) each.clear();
    }
  };

  Kept& keptFor(std::uint32_t slot, const Shape& shape, const Vec3& hip) HD_RT;
  static void begin(Kept& kept, Vicinity& vicinity, const MeshView& mesh, const ProxyPlace& place, const Vec3& step,
                    bool nearest) HD_RT;
  static void adapt(Kept& kept, const ProxyPlace& place, bool& nearest) HD_RT;
  static void gatherAhead(Kept& kept, const MeshView& mesh, const ProxyPlace& place, const Vec3& step) HD_RT;
  void gather(Kept& kept, const MeshView& mesh, const ProxyPlace& place, const Vec3& step, std::uint32_t& work) HD_RT;

  std::array<Kept, kMeshes> kept_;
  std::uint64_t tick_ = 1;
  std::uint64_t at_once_ = 0, ahead_ = 0;
};

}  // namespace hapticd
