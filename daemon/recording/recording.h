/** @file
 * What a recording says, as the rest of the program holds it.
 */
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "rt/cycle/cycle_start.h"

namespace hapticd {

/** Who made it, of what, and the state it begins with. */
struct RecordingHeader {
  struct DeviceNames {
    std::string name, uri, model;
  };
  std::string program;          ///< Version of hapticd.
  std::string build;            ///< realtimeBuild()
  std::string instructions;     ///< instructionSet()
  std::int64_t started_ns = 0;  ///< CLOCK_REALTIME
  bool flush_denormals = false;
  std::string group;
  std::vector<DeviceNames> devices;  ///< As many as start.config.device_count.
  std::uint32_t meshes = 0;          ///< That stand before the first cycle.
  CycleStart start;
};

/** One cycle: what entered it and what was sent to each device. */
struct RecordedCycle {
  CycleInput input;
  std::array<DeviceCommand, kMaxDevices> sent;
};

/** A snapshot (proto/snapshot.h) that the cycles after it use. */
struct RecordedMesh {
  std::uint32_t entry = 0;  ///< Of the mesh table.
  std::vector<std::byte> bytes;
};

/** A texture as the servo of the recording read it. */
struct RecordedTexture {
  std::uint32_t entry = 0;  ///< Of the texture table.
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint16_t> pixels;  ///< Of a relief; else empty.
  std::vector<VibrationModel> models;
  std::vector<VibrationView::Corners> triangles;

  /** Points into this. */
  [[nodiscard]] TextureView view() const;
};

struct RecordingEnd {
  std::string reason;
  std::uint64_t cycles = 0;
  std::uint64_t lost = 0;  ///< Cycles after the last one here that found no room in the log.
};

/** Checksum of the real-time library that this program is linked with: the same text, the same instructions. */
[[nodiscard]] std::string realtimeBuild();
/** What that library and the C library choose by the processor: "x86_64 avx2 fma, glibc 2.36". */
[[nodiscard]] std::string instructionSet();

}  // namespace hapticd
