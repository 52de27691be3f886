// What hapticd-vendor says to the daemon, and what it is told: whatever the bytes, an error or values within bounds.
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "drivers/vendor/helper_protocol.h"

namespace {

using namespace hapticd;

/** A good message of each kind, from which the fuzzer's bytes are only so far as it changes them. */
std::vector<std::uint8_t> sent(bool request) {
  int pair[2];
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET, 0, pair) != 0) std::abort();
  const Result<void> done = request ? sendRequest(pair[0], {"dhd://0", 1}, pair[0]) : sendAnswer(pair[0], {});
  std::vector<std::uint8_t> bytes(1 << 16);
  const ssize_t size = ::recv(pair[1], bytes.data(), bytes.size(), 0);
  if (!done || size <= 0) std::abort();
  bytes.resize(static_cast<std::size_t>(size));
  ::close(pair[0]);
  ::close(pair[1]);
  return bytes;
}

void judge(std::span<const std::uint8_t> bytes) {
  if (const auto request = decodeRequest(bytes); request && request.value().uri.size() > kMostHelperUri) std::abort();
  const auto answer = decodeAnswer(bytes);
  if (!answer) return;
  const DeviceInfo& info = answer.value().info;
  std::string said = info.model + info.serial;
  if (answer.value().opened) {
    if (!std::isfinite(info.max_force) || !info.max_workspace_upper.allFinite()) std::abort();
  } else {
    said += toString(answer.value().opened.error());
  }
  if (std::any_of(said.begin(), said.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; })) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::vector<std::uint8_t> kGood[] = {sent(true), sent(false)};
  judge({data, size});
  constexpr std::size_t kHead = 16;
  for (std::vector<std::uint8_t> bytes : kGood) {
    std::copy_n(data, std::min(size, bytes.size() - kHead), bytes.begin() + kHead);
    judge(bytes);
  }
  return 0;
}
