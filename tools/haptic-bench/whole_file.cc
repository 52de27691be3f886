#include "tools/haptic-bench/whole_file.h"

#include <filesystem>
#include <fstream>

#include "tools/haptic-bench/failure.h"

namespace haptic_bench {

WholeFile::WholeFile(std::string path) : path_(std::move(path)), part_(path_) {
  std::error_code none;
  const auto kind = std::filesystem::status(path_, none).type();
  if (kind == std::filesystem::file_type::directory) throw Failure(path_, "it is a folder", "the name of a file");
  const bool plain = kind == std::filesystem::file_type::not_found || kind == std::filesystem::file_type::regular;
  if (plain && !std::filesystem::is_symlink(path_, none)) part_ += ".part";
  if (!std::ofstream(part_, std::ios::binary))
    throw Failure(path_, "it cannot be written", "see the path and its rights");
  if (part_ != path_) std::filesystem::remove(part_, none);  // Nothing lies about while the results are made.
}

WholeFile::~WholeFile() {
  std::error_code none;
  if (part_ != path_) std::filesystem::remove(part_, none);
}

void WholeFile::keep() {
  if (part_ == path_) return;
  std::error_code error;
  std::filesystem::rename(part_, path_, error);
  if (error) throw Failure(path_, "it cannot be put in its place: " + error.message(), "see the path and its rights");
}

}  // namespace haptic_bench
