/** @file
 * Reads a recording from its beginning to its end, and checks all of it on the way.
 */
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/recording/recording.h"

namespace hapticd {

/**
 * Cycles in their order. For a trajectory: open(), then next() until it says false; `input.device[d]` is the sample,
 * `sent[d]` the force. Any one thread. Errors name block and byte; after one the reader gives no more.
 */
class RecordingReader {
 public:
  [[nodiscard]] static Result<RecordingReader> open(const std::string& path);
  /** From any stream. */
  [[nodiscard]] static Result<RecordingReader> read(std::unique_ptr<std::istream> in);
  RecordingReader(RecordingReader&&) noexcept;
  RecordingReader& operator=(RecordingReader&&) noexcept;
  ~RecordingReader();

  [[nodiscard]] const RecordingHeader& header() const;

  /** The next cycle; false at the end. */
  [[nodiscard]] Result<bool> next(RecordedCycle& cycle);
  /** The meshes and textures that stood since the last call before the cycle that next() gave. */
  [[nodiscard]] std::vector<RecordedMesh> takeMeshes();

  [[nodiscard]] std::vector<RecordedTexture> takeTextures();

  /** How it ended, once next() has said false: nothing if it was cut off, as by a crash. */
  [[nodiscard]] const std::optional<RecordingEnd>& end() const;

 private:
  struct State;
  explicit RecordingReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace hapticd
