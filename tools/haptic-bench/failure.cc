#include "tools/haptic-bench/failure.h"

namespace haptic_bench {

Failure::Failure(const std::string& where, const std::string& what, const std::string& remedy)
    : std::runtime_error(where + ": " + what + (remedy.empty() ? "" : " (" + remedy + ")")) {}

}  // namespace haptic_bench
