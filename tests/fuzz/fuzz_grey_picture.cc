// Pictures of hapticctl: whatever the bytes, refused with a reason or as many pixels as promised.
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <string>

#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/file/grey_picture.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace hapticctl;
  static const int kFile = memfd_create("picture", MFD_CLOEXEC);
  static const std::string kPath = "/proc/self/fd/" + std::to_string(kFile);
  if (ftruncate(kFile, 0) != 0 || pwrite(kFile, data, size, 0) != static_cast<ssize_t>(size)) std::abort();
  try {
    const GreyPicture picture = readPng(kPath);
    if (picture.grey.size() != std::size_t{picture.width} * picture.height) std::abort();
  } catch (const Failure& failure) {
    if (failure.where != kPath || failure.what.empty() || failure.exit != kExitFile) std::abort();
  }
  return 0;
}
