// hapticd-builder: turns uploaded meshes into snapshots for hapticd, which starts it with a socket on descriptor 3.
#include <sys/socket.h>

#include <charconv>
#include <cstdio>
#include <cstring>

#include "daemon/builder/sandbox.h"
#include "daemon/builder/serve.h"
#include "daemon/ipc/builder_protocol.h"

int main(int argc, char** argv) {
  using namespace hapticd;  // NOLINT(google-build-using-namespace)
  std::uint64_t memory_bytes = 0;
  int type = 0;
  socklen_t size = sizeof type;
  const bool started = argc == 2 && ::getsockopt(kBuilderSocket, SOL_SOCKET, SO_TYPE, &type, &size) == 0;
  const char* const end = argc == 2 ? argv[1] + std::strlen(argv[1]) : nullptr;
  if (!started || std::from_chars(argv[1], end, memory_bytes).ptr != end) {
    std::fputs("hapticd-builder is started by hapticd; it does nothing by itself.\n", stderr);
    return 2;
  }
  if (const auto entered = enterSandbox(memory_bytes); !entered) {
    std::fprintf(stderr, "hapticd-builder: %s\n", toString(entered.error()).c_str());
    return 3;
  }
  return serveBuilds(kBuilderSocket);
}
