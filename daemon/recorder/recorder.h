/** @file
 * One recording under way: drains a servo's log and writes it into a stream that somebody else reads.
 *
 * The daemon opens no file. What it writes goes into a socket whose other end the client gets; the file is the
 * client's, with the client's rights, and a client that does not read costs a full log and nothing else.
 */
#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "daemon/ipc/memfd.h"
#include "daemon/recording/writer.h"
#include "daemon/scene/texture/texture_store.h"
#include "rt/cycle/cycle_log.h"

namespace hapticd {

/** Control thread only, but for the thread it owns. */
class Recorder {
 public:
  static constexpr std::int64_t kFlushNs = 250'000'000;  ///< A cycle waits at most so long for its block.
  /**
   * The reader takes nothing for so long, or so long after finish() not all that was left: given up. Less than a client
   * waits for the answer to its stop().
   */
  static constexpr std::int64_t kPatienceNs = 4'000'000'000;

  /** A snapshot that cycles use from the log's cycle number `after` on: shared and sealed, or a copy. */
  struct Mesh {
    std::uint32_t entry = 0;
    std::uint64_t after = 0;
    Mapping shared;
    std::vector<std::byte> copy;
    bool open = false;  ///< The copy is to be closed (closeDeformed()), on the recorder's thread.
    [[nodiscard]] std::span<const std::byte> bytes() const {
      return shared ? shared.bytes() : std::span<const std::byte>(copy);
    }
  };

  /** A texture, likewise. */
  struct Texture {
    std::uint64_t after = 0;
    PublishedTexture texture;
  };

  /** The log, the stream and a thread that waits for begin(); the log is locked if `lock`. */
  [[nodiscard]] static Result<std::unique_ptr<Recorder>> create(bool lock);
  /** Ends at once; what is not written is lost. The servo has let go of the log. */
  ~Recorder();

  [[nodiscard]] CycleLog& log() { return *log_; }
  /** The end to read from; once. */
  [[nodiscard]] UniqueFd takeStream() { return std::move(reader_end_); }

  /** From here on it writes. Fails never: the servo may have the log already. */
  void begin(RecordingHeader header, std::vector<Mesh> meshes, std::vector<Texture> textures);
  /** What is published from now on. */
  void add(Mesh mesh);
  void add(PublishedTexture texture);
  /** The servo has let go of the log: writes the rest and the end. The first reason stays. */
  void finish(const std::string& reason);
  /** Nothing more is written: finished, given up, or cycles were lost. */
  [[nodiscard]] bool done() const { return done_.load(std::memory_order_acquire); }
  /** How it ended, once done(). */
  [[nodiscard]] const RecordingEnd& end() const { return end_; }

 private:
  Recorder() = default;
  void run() noexcept;
  void record();
  [[nodiscard]] std::uint64_t lostAfter(std::uint64_t cycles) const;
  bool drain(RecordingWriter& writer);
  bool writeDue(RecordingWriter& writer);
  bool send(std::span<const std::byte> bytes);

  Mapping log_memory_;
  CycleLog* log_ = nullptr;
  UniqueFd stream_, reader_end_;
  std::unique_ptr<RecordedCycle> cycle_;
  std::uint64_t taken_ = 0;  ///< Cycles of the log.

  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<RecordingHeader> header_;  ///< Set once, under the mutex.
  std::vector<Mesh> meshes_;               ///< Not written yet, `after` rising. Under the mutex.
  std::vector<Texture> textures_;          ///< Likewise.
  std::optional<std::string> reason_;      ///< Under the mutex.
  std::atomic<bool> abandon_{false};
  std::atomic<std::int64_t> finished_ns_{0};  ///< When finish() was called; 0: not yet.
  std::atomic<bool> done_{false};
  RecordingEnd end_;
  std::thread thread_;
};

}  // namespace hapticd
