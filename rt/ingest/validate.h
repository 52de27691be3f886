/** @file
 * The check every client message passes before the servo may see it.
 */
#pragma once

#include <cstdint>

#include "proto/shm_layout.h"
#include "rt/base/contract.h"
#include "rt/base/error.h"
#include "rt/command.h"

namespace hapticd {

/**
 * Checks a private copy of a slot: kind, length, finite, ranges (limits.h), reserved fields zero. On kOk `out` is what
 * the servo may use: kind, seq, at_tick and payload are set, unit vectors and quaternions normalised, and every field
 * that the kind of model does not use is zero, so that no unchecked number goes further. `session` is the caller's to
 * set. Else kInvalidArgument (kUnsupported for a kind this version does not know) and `out` is untouched.
 *
 * Object ids and vertex indices are checked by the cycle, which knows the scene. Pure.
 */
[[nodiscard]] ErrorCode validate(const hd_slot& copy, std::uint32_t device_count, Command& out) HD_RT;

}  // namespace hapticd
