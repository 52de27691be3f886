#include "libclient/src/session/mapping.h"

#include <sys/mman.h>
#include <sys/stat.h>

#include <cerrno>

namespace hapticd::client {

Failure Mapping::map(int fd, std::size_t bytes, bool writable, const char* name, Mapping& mapping) {
  struct stat status {};
  if (fstat(fd, &status) != 0) return {HAPTIC_SYSTEM, name, strerror(errno), {}};
  if (status.st_size < 0 || static_cast<std::size_t>(status.st_size) < bytes) {
    return {HAPTIC_VERSION_MISMATCH, name,
            "holds " + std::to_string(status.st_size) + " bytes, expected " + std::to_string(bytes),
            "install hapticd and libhapticclient of the same release"};
  }
  void* address = mmap(nullptr, bytes, writable ? PROT_READ | PROT_WRITE : PROT_READ, MAP_SHARED | MAP_POPULATE, fd, 0);
  if (address == MAP_FAILED) return {HAPTIC_SYSTEM, name, std::string("cannot be mapped: ") + strerror(errno), {}};
  madvise(address, bytes, MADV_DONTFORK);
  Mapping made;
  made.address_ = address;
  made.bytes_ = bytes;
  mapping = std::move(made);
  return {};
}

void Mapping::unmap() noexcept {
  if (address_ != nullptr) munmap(address_, bytes_);
  address_ = nullptr;
  bytes_ = 0;
}

}  // namespace hapticd::client
