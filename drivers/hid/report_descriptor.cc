#include "drivers/hid/report_descriptor.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

namespace hapticd {
namespace {

/** State that lasts until it is set anew, and can be pushed. */
struct Globals {
  std::uint16_t usage_page = 0;
  std::int32_t logical_min = 0, physical_min = 0, physical_max = 0;
  std::int32_t logical_max = 0;
  std::uint32_t logical_max_unsigned = 0;
  std::uint32_t unit = 0;
  std::int8_t unit_exponent = 0;
  std::uint32_t report_size = 0, report_count = 0;
  std::uint8_t report_id = 0;
};

/** State of the next main item alone. */
struct Locals {
  struct Named {
    HidUsage usage;
    bool whole;  ///< With its page, in four bytes.
  };
  std::vector<Named> named;
  std::optional<HidUsage> minimum;

  /**
   * The usages, of the page in force at their main item (HID 1.11, 6.2.2.8). Those before another of that page keep
   * theirs: so the kernel reads descriptors that name several pages for one item.
   */
  [[nodiscard]] std::vector<HidUsage> usages(std::uint16_t page) const {
    std::vector<HidUsage> out(named.size());
    bool late = true;
    for (std::size_t i = named.size(); i-- > 0;) {
      late = late && (named[i].whole || named[i].usage >> 16 != page);
      out[i] = late && !named[i].whole ? hidUsage(page, static_cast<std::uint16_t>(named[i].usage)) : named[i].usage;
    }
    return out;
  }
};

enum ItemType : std::uint8_t { kMain = 0, kGlobal = 1, kLocal = 2 };

struct Item {
  std::size_t at = 0;
  std::uint8_t type = 0, tag = 0, bytes = 0;
  std::uint32_t data = 0;

  [[nodiscard]] std::int32_t value() const {
    const std::uint32_t sign = bytes == 1 ? 0x80u : bytes == 2 ? 0x8000u : 0;
    return static_cast<std::int32_t>((data & sign) != 0 ? data - 2 * sign : data);
  }
};

Error malformed(std::size_t at, std::string what) {
  return {ErrorCode::kInvalidArgument, fmt::format("report descriptor, byte {}", at), std::move(what),
          "the device's firmware is at fault"};
}

Error tooMuch(std::size_t at, std::string what) {
  return {ErrorCode::kUnsupported, fmt::format("report descriptor, byte {}", at), std::move(what),
          "such a device is not supported"};
}

}  // namespace

/** Goes through the items once. */
class HidDescriptorReader {
 public:
  explicit HidDescriptorReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  Result<HidReports> read() {
    std::size_t at = 0;
    while (at < bytes_.size()) {
      constexpr std::uint8_t kLongItem = 0xfe;
      if (bytes_[at] == kLongItem) {
        const std::size_t skip = at + 1 < bytes_.size() ? 3u + bytes_[at + 1] : bytes_.size();
        if (skip > bytes_.size() - at) return malformed(at, "a long item that ends beyond the descriptor");
        at += skip;
        continue;
      }
      Item item;
      item.at = at;
      const std::uint8_t head = bytes_[at++];
      item.bytes = (head & 3) == 3 ? 4 : head & 3;
      item.type = (head >> 2) & 3;
      item.tag = head >> 4;
      if (item.bytes > bytes_.size() - at) return malformed(item.at, "an item that ends beyond the descriptor");
      for (std::uint8_t i = 0; i < item.bytes; ++i) item.data |= static_cast<std::uint32_t>(bytes_[at + i]) << (8 * i);
      at += item.bytes;
      if (auto taken = take(item); !taken) return taken.error();
    }
    if (open_ >= 0) return malformed(bytes_.size(), "a collection that is not closed");
    return std::move(out_);
  }

 private:
  Result<void> take(const Item& item) {
    if (item.type == kMain) return main(item);
    if (item.type == kGlobal) return global(item);
    if (item.type == kLocal) return local(item);
    return malformed(item.at, "an item of the reserved type");
  }

  Result<void> main(const Item& item) {
    Result<void> done;
    usages_ = locals_.usages(globals_.usage_page);
    switch (item.tag) {
      case 8:
        done = field(item, HidKind::kInput);
        break;
      case 9:
        done = field(item, HidKind::kOutput);
        break;
      case 11:
        done = field(item, HidKind::kFeature);
        break;
      case 10:
        done = openCollection(item);
        break;
      case 12:
        if (open_ < 0) return malformed(item.at, "the end of a collection that was not begun");
        open_ = out_.collections_[static_cast<std::size_t>(open_)].parent;
        --depth_;
        break;
      default:
        return malformed(item.at, fmt::format("a main item of unknown tag {}", item.tag));
    }
    locals_ = Locals{};
    return done;
  }

  Result<void> openCollection(const Item& item) {
    if (out_.collections_.size() >= HidReports::kMostCollections || depth_ >= HidReports::kMostDepth) {
      return tooMuch(item.at, "too many or too deep collections");
    }
    const HidUsage usage = usages_.empty() ? 0 : usages_.front();
    out_.collections_.push_back({usage, static_cast<std::uint8_t>(item.data), open_});
    open_ = static_cast<std::int16_t>(out_.collections_.size() - 1);
    ++depth_;
    return {};
  }

  Result<void> global(const Item& item) {
    switch (item.tag) {
      case 0:
        globals_.usage_page = static_cast<std::uint16_t>(item.data);
        break;
      case 1:
        globals_.logical_min = item.value();
        break;
      case 2:
        globals_.logical_max = item.value();
        globals_.logical_max_unsigned = item.data;
        break;
      case 3:
        globals_.physical_min = item.value();
        break;
      case 4:
        globals_.physical_max = item.value();
        break;
      case 5: {  // Four bits with a sign; many write it out in eight.
        const auto nibble = static_cast<std::int8_t>(item.data & 0xf);
        globals_.unit_exponent = static_cast<std::int8_t>(nibble < 8 ? nibble : nibble - 16);
        break;
      }
      case 6:
        globals_.unit = item.data;
        break;
      case 7:
        globals_.report_size = item.data;
        break;
      case 8:
        if (item.data == 0 || item.data > 255) return malformed(item.at, "a report ID that is not 1 to 255");
        globals_.report_id = static_cast<std::uint8_t>(item.data);
        out_.numbered_ = true;
        break;
      case 9:
        globals_.report_count = item.data;
        break;
      case 10:
        if (pushed_.size() >= HidReports::kMostDepth) return tooMuch(item.at, "too many pushes");
        pushed_.push_back(globals_);
        break;
      case 11:
        if (pushed_.empty()) return malformed(item.at, "a pop without a push");
        globals_ = pushed_.back();
        pushed_.pop_back();
        break;
      default:
        return malformed(item.at, fmt::format("a global item of unknown tag {}", item.tag));
    }
    return {};
  }

  Result<void> local(const Item& item) {
    const HidUsage usage =
        item.bytes == 4 ? item.data : hidUsage(globals_.usage_page, static_cast<std::uint16_t>(item.data));
    if (item.tag == 0) {
      if (locals_.named.size() >= HidReports::kMostChoices) return tooMuch(item.at, "too many usages");
      locals_.named.push_back({usage, item.bytes == 4});
    } else if (item.tag == 1) {
      locals_.minimum = usage;
    } else if (item.tag == 2) {
      if (!locals_.minimum || usage < *locals_.minimum) return malformed(item.at, "a usage maximum without a minimum");
      const std::size_t room = HidReports::kMostChoices - locals_.named.size();
      // A range larger than anything here looks at (a keyboard's, a vendor's): its first part.
      const std::size_t count = std::min(std::size_t{usage - *locals_.minimum} + 1, room);
      for (std::size_t i = 0; i < count; ++i)
        locals_.named.push_back({*locals_.minimum + static_cast<HidUsage>(i), item.bytes == 4});
      locals_.minimum.reset();
    }
    return {};
  }

  HidReports::Report& report(HidKind kind) {
    for (HidReports::Report& one : out_.reports_) {
      if (one.kind == kind && one.id == globals_.report_id) return one;
    }
    return out_.reports_.emplace_back(HidReports::Report{kind, globals_.report_id, 0});
  }

  Result<void> field(const Item& item, HidKind kind) {
    constexpr std::uint32_t kConstant = 1, kVariable = 2, kRelative = 4;
    const Globals& g = globals_;
    HidReports::Report& into = report(kind);
    if (g.report_size > HidReports::kMostReportBits || g.report_count > HidReports::kMostReportBits ||
        g.report_size * g.report_count > HidReports::kMostReportBits - into.bits) {
      return tooMuch(item.at, "a report longer than 1023 bytes");
    }
    const std::size_t begin = into.bits;
    into.bits += g.report_size * g.report_count;
    // Padding, numbers that have no name, and numbers wider than any here.
    if ((item.data & kConstant) != 0 || usages_.empty() || g.report_size == 0 || g.report_size > 32) return {};
    if (g.report_count > HidReports::kMostFields - out_.fields_.size()) return tooMuch(item.at, "too many fields");
    HidField one;
    one.kind = kind;
    one.report_id = g.report_id;
    one.bits = static_cast<std::uint8_t>(g.report_size);
    one.is_array = (item.data & kVariable) == 0;
    one.is_relative = (item.data & kRelative) != 0;
    one.logical_min = g.logical_min;
    one.logical_max = g.logical_max;
    // Written in too few bytes, 0 to 255 looks like 0 to -1: everybody takes it for what was meant.
    if (g.logical_min >= 0 && g.logical_max < g.logical_min) {
      one.logical_max = static_cast<std::int32_t>(std::min<std::uint32_t>(g.logical_max_unsigned, 0x7fffffffu));
    }
    // A range beyond what the bits hold: a force at its far end would come out small, or turned round.
    const std::int64_t values = std::int64_t{1} << one.bits, lowest = g.logical_min < 0 ? -values / 2 : 0;
    one.logical_min = static_cast<std::int32_t>(std::max<std::int64_t>(one.logical_min, lowest));
    one.logical_max = static_cast<std::int32_t>(std::min<std::int64_t>(one.logical_max, lowest + values - 1));
    if (one.logical_max < one.logical_min) return malformed(item.at, "a logical maximum below the minimum");
    one.physical_min = g.physical_min;
    one.physical_max = g.physical_max;
    one.unit = g.unit;
    one.unit_exponent = g.unit_exponent;
    one.collection = open_;
    if (one.is_array) one.choices = usages_;
    // Those that no value selects are none.
    const std::int64_t selects = std::int64_t{one.logical_max} - one.logical_min + 1;
    if (std::cmp_less(selects, one.choices.size())) one.choices.resize(static_cast<std::size_t>(selects));
    for (std::uint32_t i = 0; i < g.report_count; ++i) {
      one.bit_offset = static_cast<std::uint16_t>(begin + i * g.report_size);
      if (!one.is_array) one.usage = usages_[std::min<std::size_t>(i, usages_.size() - 1)];
      out_.fields_.push_back(one);
    }
    return {};
  }

  std::span<const std::uint8_t> bytes_;
  HidReports out_;
  Globals globals_;
  std::vector<Globals> pushed_;
  Locals locals_;
  std::vector<HidUsage> usages_;  ///< Of the main item at hand.
  std::int16_t open_ = -1;
  std::size_t depth_ = 0;
};

Result<HidReports> HidReports::parse(std::span<const std::uint8_t> descriptor) {
  return HidDescriptorReader(descriptor).read();
}

bool HidReports::isWithin(const HidField& field, HidUsage collection) const noexcept {
  for (std::int16_t at = field.collection; at >= 0; at = collections_[static_cast<std::size_t>(at)].parent) {
    if (collections_[static_cast<std::size_t>(at)].usage == collection) return true;
  }
  return false;
}

bool HidReports::hasCollection(HidUsage usage) const noexcept {
  return std::any_of(collections_.begin(), collections_.end(), [&](const auto& c) { return c.usage == usage; });
}

const HidField* HidReports::find(HidKind kind, HidUsage usage, HidUsage within) const noexcept {
  for (const HidField& field : fields_) {
    if (field.kind == kind && !field.is_array && field.usage == usage && (within == 0 || isWithin(field, within))) {
      return &field;
    }
  }
  return nullptr;
}

const HidField* HidReports::findChoice(HidKind kind, HidUsage choice, HidUsage within) const noexcept {
  for (const HidField& field : fields_) {
    if (field.kind == kind && field.is_array && (within == 0 || isWithin(field, within)) &&
        std::find(field.choices.begin(), field.choices.end(), choice) != field.choices.end()) {
      return &field;
    }
  }
  return nullptr;
}

std::size_t HidReports::reportBytes(HidKind kind, std::uint8_t report_id) const noexcept {
  for (const Report& one : reports_) {
    if (one.kind == kind && one.id == report_id) return (one.bits + 7) / 8 + (numbered_ ? 1 : 0);
  }
  return 0;
}

std::int32_t valueOfChoice(const HidField& field, HidUsage choice) noexcept {
  const auto at = std::find(field.choices.begin(), field.choices.end(), choice);
  if (at == field.choices.end()) return field.logical_min - 1;
  return field.logical_min + static_cast<std::int32_t>(at - field.choices.begin());
}

std::int32_t extract(const HidField& field, std::span<const std::uint8_t> data) HD_RT {
  if (field.bits == 0 || field.bit_offset + field.bits > 8 * data.size()) return 0;
  std::uint64_t value = 0;
  for (unsigned i = 0; i < field.bits; ++i) {
    const unsigned bit = field.bit_offset + i;
    value |= static_cast<std::uint64_t>((data[bit / 8] >> (bit % 8)) & 1u) << i;
  }
  const bool negative = field.logical_min < 0 && ((value >> (field.bits - 1)) & 1u) != 0;
  if (negative) value |= ~std::uint64_t{0} << field.bits;
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(value));
}

void insert(const HidField& field, std::int32_t value, std::span<std::uint8_t> data) HD_RT {
  if (field.bit_offset + field.bits > 8 * data.size()) return;
  const auto bits = static_cast<std::uint32_t>(std::clamp(value, field.logical_min, field.logical_max));
  for (unsigned i = 0; i < field.bits; ++i) {
    const unsigned bit = field.bit_offset + i;
    const auto mask = static_cast<std::uint8_t>(1u << (bit % 8));
    const bool on = ((bits >> i) & 1u) != 0;
    data[bit / 8] = static_cast<std::uint8_t>(on ? data[bit / 8] | mask : data[bit / 8] & ~mask);
  }
}

}  // namespace hapticd
