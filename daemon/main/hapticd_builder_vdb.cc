// hapticd-builder-vdb: makes an OpenVDB file (descriptor 4) of a file of hapticd's volume cache (descriptor 3).
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>

#include "daemon/builder/sandbox.h"
#include "daemon/builder/vdb/cached_vdb.h"
#include "daemon/builder/vdb/write_vdb.h"
#include "daemon/ipc/unique_fd.h"

namespace {

constexpr int kFrom = 3, kTo = 4;

int fail(const hapticd::Error& error) {
  std::fprintf(stderr, "hapticd-builder-vdb: %s\n", toString(error).c_str());
  return 1;
}

int writeAll(const std::string& bytes) {
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t n = ::write(kTo, bytes.data() + at, bytes.size() - at);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return fail(hapticd::systemError("vdb", "write", errno));
    at += static_cast<std::size_t>(n);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace hapticd;  // NOLINT(google-build-using-namespace)
  std::uint64_t memory_bytes = 0;
  struct stat from {
  }, to{};
  const bool started = argc == 2 && ::fstat(kFrom, &from) == 0 && ::fstat(kTo, &to) == 0 && from.st_size > 0;
  const char* const end = argc == 2 ? argv[1] + std::strlen(argv[1]) : nullptr;
  if (!started || std::from_chars(argv[1], end, memory_bytes).ptr != end) {
    std::fputs("hapticd-builder-vdb is started by hapticd; it does nothing by itself.\n", stderr);
    return 2;
  }
  prepareVdb();
  // OpenVDB's log library has threads from the start.
  if (const auto entered = enterSandbox(memory_bytes, SandboxThreads::kAll); !entered) return fail(entered.error());
  const auto size = static_cast<std::size_t>(from.st_size);
  void* const mapped = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, kFrom, 0);
  if (mapped == MAP_FAILED) return fail(systemError("vdb", "mmap", errno));
  const auto vdb = vdbOfCached({static_cast<const std::byte*>(mapped), size});
  const int code = vdb ? writeAll(*vdb) : fail(vdb.error());
  ::_exit(code);  // Libraries' farewells make calls that the sandbox forbids.
}
