/** @file
 * Value-or-error results and owned replies. Nothing here throws but std::bad_alloc.
 */
#pragma once

#include <hapticclient/base.h>

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <variant>

namespace haptic {

/** A refusal: what kind, where, what is wrong and what to do. Servo-safe calls give the code alone, but for
 * pushes. */
struct [[nodiscard]] Error {
  int code = HAPTIC_INTERNAL;
  std::string where;
  std::string what;
  std::string remedy;

  /** "where: what (remedy)" for people. */
  [[nodiscard]] std::string message() const {
    std::string text = where.empty() ? std::string() : where + ": ";
    text += what.empty() ? haptic_error_text(code) : what;
    if (!remedy.empty()) text += " (" + remedy + ")";
    return text;
  }
};

/** A value or an Error. Ask first: value(), * and -> are undefined on an error. */
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
  [[nodiscard]] T& operator*() & noexcept { return value(); }
  [[nodiscard]] const T& operator*() const& noexcept { return value(); }
  [[nodiscard]] T&& operator*() && noexcept { return std::move(*this).value(); }
  T* operator->() noexcept { return std::get_if<0>(&state_); }
  const T* operator->() const noexcept { return std::get_if<0>(&state_); }
  [[nodiscard]] const Error& error() const noexcept { return *std::get_if<1>(&state_); }
  [[nodiscard]] int code() const noexcept { return ok() ? int{HAPTIC_OK} : error().code; }

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
  [[nodiscard]] const Error& error() const noexcept { return error_; }
  [[nodiscard]] int code() const noexcept { return ok_ ? int{HAPTIC_OK} : error_.code; }

 private:
  Error error_{HAPTIC_OK, {}, {}, {}};
  bool ok_ = true;
};

struct FreeReply {
  void operator()(const void* reply) const noexcept { haptic_free(reply); }
};
/** A result of the daemon, with all that it points to. */
template <class T>
using Reply = std::unique_ptr<T, FreeReply>;

/** The entries of a list reply (devices, objects, checks). */
template <class List>
[[nodiscard]] auto items(const Reply<List>& list) noexcept {
  return std::span(list->items, list->count);
}

namespace detail {

/** Calls a function of the C interface whose last argument is the error. */
template <class Call>
Result<void> run(Call&& call) {
  haptic_error error = HAPTIC_ERROR_INIT;
  const int code = call(&error);
  if (code == HAPTIC_OK) return {};
  return Error{code, error.where, error.what, error.remedy};
}

/** The same for one that hands out a reply. */
template <class T, class Call>
Result<Reply<T>> ask(Call&& call) {
  T* reply = nullptr;
  if (auto done = run([&](haptic_error* error) { return call(&reply, error); }); !done) return done.error();
  return Reply<T>(reply);
}

/** The same for one that hands out a text. */
template <class Call>
Result<std::string> askText(Call&& call) {
  auto reply = ask<haptic_text>(std::forward<Call>(call));
  if (!reply) return reply.error();
  return std::string((*reply)->text, (*reply)->length);
}

inline Result<void> fromCode(int code) {
  if (code == HAPTIC_OK) return {};
  return Error{code, {}, {}, {}};
}

inline const char* orNull(const std::string& text) { return text.empty() ? nullptr : text.c_str(); }

}  // namespace detail
}  // namespace haptic
