#include "tools/haptic-bench/whole_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tools/haptic-bench/failure.h"

namespace haptic_bench {
namespace {

constexpr int kEnds[] = {SIGINT, SIGTERM, SIGHUP};
std::atomic<const char*> under_way{nullptr};  // There is one at a time.

void removeAndEnd(int number) {
  if (const char* const part = under_way.load()) ::unlink(part);
  std::signal(number, SIG_DFL);
  std::raise(number);
}

}  // namespace

WholeFile::WholeFile(std::string path) : path_(std::move(path)), part_(path_) {
  if (path_.empty()) throw Failure("the file to write", "its name is empty", "a name");  // ".part" would be written.
  namespace fs = std::filesystem;
  std::error_code none, dangling;
  const fs::file_status status = fs::status(path_, none);
  if (fs::is_directory(status)) throw Failure(path_, "it is a folder", "the name of a file");
  const bool there = fs::is_regular_file(status);
  const auto refuse = [this] { throw Failure(path_, "it cannot be written", "see the path and its rights"); };
  if (there && ::access(path_.c_str(), W_OK) != 0) refuse();  // It is protected, though its folder is not.
  const bool fresh = status.type() == fs::file_type::not_found && !fs::is_symlink(path_, none);
  if (!there && !fresh) {
    if (!std::ofstream(part_, std::ios::binary)) refuse();
    return;
  }
  if (const fs::path real = fs::canonical(path_, dangling); !dangling) path_ = real.string();  // A link stays one.
  int fd = -1;
  for (int i = 0; fd < 0 && i < 100; ++i) {  // What somebody else has there stays.
    part_ = fmt::format("{}.{}.part", path_, i);
    fd = ::open(part_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd < 0 && errno != EEXIST) break;
  }
  if (fd < 0) refuse();
  if (there) (void)::fchmod(fd, static_cast<mode_t>(status.permissions()));
  ::close(fd);
  under_way = part_.c_str();
  struct sigaction removes = {};
  removes.sa_handler = removeAndEnd;
  for (std::size_t i = 0; i < std::size(kEnds); ++i) {
    sigaction(kEnds[i], nullptr, &before_[i]);
    if (before_[i].sa_handler != SIG_IGN) sigaction(kEnds[i], &removes, nullptr);  // nohup stays so.
  }
}

WholeFile::~WholeFile() {
  if (part_ == path_) return;
  for (std::size_t i = 0; i < std::size(kEnds); ++i) sigaction(kEnds[i], &before_[i], nullptr);
  under_way = nullptr;
  std::error_code none;
  std::filesystem::remove(part_, none);
}

void WholeFile::keep() {
  if (part_ == path_) return;
  std::error_code error;
  std::filesystem::rename(part_, path_, error);
  if (error) throw Failure(path_, "it cannot be put in its place: " + error.message(), "see the path and its rights");
}

void refuseToReplace(const std::string& input, const std::string& output) {
  std::error_code none;
  if (std::filesystem::equivalent(input, output, none))
    throw Failure(output, "it is what is read, and would be lost", "another name");
}

}  // namespace haptic_bench
