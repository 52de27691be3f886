/** @file
 * How refusals travel inside the library, and the edge where they become codes and haptic_error.
 */
#pragma once

#include <hapticclient/base.h>

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

namespace hapticd::client {

/** A refusal, or nothing when `code` is HAPTIC_OK. */
struct [[nodiscard]] Failure {
  int code = HAPTIC_OK;
  std::string where;
  std::string what;
  std::string remedy;

  explicit operator bool() const noexcept { return code != HAPTIC_OK; }
};

/** The remedy where the program, or its user, may have no more of them. */
inline constexpr const char* kFewerDescriptors = "close some descriptors, or raise the program's limit (ulimit -n)";

/** Writes a refusal into the caller's structure, as much of it as its size holds. Gives the code. */
int report(const Failure& failure, haptic_error* error) noexcept;

/** The bug that is nobody's argument: an exception at the edge. Call it within a catch block. */
Failure fromException() noexcept;

/** Runs `body`, which gives a Failure, behind the edge: no exception leaves. */
template <class Body>
int edge(haptic_error* error, Body&& body) noexcept {
  try {
    return report(body(), error);
  } catch (...) {
    return report(fromException(), error);
  }
}

/** The shortest text that reads back as this number, whatever the locale. */
inline std::string textOf(double number) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, number).ptr};
}

/** A refusal of an argument. */
inline Failure badArgument(std::string where, std::string what, std::string remedy = {}) {
  return {HAPTIC_INVALID_ARGUMENT, std::move(where), std::move(what), std::move(remedy)};
}

/** The refusal of a field that later versions may give a meaning, where it is set. */
Failure checkReserved(std::uint32_t value, const char* field);

/** The refusal of a sized structure whose `size` no version had. */
Failure wrongSize(const char* name, std::size_t size);

/**
 * Reads a sized structure that may be older or newer than ours: what is missing stays as `out` has it; what we do not
 * know must be zero. `minimum`: bytes without which it makes no sense.
 */
template <class T>
Failure readSized(const T* in, T& out, std::size_t minimum, const char* name) {
  if (in == nullptr) return badArgument(name, "is null");
  const std::size_t size = in->size;
  constexpr std::size_t kMost = 4096;  // Else a size that nobody set has us read what is not there.
  if (size < minimum || size > kMost || size % 8 != 0) {
    return wrongSize(name, size);
  }
  std::memcpy(static_cast<void*>(&out), in, size < sizeof(T) ? size : sizeof(T));
  out.size = sizeof(T);
  const auto* bytes = reinterpret_cast<const unsigned char*>(in);
  for (std::size_t i = sizeof(T); i < size; ++i) {
    if (bytes[i] != 0) {
      return {HAPTIC_UNSUPPORTED, name, "uses a field that this older library does not know",
              "install the library that the program was built with"};
    }
  }
  return {};
}

/** Whether a sized structure can be written to: to be asked before anything is changed. */
template <class T>
Failure checkSized(const T* out, const char* name) {
  const std::size_t size = out->size;
  if (size >= 8 && size % 8 == 0) return {};
  return wrongSize(name, size);
}

/** Writes a sized structure into the caller's, as much of it as its `size` holds; the size stays the caller's. */
template <class T>
Failure writeSized(const T& value, T* out, const char* name) {
  if (Failure bad = checkSized(out, name)) return bad;
  const std::size_t size = out->size;
  std::memcpy(static_cast<void*>(out), &value, size < sizeof(T) ? size : sizeof(T));
  out->size = static_cast<std::uint32_t>(size);
  return {};
}

}  // namespace hapticd::client
