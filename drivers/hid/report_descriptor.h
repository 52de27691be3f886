/** @file
 * What a HID device says of its reports (USB HID 1.11, section 6.2.2): which bits of which report mean what. Pure and
 * bounded: descriptors come from whatever is plugged in. Fuzzed.
 */
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "rt/base/contract.h"
#include "rt/base/error.h"

namespace hapticd {

enum class HidKind : std::uint8_t { kInput, kOutput, kFeature };

/** Usage page and usage in one number: 0x000f0073 is usage 0x73 of page 0x0f. */
using HidUsage = std::uint32_t;
[[nodiscard]] constexpr HidUsage hidUsage(std::uint16_t page, std::uint16_t usage) noexcept {
  return static_cast<HidUsage>(page) << 16 | usage;
}

/** A group of fields, within others. */
struct HidCollection {
  HidUsage usage = 0;
  std::uint8_t type = 0;     ///< 0 physical, 1 application, 2 logical ...
  std::int16_t parent = -1;  ///< Index; -1: none.
};

/** One number in a report. */
struct HidField {
  HidKind kind = HidKind::kInput;
  std::uint8_t report_id = 0;    ///< 0: reports are not numbered.
  std::uint16_t bit_offset = 0;  ///< From the first bit behind the report's ID.
  std::uint8_t bits = 0;         ///< 1 to 32.
  bool is_array = false;         ///< Its value selects one of `choices`.
  bool is_relative = false;
  HidUsage usage = 0;             ///< Of a variable.
  std::vector<HidUsage> choices;  ///< Of an array: the values logical_min, logical_min + 1, ...
  std::int32_t logical_min = 0, logical_max = 0;
  std::int32_t physical_min = 0, physical_max = 0;  ///< Both 0: as the logical ones.
  std::uint32_t unit = 0;                           ///< HID 1.11, 6.2.2.7, as it stands there; 0: none.
  std::int8_t unit_exponent = 0;                    ///< Of ten: -8 to 7.
  std::int16_t collection = -1;                     ///< Innermost.
};

/** All of it. Immutable; the lookups are not for the servo, insert() and extract() are. */
class HidReports {
 public:
  /** Bounds on what a device may declare. */
  static constexpr std::size_t kMostFields = 1024, kMostCollections = 256, kMostDepth = 16, kMostChoices = 256;
  static constexpr std::size_t kMostReportBits = 8 * 1023;

  /** kInvalidArgument names the byte; kUnsupported what is beyond the bounds above. */
  [[nodiscard]] static Result<HidReports> parse(std::span<const std::uint8_t> descriptor);

  [[nodiscard]] const std::vector<HidField>& fields() const noexcept { return fields_; }

  /** The field of that usage within a collection of usage `within` at any depth (0: anywhere); null if there is none.
   */
  [[nodiscard]] const HidField* find(HidKind kind, HidUsage usage, HidUsage within = 0) const noexcept;
  /** The array that can select `choice`. */
  [[nodiscard]] const HidField* findChoice(HidKind kind, HidUsage choice, HidUsage within = 0) const noexcept;
  /** Whether a collection of that usage encloses the field. */
  [[nodiscard]] bool isWithin(const HidField& field, HidUsage collection) const noexcept;
  [[nodiscard]] bool hasCollection(HidUsage usage) const noexcept;
  /** Bytes of that report, its ID included if reports are numbered; 0 if there is none. */
  [[nodiscard]] std::size_t reportBytes(HidKind kind, std::uint8_t report_id) const noexcept;
  /** Whether reports begin with an ID. */
  [[nodiscard]] bool numbered() const noexcept { return numbered_; }

 private:
  friend class HidDescriptorReader;
  struct Report {
    HidKind kind;
    std::uint8_t id;
    std::size_t bits;
  };
  std::vector<HidField> fields_;
  std::vector<HidCollection> collections_;
  std::vector<Report> reports_;
  bool numbered_ = false;
};

/** Value of an array for `choice`; logical_min - 1 if it has none such. */
[[nodiscard]] std::int32_t valueOfChoice(const HidField& field, HidUsage choice) noexcept;

/** `data` begins behind the report's ID. 0 where it is too short. Signed if the field's range is. */
[[nodiscard]] std::int32_t extract(const HidField& field, std::span<const std::uint8_t> data) HD_RT;
/** Writes the value, clamped to the logical range, and no other bit. Nothing where `data` is too short. */
void insert(const HidField& field, std::int32_t value, std::span<std::uint8_t> data) HD_RT;

}  // namespace hapticd
