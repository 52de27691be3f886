/** @file
 * The bytes of the Novint Falcon: the serial line's settings, the start of its firmware, and the run packets. Pure.
 *
 * Facts: libnifalcon (FalconCommLibUSB.cpp, FalconFirmwareNovintSDK.cpp, translate_packet.py). No checksum protects a
 * run packet: its two marks and the range of each byte are all there is.
 */
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/usb/transport.h"

namespace hapticd::falcon {

inline constexpr std::uint16_t kVendor = 0x0403, kProduct = 0xcb48;
inline constexpr UsbInterface kInterface{0, 0x81, 0x02, 64, false};

/** Each IN packet begins with two bytes of the serial chip (FT232R): the state of its lines. */
inline constexpr std::size_t kModemBytes = 2;
/** The payload of an IN packet; shorter when the chip's latency timer ran out first. */
[[nodiscard]] inline std::span<const std::uint8_t> payload(std::span<const std::uint8_t> packet) noexcept {
  return packet.size() < kModemBytes ? std::span<const std::uint8_t>{} : packet.subspan(kModemBytes);
}

/** To the state in which the device says which loader it has: 9600 baud, then a reset by its DTR line. */
inline constexpr std::array<UsbControl, 9> kToLoader{{
    {0x40, 0, 1, 0},       // purge what came
    {0x40, 0, 2, 0},       // purge what goes
    {0x40, 9, 16, 0},      // latency timer [ms]
    {0x40, 3, 0x4138, 0},  // 9600 baud
    {0x40, 4, 0x0008, 0},  // 8N1
    {0x40, 2, 0, 0},       // no flow control
    {0x40, 1, 0x0200, 0},  // RTS low
    {0x40, 1, 0x0100, 0},  // DTR low
    {0x40, 1, 0x0101, 0},  // DTR high
}};
inline constexpr std::array<std::uint8_t, 3> kHello{0x0a, 0x43, 0x0d};
inline constexpr std::array<std::uint8_t, 4> kHelloAnswer{0x0a, 0x44, 0x2c, 0x0d};

/** To the state in which the device takes its firmware, 142 857 baud; then kReady goes out and comes back. */
inline constexpr std::array<UsbControl, 2> kToUpload{{{0x40, 1, 0x0100, 0}, {0x40, 3, 0x0015, 0}}};
inline constexpr std::array<std::uint8_t, 1> kReady{0x41};  // 0x40 by a comment there; 0x41 is what works.
/** Firmware goes in pieces of this size; the device echoes every byte, which is the only check. */
inline constexpr std::size_t kChunk = 62;

/** To the run state: 1.5 Mbaud, the latency timer as short as it can be. */
inline constexpr std::array<UsbControl, 4> kToRun{
    {{0x40, 9, 1, 0}, {0x40, 3, 0x0002, 0}, {0x40, 0, 1, 0}, {0x40, 0, 2, 0}}};

/** Bits of Order::lights. */
inline constexpr std::uint8_t kHome = 1, kGreen = 2, kBlue = 4, kRed = 8;
/** The vendor's driver saturates here. */
inline constexpr std::int16_t kMostCounts = 4095;

inline constexpr std::size_t kPacket = 16;

/** What goes to the device. */
struct Order {
  std::array<std::int16_t, 3> motor{};  ///< At most kMostCounts either way: beyond it is cut, never wrapped.
  std::uint8_t lights = 0;
};
[[nodiscard]] std::array<std::uint8_t, kPacket> encode(const Order& order) noexcept;

/** What comes from it. */
struct Reading {
  std::array<std::int16_t, 3> encoder{};
  std::uint8_t buttons = 0;  ///< 1 plus (right), 2 forward, 4 centre, 8 minus (left).
  std::uint8_t homed = 0;    ///< A bit for each arm.

  [[nodiscard]] bool allHomed() const noexcept { return homed == 7; }
  bool operator==(const Reading&) const = default;
};

/**
 * Finds packets in the stream. What does not fit is dropped byte by byte, so that one stray byte costs one packet at
 * most (libnifalcon drops sixteen, and can stay out of step for ever). Fuzzed.
 */
class Parser {
 public:
  /** Payload of one IN packet; what is older than the last kMost bytes is dropped. */
  void feed(std::span<const std::uint8_t> bytes) noexcept;
  /** The next whole packet. */
  [[nodiscard]] bool next(Reading& reading) noexcept;
  /** Bytes that belonged to no packet. */
  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_; }
  void clear() noexcept { size_ = 0; }

 private:
  static constexpr std::size_t kMost = 256;
  void drop(std::size_t n) noexcept;

  std::array<std::uint8_t, kMost> bytes_{};
  std::size_t size_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace hapticd::falcon
