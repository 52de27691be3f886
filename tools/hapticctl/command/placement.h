/** @file
 * The options that say where an object stands and what it feels like: shared by load and add.
 */
#pragma once

#include <string>
#include <vector>

#include "tools/hapticctl/daemon.h"

namespace CLI {
class App;
}

namespace hapticctl {

struct Placement {
  std::string name, parent, at;
  std::vector<std::string> rotate;
  double stiffness = 1000, damping = 1;
  double mass = 0;
  std::string friction;
  bool two_sided = false, disabled = false, replace = false;
};

void addPlacement(CLI::App& command, Placement& placement);

/** The object as asked for, without its shape. Texts point into `placement`. Fails with usage. */
[[nodiscard]] haptic_object makeObject(const Placement& placement);

/**
 * Creates the object, or with --replace gives the one of that name the new shape, pose and material without a moment in
 * which it is gone; refused, that one is as it was. Returns its id for pushes. Objects of hapticctl stay when it ends.
 */
std::uint32_t place(const Daemon& daemon, const Placement& placement, const haptic_object& object);

/**
 * Throws Failure if another object has the name and is not to be replaced, or has another parent than is asked for.
 * To be asked before the long work.
 */
void requirePlace(const Daemon& daemon, const Placement& placement);

/** A file name as an object name: "My part.stl" becomes "My_part". */
[[nodiscard]] std::string nameOf(const std::string& path);

}  // namespace hapticctl
