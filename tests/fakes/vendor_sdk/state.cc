#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>

#include "fake_sdk.h"

namespace {

fake_sdk::State* makeState() {
  const char* const path = std::getenv("FAKE_SDK_STATE");
  const int file = path == nullptr ? -1 : ::open(path, O_RDWR | O_CLOEXEC);
  const int flags = file < 0 ? MAP_SHARED | MAP_ANONYMOUS : MAP_SHARED;
  void* const at = ::mmap(nullptr, sizeof(fake_sdk::State), PROT_READ | PROT_WRITE, flags, file, 0);
  if (file >= 0) ::close(file);
  if (at == MAP_FAILED) std::abort();
  auto* state = static_cast<fake_sdk::State*>(at);  // All zeros is its beginning.
  if (state->version_major == 0) {                  // Nobody has set it up.
    state->version_major = 3;
    state->system_type = 33;
    state->calibrated = true;
    for (int i = 0; i < 9; i += 4) state->rotation[i] = 1;
  }
  return state;
}

/** As SDKs look for devices behind the network. */
bool mayUseTheNetwork() {
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket >= 0) ::close(socket);
  return socket >= 0;
}

}  // namespace

fake_sdk::State* fake_sdk_state() {
  static fake_sdk::State* const state = makeState();
  return state;
}

bool fake_sdk::held() {
  const int owner = fake_sdk_state()->owner;
  return owner != 0 && ::kill(owner, 0) == 0;
}

void fake_sdk::hold(bool on) {
  if (on && fake_sdk_state()->crashes) std::abort();
  if (on) fake_sdk_state()->network = mayUseTheNetwork() ? 1 : -1;
  fake_sdk_state()->owner = on ? ::getpid() : 0;
}
