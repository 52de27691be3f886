/** @file
 * The file of a recorded motion: opened and judged where a device is made, read where it opens.
 */
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "drivers/pose_track.h"

namespace hapticd {

struct OpenedFile;

/** A regular file of at most PoseTrack::kMaxFileBytes that whoever named it may name. Copies share what is open. */
class PoseFile {
 public:
  /** None. */
  PoseFile() = default;
  /**
   * Quick. With a folder as `within`, kPermissionDenied unless what is opened lies there, whatever the path or its
   * links say; a path with ".." in it does not.
   */
  [[nodiscard]] static Result<PoseFile> open(const std::string& path, const std::string& within = {});

  /** Reads and parses it (parsePoseCsv()): seconds, for the largest. What was judged is read, whatever has its name
   * now. kCancelled soon after `given_up` is true. Any thread. */
  [[nodiscard]] Result<std::shared_ptr<const PoseTrack>> read(const std::atomic<bool>& given_up) const;
  [[nodiscard]] bool valid() const noexcept { return file_ != nullptr; }

 private:
  std::shared_ptr<const OpenedFile> file_;  ///< Closed with the last copy.
  std::size_t bytes_ = 0;                   ///< When it was judged.
  std::string path_;
};

}  // namespace hapticd
