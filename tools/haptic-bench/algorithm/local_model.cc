// A client that sends local models at its own low rate, rendered at the servo's rate: thesis section 5.2. The client
// sees where the hand was, finds the exact nearest point of the mesh and sends the tangent plane there; it arrives
// later, and others may be sent meanwhile. Its search is within the step that sends, so the median time is the servo's
// and the maximum the client's.
#include "rt/render/model/local_model.h"

#include <cmath>
#include <deque>
#include <memory>

#include "tools/haptic-bench/algorithm/algorithms.h"
#include "tools/haptic-bench/algorithm/native.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/model/nearest.h"
#include "tools/haptic-bench/spec.h"

namespace haptic_bench {
namespace {

class LocalPlanes {
 public:
  explicit LocalPlanes(const haptic_algorithm_problem& problem) : surface_(modelOf(problem)) {
    Spec options(std::string("local:") + problem.options);
    period_s_ = 1 / options.number("rate", 30, 0.1, 10000);
    latency_s_ = options.number("latency", 0.005, 0, 1);
    blend_s_ = options.number("blend", period_s_, 0, 1);
    options.finish();
    refuseBall(problem);
    plane_.kind = HD_MODEL_PLANE;
    plane_.material.stiffness = problem.stiffness;
    plane_.material.damping = problem.damping;
    plane_.material.friction_static = problem.friction_static;
    plane_.material.friction_dynamic = problem.friction_dynamic;
    plane_.lease_ns = nanoseconds(10 * (period_s_ + latency_s_));
    plane_.blend_ns = nanoseconds(blend_s_);
    plane_.normal[2] = 1;
    if (const hapticd::ErrorCode code = put(plane_); code != hapticd::ErrorCode::kOk) {
      throw Failure("local", std::string(hapticd::describe(code)),
                    "stiffness, damping and friction as the daemon takes them");
    }
  }

  void start(const Vec3& hip) {
    slot_.reset();
    under_way_.clear();
    seq_ = 0;
    now_s_ = -blend_s_ - 0.01;  // The client has been there before the hand.
    look(hip);
    arrive();
    now_s_ = next_look_s_ = 0;
  }

  void step(const Vec3& hip, const Vec3& v, double dt_s, haptic_algorithm_contact& contact) {
    now_s_ += dt_s;
    if (now_s_ >= next_look_s_ - kRounding_s) {
      look(hip);
      while (next_look_s_ <= now_s_ + kRounding_s) next_look_s_ += period_s_;
    }
    while (!under_way_.empty() && now_s_ >= under_way_.front().arrives_s - kRounding_s) arrive();
    const hapticd::ModelForce felt = slot_.evaluate({hip, v, 0}, nanoseconds(now_s_), *scene_);
    answer(contact, felt.force, hip + felt.force / plane_.material.stiffness, !felt.force.isZero(0));
  }

  [[nodiscard]] std::size_t bytes() const { return sizeof(slot_); }

 private:
  static constexpr double kRounding_s = 1e-9;  ///< Of sums of steps.

  static std::int64_t nanoseconds(double s) { return std::llround(s * 1e9); }

  void look(const Vec3& hip) {
    const SurfacePoint at = surface_.find(hip);
    hapticd::store(at.point, plane_.origin);
    hapticd::store(at.outward(hip), plane_.normal);
    under_way_.push_back({now_s_ + latency_s_, plane_});
  }

  void arrive() {
    (void)put(under_way_.front().plane);
    under_way_.pop_front();
  }

  hapticd::ErrorCode put(const hd_local_model& plane) {
    hapticd::Command command = hapticd::makeCommand(hapticd::CommandKind::kLocalModel, plane);
    command.seq = ++seq_;
    return slot_.set(command, nanoseconds(now_s_), *scene_);
  }

  struct Sent {
    double arrives_s;
    hd_local_model plane;
  };

  NearestPoint surface_;
  hd_local_model plane_{};
  double period_s_ = 0, latency_s_ = 0, blend_s_ = 0;
  double now_s_ = 0, next_look_s_ = 0;
  std::deque<Sent> under_way_;
  std::uint64_t seq_ = 0;
  hapticd::LocalModelSlot slot_;
  std::unique_ptr<hapticd::MeshTable> meshes_ = std::make_unique<hapticd::MeshTable>();
  std::unique_ptr<hapticd::Scene> scene_ = std::make_unique<hapticd::Scene>(*meshes_);
};

}  // namespace

const haptic_algorithm kLocal =
    nativeAlgorithm<LocalPlanes>("local", "tangent planes from a slow client; local:rate=30,latency=0.005,blend=0.033");

}  // namespace haptic_bench
