#include <hapticclient/base.h>
#include <time.h>

#include "proto/errors.h"

#define HAPTICD_SAME(c_name, cpp_name, number, text) static_assert(HAPTIC_##c_name == number, text);
HAPTIC_ERROR_LIST(HAPTICD_SAME)
#undef HAPTICD_SAME

#define HAPTICD_STRING(x) #x
#define HAPTICD_VERSION(a, b, c) HAPTICD_STRING(a) "." HAPTICD_STRING(b) "." HAPTICD_STRING(c)

extern "C" {

const char* haptic_error_name(int code) {
  switch (code) {
#define HAPTICD_NAME(c_name, cpp_name, number, text) \
  case number:                                       \
    return "HAPTIC_" #c_name;
    HAPTIC_ERROR_LIST(HAPTICD_NAME)
#undef HAPTICD_NAME
  }
  return "HAPTIC_UNKNOWN";
}

const char* haptic_error_text(int code) {
  switch (code) {
#define HAPTICD_TEXT(c_name, cpp_name, number, text) \
  case number:                                       \
    return text;
    HAPTIC_ERROR_LIST(HAPTICD_TEXT)
#undef HAPTICD_TEXT
  }
  return "an error that this version of the library does not know";
}

const char* haptic_version(void) {
  return HAPTICD_VERSION(HAPTIC_VERSION_MAJOR, HAPTIC_VERSION_MINOR, HAPTIC_VERSION_PATCH);
}

int64_t haptic_now_ns(void) {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * INT64_C(1000000000) + now.tv_nsec;
}

}  // extern "C"
