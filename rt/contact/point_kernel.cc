#include "rt/contact/point_kernel.h"

namespace hapticd {
namespace {

bool can(PointPath path) noexcept {
#if defined(__x86_64__)
  __builtin_cpu_init();
  switch (path) {
    case PointPath::kPortable:
      return true;
    case PointPath::kAvx2:
      return __builtin_cpu_supports("avx2") != 0;
    case PointPath::kAvx512:
      return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512bw") != 0 &&
             __builtin_cpu_supports("avx512dq") != 0 && __builtin_cpu_supports("avx512vl") != 0;
  }
#endif
  return path == PointPath::kPortable;
}

const PointKernel& kernelOf(PointPath path) noexcept {
#if defined(__x86_64__)
  if (path == PointPath::kAvx2) return kAvx2PointKernel;
  if (path == PointPath::kAvx512) return kAvx512PointKernel;
#endif
  (void)path;
  return kPortablePointKernel;
}

PointPath best() noexcept {
  if (can(PointPath::kAvx512)) return PointPath::kAvx512;
  return can(PointPath::kAvx2) ? PointPath::kAvx2 : PointPath::kPortable;
}

PointPath chosen = best();
const PointKernel* kernel = &kernelOf(chosen);

}  // namespace

const PointKernel& pointKernel() noexcept { return *kernel; }

PointPath pointPath() noexcept { return chosen; }

bool choosePointPath(PointPath path) noexcept {
  if (!can(path)) return false;
  chosen = path;
  kernel = &kernelOf(path);
  return true;
}

const char* nameOf(PointPath path) noexcept {
  switch (path) {
    case PointPath::kAvx512:
      return "AVX-512";
    case PointPath::kAvx2:
      return "AVX2";
    case PointPath::kPortable:
      break;
  }
  return "portable";
}

}  // namespace hapticd
