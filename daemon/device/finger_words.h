/** @file
 * A soft finger in words, as resources and the configuration have it: LAW and then what differs from the usual.
 */
#pragma once

#include <string>
#include <string_view>

#include "rt/base/error.h"
#include "rt/command.h"

namespace hapticd {

/**
 * "soft", "hertz", "modified-hertz", "viscous-sphere" or "membrane", then any of arm=M, radius=M, stiffness=N m/rad,
 * damping=N s/m, cue=N s/m and the word uncoupled; "none" or nothing is a point. kInvalidArgument names the word at
 * fault. `device` and `shows_moment` are left for the caller.
 */
[[nodiscard]] Result<SetFinger> parseFinger(std::string_view words, const std::string& where);

/** The name of a law (PadLaw); empty for none. */
[[nodiscard]] std::string_view fingerLaw(const SetFinger& finger);

}  // namespace hapticd
