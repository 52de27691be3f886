#include "tools/hapticctl/command/placement.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>

#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/lengths.h"
#include "tools/hapticctl/numbers.h"
#include "tools/hapticctl/option.h"
#include "tools/hapticctl/output/to_json.h"

namespace hapticctl {

void addPlacement(CLI::App& command, Placement& p) {
  command.add_option("--name", p.name, "Name of the object")
      ->type_name("NAME")
      ->check(CLI::Validator(
          [](const std::string& text) { return std::string(text.empty() ? "a name has at least one letter" : ""); },
          ""));
  command.add_option("--parent", p.parent, "Object that it moves with")->type_name("NAME");
  command.add_option("--at", p.at, "Place in the parent's frame: metres, or with units (10mm)")->type_name("X,Y,Z");
  command.add_option("--rotate", p.rotate, "Turn by degrees about an axis (x,90), or a quaternion; several: in order")
      ->type_name("AXIS,DEG|W,X,Y,Z")
      ->take_all();
  command.add_option("--stiffness", p.stiffness, "N/m")->capture_default_str()->check(positive());
  command.add_option("--damping", p.damping, "N s/m, while touched")->capture_default_str()->check(number(0));
  command.add_option("--friction", p.friction, "Static and dynamic coefficient; without it: 0,0")->type_name("S,D");
  command.add_option("--mass", p.mass, "With a mass it moves freely and is pushed by tools and hands, 0.005 to 100")
      ->type_name("KG")
      ->check(number(0, 100));
  command.add_flag("--two-sided", p.two_sided, "Both faces of an open mesh stop the hand");
  command.add_flag("--disabled", p.disabled, "Not to be touched yet");
  command.add_flag("--replace", p.replace, "Take the place of the object of that name");
}

haptic_object makeObject(const Placement& p) {
  haptic_object object = HAPTIC_OBJECT_INIT;
  object.name = p.name.c_str();
  object.parent = p.parent.c_str();
  object.flags |= HAPTIC_OBJECT_KEEP;
  if (p.two_sided) object.flags |= HAPTIC_OBJECT_TWO_SIDED;
  if (p.disabled) object.flags &= ~static_cast<std::uint32_t>(HAPTIC_OBJECT_ENABLED);
  if (!p.at.empty()) {
    const auto at = parseLengths("--at", p.at, 3);
    std::copy(at.begin(), at.end(), object.pose.p);
  }
  std::array<double, 4> q{1, 0, 0, 0};
  for (const std::string& turn : p.rotate) q = multiply(parseRotation("--rotate", turn), q);
  std::copy(q.begin(), q.end(), object.pose.q);
  object.material.stiffness = p.stiffness;
  object.material.damping = p.damping;
  if (!p.friction.empty()) {
    const auto mu = parseNumbers("--friction", p.friction, 0);
    if (mu.empty() || mu.size() > 2 || *std::min_element(mu.begin(), mu.end()) < 0 || mu.back() > mu.front()) {
      failUsage("--friction", fmt::format("'{}' is no pair of coefficients", p.friction),
                "write static,dynamic with dynamic at most static: 0.4,0.3");
    }
    object.material.friction_static = mu.front();
    object.material.friction_dynamic = mu.back();
  }
  return object;
}

namespace {

std::string massOf(const std::string& name) { return fmt::format("/objects/{}/mass", name); }

void setMass(const Daemon& daemon, const std::string& name, const std::string& mass) {
  try {
    (void)daemon.ask<haptic_text>(haptic_set, (massOf(name) + "?value=" + mass).c_str());
  } catch (Failure& failure) {
    if (failure.where.starts_with(massOf(name))) failure.where = "--mass";
    throw;
  }
}

constexpr FieldOption kPlacementFields[] = {
    {"name", "--name"},
    {"parent", "--parent"},
    {"pose.p", "--at"},
    {"pose.q", "--rotate"},
    {"material.stiffness", "--stiffness"},
    {"material.damping", "--damping"},
    {"material.friction", "--friction"},
    {"shape.size", "--size"},
};

Owned<haptic_object_state> find(const Daemon& daemon, const std::string& name) {
  haptic_object_state* found = nullptr;
  haptic_error error = HAPTIC_ERROR_INIT;
  const int code = haptic_object_find(daemon.client(), name.c_str(), &found, &error);
  try {
    if (code != HAPTIC_NOT_FOUND) check(code, error);
  } catch (Failure& failure) {
    failure.where = optionOf(failure.where, kPlacementFields);
    throw;
  }
  return Owned<haptic_object_state>(found);
}

/** An object stays where it hangs: the daemon moves none to another parent. */
void requireSameParent(const Placement& p, const haptic_object_state& old) {
  if (p.parent.empty() || p.parent == old.object->parent) return;
  throw Failure{kExitRefused, "--parent",
                *old.object->parent == '\0' ? fmt::format("'{}' hangs on no object", p.name)
                                            : fmt::format("'{}' hangs on '{}'", p.name, old.object->parent),
                "leave --parent out, or remove it and load or add it anew", "INVALID_ARGUMENT"};
}

/** As a tool, whose place is the hand's alone to say. */
bool isHeld(const Daemon& daemon, const std::string& name) {
  const auto status = daemon.ask<haptic_status>(haptic_get_status);
  for (std::uint32_t i = 0; i < status->device_count; ++i) {
    haptic_text* got = nullptr;
    haptic_error error = HAPTIC_ERROR_INIT;
    const std::string resource = fmt::format("/devices/{}/tool", status->devices[i]->name);
    const int code = haptic_get(daemon.client(), resource.c_str(), &got, &error);
    if (code == HAPTIC_NOT_FOUND) continue;  // Closed meanwhile.
    check(code, error);
    const Owned<haptic_text> text(got);
    const Json tool = Json::parse(std::string_view(text->text, text->length), nullptr, false);
    if (tool.is_object() && tool.value("object", "") == name) return true;
  }
  return false;
}

/** What may be refused for its place comes before the shape: the wrong one must not be felt there meanwhile. */
void show(const Daemon& daemon, const haptic_object& object) {
  daemon.tell(haptic_object_set_material, object.name, &object.material);
  if (!isHeld(daemon, object.name)) daemon.tell(haptic_object_set_pose, object.name, &object.pose);
  daemon.tell(haptic_object_set_shape, object.name, &object.shape);
  daemon.tell(haptic_object_set_flags, object.name, object.flags & 7u);
}

/** All or nothing. */
void takePlace(const Daemon& daemon, const Placement& placement, const haptic_object& object,
               const haptic_object_state& old) {
  requireSameParent(placement, old);
  const auto mass = daemon.ask<haptic_text>(haptic_get, massOf(placement.name).c_str());
  try {
    show(daemon, object);
    setMass(daemon, placement.name, exact(placement.mass));
  } catch (...) {
    try {
      show(daemon, *old.object);
      setMass(daemon, placement.name, std::string(mass->text, mass->length));
    } catch (const Failure&) {  // What went wrong first is told.
    }
    throw;
  }
}

}  // namespace

std::uint32_t place(const Daemon& daemon, const Placement& placement, const haptic_object& object) {
  std::uint32_t id = 0;
  try {
    if (const auto old = placement.replace ? find(daemon, placement.name) : nullptr) {
      takePlace(daemon, placement, object, *old);
      // Nobody asked for the old mesh any more, unless another object shows it: then the daemon keeps it.
      if (old->object->shape.kind == HAPTIC_SHAPE_MESH)
        haptic_mesh_drop(daemon.client(), old->object->shape.mesh, nullptr);
      return old->id;
    }
    daemon.tell(haptic_object_create, &object, &id);
  } catch (Failure& failure) {
    failure.where = optionOf(failure.where, kPlacementFields);
    throw;
  }
  if (!(placement.mass > 0)) return id;
  try {
    setMass(daemon, placement.name, exact(placement.mass));
  } catch (...) {
    haptic_object_remove(daemon.client(), object.name, nullptr);  // All or nothing.
    throw;
  }
  return id;
}

void requirePlace(const Daemon& daemon, const Placement& placement) {
  const auto there = find(daemon, placement.name);
  if (!there) return;
  if (placement.replace) return requireSameParent(placement, *there);
  throw Failure{kExitRefused, "--name", fmt::format("there is an object '{}' already", placement.name),
                "give another --name, or --replace to take its place", "ALREADY_EXISTS"};
}

std::string nameOf(const std::string& path) {
  std::string name = std::filesystem::path(path).stem().string().substr(0, 63);
  for (char& c : name) {
    const bool plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.' || c == '-';
    if (!plain) c = '_';
  }
  return name.empty() || name == "." || name == ".." ? "mesh" : name;
}

}  // namespace hapticctl
