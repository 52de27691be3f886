#include "daemon/rpc/answer.h"

#include <string_view>

#include "daemon/log/log.h"

namespace hapticd {

Error defect(const char* text) noexcept {
  try {
    log::error("a defect in a control method: {}", log::printable(text));
  } catch (...) {  // the answer matters more than the line
  }
  return {ErrorCode::kInternal, {}, {}, {}};
}

Error thrown(const kj::Exception& e) noexcept {
  // Where messages are read; what of ours could fail there, building an answer, has no limit that it meets.
  const std::string_view at = e.getFile();
  const bool unreadable = at.find("capnp/layout.c++") != at.npos || at.find("capnp/arena.c++") != at.npos;
  if (!unreadable) return defect(e.getDescription().cStr());
  try {
    return {ErrorCode::kInvalidArgument, "message", "it is damaged, or of another schema",
            "update libhapticclient, or build what speaks for itself with the daemon's control.capnp"};
  } catch (...) {
    return {ErrorCode::kInvalidArgument, {}, {}, {}};
  }
}

Error outOfMemory() noexcept {
  try {
    return {ErrorCode::kSystem, "memory", "hapticd can have no more", "end programs, or raise MemoryMax= or ulimit -v"};
  } catch (...) {
    return {ErrorCode::kSystem, {}, {}, {}};
  }
}

}  // namespace hapticd
