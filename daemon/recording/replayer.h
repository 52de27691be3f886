/** @file
 * Runs a recording again, cycle by cycle, and compares what comes out with what was sent.
 */
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "daemon/ipc/memfd.h"
#include "daemon/recording/reader.h"

namespace hapticd {

struct ReplayedMesh;
struct ReplayedTexture;

/** A recording in step with a cycle of its own. Any one thread. */
class Replayer {
 public:
  /** The recording's meshes and state at its start are in force then. */
  [[nodiscard]] static Result<std::unique_ptr<Replayer>> open(const std::string& path);
  [[nodiscard]] static Result<std::unique_ptr<Replayer>> start(RecordingReader reader);
  ~Replayer();

  /** Reads one cycle and runs it; false at the end. */
  [[nodiscard]] Result<bool> step();

  [[nodiscard]] const RecordingReader& recording() const { return reader_; }
  [[nodiscard]] const RecordedCycle& recorded() const { return *recorded_; }
  [[nodiscard]] const CycleOutput& output() const { return *output_; }
  [[nodiscard]] const Cycle& cycle() const { return *cycle_; }

 private:
  explicit Replayer(RecordingReader reader);
  Result<void> takeMeshes();
  void takeTextures();
  Result<bool> readOne();

  RecordingReader reader_;
  std::unique_ptr<MeshTable> table_;
  std::vector<std::unique_ptr<ReplayedMesh>> meshes_;  ///< A former one of the same entry may still be shown.
  std::vector<std::unique_ptr<ReplayedTexture>> textures_;
  std::unique_ptr<Cycle> cycle_;
  std::unique_ptr<RecordedCycle> recorded_;
  std::unique_ptr<CycleOutput> output_;
  bool ahead_ = false;  ///< `recorded_` is read and not run yet.
  bool over_ = false;
};

/** What a replay found. */
struct Verdict {
  bool same_program = false;  ///< Same build and instructions: compared bit for bit; else to kTolerance.
  std::uint64_t cycles = 0;
  std::uint64_t differing = 0;  ///< Cycles with a command beyond that.
  double largest = 0;           ///< Difference of a force [N], a torque [N m] or the gripper [N].
  std::string first;            ///< The first difference in words.
  static constexpr double kTolerance = 1e-9;
};

/** Replays to the end. */
[[nodiscard]] Result<Verdict> verify(Replayer& replayer);

}  // namespace hapticd
