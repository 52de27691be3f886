#include "tools/hapticctl-import/itk/dicom_frames.h"

#include <fmt/core.h>
#include <gdcmAttribute.h>
#include <gdcmByteValue.h>
#include <gdcmReader.h>
#include <gdcmSequenceOfItems.h>

#include <algorithm>
#include <cstring>
#include <initializer_list>
#include <set>

#include "tools/hapticctl-import/complaints.h"
#include "tools/hapticctl-import/format/image_file.h"

namespace hapticctl_import {
namespace {

using Items = gdcm::SmartPointer<gdcm::SequenceOfItems>;

constexpr std::size_t kMostFrames = 65536;  ///< As an image may have values along an axis.

gdcm::Tag pixels() { return {0x7fe0, 0x10}; }

Items itemsOf(const gdcm::DataSet& set, const gdcm::Tag& tag) {
  return set.FindDataElement(tag) ? set.GetDataElement(tag).GetValueAsSQ() : Items();
}

/** Numbers in words; empty if they are not there. */
std::vector<double> numbersOf(const gdcm::DataSet& set, const gdcm::Tag& tag, std::size_t count) {
  if (!set.FindDataElement(tag)) return {};
  const gdcm::ByteValue* const value = set.GetDataElement(tag).GetByteValue();
  if (value == nullptr || value->GetLength() == 0) return {};
  std::string text(value->GetPointer(), value->GetLength());
  for (char& c : text) {
    if (c == '\\' || c == '\0') c = ' ';
    if (c < 32 || c > 126) c = '?';  // It goes to a terminal.
  }
  return numbersIn(text, fmt::format("({:04x},{:04x})", tag.GetGroup(), tag.GetElement()), count, "is the file whole?");
}

/** In the one item of a group. */
std::vector<double> numbersOf(const gdcm::DataSet& set, const gdcm::Tag& group, const gdcm::Tag& tag,
                              std::size_t count) {
  const Items items = itemsOf(set, group);
  if (items == nullptr || items->GetNumberOfItems() == 0) return {};
  return numbersOf(items->GetItem(1).GetNestedDataSet(), tag, count);
}

template <std::uint16_t kGroup, std::uint16_t kElement>
std::uint64_t countOf(const gdcm::DataSet& set, std::uint64_t otherwise) {
  gdcm::Attribute<kGroup, kElement> attribute;
  if (!set.FindDataElement(attribute.GetTag())) return otherwise;
  attribute.SetFromDataElement(set.GetDataElement(attribute.GetTag()));
  return static_cast<std::uint64_t>(std::max<std::int64_t>(0, attribute.GetValue()));
}

/** Low is bright in it. */
bool isTurnedAbout(const gdcm::DataSet& set) {
  const gdcm::Tag kind(0x28, 0x4);
  const gdcm::ByteValue* const value = set.FindDataElement(kind) ? set.GetDataElement(kind).GetByteValue() : nullptr;
  return value != nullptr && std::string(value->GetPointer(), value->GetLength()).rfind("MONOCHROME1", 0) == 0;
}

/** Of a file without functional groups: one step after the other from the first, if it says how far apart they are. */
std::vector<DicomFrame> stackOf(const gdcm::DataSet& set) {
  const std::size_t count = countOf<0x28, 0x8>(set, 1);
  const auto position = numbersOf(set, {0x20, 0x32}, 3), axes = numbersOf(set, {0x20, 0x37}, 6),
             spacing = numbersOf(set, {0x28, 0x30}, 2), step = numbersOf(set, {0x18, 0x88}, 1);
  auto offsets = numbersOf(set, {0x3004, 0xc}, count);  // A dose has these.
  if (count < 2 || count > kMostFrames || position.empty() || axes.empty() || spacing.empty()) return {};
  if (offsets.empty() && !step.empty())
    for (std::size_t i = 0; i < count; ++i) offsets.push_back(static_cast<double>(i) * step[0]);
  std::vector<DicomFrame> frames;
  for (const double offset : offsets) {
    DicomFrame frame;
    std::copy_n(axes.begin(), 3, frame.row.begin());
    std::copy_n(axes.begin() + 3, 3, frame.column.begin());
    const Double3 &r = frame.row, &c = frame.column;
    const Double3 normal{r[1] * c[2] - r[2] * c[1], r[2] * c[0] - r[0] * c[2], r[0] * c[1] - r[1] * c[0]};
    for (std::size_t k = 0; k < 3; ++k) frame.position[k] = position[k] + (offset - offsets[0]) * normal[k];
    frame.row_spacing = spacing[0];
    frame.column_spacing = spacing[1];
    frames.push_back(frame);
  }
  return frames;
}

}  // namespace

std::vector<DicomFrame> framesOf(const std::string& path) {
  const Complaints complaints;
  gdcm::Reader reader;
  reader.SetFileName(path.c_str());
  if (!reader.ReadUpToTag(pixels(), {})) return {};
  const gdcm::DataSet& set = reader.GetFile().GetDataSet();
  const Items shared = itemsOf(set, {0x5200, 0x9229}), each = itemsOf(set, {0x5200, 0x9230});
  if (each == nullptr) return stackOf(set);
  std::vector<DicomFrame> frames;
  for (std::size_t i = 1; i <= each->GetNumberOfItems(); ++i) {
    const auto of = [&](const gdcm::Tag& group, const gdcm::Tag& tag, std::size_t count) {
      auto numbers = numbersOf(each->GetItem(i).GetNestedDataSet(), group, tag, count);
      if (numbers.empty() && shared != nullptr && shared->GetNumberOfItems() > 0)
        numbers = numbersOf(shared->GetItem(1).GetNestedDataSet(), group, tag, count);
      return numbers;
    };
    const auto position = of({0x20, 0x9113}, {0x20, 0x32}, 3), axes = of({0x20, 0x9116}, {0x20, 0x37}, 6),
               spacing = of({0x28, 0x9110}, {0x28, 0x30}, 2), intercept = of({0x28, 0x9145}, {0x28, 0x1052}, 1),
               slope = of({0x28, 0x9145}, {0x28, 0x1053}, 1);
    if (position.empty() || axes.empty() || spacing.empty()) return {};
    DicomFrame frame;
    std::copy_n(position.begin(), 3, frame.position.begin());
    std::copy_n(axes.begin(), 3, frame.row.begin());
    std::copy_n(axes.begin() + 3, 3, frame.column.begin());
    frame.row_spacing = spacing[0];
    frame.column_spacing = spacing[1];
    if (!slope.empty()) frame.slope = slope[0];
    if (!intercept.empty()) frame.intercept = intercept[0];
    frames.push_back(frame);
  }
  return frames;
}

void placeSlice(const std::string& path, Image& slice) {
  const Complaints complaints;
  gdcm::Reader reader;
  reader.SetFileName(path.c_str());
  if (!reader.ReadSelectedTags({{0x20, 0x32}, {0x20, 0x37}, {0x28, 0x30}})) return;
  const gdcm::DataSet& set = reader.GetFile().GetDataSet();
  const auto position = numbersOf(set, {0x20, 0x32}, 3), axes = numbersOf(set, {0x20, 0x37}, 6),
             apart = numbersOf(set, {0x28, 0x30}, 2);
  if (slice.origin == Double3{} && !position.empty() && !axes.empty()) {
    std::copy(position.begin(), position.end(), slice.origin.begin());
    for (std::size_t k = 0; k < 2; ++k) {
      const double length = spacing(slice, k);
      for (std::size_t a = 0; a < 3; ++a) slice.step[k][a] = axes[3 * k + a] * length;
    }
  }
  if (apart.empty()) return;
  for (std::size_t k = 0; k < 2; ++k) {  // Between rows stands first.
    const double times = apart[1 - k] / spacing(slice, k);
    for (double& x : slice.step[k]) x *= times;
  }
}

std::optional<float> paddingOf(const std::string& path) {
  const Complaints complaints;
  gdcm::Reader reader;
  reader.SetFileName(path.c_str());
  if (!reader.ReadUpToTag(pixels(), {})) return std::nullopt;
  const gdcm::DataSet& set = reader.GetFile().GetDataSet();
  const gdcm::Tag padding(0x28, 0x120), each_frame(0x5200, 0x9230);
  if (!set.FindDataElement(padding) || set.FindDataElement(each_frame) || isTurnedAbout(set)) return std::nullopt;
  const gdcm::ByteValue* const bytes = set.GetDataElement(padding).GetByteValue();
  if (bytes == nullptr || bytes->GetLength() != 2) return std::nullopt;
  std::uint16_t stored = 0;
  std::memcpy(&stored, bytes->GetPointer(), sizeof stored);
  // As the values, whatever its own kind: some write one for the other.
  const bool is_signed = countOf<0x28, 0x103>(set, 0) == 1;
  const double value = is_signed ? static_cast<double>(static_cast<std::int16_t>(stored)) : stored;
  const auto slope = numbersOf(set, {0x28, 0x1053}, 1), intercept = numbersOf(set, {0x28, 0x1052}, 1);
  return static_cast<float>(value * (slope.empty() ? 1 : slope[0]) + (intercept.empty() ? 0 : intercept[0]));
}

void scaleDose(const std::string& path, Image& image) {
  const Complaints complaints;
  gdcm::Reader reader;
  reader.SetFileName(path.c_str());
  if (!reader.ReadUpToTag(pixels(), {})) return;
  const auto scaling = numbersOf(reader.GetFile().GetDataSet(), {0x3004, 0xe}, 1);
  if (scaling.empty()) return;
  for (float& v : image.values) v = static_cast<float>(static_cast<double>(v) * scaling[0]);
  image.exact = {};
}

std::string whatIsNotSaid(const std::string& path, bool several_frames, bool is_1_mm) {
  const Complaints complaints;
  gdcm::Reader reader;
  reader.SetFileName(path.c_str());
  if (!reader.ReadUpToTag(pixels(), {})) return {};
  const gdcm::DataSet& set = reader.GetFile().GetDataSet();
  const auto none = [&set](std::initializer_list<gdcm::Tag> tags) {
    return std::none_of(tags.begin(), tags.end(), [&](const gdcm::Tag& tag) { return set.FindDataElement(tag); });
  };
  std::string text;
  if (none({{0x5200, 0x9229}, {0x5200, 0x9230}})) {  // Functional groups say it.
    // That at the detector, of a scanned film, and of regions of ultrasound GDCM takes of their kinds of files alone.
    if (is_1_mm && none({{0x28, 0x30}})) {
      text = ", does not say its spacing";
    } else if (several_frames && none({{0x18, 0x88}, {0x3004, 0xc}})) {
      text = ", does not say the spacing of its frames";
    }
  }
  if (isTurnedAbout(set)) text += ", values turned about (MONOCHROME1)";
  return text;
}

void requireWholeDicom(const std::string& path) {
  const Complaints complaints;
  gdcm::Reader reader;
  reader.SetFileName(path.c_str());
  const std::set<gdcm::Tag> tags = {{0x28, 0x2},   {0x28, 0x8},   {0x28, 0x10},  {0x28, 0x11},
                                    {0x28, 0x100}, {0x28, 0x101}, {0x28, 0x102}, pixels()};
  if (!reader.ReadSelectedTags(tags)) return;  // For others to say.
  const gdcm::DataSet& set = reader.GetFile().GetDataSet();
  if (reader.GetFile().GetHeader().GetDataSetTransferSyntax().IsEncapsulated() || !set.FindDataElement(pixels()))
    return;
  if (const std::uint64_t stored = countOf<0x28, 0x101>(set, 0), high = countOf<0x28, 0x102>(set, 0);
      stored > 0 && high > 0 && high + 1 != stored) {
    throw ImportError("HighBit",
                      fmt::format("is {} of {} bits stored: GDCM would cut the upper ones off", high, stored),
                      "shift the values down elsewhere, so that it is one less than BitsStored");
  }
  const std::uint64_t values = countOf<0x28, 0x10>(set, 0) * countOf<0x28, 0x11>(set, 0) * countOf<0x28, 0x2>(set, 1) *
                               std::max<std::uint64_t>(1, countOf<0x28, 0x8>(set, 1));
  const std::uint64_t needed = (values * countOf<0x28, 0x100>(set, 8) + 7) / 8;
  const std::uint64_t there = set.GetDataElement(pixels()).GetVL();
  if (there < needed) {
    throw ImportError("values", fmt::format("{} bytes are there, {} are needed", there, needed),
                      "is the file whole? Fetch it again");
  }
}

}  // namespace hapticctl_import
