/** @file
 * From a file of the volume cache to the OpenVDB file beside it. No process or descriptor here.
 */
#pragma once

#include <span>
#include <string>

#include "rt/base/error.h"

namespace hapticd {

/**
 * `cached` is the whole file (cached_build.h). Distances that the volume's bricks do not hold are measured anew on its
 * mesh. kBadSnapshot if the file is damaged or of another version. Some 0.4 of the time that the volume took. Needs
 * the file's size again, and about as much for each grid.
 */
[[nodiscard]] Result<std::string> vdbOfCached(std::span<const std::byte> cached);

}  // namespace hapticd
