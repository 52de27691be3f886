/** @file
 * Memory that cannot be had: allocations of a program that links shortage.cc fail where a test says so.
 */
#pragma once

#include <cstdint>
#include <limits>

namespace hapticd::test {

/** Of what the calling thread asks for with operator new while a Scope is open. */
class Shortage {
 public:
  enum class Lasts { kOnce, kOn };  ///< One allocation fails; or all that follow, too, while the scope is open.

  /** From 0: that allocation fails, counted over all scopes. */
  explicit Shortage(std::uint64_t nth, Lasts lasts = Lasts::kOnce) : left_(nth), lasts_(lasts) {}
  Shortage(const Shortage&) = delete;
  Shortage& operator=(const Shortage&) = delete;

  class Scope {
   public:
    explicit Scope(Shortage& shortage) noexcept;
    ~Scope();
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    Shortage* const before_;
  };

  /** Whether any has failed. */
  [[nodiscard]] bool struck() const { return struck_; }
  /** Whether this allocation fails. */
  [[nodiscard]] bool strikes() noexcept;

 private:
  std::uint64_t left_;
  Lasts lasts_;
  bool struck_ = false;
};

/** What all threads have got of operator new and not given back. */
[[nodiscard]] std::int64_t allocations() noexcept;

}  // namespace hapticd::test
