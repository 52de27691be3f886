// A client that sends local models at its own low rate, rendered at the servo's rate: thesis section 5.2. The client
// sees where the hand was, finds the exact nearest point of the mesh and sends the tangent plane there; it arrives
// later. Its search is within the step that sends, so the median time is the servo's and the maximum the client's.
#include "rt/render/local_model.h"

#include <cmath>
#include <memory>
#include <optional>

#include "tools/haptic-bench/algorithm/algorithms.h"
#include "tools/haptic-bench/algorithm/native.h"
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
  }

  void start(const Vec3& hip) {
    slot_.reset();
    seq_ = 0;
    now_s_ = next_look_s_ = -blend_s_ - 0.01;  // The client has been there before the hand.
    look(hip);
    arrive();
    now_s_ = next_look_s_ = 0;
  }

  void step(const Vec3& hip, const Vec3& v, double dt_s, haptic_algorithm_contact& contact) {
    now_s_ += dt_s;
    if (on_its_way_ && now_s_ >= arrives_s_) arrive();
    if (!on_its_way_ && now_s_ >= next_look_s_) look(hip);
    if (on_its_way_ && latency_s_ <= 0) arrive();
    const hapticd::ModelForce felt = slot_.evaluate({hip, v, 0}, nanoseconds(now_s_), *scene_);
    answer(contact, felt.force, hip + felt.force / plane_.material.stiffness, !felt.force.isZero(0));
  }

  [[nodiscard]] std::size_t bytes() const { return sizeof(slot_); }

 private:
  static std::int64_t nanoseconds(double s) { return std::llround(s * 1e9); }

  void look(const Vec3& hip) {
    const SurfacePoint at = surface_.find(hip);
    const Vec3 out = at.inside ? Vec3(at.point - hip) : Vec3(hip - at.point);
    hapticd::store(at.point, plane_.origin);
    hapticd::store(out.isZero(0) ? at.normal : Vec3(out.normalized()), plane_.normal);
    on_its_way_ = true;
    arrives_s_ = now_s_ + latency_s_;
    next_look_s_ += period_s_;
  }

  void arrive() {
    hapticd::Command command;
    command.kind = hapticd::CommandKind::kLocalModel;
    command.seq = ++seq_;
    command.as<hd_local_model>() = plane_;
    (void)slot_.set(command, nanoseconds(now_s_), *scene_);
    on_its_way_ = false;
  }

  NearestPoint surface_;
  hd_local_model plane_{};
  double period_s_ = 0, latency_s_ = 0, blend_s_ = 0;
  double now_s_ = 0, next_look_s_ = 0, arrives_s_ = 0;
  bool on_its_way_ = false;
  std::uint64_t seq_ = 0;
  hapticd::LocalModelSlot slot_;
  std::unique_ptr<hapticd::MeshTable> meshes_ = std::make_unique<hapticd::MeshTable>();
  std::unique_ptr<hapticd::Scene> scene_ = std::make_unique<hapticd::Scene>(*meshes_);
};

}  // namespace

const haptic_algorithm kLocal =
    nativeAlgorithm<LocalPlanes>("local", "tangent planes from a slow client; local:rate=30,latency=0.005,blend=0.033");

}  // namespace haptic_bench
