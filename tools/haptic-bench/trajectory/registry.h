/** @file
 * Trajectories by the name on the command line: generators, and readers by the kind of file.
 */
#pragma once

#include <string>

#include "tools/haptic-bench/model/model.h"
#include "tools/haptic-bench/trajectory/file_reader.h"
#include "tools/haptic-bench/trajectory/trajectory.h"

namespace haptic_bench {

/**
 * "spiral:turns=20" and the like, made for `model` and pressed into it for `surface`; or a file, read by its kind.
 * Throws Failure: unknown, unfit for the model, or a fault in the file with its line.
 */
[[nodiscard]] Trajectory makeTrajectory(const std::string& spec, const Model& model, const Surface& surface,
                                        const FileOptions& file = {});

/** One line for each generator and file kind, for --help. */
[[nodiscard]] std::string trajectoryHelp();

}  // namespace haptic_bench
