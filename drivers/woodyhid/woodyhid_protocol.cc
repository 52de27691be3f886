#include "drivers/woodyhid/woodyhid_protocol.h"

namespace hapticd::woodyhid {
namespace {

constexpr std::int16_t kSetCurrents = 0, kSetCounters = 1;
/** The firmware adds 10000 to the fourth encoder while the button of the stylus is pressed. */
constexpr std::int32_t kButtonOffset = 10'000, kButtonThreshold = 5'000;

Report pack(const std::array<std::int16_t, 7>& fields) HD_RT {
  Report report{};
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const auto bits = static_cast<std::uint16_t>(fields[i]);
    report[1 + 2 * i] = static_cast<std::uint8_t>(bits & 0xff);
    report[2 + 2 * i] = static_cast<std::uint8_t>(bits >> 8);
  }
  return report;
}

}  // namespace

std::optional<Reading> decode(std::span<const std::uint8_t> report) HD_RT {
  if (report.size() < kReportBytes) return std::nullopt;
  const auto field = [&](std::size_t i) noexcept {
    return static_cast<std::int16_t>(static_cast<std::uint16_t>(report[2 * i] | (report[2 * i + 1] << 8)));
  };
  Reading reading;
  for (std::size_t i = 0; i < reading.encoder.size(); ++i) reading.encoder[i] = field(i);
  if (reading.encoder[3] > kButtonThreshold) {
    reading.encoder[3] -= kButtonOffset;
    reading.button = true;
  }
  reading.calibrate = field(6) == 1;
  return reading;
}

Report encodeCurrents(const std::array<std::int16_t, 3>& current_mA) HD_RT {
  return pack({current_mA[0], current_mA[1], current_mA[2], kSetCurrents, 0, 0, 0});
}

Report encodeCounters(const std::array<std::int16_t, 6>& counts) HD_RT {
  return pack({counts[3], counts[4], counts[5], kSetCounters, counts[0], counts[1], counts[2]});
}

}  // namespace hapticd::woodyhid
