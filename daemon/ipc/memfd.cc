#include "daemon/ipc/memfd.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <atomic>
#include <cerrno>
#include <limits>
#include <system_error>

#include "drivers/run_out.h"

#ifndef MFD_NOEXEC_SEAL
#define MFD_NOEXEC_SEAL 0x0008U
#endif
#ifndef F_SEAL_EXEC
#define F_SEAL_EXEC 0x0020
#endif

namespace hapticd {
namespace {

constexpr int kFixed = F_SEAL_SHRINK | F_SEAL_GROW;

int bitsOf(Seals seals) {
  switch (seals) {
    case Seals::kNone:
      return 0;
    case Seals::kFixedSize:
      return kFixed;
    case Seals::kNoNewWriters:
      return kFixed | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL;
    case Seals::kFrozen:
      return kFixed | F_SEAL_WRITE | F_SEAL_SEAL;
  }
  return 0;
}

std::string namesOf(int bits) {
  static constexpr struct {
    int bit;
    const char* name;
  } kNames[] = {{F_SEAL_SHRINK, "SHRINK"},
                {F_SEAL_GROW, "GROW"},
                {F_SEAL_WRITE, "WRITE"},
                {F_SEAL_FUTURE_WRITE, "FUTURE_WRITE"},
                {F_SEAL_SEAL, "SEAL"}};
  std::string text;
  for (const auto& [bit, name] : kNames) {
    if ((bits & bit) == 0) continue;
    if (!text.empty()) text += '|';
    text += name;
  }
  return text.empty() ? "none" : text;
}

/** What to do where something has run out; empty for what is no want. */
std::string remedyFor(int number) {
  switch (number) {
    case ENOMEM:
      return std::string(remedyForWant(number)) + " (the builder's: builder.memory_mb)";
    case ENOSPC:
    case EDQUOT:
      return "make room on the disk";
    case EFBIG:
      return "raise LimitFSIZE= or ulimit -f";
    default:
      const char* const remedy = remedyForWant(number);
      return remedy == nullptr ? "" : remedy;
  }
}

}  // namespace

std::string unlessRunOut(int number, std::string remedy) {
  if (std::string of_want = remedyFor(number); !of_want.empty()) return of_want;
  return remedy;
}

Error systemError(std::string where, const char* call, int number, std::string remedy) {
  if (remedy.empty()) remedy = remedyFor(number);
  return {ErrorCode::kSystem, std::move(where), std::string(call) + ": " + std::generic_category().message(number),
          std::move(remedy)};
}

Result<UniqueFd> duplicate(int fd) {
  UniqueFd copy(::fcntl(fd, F_DUPFD_CLOEXEC, 3));
  if (!copy.valid()) return systemError("descriptor " + std::to_string(fd), "F_DUPFD_CLOEXEC", errno);
  return copy;
}

Mapping& Mapping::operator=(Mapping&& other) noexcept {
  if (this != &other) {
    reset();
    data_ = std::exchange(other.data_, nullptr);
    size_ = std::exchange(other.size_, 0);
    writable_ = std::exchange(other.writable_, false);
  }
  return *this;
}

void Mapping::reset() noexcept {
  if (data_ != nullptr) ::munmap(data_, size_);
  data_ = nullptr;
  size_ = 0;
  writable_ = false;
}

Result<void> Mapping::lock() {
  if (data_ == nullptr) return {};
  if (::mlock(data_, size_) != 0) {
    const int number = errno;
    rlimit limit{};
    ::getrlimit(RLIMIT_MEMLOCK, &limit);
    const std::string allowed = limit.rlim_cur == RLIM_INFINITY ? "unlimited" : std::to_string(limit.rlim_cur);
    return systemError(
        "locking " + std::to_string(size_) + " bytes", "mlock", number,
        "RLIMIT_MEMLOCK is " + allowed + " bytes in all; raise it (LimitMEMLOCK=, limits.conf) or unload meshes");
  }
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  for (std::size_t i = 0; i < size_; i += page) {
    auto& first = reinterpret_cast<unsigned char&>(data_[i]);
    if (writable_) {
      std::atomic_ref<unsigned char>(first).fetch_or(0, std::memory_order_relaxed);
    } else {
      (void)*const_cast<volatile unsigned char*>(&first);
    }
  }
  return {};
}

Result<Memfd> Memfd::create(const char* name, std::size_t bytes) {
  if (bytes == 0 || bytes > static_cast<std::size_t>(std::numeric_limits<off_t>::max())) {
    return Error{
        ErrorCode::kInvalidArgument, name, "a size of " + std::to_string(bytes) + " bytes is not possible", {}};
  }
  unsigned flags = MFD_CLOEXEC | MFD_ALLOW_SEALING | MFD_NOEXEC_SEAL;
  int fd = ::memfd_create(name, flags);
  if (fd < 0 && errno == EINVAL) fd = ::memfd_create(name, flags & ~MFD_NOEXEC_SEAL);  // before Linux 6.3
  if (fd < 0) return systemError(name, "memfd_create", errno);
  Memfd memfd;
  memfd.fd_.reset(fd);
  memfd.size_ = bytes;
  if (::ftruncate(fd, static_cast<off_t>(bytes)) != 0)
    return systemError(std::string(name) + ", " + std::to_string(bytes) + " bytes", "ftruncate", errno);
  return memfd;
}

Result<Memfd> Memfd::adopt(UniqueFd fd) {
  Memfd memfd;
  memfd.fd_ = std::move(fd);
  if (::fcntl(memfd.fd(), F_GET_SEALS) < 0)
    return Error{ErrorCode::kInvalidArgument, "descriptor", "is not memory that can be sealed", {}};
  struct stat status {};
  if (::fstat(memfd.fd(), &status) != 0) return systemError("memfd", "fstat", errno);
  if (status.st_size <= 0) return Error{ErrorCode::kInvalidArgument, "memfd", "is empty", {}};
  memfd.size_ = static_cast<std::size_t>(status.st_size);
  return memfd;
}

Result<Mapping> Memfd::map(Access access) const {
  const int protection = access == Access::kRead ? PROT_READ : PROT_READ | PROT_WRITE;
  const int flags = access == Access::kPrivate ? MAP_PRIVATE : MAP_SHARED;
  void* address = ::mmap(nullptr, size_, protection, flags, fd_.get(), 0);
  if (address == MAP_FAILED) return systemError("mapping " + std::to_string(size_) + " bytes", "mmap", errno);
  Mapping mapping;
  mapping.data_ = static_cast<std::byte*>(address);
  mapping.size_ = size_;
  mapping.writable_ = access != Access::kRead;
  return mapping;
}

Result<int> Memfd::sealBits() const {
  const int bits = ::fcntl(fd_.get(), F_GET_SEALS);
  if (bits < 0) return systemError("memfd", "F_GET_SEALS", errno);
  return bits & ~F_SEAL_EXEC;
}

Result<void> Memfd::seal(Seals seals) const {
  auto present = sealBits();
  if (!present) return present.error();
  const int missing = bitsOf(seals) & ~*present;
  if (missing != 0 && ::fcntl(fd_.get(), F_ADD_SEALS, missing) != 0) {
    if (errno == EBUSY)
      return Error{ErrorCode::kStillMapped, "memfd", "is mapped writable by somebody", "unmap it before commit"};
    return systemError("memfd", ("F_ADD_SEALS " + namesOf(missing)).c_str(), errno);
  }
  return requireSeals(seals);
}

Result<void> Memfd::requireSeals(Seals seals) const {
  auto present = sealBits();
  if (!present) return present.error();
  if (*present == bitsOf(seals)) return {};
  return Error{ErrorCode::kPermissionDenied,
               "memfd",
               "its seals are " + namesOf(*present) + " and must be " + namesOf(bitsOf(seals)),
               {}};
}

}  // namespace hapticd
