/** @file
 * What an object does to a hand in free space, in a user's terms (docs/effects.md).
 */
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rt/base/error.h"
#include "rt/base/math.h"
#include "rt/command.h"

namespace hapticd {

/** Nothing is on, and whatever is turned on is moderate. */
struct EffectSpec {
  EffectKind kind = EffectKind::kNone;
  double force = 1;        ///< The most it pushes [N].
  double stiffness = 200;  ///< Of a guide, and of friction that sticks [N/m].
  double damping = 2;      ///< Of viscous, and of a guide across its way [N s/m].
  double reach = 0.02;     ///< Beyond this distance there is nothing [m].
  double hz = 100;         ///< Of a vibration.
  double duration_s = 0;   ///< After it was set or changed; 0: it does not end.
  std::vector<Vec3> path;  ///< A smooth curve goes through these, in the object's frame [m]; empty: none.

  [[nodiscard]] bool operator==(const EffectSpec&) const = default;
};

/** Names the field at fault under `where`. */
[[nodiscard]] Result<void> checkEffect(const EffectSpec& effect, const std::string& where);

/** none, force, viscous, friction, vibration or guide. */
[[nodiscard]] const char* effectName(EffectKind kind) noexcept;
[[nodiscard]] Result<EffectKind> parseEffect(std::string_view word, const std::string& where);

/** For a servo. The spec has been checked. `until_ns`, on the servo's clock: when it ends, 0 for never. */
[[nodiscard]] EffectParameters effectParameters(const EffectSpec& effect, std::int64_t until_ns);

}  // namespace hapticd
