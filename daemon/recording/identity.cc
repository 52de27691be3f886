// What has to be the same for a replay to be the same bit for bit.
#include <gnu/libc-version.h>

#include "daemon/recording/recording.h"

namespace hapticd {

std::string realtimeBuild() {
  static const char kBuild[] =
#include "realtime_build.inc"
      ;
  return kBuild;
}

std::string instructionSet() {
  std::string out;
#if defined(__x86_64__)
  out = "x86_64";
  // The wide paths of the library, and those by which glibc picks its sine and cosine.
  if (__builtin_cpu_supports("avx2")) out += " avx2";
  if (__builtin_cpu_supports("fma")) out += " fma";
  if (__builtin_cpu_supports("avx512f")) out += " avx512f";
#elif defined(__aarch64__)
  out = "aarch64";
#else
  out = "unknown";
#endif
  return out + ", glibc " + gnu_get_libc_version();
}

}  // namespace hapticd
