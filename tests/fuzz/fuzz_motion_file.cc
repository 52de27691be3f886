// The motions of hapticctl: whatever the file holds, it is refused with a place or can be played.
#include <sys/mman.h>
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/file/motion_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace hapticctl;
  static const int kFile = memfd_create("motion", MFD_CLOEXEC);
  static const std::string kPath = "/proc/self/fd/" + std::to_string(kFile);
  std::string text(reinterpret_cast<const char*>(data), size);
  if (size > 0 && data[0] != '#') text = "t,x,y,z\n0,0,0,0\n" + text;  // most inputs begin behind a good header
  if (ftruncate(kFile, 0) != 0 || pwrite(kFile, text.data(), text.size(), 0) != static_cast<ssize_t>(text.size())) {
    std::abort();
  }
  try {
    const Motion motion = Motion::read(kPath);
    if (!(motion.duration() > 0) || !std::isfinite(motion.duration())) std::abort();
    for (const double share : {-1.0, 0.0, 0.3, 0.999999, 1.0, 1.7}) {
      for (const double x : motion.at(share * motion.duration())) {
        if (!std::isfinite(x)) std::abort();
      }
    }
  } catch (const Failure& failure) {
    if (failure.where.rfind(kPath, 0) != 0 || failure.what.empty() || failure.exit != kExitFile) std::abort();
  }
  return 0;
}
