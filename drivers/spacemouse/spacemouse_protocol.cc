#include "drivers/spacemouse/spacemouse_protocol.h"

#include <algorithm>

namespace hapticd::spacemouse {
namespace {

constexpr std::uint8_t kTranslationId = 1, kRotationId = 2, kButtonsId = 3, kLightId = 4, kBatteryId = 0x17;

// spacenavd (src/dev.c) and pyspacemouse list these; buttons as far as they are published, else 2.
constexpr Product kProducts[] = {
    {0x046d, 0xc603, "SpaceMouse Plus XT", 11},
    {0x046d, 0xc605, "CadMan", 4},
    {0x046d, 0xc606, "SpaceMouse Classic", 11},
    {0x046d, 0xc621, "SpaceBall 5000", 12},
    {0x046d, 0xc623, "SpaceTraveler", 8},
    {0x046d, 0xc625, "SpacePilot", 21},
    {0x046d, 0xc626, "SpaceNavigator", 2},
    {0x046d, 0xc627, "SpaceExplorer", 15},
    {0x046d, 0xc628, "SpaceNavigator Notebook", 2},
    {0x046d, 0xc629, "SpacePilot Pro", 31},
    {0x046d, 0xc62b, "SpaceMouse Pro", 32},
    {0x256f, 0xc62e, "SpaceMouse Wireless", 2},
    {0x256f, 0xc62f, "SpaceMouse Wireless Receiver", 2},
    {0x256f, 0xc631, "SpaceMouse Pro Wireless", 32},
    {0x256f, 0xc632, "SpaceMouse Pro Wireless Receiver", 32},
    {0x256f, 0xc633, "SpaceMouse Enterprise", 32},
    {0x256f, 0xc635, "SpaceMouse Compact", 2},
    {0x256f, 0xc636, "SpaceMouse Module", 2},
    {0x256f, 0xc638, "SpaceMouse Pro Wireless Bluetooth", 32},
    {0x256f, 0xc63a, "SpaceMouse Wireless Bluetooth", 2},
    {0x256f, 0xc652, "Universal Receiver", 32},
};

/** A cap that reports more than this is no cap; such a report is torn or another's. */
constexpr int kMost = 2 * 350 + 100;

bool axes(std::span<const std::uint8_t> data, std::span<std::int16_t> out) HD_RT {
  std::array<std::int16_t, 6> read{};
  for (std::size_t i = 0; i < out.size(); ++i) {
    read[i] = static_cast<std::int16_t>(static_cast<std::uint16_t>(data[2 * i] | (data[2 * i + 1] << 8)));
    if (read[i] > kMost || read[i] < -kMost) return false;
  }
  std::copy_n(read.begin(), out.size(), out.begin());
  return true;
}

}  // namespace

Report take(std::span<const std::uint8_t> report, State& state) HD_RT {
  if (report.empty()) return Report::kNone;
  const std::span<const std::uint8_t> data = report.subspan(1);
  const std::span<std::int16_t> axis = state.axis;
  switch (report[0]) {
    case kTranslationId:
      if (data.size() >= 12) return axes(data, axis) ? Report::kBoth : Report::kNone;
      return data.size() >= 6 && axes(data, axis.first(3)) ? Report::kTranslation : Report::kNone;
    case kRotationId:
      return data.size() >= 6 && axes(data, axis.subspan(3)) ? Report::kRotation : Report::kNone;
    case kButtonsId:
      if (data.empty()) return Report::kNone;
      state.buttons = 0;
      for (std::size_t i = 0; i < std::min<std::size_t>(4, data.size()); ++i) {
        state.buttons |= static_cast<std::uint32_t>(data[i]) << (8 * i);
      }
      return Report::kButtons;
    case kBatteryId:
      if (data.empty() || data[0] > 100) return Report::kNone;
      state.battery_percent = data[0];
      return Report::kBattery;
    default:
      return Report::kNone;
  }
}

std::array<std::uint8_t, 2> encodeLight(bool on) HD_RT { return {kLightId, static_cast<std::uint8_t>(on ? 1 : 0)}; }

const Product* findProduct(std::uint16_t vendor, std::uint16_t product) noexcept {
  for (const Product& one : kProducts) {
    if (one.vendor == vendor && one.product == product) return &one;
  }
  return nullptr;
}

}  // namespace hapticd::spacemouse
