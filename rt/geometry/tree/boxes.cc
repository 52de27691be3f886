#include "rt/geometry/tree/boxes.h"

namespace hapticd {
namespace {

bool canAvx2() noexcept {
#if defined(__x86_64__)
  __builtin_cpu_init();
  return __builtin_cpu_supports("avx2") != 0;
#else
  return false;
#endif
}

const BoxTests& testsOf(VectorPath path) noexcept {
#if defined(__x86_64__)
  if (path == VectorPath::kAvx2) return kAvx2BoxTests;
#endif
  (void)path;
  return kPortableBoxTests;
}

VectorPath chosen = canAvx2() ? VectorPath::kAvx2 : VectorPath::kPortable;
const BoxTests* tests = &testsOf(chosen);

}  // namespace

const BoxTests& boxTests() noexcept { return *tests; }

VectorPath vectorPath() noexcept { return chosen; }

bool choosePath(VectorPath path) noexcept {
  if (path == VectorPath::kAvx2 && !canAvx2()) return false;
  chosen = path;
  tests = &testsOf(path);
  return true;
}

const char* nameOf(VectorPath path) noexcept { return path == VectorPath::kAvx2 ? "AVX2" : "portable"; }

}  // namespace hapticd
