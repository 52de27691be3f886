#include <fmt/core.h>
#include <gdcmTrace.h>
#include <itkGDCMImageIO.h>
#include <itkGDCMSeriesFileNames.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "tools/hapticctl-import/complaints.h"
#include "tools/hapticctl-import/format/image_file.h"
#include "tools/hapticctl-import/itk/dicom_frames.h"
#include "tools/hapticctl-import/itk/itk_values.h"
#include "tools/hapticctl-import/itk/scan_file.h"

namespace hapticctl_import {
namespace {

namespace fs = std::filesystem;

constexpr double kMostOff = 0.02;  // Of a step, by which a slice may be out of its place: positions are rounded.

struct Slice {
  Image image;
  std::string file;
  double along = 0;  ///< The slices' normal [mm].
  std::optional<float> padding{};
};

Double3 cross(const Double3& a, const Double3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Double3& a, const Double3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length(const Double3& a) { return std::sqrt(dot(a, a)); }
Double3 minus(const Double3& a, const Double3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

std::string nameOf(const std::string& path) { return fs::path(path).filename().string(); }

std::string tagOf(itk::GDCMImageIO& io, const char* tag) {
  std::string value;
  io.GetValueFromTag(tag, value);
  while (!value.empty() && (value.back() == ' ' || value.back() == '\0')) value.pop_back();
  for (char& c : value)
    if (static_cast<unsigned char>(c) < 32 || c == 127) c = '?';  // It goes to a terminal.
  return value;
}

/** "CT, Head 1.0 B31f, 108 files" */
std::string describe(const std::vector<std::string>& files) {
  const auto io = itk::GDCMImageIO::New();
  io->SetFileName(files.front());
  std::string text;
  try {
    io->ReadImageInformation();
    for (const char* tag : {"0008|0060", "0008|103e"})
      if (const std::string value = tagOf(*io, tag); !value.empty()) text += value + ", ";
    text += fmt::format("{} x {} values, ", io->GetDimensions(0), io->GetDimensions(1));
  } catch (const itk::ExceptionObject&) {
    text = "no picture, ";  // A report, say; it can still be listed.
  }
  return text + fmt::format("{} {}", files.size(), files.size() == 1 ? "file" : "files");
}

Image readSlice(const std::string& file) try {
  const auto io = itk::GDCMImageIO::New();
  io->SetFileName(file);
  Image image = readWith(*io);
  requireWholeDicom(file);
  if (image.size[2] == 1) placeSlice(file, image);
  scaleDose(file, image);
  return image;
} catch (const ImportError& error) {
  throw ImportError(nameOf(file), (error.where.empty() ? "" : error.where + ": ") + error.what(), error.remedy);
}

/** Within a slice. */
bool isOneMillimetre(const Image& image) { return spacing(image, 0) == 1 && spacing(image, 1) == 1; }

/** The slices' normal, whose sign is that of the first one's axes. */
Double3 normalOf(const Image& slice) {
  Double3 n = cross(slice.step[0], slice.step[1]);
  const double size = length(n);
  for (double& x : n) x /= size;
  return n;
}

void requireAlike(const Slice& first, const Slice& other) {
  if (other.image.size != first.image.size) {
    throw ImportError(nameOf(other.file),
                      fmt::format("is {} x {} values, {} is {} x {}", other.image.size[0], other.image.size[1],
                                  nameOf(first.file), first.image.size[0], first.image.size[1]),
                      "put only slices of one kind into the folder");
  }
  for (std::size_t k = 0; k < 2; ++k) {
    if (length(minus(other.image.step[k], first.image.step[k])) > 1e-3 * length(first.image.step[k])) {
      throw ImportError(nameOf(other.file), fmt::format("is turned or spaced otherwise than {}", nameOf(first.file)),
                        "put only slices of one kind into the folder");
    }
  }
}

/**
 * The frames of an image as slices of their own, or none if it does not say where each lies: of enhanced ones GDCM
 * takes only those that are in order and evenly spaced for a volume, of others the spacing of few kinds, and else tells
 * 1 mm.
 */
std::vector<Slice> slicesOf(const Slice& all) {
  const std::vector<DicomFrame> frames = framesOf(all.file);
  if (frames.size() < 2) return {};
  if (frames.size() != all.image.size[2]) {
    throw ImportError(nameOf(all.file),
                      fmt::format("says of {} frames where they lie, and holds {}", frames.size(), all.image.size[2]),
                      "is the file whole?");
  }
  const std::size_t count = std::size_t{all.image.size[0]} * all.image.size[1];
  std::vector<Slice> slices;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const DicomFrame &frame = frames[i], &first = frames[0];
    Slice slice{{}, fmt::format("{}, frame {}", all.file, i + 1), 0, all.padding};
    slice.image.size = {all.image.size[0], all.image.size[1], 1};
    slice.image.origin = frame.position;
    for (std::size_t a = 0; a < 3; ++a) {
      slice.image.step[0][a] = frame.row[a] * frame.column_spacing;
      slice.image.step[1][a] = frame.column[a] * frame.row_spacing;
    }
    const auto part = [&](const auto& from, auto& to) {
      if (from.empty()) return;
      const auto begin = from.begin() + static_cast<std::ptrdiff_t>(i * count);
      to.assign(begin, begin + static_cast<std::ptrdiff_t>(count));
    };
    part(all.image.values, slice.image.values);
    part(all.image.exact, slice.image.exact);
    if (frame.slope != first.slope || frame.intercept != first.intercept) {  // GDCM has taken the first one's.
      const auto asItsOwn = [&](double v) {
        return (v - first.intercept) / first.slope * frame.slope + frame.intercept;
      };
      for (float& v : slice.image.values) v = static_cast<float>(asItsOwn(static_cast<double>(v)));
      for (double& v : slice.image.exact) v = asItsOwn(v);
    }
    slices.push_back(std::move(slice));
  }
  return slices;
}

/** Puts a slice's values behind those of the slices before it. */
void append(const Image& slice, Image& all) {
  if (!slice.exact.empty() || !all.exact.empty()) {
    all.exact.insert(all.exact.end(), all.values.begin() + static_cast<std::ptrdiff_t>(all.exact.size()),
                     all.values.end());
    if (slice.exact.empty()) {
      all.exact.insert(all.exact.end(), slice.values.begin(), slice.values.end());
    } else {
      all.exact.insert(all.exact.end(), slice.exact.begin(), slice.exact.end());
    }
  }
  all.values.insert(all.values.end(), slice.values.begin(), slice.values.end());
}

/** The step from slice to slice, which must be the same everywhere; oblique if the gantry was tilted. */
Double3 evenStep(const std::vector<Slice>& slices) {
  std::vector<double> gaps;
  for (std::size_t i = 1; i < slices.size(); ++i) {
    gaps.push_back(slices[i].along - slices[i - 1].along);
    if (gaps.back() < 1e-4) {
      throw ImportError(nameOf(slices[i].file), fmt::format("stands where {} does", nameOf(slices[i - 1].file)),
                        "choose one time or echo of the series");
    }
  }
  std::vector<double> sorted = gaps;
  std::sort(sorted.begin(), sorted.end());
  const double usual = sorted[sorted.size() / 2];
  const double most = kMostOff * usual + 2e-3;
  const auto refuse = [&](std::size_t i) {
    throw ImportError(nameOf(slices[i].file),
                      fmt::format("stands {:.4g} mm after {}, but steps are {:.4g} mm: is a slice missing?",
                                  gaps[i - 1], nameOf(slices[i - 1].file), usual),
                      "fetch the series again, or resample it elsewhere");
  };
  for (std::size_t i = 1; i < slices.size(); ++i)
    if (std::abs(gaps[i - 1] - usual) > most) refuse(i);
  Double3 step = minus(slices.back().image.origin, slices[0].image.origin);
  for (double& x : step) x /= static_cast<double>(gaps.size());
  for (std::size_t i = 1; i < slices.size(); ++i) {
    Double3 off = minus(slices[i].image.origin, slices[0].image.origin);
    for (std::size_t a = 0; a < 3; ++a) off[a] -= static_cast<double>(i) * step[a];
    if (length(off) > 2 * most) refuse(i);
  }
  return step;
}

/**
 * Where nothing was measured there is nothing solid: it becomes the lowest value, as what is no number does. Padding
 * below what was measured is that already, and one among it may be no padding, for some files name a value that they
 * measure: both stay.
 */
void clearPadding(Image& image, const std::optional<float>& padding) {
  if (!padding) return;
  float lowest = INFINITY, highest = -INFINITY;
  std::size_t count = 0;
  const auto isPadding = [&](float v) { return std::abs(v - *padding) <= 1e-6F * std::abs(*padding); };
  for (const float v : image.values) {
    if (isPadding(v)) {
      ++count;
      continue;
    }
    lowest = std::min(lowest, v);
    highest = std::max(highest, v);
  }
  if (count == 0 || lowest > highest || highest > *padding) return;
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    if (!isPadding(image.values[i])) continue;
    image.values[i] = lowest;
    if (!image.exact.empty()) image.exact[i] = lowest;
  }
  image.format += fmt::format(", {} values of it padding", count);
}

}  // namespace

bool isDicom(const std::string& path) {
  const Complaints complaints;
  return fs::is_regular_file(path) && itk::GDCMImageIO::New()->CanReadFile(path.c_str());
}

std::vector<DicomSeries> dicomSeriesIn(const std::string& path) try {
  const Complaints complaints;
  const bool folder = fs::is_directory(path);
  const fs::path parent = fs::path(path).parent_path();
  const auto names = itk::GDCMSeriesFileNames::New();
  names->SetUseSeriesDetails(true);  // Series of one number that differ in kind come apart.
  names->SetInputDirectory(folder ? path : parent.empty() ? "." : parent.string());
  std::vector<DicomSeries> all;
  for (const std::string& uid : names->GetSeriesUIDs()) {
    DicomSeries series{uid, {}, names->GetFileNames(uid)};
    if (series.files.empty()) continue;
    const bool wanted = folder || std::any_of(series.files.begin(), series.files.end(), [&](const std::string& file) {
                          std::error_code ignored;
                          return fs::equivalent(file, path, ignored);
                        });
    if (!wanted) continue;
    series.text = describe(series.files);
    all.push_back(std::move(series));
  }
  if (all.empty() && folder)
    throw ImportError({}, "holds no DICOM images", "name the folder in which the slices lie, or an image file");
  if (all.empty()) throw ImportError({}, "belongs to no series", "is it whole?");
  return all;
} catch (const itk::ExceptionObject& error) {
  throw ImportError({}, inWords(error), "is it whole?");
}

Image readSeries(const DicomSeries& series) {
  gdcm::Trace::WarningOn();  // GDCM tells of incomplete values in no other way; ITK turns it off.
  std::vector<Slice> slices;
  for (const std::string& file : series.files) slices.push_back({readSlice(file), file, 0, paddingOf(file)});
  if (slices.size() == 1) {  // All slices in one file.
    if (auto frames = slicesOf(slices[0]); !frames.empty()) slices = std::move(frames);
  }
  if (slices.size() == 1) {
    Image image = std::move(slices[0].image);
    image.format = "DICOM, " + series.text + whatIsNotSaid(series.files.front(), true, isOneMillimetre(image));
    clearPadding(image, slices[0].padding);
    requireTwo(image, "size");
    checkPlace(image);
    return image;
  }
  const Double3 normal = normalOf(slices[0].image);
  for (Slice& slice : slices) {
    if (slice.image.size[2] != 1)
      throw ImportError(nameOf(slice.file), "holds several slices, and is one of several files", "import it alone");
    requireAlike(slices[0], slice);
    slice.along = dot(slice.image.origin, normal);
  }
  std::stable_sort(slices.begin(), slices.end(), [](const Slice& a, const Slice& b) { return a.along < b.along; });
  Image image;
  image.format = "DICOM, " + series.text + whatIsNotSaid(series.files.front(), false, isOneMillimetre(slices[0].image));
  image.size = {slices[0].image.size[0], slices[0].image.size[1], static_cast<std::uint32_t>(slices.size())};
  image.origin = slices[0].image.origin;
  image.step = slices[0].image.step;
  image.step[2] = evenStep(slices);
  for (Slice& slice : slices) {
    append(slice.image, image);
    slice.image = {};
  }
  const auto same = [&](const Slice& slice) { return slice.padding == slices[0].padding; };
  if (std::all_of(slices.begin(), slices.end(), same)) clearPadding(image, slices[0].padding);
  requireTwo(image, "size");
  checkPlace(image);
  return image;
}

}  // namespace hapticctl_import
