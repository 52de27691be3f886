// Which object is the tool in a device's hand.
#include <fmt/format.h>

#include <cmath>

#include "daemon/control/core.h"
#include "daemon/log.h"
#include "rt/body/coupling.h"
#include "rt/body/rigid_body.h"
#include "rt/volume/volume_view.h"

namespace hapticd {
namespace {

constexpr double kLightest = 0.01, kHeaviest = 10;  ///< [kg]
constexpr double kThinnest = 1e-3;                  ///< Of the box whose inertia a tool gets [m].

/** Of the solid itself where it has a volume; else of one as heavy and large as the shape's box. */
MassProperties massOf(const ShapeSpec& shape, const MeshInfo* mesh, const VolumeView* volume, double mass) {
  if (volume != nullptr && volume->mass.volume > 0) {
    const hd_volume_mass& solid = volume->mass;
    const double density = mass / solid.volume;
    const double(&i)[6] = solid.inertia;  // xx yy zz xy yz zx
    MassProperties out;
    out.mass = mass;
    out.com_O = vec3(solid.centroid);
    out.inertia_O << i[0], i[3], i[5], i[3], i[1], i[4], i[5], i[4], i[2];
    out.inertia_O *= density;
    if (out.valid()) return out;
  }
  Vec3 half = shape.size;
  Vec3 center = Vec3::Zero();
  switch (shape.kind) {
    case ShapeKind::kSphere:
      return MassProperties::ofBall(mass, std::max(kThinnest, shape.size.x()));
    case ShapeKind::kCapsule:
      half = Vec3(shape.size.x(), shape.size.x(), shape.size.y() + shape.size.x());
      break;
    case ShapeKind::kCylinder:
      half = Vec3(shape.size.x(), shape.size.x(), shape.size.y());
      break;
    case ShapeKind::kMesh:
      half = 0.5 * (mesh->upper - mesh->lower);
      center = 0.5 * (mesh->upper + mesh->lower);
      break;
    default:
      break;
  }
  MassProperties out = MassProperties::ofBox(mass, (2 * half).cwiseMax(kThinnest));
  out.com_O = center;
  return out;
}

}  // namespace

Result<void> Core::mayChange(const OpenDevice& device, const Client& by) {
  const Session* holder = device.lease == 0 ? nullptr : sessions_.find(device.lease);
  if (!by.administration && holder != nullptr && holder->client.uid != by.uid) {
    return Error{ErrorCode::kLeaseHeld, device.name,
                 fmt::format("'{}' (pid {}) holds the lease", log::printable(holder->client.name), holder->client.pid),
                 "wait until it is released"};
  }
  if (!device.link->accepting()) {
    return Error{ErrorCode::kTimeout, device.name, "the servo takes no orders", "see hapticctl status"};
  }
  return {};
}

Result<void> Core::attachTool(OpenDevice& device, const ToolWish& wish, const Client& by) {
  if (auto r = mayChange(device, by); !r) return r;
  const auto refuse = [&](std::string what, std::string remedy) {
    return Error{ErrorCode::kInvalidArgument, device.name + "/tool", std::move(what), std::move(remedy)};
  };
  auto object = scene_.find(wish.object);
  if (!object) return object.error();
  const ShapeSpec& shape = object->spec.shape;
  if (!object->spec.parent.empty()) {
    return refuse(fmt::format("'{}' is part of '{}'", wish.object, object->spec.parent),
                  "a tool stands directly below the root");
  }
  if (shape.kind == ShapeKind::kGroup || shape.kind == ShapeKind::kPlane) {
    return refuse(fmt::format("'{}' is a {}", wish.object, shapeName(shape.kind)), "a tool has a surface with an end");
  }
  const MeshInfo* mesh = shape.kind == ShapeKind::kMesh ? meshes_.find(shape.mesh) : nullptr;
  if (shape.kind == ShapeKind::kMesh && (mesh == nullptr || mesh->deformable)) {
    return refuse(fmt::format("the mesh of '{}' is deformable", wish.object), "take a rigid one");
  }
  if (!(wish.mass >= kLightest && wish.mass <= kHeaviest)) {
    return refuse(fmt::format("a tool weighs {:g} to {:g} kg", kLightest, kHeaviest), "for example 0.1");
  }
  if (!(wish.stiffness >= 0 && std::isfinite(wish.stiffness))) {
    return refuse("the coupling's stiffness is a number of N/m", "0 chooses the stiffest that is passive");
  }
  for (const auto& other : devices_.devices()) {
    if (other.get() != &device && other->tool.object == wish.object && other->tool.id == object->id) {
      return Error{ErrorCode::kAlreadyExists, device.name + "/tool",
                   fmt::format("'{}' is in the hand of {}", wish.object, other->name), "detach it there first"};
    }
  }

  const VolumeView* volume = mesh != nullptr ? meshes_.volumes().get(meshes_.entryOf(shape.mesh)) : nullptr;
  const MassProperties mass = massOf(shape, mesh, volume, wish.mass);
  const DeviceInfo& info = device.info();
  const double dt = static_cast<double>(device.link->group().options().cycle.period_ns) * 1e-9;
  const CouplingGains gains = chooseGains(info, {wish.mass, mass.inertia_O.trace() / 3, dt, wish.stiffness});
  const bool shows_torque = info.actuated_rotation && info.max_torque > 0;
  AttachTool order{};
  order.device = device.index;
  order.object = object->id;
  order.shows_torque = shows_torque ? 1 : 0;
  order.mass = wish.mass;
  store(mass.com_O, order.com);
  const Mat3& I = mass.inertia_O;
  const double six[] = {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)};
  std::copy(std::begin(six), std::end(six), order.inertia);
  order.outer = gains.outer;
  order.stiffness = gains.stiffness;
  order.damping = gains.damping;
  order.angular_outer = gains.angular_outer;
  order.angular_stiffness = gains.angular_stiffness;
  order.angular_damping = gains.angular_damping;
  (void)device.link->post(makeCommand(CommandKind::kAttachTool, order));
  device.tool = {wish.object, object->id, wish.mass, gains.outer * gains.stiffness / (gains.outer + gains.stiffness),
                 shows_torque};
  log::info("{}: holds '{}', {:g} kg at {:g} N/m{}", device.name, log::printable(wish.object), wish.mass,
            device.tool.stiffness,
            shows_torque ? "" : "; the device cannot show torque: the hand feels the force alone");
  return {};
}

Result<void> Core::detachTool(OpenDevice& device, const Client& by) {
  if (auto r = mayChange(device, by); !r) return r;
  device.tool = HeldObject{};
  (void)device.link->post(makeCommand(CommandKind::kDetachTool, DeviceRef{device.index}));
  return {};
}

}  // namespace hapticd
