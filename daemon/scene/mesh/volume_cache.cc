#include "daemon/scene/mesh/volume_cache.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/sendfile.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <regex>
#include <system_error>

#include "daemon/ipc/memfd.h"
#include "daemon/log/log.h"
#include "daemon/scene/mesh/sync_in_parts.h"
#include "rt/base/clock.h"
#include "rt/scene/snapshot_checksum.h"

namespace hapticd {
namespace {

namespace fs = std::filesystem;

/** By parts, as long as `go_on` says so: else ECANCELED. After each as long as `part_done` is well, with its errno. */
template <class GoOn, class PartDone>
bool copy(int from, int to, std::uint64_t bytes, GoOn go_on, PartDone part_done) {
  while (bytes > 0) {
    if (!go_on()) {
      errno = ECANCELED;
      return false;
    }
    const ssize_t n = ::sendfile(to, from, nullptr, std::min<std::uint64_t>(bytes, kDiskPart_bytes));
    if (n <= 0 || !part_done()) return false;
    bytes -= static_cast<std::uint64_t>(n);
  }
  return true;
}

/** The next `bytes` of a file as a sealed memfd; invalid if that cannot be, or is not to be. */
template <class GoOn>
UniqueFd readPart(int file, std::uint64_t bytes, const char* name, GoOn go_on) {
  auto memfd = Memfd::create(name, bytes);
  if (!memfd || !copy(file, memfd->fd(), bytes, go_on, [] { return true; }) || !memfd->seal(Seals::kFrozen)) return {};
  auto fd = memfd->share();
  return fd ? std::move(*fd) : UniqueFd();
}

std::uint64_t sizeOf(int fd) {
  struct stat s {};
  return ::fstat(fd, &s) == 0 ? static_cast<std::uint64_t>(s.st_size) : 0;
}

/** Of a volume; nothing if it is too short for one. */
std::optional<std::uint64_t> headerChecksum(int volume) {
  std::array<std::byte, sizeof(hd_volume_header)> header;
  if (::pread(volume, header.data(), header.size(), 0) != static_cast<ssize_t>(header.size())) return {};
  return snapshotChecksum(header);
}

constexpr const char* kNoFolder = "hapticd must be able to write to that folder; builder.cache names another";

/** `number` becomes that of the system's error, if it is one; ECANCELED where `go_on` no longer says so. */
template <class GoOn>
Result<void> writeFile(const std::string& path, int snapshot, int volume, const std::string& notes, int& number,
                       GoOn go_on) {
  const auto failed = [&](const char* call, const char* remedy) {
    number = errno;
    return systemError(path, call, number, remedy);
  };
  UniqueFd file(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0600));
  if (!file.valid()) return failed("open", unlessRunOut(errno, kNoFolder).c_str());
  CachedBuildHead head;
  head.snapshot_bytes = sizeOf(snapshot);
  head.volume_bytes = sizeOf(volume);
  head.notes_bytes = notes.size();
  const auto header = headerChecksum(volume);
  if (!header) return Error{ErrorCode::kBadSnapshot, path, "has no volume", {}};
  head.volume_header = *header;
  const auto whole = [&](const void* data, std::size_t bytes) {
    const ssize_t n = ::write(file.get(), data, bytes);
    if (n >= 0 && n != static_cast<ssize_t>(bytes)) errno = ENOSPC;  // A short write means a full disk.
    return n == static_cast<ssize_t>(bytes);
  };
  const auto whole_copy = [&](int from, std::uint64_t bytes) {
    // Onto the disk part by part: fsync() of all of it would hear nothing until the end.
    return copy(from, file.get(), bytes, go_on, [&] { return putOntoDisk(file.get(), 0, 0); });
  };
  // Descriptors of one memfd share their offset, so rewind: somebody else may have read it.
  if (::lseek(snapshot, 0, SEEK_SET) != 0 || ::lseek(volume, 0, SEEK_SET) != 0) return failed("lseek", "");
  if (whole(&head, sizeof head) && whole_copy(snapshot, head.snapshot_bytes) && whole_copy(volume, head.volume_bytes) &&
      whole(notes.data(), notes.size()) && ::fsync(file.get()) == 0)
    return {};
  return failed("write", "make room on the disk, or see builder.cache_mb");
}

/** A volume on disk with what lies beside it. */
struct Entry {
  fs::path cached, vdb;
  fs::file_time_type used;
  std::uint64_t bytes = 0, vdb_bytes = 0;
  bool ahead = false;  ///< Used by a clock that has been set back since: nobody knows when.
};

/** Where the volume lies beside which that OpenVDB file is; empty if it is of another version. */
std::string cachedOf(const std::string& vdb) {
  const std::string_view ending = kCachedVdbEnding;
  if (vdb.size() < ending.size() || vdb.substr(vdb.size() - ending.size()) != ending) return {};
  return vdb.substr(0, vdb.size() - ending.size()) + ".hvol";
}

/**
 * Whether it is named as this class, of whatever version, names what it makes. Nothing else is touched: an
 * administrator may name a folder where other volumes lie.
 */
bool isOurs(const fs::path& file) {
  static const std::regex kName(R"(\d+-[0-9a-f]{16}-\d+-\d+(\.\d+)+\.(hvol|(v\d+\.)?vdb)(\.new)?)");
  return std::regex_match(file.filename().string(), kName);
}

/** Those longest unused first, what is built now last whatever the clock was. OpenVDB files of another version, or
 * whose volume is gone, are removed. */
std::vector<Entry> entriesOf(const std::string& directory) {
  std::vector<Entry> entries;
  std::error_code error;
  const auto now = fs::file_time_type::clock::now();
  for (const auto& file : fs::directory_iterator(directory, error)) {
    fs::path other = file.path();
    if (!isOurs(other)) continue;
    if (other.extension() == ".vdb" && !fs::exists(cachedOf(other), error)) fs::remove(file.path(), error);
    if (other.extension() != ".hvol" || !file.is_regular_file(error)) continue;
    other.replace_extension(kCachedVdbEnding);
    Entry entry{file.path(), other, file.last_write_time(error), 0};
    entry.bytes = fs::file_size(entry.cached, error);
    if (error) continue;  // It has gone meanwhile.
    entry.ahead = entry.used > now;
    if (const auto beside = fs::file_size(entry.vdb, error); !error) entry.vdb_bytes = beside;
    entries.push_back(std::move(entry));
  }
  std::sort(entries.begin(), entries.end(),
            [](const Entry& a, const Entry& b) { return a.ahead != b.ahead ? a.ahead : a.used < b.used; });
  return entries;
}

}  // namespace

VolumeCache::VolumeCache(std::string directory, std::uint64_t most_bytes, std::optional<VdbOptions> vdb)
    : directory_(std::move(directory)), most_bytes_(most_bytes) {
  std::error_code error;
  fs::create_directories(directory_, error);
  if (!error && ::access(directory_.c_str(), W_OK | X_OK) != 0) error.assign(errno, std::generic_category());
  if (error) {
    trouble_ = Trouble{{ErrorCode::kSystem, directory_, error.message(), kNoFolder}, error.value(), 0};
    log::warn("built volumes are not kept on disk: {}", toString(trouble_->why));
  }
  for (const auto& file : fs::directory_iterator(directory_, error))
    if (file.path().extension() == ".new" && isOurs(file.path())) fs::remove(file.path(), error);
  (void)entriesOf(directory_);  // What an older hapticd made goes.
  if (vdb) maker_ = std::make_unique<VdbMaker>(std::move(*vdb), [this] { prune(); });
}

VolumeCache::~VolumeCache() {
  stop();
  awaitWriter();
}

void VolumeCache::stop(std::int64_t patience_ns) noexcept {
  std::int64_t never = kNever;
  (void)stop_ns_.compare_exchange_strong(never, MonotonicClock().now() + patience_ns);
  const std::lock_guard lock(mutex_);
  if (jobs_.size() <= 1) return;
  log::warn("{} volumes that were still to be written are not kept on disk", jobs_.size() - 1);
  jobs_.resize(1);
}

bool VolumeCache::mayWrite() const noexcept { return MonotonicClock().now() < stop_ns_.load(); }

std::vector<CachedVolume> VolumeCache::list() const {
  std::vector<CachedVolume> all;
  const auto now = fs::file_time_type::clock::now();
  for (const Entry& entry : entriesOf(directory_)) {
    all.push_back({entry.cached.stem(), entry.bytes, entry.vdb_bytes,
                   std::max(0.0, std::chrono::duration<double>(now - entry.used).count())});
  }
  return all;
}

Result<UniqueFd> VolumeCache::openVdb(const std::string& key) {
  const std::string where = "OpenVDB file";
  UniqueFd file(::open(vdbOf(key).c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
  if (file.valid()) return file;
  if (!maker_)
    return Error{ErrorCode::kUnsupported, where, "none are made here", "install hapticd-vdb, and see builder.vdb"};
  if (isWaiting(key) || maker_->waits(vdbOf(key)))
    return Error{ErrorCode::kWouldBlock, where, "it is being made", "try again in some seconds"};
  return Error{ErrorCode::kNotFound, where, "it is not there", "hapticd's log says why; load the mesh again"};
}

bool VolumeCache::isWaiting(const std::string& key) {
  const std::lock_guard lock(mutex_);
  return std::any_of(jobs_.begin(), jobs_.end(), [&](const Job& job) { return job.key == key; });
}

void VolumeCache::awaitWriter() {
  if (writer_.joinable()) writer_.join();
}

void VolumeCache::wait() {
  awaitWriter();
  if (maker_) maker_->wait();
}

void VolumeCache::prune() {
  const std::lock_guard lock(pruning_);
  std::vector<Entry> entries = entriesOf(directory_);
  if (entries.empty()) return;
  std::uint64_t sum = 0;
  for (const Entry& entry : entries) sum += entry.bytes + entry.vdb_bytes;
  std::size_t left = entries.size();
  const auto remove = [&](const fs::path& path, std::uint64_t bytes) {
    std::error_code error;
    fs::remove(path, error);
    sum -= bytes;
  };
  // What cannot stay pushes nothing else out.
  if (Entry& last = entries.back(); last.bytes + last.vdb_bytes > most_bytes_) {
    remove(last.vdb, last.vdb_bytes);
    last.vdb_bytes = 0;
  }
  for (const Entry& entry : entries) {
    if (sum <= most_bytes_ && left <= kMostVolumes) return;
    // The OpenVDB file goes first; the newest volume is better kept without its own than dropped.
    remove(entry.vdb, entry.vdb_bytes);
    if (&entry == &entries.back() && sum <= most_bytes_) return;
    remove(entry.cached, entry.bytes);
    --left;
  }
}

std::string VolumeCache::keyOf(std::span<const std::byte> upload, std::uint32_t uid) {
  // The checksum covers whole words only: add the bytes after the last of them.
  std::uint64_t rest = 0;
  const std::size_t tail = upload.size() % 8;
  std::memcpy(&rest, upload.data() + upload.size() - tail, tail);
  const std::uint64_t sum = snapshotChecksum(upload) ^ (rest * HD_CHECKSUM_PRIME);
  return fmt::format("{}-{:016x}-{}-{}.{}.{}", uid, sum, upload.size(), HD_SNAPSHOT_VERSION, HD_VOLUME_VERSION,
                     kBuilderVersion);
}

std::optional<CachedBuild> VolumeCache::find(const std::string& key) {
  UniqueFd file(::open(pathOf(key).c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
  if (!file.valid()) return {};
  CachedBuildHead head;
  if (::read(file.get(), &head, sizeof head) != static_cast<ssize_t>(sizeof head)) return {};
  if (!head.fits(sizeOf(file.get()))) return {};
  CachedBuild found;
  const auto go_on = [this] { return stop_ns_.load() == kNever; };
  found.snapshot = readPart(file.get(), head.snapshot_bytes, "hapticd-mesh", go_on);
  found.volume = readPart(file.get(), head.volume_bytes, "hapticd-volume", go_on);
  if (headerChecksum(found.volume.get()) != head.volume_header) return {};
  std::string notes(head.notes_bytes, '\0');
  if (!found.snapshot.valid() || !found.volume.valid() ||
      ::read(file.get(), notes.data(), notes.size()) != static_cast<ssize_t>(notes.size()))
    return {};
  for (std::size_t at = 0, end; (end = notes.find('\n', at)) != std::string::npos; at = end + 1)
    found.notes.push_back(log::printable(notes.substr(at, end - at)));
  (void)::futimens(file.get(), nullptr);  // Used now: it goes last.
  if (maker_ && ::access(vdbOf(key).c_str(), F_OK) != 0) maker_->want(pathOf(key), vdbOf(key), false);
  return found;
}

void VolumeCache::drop(const std::string& key) {
  std::error_code error;
  fs::remove(pathOf(key), error);
  fs::remove(vdbOf(key), error);
}

void VolumeCache::keep(const std::string& key, UniqueFd snapshot, UniqueFd volume,
                       const std::vector<std::string>& notes) {
  if (isWaiting(key)) return;
  Job job{key, {}, std::move(snapshot), std::move(volume)};
  for (const std::string& note : notes) job.notes += note + "\n";
  job.bytes = sizeof(CachedBuildHead) + sizeOf(job.snapshot.get()) + sizeOf(job.volume.get()) + job.notes.size();
  {
    const std::lock_guard lock(mutex_);
    std::uint64_t waiting = 0;
    for (const Job& other : jobs_) waiting += other.bytes;
    if (!jobs_.empty() && (jobs_.size() >= kMostJobs || waiting + job.bytes > kMostJobBytes)) {
      log::warn("a volume is not kept on disk: {} MB of {} wait to be written (load it again later)",
                fmt::format("{:.1f}", static_cast<double>(waiting) * 1e-6),
                jobs_.size() == 1 ? std::string("another") : fmt::format("{} others", jobs_.size()));
      return;
    }
    jobs_.push_back(std::move(job));
    if (jobs_.size() > 1) return;  // The writer comes to it.
  }
  awaitWriter();  // It has found nothing more, and ends.
  try {
    writer_ = std::thread([this] { write(); });
  } catch (const std::exception& e) {  // No more threads: the mesh is there all the same.
    {
      const std::lock_guard lock(mutex_);
      jobs_.clear();
    }
    log::warn("a volume is not kept on disk: no thread can be started: {} (raise TasksMax= or the user's nproc)",
              e.what());
  }
}

void VolumeCache::write() noexcept {
  std::unique_lock lock(mutex_);
  while (!jobs_.empty()) {
    Job& job = jobs_.front();  // A reference stays valid while others are appended.
    lock.unlock();
    try {
      store(job);
    } catch (const std::exception& e) {  // Nobody is above us.
      log::warn("a volume is not kept on disk: {}", e.what());
    }
    job.snapshot = UniqueFd();  // Here: giving large memory back takes its time.
    job.volume = UniqueFd();
    lock.lock();
    jobs_.pop_front();
  }
}

void VolumeCache::notKept(Error why, int number, std::uint64_t bytes) {
  log::warn("a volume is not kept on disk: {}", toString(why));
  const std::lock_guard lock(mutex_);
  trouble_ = Trouble{std::move(why), number, bytes};
}

std::optional<Error> VolumeCache::trouble() {
  const std::lock_guard lock(mutex_);
  if (trouble_ && isGone(*trouble_)) trouble_.reset();
  if (!trouble_) return {};
  return trouble_->why;
}

/** As far as it can be seen without writing. */
bool VolumeCache::isGone(const Trouble& trouble) const {
  const UniqueFd folder(::open(directory_.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
  if (!folder.valid() || ::faccessat(folder.get(), ".", W_OK | X_OK, 0) != 0) return false;
  switch (trouble.number) {
    case EACCES:
    case EPERM:
    case EROFS:
    case ENOENT:
    case ENOTDIR:
    case EMFILE:
    case ENFILE:
      return true;
    case ENOSPC: {
      struct statvfs disk {};
      if (::fstatvfs(folder.get(), &disk) != 0 || (disk.f_files != 0 && disk.f_favail == 0)) return false;
      return disk.f_bavail >= trouble.bytes / disk.f_frsize + 1;
    }
    default:
      return false;
  }
}

void VolumeCache::store(const Job& job) {
  const std::string path = pathOf(job.key), vdb = vdbOf(job.key), unfinished = path + ".new";
  std::error_code error, ignored;
  if (job.bytes > most_bytes_) {  // It would push out all others, and then go itself.
    log::warn("a volume is not kept on disk: it has {:.1f} MB, all of them may have {:.1f} MB (see builder.cache_mb)",
              static_cast<double>(job.bytes) * 1e-6, static_cast<double>(most_bytes_) * 1e-6);
    return;
  }
  int number = 0;
  const auto written =
      writeFile(unfinished, job.snapshot.get(), job.volume.get(), job.notes, number, [this] { return mayWrite(); });
  if (!written) {
    if (number == ECANCELED) {
      log::warn("a volume that was being written is not kept on disk: hapticd ends");
    } else {
      notKept(written.error(), number, job.bytes);
    }
    fs::remove(unfinished, ignored);
    return;
  }
  fs::remove(vdb, ignored);  // Of another volume than the one that comes.
  fs::rename(unfinished, path, error);
  if (error) {
    notKept({ErrorCode::kSystem, path, error.message(), kNoFolder}, error.value(), job.bytes);
    fs::remove(unfinished, ignored);
    return;
  }
  {
    const std::lock_guard lock(mutex_);
    trouble_.reset();
  }
  prune();
  if (maker_) maker_->want(path, vdb, true);
}

}  // namespace hapticd
