/** @file
 * The scene as the control thread knows it: named objects in a tree. Every edit is checked here and then becomes the
 * same order to every servo; a servo that comes later gets the whole scene replayed.
 */
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/scene/command_sink.h"
#include "daemon/scene/free_slots.h"
#include "daemon/scene/mesh/mesh_store.h"
#include "daemon/scene/object.h"
#include "daemon/scene/texture/texture_store.h"

namespace hapticd {

inline constexpr std::size_t kMaxGroups = 8;  ///< Servos of one daemon.

/** An object with what is in force now. */
struct ObjectNow {
  ObjectSpec spec;
  std::uint32_t id = 0;
  Pose X_WO;
  Twist V_PO;
  std::string path;   ///< /_objects/A/B/C
  std::string owner;  ///< Name of the client that made it, empty when that has left.
  std::uint32_t triangles = 0;
};

/** Control thread only. Every refusal leaves the scene as it was. */
class SceneModel {
 public:
  explicit SceneModel(MeshStore& meshes) : meshes_(meshes) {}

  [[nodiscard]] TextureStore& textures() { return textures_; }
  [[nodiscard]] const TextureStore& textures() const { return textures_; }

  /** Objects one user may own. */
  void setQuota(std::uint32_t objects_per_user) { quota_ = objects_per_user; }
  /** Told of each object made, changed ("pose", "material", "flags", "shape", "surface", "body",
   * "effect") or removed.
   * After "body" and "; " why a mesh meets things by its vertices alone, if it does. */
  void onChange(std::function<void(const std::string& name, const char* what)> f) { changed_ = std::move(f); }

  [[nodiscard]] Result<std::uint32_t> create(ObjectSpec spec, const Client& by);
  /** With its children. Only its maker's user or administration, and likewise for each child. */
  [[nodiscard]] Result<void> remove(std::string_view name, const Client& by);
  [[nodiscard]] Result<void> setPose(std::string_view name, Pose X_PO);
  [[nodiscard]] Result<void> setVelocity(std::string_view name, const Twist& V_PO);
  [[nodiscard]] Result<void> setMaterial(std::string_view name, const hd_material& material);
  [[nodiscard]] Result<void> setSurface(std::string_view name, const SurfaceSpec& surface);
  /** Lets it move freely, or with mass 0 no longer. At most kMaxBodies move. */
  [[nodiscard]] Result<void> setBody(std::string_view name, const BodySpec& body);
  /** At most kMaxEffects objects have one. A duration counts from `now_ns`, on the servos' clock. */
  [[nodiscard]] Result<void> setEffect(std::string_view name, const EffectSpec& effect, std::int64_t now_ns);
  /** Of the whole scene [m/s^2]. */
  [[nodiscard]] Result<void> setGravity(const Vec3& gravity);
  [[nodiscard]] const Vec3& gravity() const { return gravity_; }
  [[nodiscard]] Result<void> setFlags(std::string_view name, const ObjectFlags& flags);
  [[nodiscard]] Result<void> setShape(std::string_view name, const ShapeSpec& shape);

  /** kNotFound lists the nearest names. */
  [[nodiscard]] Result<ObjectNow> find(std::string_view name);
  [[nodiscard]] std::vector<ObjectNow> list();
  [[nodiscard]] std::vector<std::string> names() const;
  /** Children of an object in the order of their names; of the root for "". */
  [[nodiscard]] std::vector<std::string> childrenOf(std::string_view name) const;
  [[nodiscard]] bool has(std::string_view name) const { return by_name_.count(std::string(name)) != 0; }
  /** Name of the object with that id, empty when it is gone. */
  [[nodiscard]] std::string nameOf(std::uint32_t id) const;
  /** Also when it is gone, until its slot's next object is gone, too: a servo tells of it a bit later. */
  [[nodiscard]] std::string lastNameOf(std::uint32_t id) const;
  /** World pose of an object, or identity for "". */
  [[nodiscard]] Pose worldPose(std::string_view name);
  [[nodiscard]] std::size_t size() const { return by_name_.size(); }
  [[nodiscard]] std::uint64_t triangles() const;
  [[nodiscard]] std::uint32_t countOf(std::uint32_t uid) const;

  /** A connection ended: its objects go, but for those to keep; one that carries another's object becomes that one's.
   */
  void clientLeft(std::uint64_t connection);

  /**
   * What clients of one servo changed through their rings, for the other servos: a moved object moves for everybody.
   * Of place, material and flags, each by itself, the last writer wins. Where a body goes one servo says, for no two
   * come to the same: the last in which anybody has moved it. Vertex moves stay where they were made. Call every few
   * milliseconds.
   */
  void followClients();

  /** Replays the whole scene to a servo that has just started. */
  void attach(CommandSink& sink);
  void detach(CommandSink& sink);
  /** Takes over all that servos tell now: before one goes, for nobody else may know where it had things. */
  void refresh();
  /** The object with that id, whose mover, who gave it that velocity, is gone, stays where it is; a body flies on. */
  void stand(std::uint32_t id, const Twist& V_PO);
  /** The object with that id is in a hand, or no more: what clients say of its place is nothing meanwhile. */
  void setInHand(std::uint32_t id, bool in_hand);
  /** That servo's cycle was made anew, with orders(): it counts what its clients change from the start. */
  void madeAnew(const CommandSink& sink);
  /** The orders that make the whole scene, as it now is there, in that servo made anew. */
  [[nodiscard]] std::vector<Command> orders(const CommandSink& sink);

 private:
  using Part = SceneObject::Part;
  static constexpr std::array kAllParts{SceneObject::kPlace, SceneObject::kMaterial, SceneObject::kFlags};

  /** Of one part of an object in one servo. */
  struct Known {
    std::uint64_t ticket = 0;        ///< Of the last order about it.
    std::uint32_t client_edits = 0;  ///< Changes by that servo's clients taken over so far.
    bool behind = false;             ///< It is to be told what others changed.
    bool crossed = false;  ///< Not looked at since that order: whether a change came before or after it is not known.
  };

  struct Object {
    ObjectSpec spec;
    Client owner;
    std::uint32_t id = 0;
    std::uint32_t parent_slot = 0;
    Twist V_PO;
    bool in_hand = false;
    bool settles = false;                    ///< No body any more: where it stopped its teller will say.
    const CommandSink* placed_in = nullptr;  ///< With a velocity: in whose tick it stands at spec.X_PO,
    std::uint64_t placed_at = 0;             ///< and in which.
    std::int64_t effect_until_ns = 0;        ///< 0: it does not end.
    const CommandSink* teller = nullptr;     ///< Of a body: whose clients, hands or tools moved it last,
    std::array<double, 13> told{};           ///< and where and how fast the others were last told that it is there,
    int put_back = 0;                        ///< to which it has been put back so often in one of them.
    std::array<std::array<Known, SceneObject::kParts>, kMaxGroups> known{};  ///< By sink.
  };

  /** The last object that a slot had. */
  struct Gone {
    std::uint32_t id = 0;
    std::array<char, 64> name{};  ///< Ends in a zero: it has 63 bytes at most (checkName()).
  };

  Object* lookUp(std::string_view name);
  Error notFound(std::string_view name, const std::string& where) const;
  Result<void> accepting() const;
  Result<void> checkShapeMesh(const ShapeSpec& shape, const std::string& where) const;
  void post(Object& object, const Command& command);
  void postBody(Object& object, bool was_body);
  /** As it now is, to every servo. */
  void postPart(Object& object, Part part);
  void postPart(Object& object, Part part, std::size_t sink);
  /** Each object in turn, parents first, with the orders that make it for a servo of that period. */
  void replay(const CommandSink& sink, const std::function<void(Object&, const Command&)>& give);
  void postSurface(const Object& object);
  [[nodiscard]] Command surfaceCommand(const Object& object, std::int64_t period_ns) const;
  [[nodiscard]] Command bodyCommand(const Object& object) const;
  [[nodiscard]] static Command effectCommand(const Object& object);
  [[nodiscard]] Command gravityCommand() const;
  [[nodiscard]] Command shapeCommand(const Object& object) const;
  [[nodiscard]] Command addCommand(const Object& object) const;
  [[nodiscard]] static Command poseCommand(const Object& object);
  [[nodiscard]] static Command materialCommand(const Object& object);
  [[nodiscard]] static Command flagsCommand(const Object& object);
  /** The slot and all below it, each after its parent. */
  [[nodiscard]] std::vector<std::uint32_t> subtreeOf(std::uint32_t slot) const;
  void removeAll(const std::vector<std::uint32_t>& subtree);
  void removeOne(std::uint32_t slot);
  std::vector<std::uint32_t> childSlots(std::uint32_t slot) const;
  /**
   * Takes over what clients changed through their rings. Before each edit: after it the board tells nothing of that
   * part until the edit has passed, and what was not taken over would be answered, and told to the servos again, as it
   * once was.
   */
  void refresh(Object& object, const CommandSink* first = nullptr);
  void follow(Object& object);
  void settle(Object& object);
  void followBody(Object& object);
  /** Of a body: by number the sink that says where it is; of what nobody has moved the first. */
  [[nodiscard]] std::size_t tellerOf(const Object& object) const;
  /** What stands there in that servo, if our own orders about that part have passed. */
  [[nodiscard]] bool posed(const Object& object, std::size_t sink, Part part, PosedObject& out) const;
  void takeOver(const PosedObject& now, std::size_t sink, Part part, Object& object);
  /** To where its velocity brings it by the tick that takes an order given now. */
  void moveOn(Object& object);
  ObjectNow describe(std::uint32_t slot);
  Pose worldPoseOf(std::uint32_t slot);
  std::string pathOf(std::uint32_t slot) const;
  void takeFreeSlot() noexcept;
  void changed(const std::string& name, const char* what) {
    if (changed_) changed_(name, what);
  }

  MeshStore& meshes_;
  TextureStore textures_;
  Vec3 gravity_ = Vec3::Zero();
  std::uint32_t quota_ = kMaxObjects;
  std::function<void(const std::string&, const char*)> changed_;
  std::array<CommandSink*, kMaxGroups> sinks_{};
  std::array<Object, kMaxObjects> slots_;
  std::array<std::uint16_t, kMaxObjects> generation_{};
  std::array<Gone, kMaxObjects> gone_{};  ///< By slot.
  FreeSlots free_;
  std::map<std::string, std::uint32_t, std::less<>> by_name_;
};

}  // namespace hapticd
