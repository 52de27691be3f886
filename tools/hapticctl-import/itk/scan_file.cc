#include "tools/hapticctl-import/itk/scan_file.h"

#include <fmt/core.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>

#include "tools/hapticctl-import/complaints.h"
#include "tools/hapticctl-import/format/image_file.h"
#include "tools/hapticctl-import/header/data_place.h"
#include "tools/hapticctl-import/header/header_lines.h"
#include "tools/hapticctl-import/header/header_place.h"
#include "tools/hapticctl-import/itk/itk_values.h"

namespace hapticctl_import {
namespace {

template <class T>
void convert(const std::vector<char>& bytes, Image& out) {
  takeValues(out, [values = reinterpret_cast<const T*>(bytes.data())](std::size_t i) { return values[i]; });
}

void convert(itk::IOComponentEnum kind, const std::vector<char>& bytes, Image& out) {
  using Kind = itk::IOComponentEnum;
  switch (kind) {
    case Kind::UCHAR:
      return convert<unsigned char>(bytes, out);
    case Kind::CHAR:
      return convert<signed char>(bytes, out);
    case Kind::USHORT:
      return convert<unsigned short>(bytes, out);
    case Kind::SHORT:
      return convert<short>(bytes, out);
    case Kind::UINT:
      return convert<unsigned int>(bytes, out);
    case Kind::INT:
      return convert<int>(bytes, out);
    case Kind::ULONG:
      return convert<unsigned long>(bytes, out);
    case Kind::LONG:
      return convert<long>(bytes, out);
    case Kind::ULONGLONG:
      return convert<unsigned long long>(bytes, out);
    case Kind::LONGLONG:
      return convert<long long>(bytes, out);
    case Kind::FLOAT:
      return convert<float>(bytes, out);
    case Kind::DOUBLE:
      return convert<double>(bytes, out);
    default:
      throw ImportError("values", "are of a kind that is not known", "convert the image");
  }
}

void requireFile(const std::string& path) {
  if (const std::ifstream file(path); !file) throw notRead(path, errno);
  if (!std::filesystem::is_regular_file(path))
    throw ImportError({}, "is no file on a disk, and is read more than once", "write it into one first");
}

itk::ImageIOBase::Pointer readerOf(const std::string& path, std::string& format) {
  const itk::ImageIOBase::Pointer readers[] = {itk::NiftiImageIO::New().GetPointer(),
                                               itk::NrrdImageIO::New().GetPointer(),
                                               itk::MetaImageIO::New().GetPointer()};
  const char* const formats[] = {"NIfTI", "NRRD", "MetaImage"};
  const Complaints complaints;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!readers[i]->CanReadFile(path.c_str())) continue;
    format = formats[i];
    return readers[i];
  }
  if (const std::string ending = lower(std::filesystem::path(path).extension().string());
      (ending == ".mha" || ending == ".mhd") && headOf(path).find("NDims") != std::string::npos) {
    format = formats[2];  // Capitals, which MetaIO does not take for its own.
    return readers[2];
  }
  if (isNifti2(path)) throw ImportError({}, "is NIfTI-2, of which NIfTI-1 alone is read", "convert it to NIfTI-1");
  throw ImportError({}, "is no NIfTI, NRRD, MetaImage, DICOM or InVesalius file that can be read",
                    "is it whole, and does its name end in .nii, .nii.gz, .nrrd, .nhdr, .mha or .mhd? For raw numbers "
                    "give --raw, --raw-size and --raw-spacing");
}

}  // namespace

std::string inWords(const itk::ExceptionObject& error) {
  // "itk::ERROR: NiftiImageIO(0x5581e...): what went wrong"
  std::string text = error.GetDescription();
  if (const auto end = text.find("): "); end != std::string::npos) text.erase(0, end + 3);
  for (char& c : text)
    if (c == '\n') c = ' ';
  // NRRD's library tells its way down, "[nrrd] function: trouble [nrrd] function: ...": the last says what is wrong.
  if (const auto last = text.rfind("[nrrd] "); last != std::string::npos)
    text.erase(0, std::min(text.find(": ", last), text.size() - 2) + 2);
  while (!text.empty() && (text.back() == ' ' || text.back() == '.')) text.pop_back();
  return text.empty() ? "cannot be read" : text;
}

Image readWith(itk::ImageIOBase& io, const BeforeValues& before_values) try {
  const Complaints complaints;
  io.ReadImageInformation();
  const unsigned axes = io.GetNumberOfDimensions();
  for (unsigned k = 3; k < axes; ++k) {
    if (io.GetDimensions(k) > 1)
      throw ImportError("axes", "there are more than three", "take one time or component out of it first");
  }
  if (io.GetNumberOfComponents() != 1) {
    throw ImportError("values", fmt::format("each has {} components", io.GetNumberOfComponents()),
                      "only one component can be used");
  }
  Image image;
  itk::ImageIORegion region(axes);
  std::size_t count = 1;
  for (unsigned k = 0; k < axes; ++k) {
    const std::uint64_t n = io.GetDimensions(k);
    if (n < 1 || n > 65536) throw ImportError("size", fmt::format("{} values along an axis", n), "2 to 65536 can be");
    region.SetSize(k, n);
    count *= n;
    if (count > kMostValues) throw ImportError("size", "more than 2^31 values", "shrink the image elsewhere first");
  }
  io.SetIORegion(region);
  image.size = {1, 1, 1};
  image.step = {};
  for (unsigned k = 0; k < 3; ++k) {
    // ITK's directions are columns; of a picture of two axes the third is what stands upright on them.
    if (k >= axes) {
      image.step[k][k] = 1;
      continue;
    }
    image.size[k] = static_cast<std::uint32_t>(io.GetDimensions(k));
    image.origin[k] = io.GetOrigin(k);
    const std::vector<double> direction = io.GetDirection(k);
    for (unsigned a = 0; a < 3 && a < axes; ++a) image.step[k][a] = direction[a] * io.GetSpacing(k);
  }
  const auto size = static_cast<std::size_t>(io.GetImageSizeInBytes());
  if (before_values) before_values(size);
  std::vector<char> bytes(size);
  io.Read(bytes.data());
  // MetaIO tells of data that cannot be unpacked in no other way, and leaves zeros. Others warn of what they mend.
  if (const std::string complaint = complaints.first();
      !complaint.empty() && dynamic_cast<itk::MetaImageIO*>(&io) != nullptr)
    throw ImportError({}, complaint, "is the file whole?");
  image.values.resize(count);
  if (bytes.size() < count * io.GetComponentSize()) throw ImportError("values", "are cut short", "is the file whole?");
  if (complaints.hold("Incomplete Pixel Data"))
    throw ImportError("values", "are cut short", "is the file whole?");  // GDCM
  convert(io.GetComponentType(), bytes, image);
  return image;
} catch (const itk::ExceptionObject& error) {
  const std::string suffix = std::filesystem::path(io.GetFileName()).extension().string();
  const std::string told = inWords(error);
  if (told.find("orthonormal") != told.npos) {
    throw ImportError("orientation", "its axes are not at right angles, or not as long as its spacing says",
                      "resample it to right angles elsewhere");
  }
  if (told.find("not available") != told.npos)
    throw ImportError({}, told, "write it with another encoding: gzip, or raw");
  const bool header = suffix == ".mhd" || suffix == ".nhdr" || suffix == ".hdr";
  throw ImportError({}, told,
                    header ? "is it whole, and are the files of values there that it names?" : "is the file whole?");
}

Image readScan(const std::string& named) {
  itk::Object::SetGlobalWarningDisplay(false);
  requireFile(named);
  std::string format;
  const itk::ImageIOBase::Pointer io = readerOf(named, format);
  const std::string path = format == "NIfTI" ? niftiHeader(named) : named;
  if (format == "NIfTI") requireOwnValues(path);
  io->SetFileName(path);
  Image image = readWith(*io, [&](std::uint64_t bytes) {
    if (format != "NIfTI") requireWhole(path, format, bytes);
  });
  image.format = format;
  if (format == "NIfTI") {
    checkNifti(path, image);
  } else {
    placeAsSaid(headOf(path), format, image);
    image.format += whatIsNotSaid(headOf(path), format);
  }
  requireTwo(image, "size");
  checkPlace(image);
  return image;
}

}  // namespace hapticctl_import
