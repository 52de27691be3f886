#include "daemon/scene/volume_cache.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/sendfile.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstring>
#include <filesystem>

#include "daemon/log.h"
#include "daemon/memfd.h"
#include "proto/volume.h"
#include "rt/scene/snapshot_checksum.h"

namespace hapticd {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMagic = UINT64_C(0x3145484341434448);  // "HDCACHE1"
constexpr std::uint64_t kMostPart = UINT64_C(1) << 34;
constexpr std::uint64_t kMostNotes = 1 << 16;

/** Snapshot, volume and notes follow, each note ended by a newline. The first two carry checksums of their own. */
struct Head {
  std::uint64_t magic = kMagic;
  std::uint32_t snapshot_version = HD_SNAPSHOT_VERSION;
  std::uint32_t volume_version = HD_VOLUME_VERSION;
  std::uint64_t snapshot_bytes = 0, volume_bytes = 0, notes_bytes = 0;
};

bool copy(int from, int to, std::uint64_t bytes) {
  while (bytes > 0) {
    const ssize_t n = ::sendfile(to, from, nullptr, bytes);
    if (n <= 0) return false;
    bytes -= static_cast<std::uint64_t>(n);
  }
  return true;
}

/** The next `bytes` of a file as a sealed memfd; invalid if that cannot be. */
UniqueFd readPart(int file, std::uint64_t bytes, const char* name) {
  auto memfd = Memfd::create(name, bytes);
  if (!memfd || !copy(file, memfd->fd(), bytes) || !memfd->seal(Seals::kFrozen)) return {};
  auto fd = memfd->share();
  return fd ? std::move(*fd) : UniqueFd();
}

std::uint64_t sizeOf(int fd) {
  struct stat s {};
  return ::fstat(fd, &s) == 0 ? static_cast<std::uint64_t>(s.st_size) : 0;
}

bool writeFile(const std::string& path, int snapshot, int volume, const std::string& notes) {
  UniqueFd file(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0600));
  if (!file.valid()) return false;
  Head head;
  head.snapshot_bytes = sizeOf(snapshot);
  head.volume_bytes = sizeOf(volume);
  head.notes_bytes = notes.size();
  const auto whole = [&](const void* data, std::size_t bytes) {
    return ::write(file.get(), data, bytes) == static_cast<ssize_t>(bytes);
  };
  // Descriptors of one memfd share their place: from the start, whoever read last.
  if (::lseek(snapshot, 0, SEEK_SET) != 0 || ::lseek(volume, 0, SEEK_SET) != 0) return false;
  return whole(&head, sizeof head) && copy(snapshot, file.get(), head.snapshot_bytes) &&
         copy(volume, file.get(), head.volume_bytes) && whole(notes.data(), notes.size()) && ::fsync(file.get()) == 0;
}

/** Removes the files longest unused until the rest fits. */
void prune(const std::string& directory, std::uint64_t most_bytes) {
  struct File {
    fs::path path;
    fs::file_time_type used;
    std::uint64_t bytes;
  };
  std::vector<File> files;
  std::error_code error;
  std::uint64_t sum = 0;
  for (const auto& entry : fs::directory_iterator(directory, error)) {
    if (entry.path().extension() != ".hvol" || !entry.is_regular_file(error)) continue;
    files.push_back({entry.path(), entry.last_write_time(error), entry.file_size(error)});
    sum += files.back().bytes;
  }
  std::sort(files.begin(), files.end(), [](const File& a, const File& b) { return a.used < b.used; });
  for (const File& file : files) {
    if (sum <= most_bytes) return;
    fs::remove(file.path, error);
    sum -= file.bytes;
  }
}

}  // namespace

VolumeCache::VolumeCache(std::string directory, std::uint64_t most_bytes)
    : directory_(std::move(directory)), most_bytes_(most_bytes) {
  std::error_code error;
  fs::create_directories(directory_, error);
  if (error) log::warn("no cache of volumes: {}: {}", directory_, error.message());
}

VolumeCache::~VolumeCache() { wait(); }

void VolumeCache::wait() {
  if (writer_.joinable()) writer_.join();
}

std::string VolumeCache::keyOf(std::span<const std::byte> upload, std::uint32_t uid) {
  // The checksum leaves out what is short of a word.
  std::uint64_t rest = 0;
  const std::size_t tail = upload.size() % 8;
  std::memcpy(&rest, upload.data() + upload.size() - tail, tail);
  const std::uint64_t sum = snapshotChecksum(upload) ^ (rest * HD_CHECKSUM_PRIME);
  return fmt::format("{}-{:016x}-{}-{}.{}", uid, sum, upload.size(), HD_SNAPSHOT_VERSION, HD_VOLUME_VERSION);
}

std::optional<CachedBuild> VolumeCache::find(const std::string& key) {
  UniqueFd file(::open(pathOf(key).c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
  if (!file.valid()) return {};
  Head head, expected;
  if (::read(file.get(), &head, sizeof head) != static_cast<ssize_t>(sizeof head)) return {};
  const bool known = head.magic == expected.magic && head.snapshot_version == expected.snapshot_version &&
                     head.volume_version == expected.volume_version && head.snapshot_bytes > 0 &&
                     head.snapshot_bytes <= kMostPart && head.volume_bytes > 0 && head.volume_bytes <= kMostPart &&
                     head.notes_bytes <= kMostNotes &&
                     sizeof head + head.snapshot_bytes + head.volume_bytes + head.notes_bytes == sizeOf(file.get());
  if (!known) return {};
  CachedBuild found;
  found.snapshot = readPart(file.get(), head.snapshot_bytes, "hapticd-mesh");
  found.volume = readPart(file.get(), head.volume_bytes, "hapticd-volume");
  std::string notes(head.notes_bytes, '\0');
  if (!found.snapshot.valid() || !found.volume.valid() ||
      ::read(file.get(), notes.data(), notes.size()) != static_cast<ssize_t>(notes.size()))
    return {};
  for (std::size_t at = 0, end; (end = notes.find('\n', at)) != std::string::npos; at = end + 1)
    found.notes.push_back(log::printable(notes.substr(at, end - at)));
  (void)::futimens(file.get(), nullptr);  // Used now: it goes last.
  return found;
}

void VolumeCache::drop(const std::string& key) {
  std::error_code error;
  fs::remove(pathOf(key), error);
}

void VolumeCache::keep(const std::string& key, UniqueFd snapshot, UniqueFd volume,
                       const std::vector<std::string>& notes) {
  if (writing_.load()) return;
  wait();
  std::string text;
  for (const std::string& note : notes) text += note + "\n";
  writing_.store(true);
  writer_ = std::thread(
      [this, path = pathOf(key), text = std::move(text), snapshot = std::move(snapshot), volume = std::move(volume)] {
        const std::string unfinished = path + ".new";
        std::error_code error;
        if (writeFile(unfinished, snapshot.get(), volume.get(), text)) {
          fs::rename(unfinished, path, error);
          prune(directory_, most_bytes_);
        } else {
          fs::remove(unfinished, error);
        }
        writing_.store(false);
      });
}

}  // namespace hapticd
