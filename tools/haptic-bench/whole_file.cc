#include "tools/haptic-bench/whole_file.h"

#include <unistd.h>

#include <atomic>
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
  std::error_code none;
  const auto kind = std::filesystem::status(path_, none).type();
  if (kind == std::filesystem::file_type::directory) throw Failure(path_, "it is a folder", "the name of a file");
  const bool plain = kind == std::filesystem::file_type::not_found || kind == std::filesystem::file_type::regular;
  if (plain && !std::filesystem::is_symlink(path_, none)) part_ += ".part";
  if (!std::ofstream(part_, std::ios::binary))
    throw Failure(path_, "it cannot be written", "see the path and its rights");
  if (part_ == path_) return;
  std::filesystem::remove(part_, none);  // Nothing lies about while the results are made.
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
