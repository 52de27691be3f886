#include "libclient/src/reply/failure.h"

#include <exception>

namespace hapticd::client {
namespace {

/** Copies as much as fits and never cuts a UTF-8 character. */
template <std::size_t N>
void cut(char (&to)[N], const std::string& from) noexcept {
  std::size_t length = from.size() < N - 1 ? from.size() : N - 1;
  if (length < from.size()) {
    while (length > 0 && (static_cast<unsigned char>(from[length]) & 0xc0) == 0x80) --length;
  }
  std::memcpy(to, from.data(), length);
  to[length] = 0;
}

}  // namespace

int report(const Failure& failure, haptic_error* error) noexcept {
  if (failure.code == HAPTIC_OK || error == nullptr || error->size < 8) return failure.code;
  haptic_error full{};
  full.size = error->size;
  full.code = failure.code;
  cut(full.where, failure.where);
  if (failure.what.empty()) {
    const char* text = haptic_error_text(failure.code);
    std::memcpy(full.what, text, std::strlen(text) + 1);
  } else {
    cut(full.what, failure.what);
  }
  cut(full.remedy, failure.remedy);
  const std::size_t size = error->size < sizeof full ? error->size : sizeof full;
  std::memcpy(error, &full, size);
  // An older, shorter structure may end within a text.
  if (size > offsetof(haptic_error, where) && size < sizeof full) reinterpret_cast<char*>(error)[size - 1] = 0;
  return failure.code;
}

Failure checkReserved(std::uint32_t value, const char* field) {
  if (value == 0) return {};
  return {HAPTIC_UNSUPPORTED, field, "is not 0", "start from the structure's INIT, or from zeros"};
}

Failure wrongSize(const char* name, std::size_t size) {
  const std::string type(name);
  return badArgument(type + ".size", "is " + std::to_string(size) + ", which no version had",
                     "set it to sizeof(" + type + ")");
}

Failure fromException() noexcept {
  try {
    try {
      throw;
    } catch (const std::bad_alloc&) {
      return {HAPTIC_SYSTEM, {}, "no memory", {}};
    } catch (const std::exception& e) {
      return {HAPTIC_INTERNAL, {}, e.what(), {}};
    } catch (...) {
      return {HAPTIC_INTERNAL, {}, {}, {}};
    }
  } catch (...) {  // no memory even for the text
    return {HAPTIC_SYSTEM, {}, {}, {}};
  }
}

}  // namespace hapticd::client
