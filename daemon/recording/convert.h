/** @file
 * Between recording.capnp and the cycle's own types. Numbers cross bit for bit.
 */
#pragma once

#include "daemon/recording/recording.h"
#include "proto/recording.capnp.h"

namespace hapticd {

void write(const RecordingHeader& header, proto::Header::Builder out);
void write(const RecordedCycle& cycle, std::uint32_t device_count, proto::CycleRecord::Builder out);

/** kVersionMismatch, kUnsupported or kInvalidArgument name the field. */
[[nodiscard]] Result<RecordingHeader> read(proto::Header::Reader in);
[[nodiscard]] Result<void> read(proto::CycleRecord::Reader in, std::uint32_t device_count, RecordedCycle& cycle);

}  // namespace hapticd
