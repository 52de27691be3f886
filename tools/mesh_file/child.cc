#include "tools/mesh_file/child.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <new>
#include <string>
#include <string_view>
#include <thread>

#include "tools/mesh_file/mesh_error.h"

namespace hapticd_mesh_file {
namespace {

enum Outcome : int { kRead = 0, kFailed = 1, kNoMemory = 2, kUnsaid = 3 };

/** Memory that both processes see; gone with the last of them. */
class Shared {
 public:
  Shared() : fd_(::memfd_create("hapticd-mesh", MFD_CLOEXEC)) {}
  Shared(const Shared&) = delete;
  Shared& operator=(const Shared&) = delete;
  ~Shared() {
    if (fd_ >= 0) ::close(fd_);
  }
  [[nodiscard]] bool valid() const { return fd_ >= 0; }

  [[nodiscard]] bool put(const void* data, std::size_t bytes) const {
    for (const char* at = static_cast<const char*>(data); bytes > 0;) {
      const ssize_t n = ::write(fd_, at, bytes);
      if (n <= 0) return false;
      at += n;
      bytes -= static_cast<std::size_t>(n);
    }
    return true;
  }
  /** What was put, from the beginning on. */
  [[nodiscard]] bool take(void* data, std::size_t bytes) {
    for (char* at = static_cast<char*>(data); bytes > 0;) {
      const ssize_t n = ::pread(fd_, at, bytes, taken_);
      if (n <= 0) return false;
      at += n;
      taken_ += n;
      bytes -= static_cast<std::size_t>(n);
    }
    return true;
  }
  [[nodiscard]] std::string takeRest() {
    std::string all(static_cast<std::size_t>(::lseek(fd_, 0, SEEK_END) - taken_), '\0');
    if (!take(all.data(), all.size())) all.clear();
    return all;
  }

 private:
  int fd_;
  off_t taken_ = 0;
};

struct Head {
  std::uint64_t vertices, triangles, meshes, skipped;
  std::array<double, 3> lower, upper;
};

/** Of the machine [B]. */
std::uint64_t memory() {
  return static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

/** In the child: so much more than it has. */
void bound(std::uint64_t bytes) {
  std::uint64_t pages = 0;  // Those of a sanitizer, say, are many.
  std::ifstream("/proc/self/statm") >> pages;
  rlimit space{};
  if (::getrlimit(RLIMIT_AS, &space) != 0) return;
  space.rlim_cur =
      std::min<rlim_t>(space.rlim_cur, pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) + bytes);
  ::setrlimit(RLIMIT_AS, &space);
}

/** In the child: whether it has come to its bound. Of memory that it did not get an XML parser says only: no scene. */
bool wasFull() {
  constexpr std::uint64_t kNearly = 64 << 20;
  rlimit space{};
  if (::getrlimit(RLIMIT_AS, &space) != 0) return false;
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    std::uint64_t kilobytes = 0;
    if (word == "VmPeak:" && status >> kilobytes) return kilobytes * 1024 + kNearly > space.rlim_cur;
  }
  return false;
}

/** In the child. */
int answer(const Shared& shared, const std::function<MeshFile()>& read) {
  try {
    const MeshFile mesh = read();
    const Head head{mesh.vertices.size(), mesh.triangles.size(), mesh.meshes, mesh.skipped, mesh.lower, mesh.upper};
    const bool put = shared.put(&head, sizeof head) &&
                     shared.put(mesh.vertices.data(), mesh.vertices.size() * sizeof mesh.vertices[0]) &&
                     shared.put(mesh.triangles.data(), mesh.triangles.size() * sizeof mesh.triangles[0]);
    return put ? kRead : kNoMemory;
  } catch (const MeshError& error) {
    if (wasFull()) return kNoMemory;
    std::string text;
    for (const std::string& part : {std::string(error.what()), error.remedy, error.code}) text += part + '\0';
    return shared.put(text.data(), text.size()) ? kFailed : kUnsaid;
  } catch (const std::bad_alloc&) {
    return kNoMemory;
  } catch (...) {
    return kUnsaid;
  }
}

MeshFile takeMesh(Shared& shared) {
  Head head{};
  MeshFile mesh;
  bool whole = shared.take(&head, sizeof head);
  if (whole) {
    mesh.vertices.resize(head.vertices);
    mesh.triangles.resize(head.triangles);
    whole = shared.take(mesh.vertices.data(), head.vertices * sizeof mesh.vertices[0]) &&
            shared.take(mesh.triangles.data(), head.triangles * sizeof mesh.triangles[0]);
  }
  if (!whole) throw MeshError("what was read of it got lost", "try again");
  mesh.meshes = head.meshes;
  mesh.skipped = head.skipped;
  mesh.lower = head.lower;
  mesh.upper = head.upper;
  return mesh;
}

MeshError takeError(Shared& shared) {
  const std::string text = shared.takeRest();
  std::string_view rest = text;
  std::string parts[3];
  for (std::string& part : parts) {
    part = rest.substr(0, rest.find('\0'));
    rest.remove_prefix(std::min(rest.size(), part.size() + 1));
  }
  return MeshError(parts[0].empty() ? "cannot be read" : parts[0], parts[1], parts[2]);
}

}  // namespace

MeshFile readInChild(const std::function<MeshFile()>& read, const std::function<bool()>& interrupted,
                     std::uint64_t most_bytes) {
  Shared shared;
  if (!shared.valid()) return read();
  const pid_t parent = ::getpid(), child = ::fork();
  if (child < 0) return read();  // No more processes: it may go well.
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // It reads for nobody else.
    if (::getppid() != parent) ::_exit(kUnsaid);
    for (const int end : {SIGINT, SIGTERM, SIGHUP}) {
      if (std::signal(end, SIG_DFL) == SIG_IGN) std::signal(end, SIG_IGN);  // nohup stays so.
    }
    const rlimit no_core{0, 0};
    ::setrlimit(RLIMIT_CORE, &no_core);
    bound(std::min(most_bytes, memory()));
    ::_exit(answer(shared, read));
  }
  int status = 0;
  // Some files keep the library busy for ever.
  for (pid_t ended = 0; ended == 0 || (ended < 0 && errno == EINTR);) {
    ended = ::waitpid(child, &status, WNOHANG);
    if (ended != 0) continue;
    if (interrupted()) ::kill(child, SIGKILL);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  // Also of one that had read it all before it was asked for the first time.
  if (interrupted()) throw MeshError("its reading was cancelled", {}, kCancelled);
  if (WIFEXITED(status) && WEXITSTATUS(status) == kRead) return takeMesh(shared);
  if (WIFEXITED(status) && WEXITSTATUS(status) == kFailed) throw takeError(shared);
  if (WIFEXITED(status) && WEXITSTATUS(status) == kNoMemory) {
    throw MeshError(most_bytes < memory()
                        ? fmt::format("holds more than {} MB, far more than its size lets expect", most_bytes >> 20)
                        : std::string("is too large for this machine's memory, or damaged"),
                    most_bytes < memory() ? "export it as STL or PLY" : "make it coarser", kBadMesh);
  }
  throw MeshError(WIFSIGNALED(status) ? fmt::format("the reader died of it ({})", ::strsignal(WTERMSIG(status)))
                                      : std::string("cannot be read"),
                  "the file is damaged or cut short: export it again", kBadMesh);
}

}  // namespace hapticd_mesh_file
