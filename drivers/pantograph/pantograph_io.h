/** @file
 * A pantograph at work: it is told two torques and answers with two angles.
 */
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "drivers/link/device_io.h"
#include "drivers/link/reading_check.h"
#include "drivers/pantograph/pantograph_parameters.h"
#include "drivers/pantograph/pantograph_protocol.h"

namespace hapticd {

/**
 * The board counts from where the arms are when it is set up: both straight out, or every place is wrong. So one that
 * fell silent or took nothing more and comes back by itself is not trusted before it was unplugged. Nothing is known of
 * a watchdog in it, so zeros are sent on every way out.
 */
class PantographIo final : public DeviceIo {
 public:
  static constexpr std::int64_t kPeriod_ns = 1'000'000;
  static constexpr std::int64_t kAnswer_ns = 5'000'000;  ///< An answer that has not come by then is lost.
  static constexpr std::int64_t kTrust_ns = 10'000'000;  ///< Age of a reading by which forces may still be computed.
  static constexpr std::int64_t kFirstWord_ns = 1'000'000'000;
  static constexpr std::int64_t kSilent_ns = 1'000'000'000;  ///< Silence after which the board counts as gone.
  /** So long somebody who plugged it in holds its arms, while it boots. */
  static constexpr std::int64_t kArmsHeld_ns = 10'000'000'000;
  static constexpr double kMostDegreesPerMs = 5;  ///< Of an arm: 14 turns a second.
  static constexpr int kBadInARow = 20;
  static constexpr int kZeros = 3;

  explicit PantographIo(PantographSetup setup) : setup_(std::move(setup)), line_(setup_.line()) {}
  ~PantographIo() override { close(); }
  PantographIo(const PantographIo&) = delete;
  PantographIo& operator=(const PantographIo&) = delete;

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return setup_.info; }
  [[nodiscard]] Calibration calibration() const noexcept override { return calibration_.load(); }
  [[nodiscard]] Result<void> open(const std::atomic<bool>& stop) override;
  void close() noexcept override;
  [[nodiscard]] bool exchange(DeviceLink& link, std::int64_t until_ns) noexcept override;
  void safe() noexcept override;

 private:
  /** As exchange(). */
  [[nodiscard]] bool talk(DeviceLink& link, std::int64_t until_ns) noexcept;
  [[nodiscard]] bool listen(DeviceLink& link, std::int64_t until_ns) noexcept;
  void take(const std::array<float, pantograph::kJoints>& degrees, DeviceLink& link) noexcept;
  [[nodiscard]] std::array<float, pantograph::kJoints> torquesFor(const DeviceCommand& command,
                                                                  std::int64_t now_ns) noexcept;

  PantographSetup setup_;
  std::unique_ptr<SerialTransport> line_;
  pantograph::Parser parser_;
  std::atomic<Calibration> calibration_{Calibration::kNeeded};
  pantograph::Grip grip_;
  std::array<float, pantograph::kJoints> last_deg_{};
  std::int64_t heard_ns_ = 0, asked_ns_ = 0, next_ns_ = 0;
  std::uint64_t dropped_ = 0;
  bool open_ = false, asked_ = false, saturated_ = false;
  bool stalled_ = false;       ///< It went and was not unplugged since: nobody holds its arms where it counts from.
  bool unanswered_ = false;    ///< Its line is there, and it has not answered yet,
  std::int64_t there_ns_ = 0;  ///< since then.
  ReadingCheck check_{kMostDegreesPerMs, kBadInARow};
};

}  // namespace hapticd
