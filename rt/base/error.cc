#include "rt/base/error.h"

namespace hapticd {

std::string_view describe(ErrorCode code) noexcept {
  switch (code) {
#define HAPTICD_TEXT(c_name, cpp_name, number, text) \
  case ErrorCode::cpp_name:                          \
    return text;
    HAPTIC_ERROR_LIST(HAPTICD_TEXT)
#undef HAPTICD_TEXT
  }
  return "unknown error";
}

std::string toString(const Error& error) {
  std::string text = error.where;
  if (!text.empty()) text += ": ";
  text += error.what.empty() ? std::string(describe(error.code)) : error.what;
  if (!error.remedy.empty()) text += " (" + error.remedy + ")";
  return text;
}

}  // namespace hapticd
