/** @file
 * A directory that is gone when the test is, and when the next one begins if that was killed.
 */
#pragma once

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

namespace hapticd::test {

/**
 * Whoever has one holds a lock on it, which the kernel takes back however it ends. Beside own_daemon.py, which keeps to
 * the same names.
 */
class TemporaryDirectory {
 public:
  TemporaryDirectory() {
    const auto folder = std::filesystem::temp_directory_path();
    static const bool kSwept = (sweep(folder), true);
    (void)kSwept;
    for (int i = 0; !make(folder); ++i)
      if (i == 1000) std::abort();
  }
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;
  ~TemporaryDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
    ::close(lock_);
  }
  [[nodiscard]] const std::string& path() const { return path_; }

  /** Removes what this user's killed tests have left in that folder. */
  static void sweep(const std::filesystem::path& folder) {
    std::error_code ignored;
    for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with(kPrefix) || name.starts_with(kFresh)) sweepOne(entry.path());
    }
  }

 private:
  static constexpr char kPrefix[] = "hapticd-tests-";
  static constexpr char kFresh[] = "hapticd-new-";  ///< For a moment, until it is locked.

  /** False: another, who sweeps, was quicker than the lock. */
  bool make(const std::filesystem::path& folder) {
    std::string fresh = (folder / kFresh).string() + "XXXXXX";
    if (mkdtemp(fresh.data()) == nullptr) std::abort();
    lock_ = ::open(fresh.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    path_ = (folder / (kPrefix + fresh.substr(fresh.size() - 6))).string();
    if (lock_ >= 0 && ::flock(lock_, LOCK_EX | LOCK_NB) == 0 && ::rename(fresh.c_str(), path_.c_str()) == 0)
      return true;
    if (lock_ >= 0) ::close(lock_);
    return false;
  }

  static void sweepOne(const std::filesystem::path& path) {
    const int fd = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (fd < 0) return;
    struct stat held {
    }, named{};
    const bool mine = ::fstat(fd, &held) == 0 && held.st_uid == ::geteuid() && ::flock(fd, LOCK_EX | LOCK_NB) == 0;
    // Once more by name: another may have swept it, and a third have that name now.
    const bool same =
        mine && ::lstat(path.c_str(), &named) == 0 && named.st_dev == held.st_dev && named.st_ino == held.st_ino;
    std::error_code ignored;
    if (same) std::filesystem::remove_all(path, ignored);
    ::close(fd);
  }

  std::string path_;
  int lock_ = -1;
};

}  // namespace hapticd::test
