/** @file
 * Typed errors and value-or-error results for everything that is not the servo.
 *
 * An Error says what kind of refusal it is (errors.h), where, what is wrong and what to do. It owns strings, so the
 * real-time threads use bare ErrorCode instead. Nothing here throws.
 */
#pragma once

#include <cassert>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "proto/errors.h"

namespace hapticd {

/** Kinds of refusal; the numbers of proto/errors.h. */
enum class ErrorCode : std::uint16_t {
#define HAPTICD_ENUM(c_name, cpp_name, number, text) cpp_name = number,
  HAPTIC_ERROR_LIST(HAPTICD_ENUM)
#undef HAPTICD_ENUM
};

/** The one sentence of proto/errors.h; "unknown error" for a number not in the list. */
[[nodiscard]] std::string_view describe(ErrorCode code) noexcept;

/** A refusal. */
struct [[nodiscard]] Error {
  ErrorCode code = ErrorCode::kInternal;
  std::string where;   ///< File and line, field, index or path at fault.
  std::string what;    ///< What is wrong there.
  std::string remedy;  ///< What to do about it.
};

/** "where: what (remedy)", for logs and terminals. */
[[nodiscard]] std::string toString(const Error& error);

/** A value or an Error. Ask ok() first; value() and error() assert it. */
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}      // NOLINT(google-explicit-constructor)
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool ok() const noexcept { return state_.index() == 0; }
  explicit operator bool() const noexcept { return ok(); }

  [[nodiscard]] T& value() & noexcept { return *std::get_if<0>(&state_); }
  [[nodiscard]] const T& value() const& noexcept { return *std::get_if<0>(&state_); }
  [[nodiscard]] T&& value() && noexcept { return std::move(*std::get_if<0>(&state_)); }
  T* operator->() noexcept { return std::get_if<0>(&state_); }
  const T* operator->() const noexcept { return std::get_if<0>(&state_); }
  T& operator*() noexcept { return value(); }
  const T& operator*() const noexcept { return value(); }

  [[nodiscard]] const Error& error() const noexcept { return *std::get_if<1>(&state_); }

 private:
  std::variant<T, Error> state_;
};

/** Done, or an Error. */
template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)), ok_(false) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool ok() const noexcept { return ok_; }
  explicit operator bool() const noexcept { return ok_; }
  [[nodiscard]] const Error& error() const noexcept {
    assert(!ok_);
    return error_;
  }

 private:
  Error error_{ErrorCode::kOk, {}, {}, {}};
  bool ok_ = true;
};

}  // namespace hapticd
