#include "daemon/rpc/answer.h"

#include "daemon/log/log.h"

namespace hapticd {

Error defect(const char* text) noexcept {
  try {
    log::error("a defect in a control method: {}", log::printable(text));
  } catch (...) {  // the answer matters more than the line
  }
  return {ErrorCode::kInternal, {}, {}, {}};
}

Error outOfMemory() noexcept {
  try {
    return {ErrorCode::kSystem, "memory", "hapticd can have no more", "end programs, or raise MemoryMax= or ulimit -v"};
  } catch (...) {
    return {ErrorCode::kSystem, {}, {}, {}};
  }
}

}  // namespace hapticd
