// A servo that comes late is told all that the others know: every order that lasts, whatever edits came before.
#include <gmock/gmock.h>

#include <cstring>
#include <map>
#include <random>
#include <set>

#include "daemon/scene/scene_model.h"
#include "rt/cycle/restated.h"
#include "tests/support/seeds.h"
#include "tests/unit/daemon/fake_sink.h"

namespace hapticd::test {
namespace {

/**
 * What is left of a stream of orders: bytes by kind and object. Of a kind that is not named here the last one stays, so
 * that a new one cannot be overlooked.
 */
class Left {
 public:
  explicit Left(const std::vector<Command>& orders) {
    for (const Command& order : orders) add(order);
  }
  [[nodiscard]] const std::map<std::pair<CommandKind, std::uint32_t>, std::string>& all() const { return left_; }

 private:
  template <class T>
  static std::string bytesOf(const T& value) {
    return {reinterpret_cast<const char*>(&value), sizeof value};
  }
  std::string& of(CommandKind kind, std::uint32_t object) { return left_[{kind, object}]; }
  template <class Change>
  void changeAdded(std::uint32_t object, Change&& change) {
    AddObject added{};
    std::string& bytes = of(CommandKind::kAddObject, object);
    ASSERT_EQ(bytes.size(), sizeof added) << "an order for an object that is not there";
    std::memcpy(&added, bytes.data(), sizeof added);
    change(added);
    bytes = bytesOf(added);
  }

  void add(const Command& order) {
    const std::uint32_t object = order.as<ObjectRef>().object;
    switch (order.kind) {
      case CommandKind::kAddObject:
        of(order.kind, object) = bytesOf(order.as<AddObject>());
        return;
      case CommandKind::kRemoveObject:
        std::erase_if(left_, [&](const auto& entry) { return entry.first.second == object; });
        return;
      case CommandKind::kSetShape:
        return changeAdded(object, [&](AddObject& a) { a.shape = order.as<SetShape>().shape; });
      case CommandKind::kObjectMaterial:
        return changeAdded(object, [&](AddObject& a) { a.material = order.as<hd_object_material>().material; });
      case CommandKind::kObjectFlags: {
        const auto& flags = order.as<hd_object_flags>();
        return changeAdded(object,
                           [&](AddObject& a) { a.flags = (a.flags & ~flags.mask) | (flags.value & flags.mask); });
      }
      case CommandKind::kObjectPose: {
        const auto& pose = order.as<hd_object_pose>();
        changeAdded(object, [&](AddObject& a) {
          std::copy_n(pose.p, 3, a.p);
          std::copy_n(pose.q, 4, a.q);
        });
        const double motion[6] = {pose.v[0], pose.v[1], pose.v[2], pose.w[0], pose.w[1], pose.w[2]};
        return keepUnless(order.kind, object, bytesOf(motion), motion[0] == 0 && motion[1] == 0 && motion[2] == 0);
      }
      case CommandKind::kSetBody:
        if (order.as<SetBody>().mass == 0 && left_.count({order.kind, object}) != 0)
          left_.erase({CommandKind::kObjectPose, object});  // What flew stands: FreeBodies::leave().
        return keepUnless(order.kind, object, bytesOf(order.as<SetBody>()), order.as<SetBody>().mass == 0);
      case CommandKind::kSetSurface: {
        const SurfaceParameters& s = order.as<SetSurface>().surface;
        const bool nothing = s.smooth_cosine == 0 && s.transient_gain == 0 && s.relief == 0 && s.vibration == 0;
        return keepUnless(order.kind, object, bytesOf(s), nothing);
      }
      case CommandKind::kSetEffect:
        return keepUnless(order.kind, object, bytesOf(order.as<SetEffect>().effect),
                          order.as<SetEffect>().effect.kind == static_cast<std::uint32_t>(EffectKind::kNone));
      case CommandKind::kSetGravity: {
        const double* g = order.as<SetGravity>().g;
        return keepUnless(order.kind, 0, bytesOf(order.as<SetGravity>()), g[0] == 0 && g[1] == 0 && g[2] == 0);
      }
      default:
        of(order.kind, object) = {reinterpret_cast<const char*>(order.payload), sizeof order.payload};
    }
  }
  void keepUnless(CommandKind kind, std::uint32_t object, std::string bytes, bool nothing) {
    if (nothing) {
      left_.erase({kind, object});
    } else {
      of(kind, object) = std::move(bytes);
    }
  }

  std::map<std::pair<CommandKind, std::uint32_t>, std::string> left_;
};

/** Does something to a scene, often in vain. */
class Editor {
 public:
  explicit Editor(std::uint32_t seed) : random_(seed) {}

  void edit(SceneModel& scene) {
    const std::string name = "o" + std::to_string(below(12));
    switch (below(12)) {
      case 0:
      case 1: {
        ObjectSpec spec;
        spec.name = name;
        if (below(3) == 0) spec.parent = "o" + std::to_string(below(12));
        spec.shape = {ShapeKind::kSphere, {0.01, 0, 0}, 0};
        spec.material = {100, 0, 0.5, 0.5};
        spec.X_PO.p = place();
        return (void)scene.create(spec, by_);
      }
      case 2:
        return (void)scene.remove(name, by_);
      case 3:
        return (void)scene.setPose(name, {place(), Quat(0, 1, 0, 0)});
      case 4:
        return (void)scene.setVelocity(name, {below(3) == 0 ? Vec3(Vec3::Zero()) : place(), Vec3::Zero()});
      case 5:
        return (void)scene.setMaterial(name, {100.0 + below(900), 1, 0.5, 0.4});
      case 6:
        return (void)scene.setFlags(name, {below(2) == 0, below(2) == 0, below(2) == 0});
      case 7:
        return (void)scene.setShape(name, {ShapeKind::kBox, {0.01, 0.01 + 0.01 * below(3), 0.02}, 0});
      case 8: {
        SurfaceSpec surface;
        if (below(3) != 0) surface.smooth_deg = 1 + below(40);
        if (below(3) != 0) surface.transient_gain = 0.5;
        return (void)scene.setSurface(name, surface);
      }
      case 9:
        return (void)scene.setBody(name, {below(3) == 0 ? 0 : 0.1 * (1 + below(5)), 1, true});
      case 10: {
        EffectSpec effect;
        if (below(3) != 0) effect.kind = EffectKind::kGuide;
        if (below(2) == 0) effect.path = {place(), place()};
        effect.duration_s = below(2);
        return (void)scene.setEffect(name, effect, below(100));
      }
      default:
        return (void)scene.setGravity({0, 0, -static_cast<double>(below(10))});
    }
  }

 private:
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(random_() % n); }
  Vec3 place() { return 0.01 * Vec3(below(9), below(9), below(9)); }

  std::mt19937 random_;
  Client by_{1, "c", 1, 1000, false};
};

TEST(LateServo, knowsWhatTheOthersDo) {
  std::set<CommandKind> said, said_late;
  for (std::uint32_t seed = 0; seed < 40; ++seed) {
    MeshStore meshes;
    SceneModel scene(meshes);
    FakeSink first;
    scene.attach(first);
    Editor editor(seedOf(seed));
    for (int i = 0; i < 300; ++i) {
      editor.edit(scene);
      if (i % 50 != 49) continue;
      FakeSink late;
      scene.attach(late);
      ASSERT_EQ(Left(late.orders).all(), Left(first.orders).all()) << "seed " << seed << ", edit " << i;
      for (const Command& order : late.orders) said_late.insert(order.kind);
      scene.detach(late);
    }
    for (const Command& order : first.orders) said.insert(order.kind);
  }
  // And these were all that the scene has to say.
  for (std::uint32_t number = 0; number < kMostKinds; ++number) {
    const auto kind = static_cast<CommandKind>(number);
    const Restated who = whoRestates(kind);
    const bool of_scene = who == Restated::kSceneAdd || who == Restated::kSceneOrder || who == Restated::kScene;
    EXPECT_EQ(said.count(kind) != 0, of_scene) << "kind " << number << " has no edit here, or is not the scene's";
    const bool again = who == Restated::kSceneOrder || who == Restated::kScene || kind == CommandKind::kAddObject;
    EXPECT_EQ(said_late.count(kind) != 0, again) << "kind " << number;
  }
}

}  // namespace
}  // namespace hapticd::test
