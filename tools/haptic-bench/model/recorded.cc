#include "tools/haptic-bench/model/recorded.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <set>

#include "daemon/recording/replayer.h"
#include "rt/base/standard_streams.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/tell.h"

namespace haptic_bench {
namespace {

using hapticd::Scene;
using hapticd::SceneObject;

/** An object as it stood when the model was made of it. */
struct Standing {
  std::uint32_t id = 0;
  hapticd::Pose X_WO;
  std::uint64_t shape = 0, moves = 0;

  explicit Standing(const SceneObject& object)
      : id(object.id), X_WO(object.X_WO), shape(object.shape.number), moves(object.shape.mesh->deform.moves) {}

  [[nodiscard]] bool stands(const Scene& scene) const {
    const SceneObject* const now = scene.find(id);
    return now != nullptr && (now->flags & HD_OBJECT_ENABLED) != 0 && now->shape.number == shape &&
           now->shape.mesh->deform.moves == moves && now->X_WO.p == X_WO.p && now->X_WO.q.coeffs() == X_WO.q.coeffs();
  }
};

bool isMesh(const SceneObject& object) {
  return object.shape.kind == hapticd::ShapeKind::kMesh && object.shape.mesh != nullptr;
}

void add(const SceneObject& object, Model& model) {
  const hapticd::MeshView& mesh = *object.shape.mesh;
  const auto base = static_cast<std::uint32_t>(model.vertices.size());
  model.vertices.resize(base + mesh.vertex_count);
  for (std::uint32_t t = 0; t < mesh.triangle_count; ++t) {
    const auto& corners = mesh.triangles[t];
    model.triangles.push_back({base + corners[0], base + corners[1], base + corners[2]});
    for (int c = 0; c < 3; ++c) {
      const Vec3 x = object.X_WO * mesh.vertex(t, c);
      for (int i = 0; i < 3; ++i)
        model.vertices[base + corners[c]][static_cast<std::size_t>(i)] = static_cast<float>(x[i]);
    }
  }
}

void tell(const std::string& path, const SceneObject& object) {
  const hd_material& material = object.material;
  hapticd::tellError(fmt::format(
      "haptic-bench: {}: object {}: {} triangles{}; felt with --stiffness {} --damping {} --friction-static {} "
      "--friction-dynamic {}\n",
      path, object.id, object.shape.mesh->triangle_count,
      (object.flags & HD_OBJECT_TWO_SIDED) != 0 ? ", two-sided (ours:two_sided=1)" : "", material.stiffness,
      material.damping, material.friction_static, material.friction_dynamic));
}

/** Says what can be touched that could not before, and so is no part of the model. */
class Latecomers {
 public:
  void look(const Scene& scene) {
    for (const std::uint16_t slot : scene.touchable()) {
      const std::uint32_t id = scene.slot(slot).id;
      if (known_.insert(id).second && !first_) words_ += fmt::format("{}{}", words_.empty() ? "" : ", ", id);
    }
    first_ = false;
  }
  void tell(const std::string& path) const {
    if (!words_.empty())
      hapticd::tellError(fmt::format("haptic-bench: {}: came later and left out: {}\n", path, words_));
  }

 private:
  std::set<std::uint32_t> known_;
  std::string words_;
  bool first_ = true;
};

/** The model, and of what it is made. */
std::vector<Standing> take(const std::string& path, const Scene& scene, std::uint32_t object, Model& model) {
  std::vector<Standing> taken;
  std::string others;
  for (const std::uint16_t slot : scene.touchable()) {
    const SceneObject& here = scene.slot(slot);
    const bool wanted = object == 0 || here.id == object;
    if (!isMesh(here) || !wanted) {
      others += fmt::format("{}{}", others.empty() ? "" : ", ", here.id);
      continue;
    }
    tell(path, here);
    add(here, model);
    taken.emplace_back(here);
  }
  if (taken.empty()) {
    if (object != 0 && !others.empty())
      throw Failure(path, fmt::format("it has no mesh {}", object), "it has objects " + others);
    throw Failure(path, "it holds no mesh that could be touched",
                  others.empty() ? "a recording of a scene with a mesh"
                                 : fmt::format("boxes and other exact shapes are none: objects {}", others));
  }
  if (!others.empty()) hapticd::tellError(fmt::format("haptic-bench: {}: left out: {}\n", path, others));
  return taken;
}

}  // namespace

Model readRecordedModel(const std::string& path, std::uint32_t object) {
  Model model;
  model.kind = "recorded";
  std::vector<Standing> taken;
  Latecomers latecomers;
  const std::unique_ptr<hapticd::Replayer> replayer = orFailIn(path, hapticd::Replayer::open(path));
  std::uint64_t cycles = 0;
  for (; orFailIn(path, replayer->step()); ++cycles) {
    const hapticd::RecordedCycle& cycle = replayer->recorded();
    const Scene& scene = replayer->cycle().scene();
    const auto armed = [](const auto& sent) { return sent.enabled; };
    if (taken.empty() && std::any_of(cycle.sent.begin(), cycle.sent.end(), armed))
      taken = take(path, scene, object, model);
    if (!taken.empty()) latecomers.look(scene);
    for (const Standing& one : taken) {
      if (one.stands(scene)) continue;
      throw Failure(path, fmt::format("object {} moves or goes at tick {}", one.id, cycle.input.tick),
                    "a recording in which it stands still while a device is armed, or object= of one that does");
    }
  }
  tellWhatLacks(path, replayer->recording(), cycles);
  if (taken.empty()) (void)take(path, replayer->cycle().scene(), object, model);
  latecomers.tell(path);
  return model;
}

void tellWhatLacks(const std::string& path, const hapticd::RecordingReader& recording, std::uint64_t cycles) {
  const auto& end = recording.end();
  if (end && end->lost == 0) return;
  const double seconds =
      1e-9 * static_cast<double>(cycles) * static_cast<double>(recording.header().start.config.period_ns);
  const std::string what = end ? fmt::format("the last {} cycles of it were lost", end->lost) : "it is cut off";
  tellOnce(fmt::format("{}: {}; what is used are the {} cycles before ({:.3f} s)", path, what, cycles, seconds));
}

}  // namespace haptic_bench
