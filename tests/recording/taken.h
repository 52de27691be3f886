/** @file
 * A recording as its reader has it: everything that came through the stream.
 */
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <optional>
#include <sstream>
#include <string>
#include <thread>

#include "daemon/recording/replayer.h"
#include "tests/session/bench.h"
#include "tests/support/eventually.h"

namespace hapticd::test {

/** Records a bench's first device from its making until finish(). */
class Taken {
 public:
  explicit Taken(Bench& bench) : bench_(bench) {
    auto started = bench.core.record("", bench.administration);
    EXPECT_TRUE(started.ok()) << toString(started.error());
    if (!started) return;
    id_ = started->id;
    reader_ = std::thread([this, stream = std::move(started->stream)] {
      char piece[65536];
      for (ssize_t n = 0; (n = ::read(stream.get(), piece, sizeof piece)) > 0;) {
        bytes_.append(piece, static_cast<std::size_t>(n));
      }
    });
  }
  ~Taken() {
    bench_.core.recordings().drop(id_);
    if (reader_.joinable()) reader_.join();
  }
  Taken(const Taken&) = delete;
  Taken& operator=(const Taken&) = delete;

  [[nodiscard]] std::uint64_t id() const { return id_; }

  /** Stops it and gives all its bytes. `step` moves the servo on until the recorder is done. */
  template <class Step>
  std::string finish(Step&& step) {
    bench_.core.recordings().stop(id_, [this](const RecordingEnd& end) { end_ = end; });
    EXPECT_TRUE(eventually([&] {
      if (!end_) step();
      return end_.has_value();
    })) << "the recorder does not end";
    reader_.join();
    return bytes_;
  }
  [[nodiscard]] const std::optional<RecordingEnd>& end() const { return end_; }

 private:
  Bench& bench_;
  std::uint64_t id_ = 0;
  std::thread reader_;
  std::string bytes_;
  std::optional<RecordingEnd> end_;
};

inline Result<RecordingReader> readerOf(const std::string& bytes) {
  return RecordingReader::read(std::make_unique<std::istringstream>(bytes));
}

inline std::unique_ptr<Replayer> replayerOf(const std::string& bytes) {
  auto reader = readerOf(bytes);
  EXPECT_TRUE(reader.ok()) << toString(reader.error());
  if (!reader) return nullptr;
  auto replayer = Replayer::start(std::move(*reader));
  EXPECT_TRUE(replayer.ok()) << toString(replayer.error());
  return replayer ? std::move(*replayer) : nullptr;
}

}  // namespace hapticd::test
