/** @file
 * Results that the caller frees with haptic_free(): one block each, with its strings and lists behind it.
 */
#pragma once

#include <cstddef>
#include <cstring>
#include <string_view>
#include <type_traits>

namespace hapticd::client {

/**
 * Memory of one result. What it makes is zeroed, trivially destructible and lives until haptic_free() of the root.
 * The root is the first thing made. Throws std::bad_alloc; callers stand behind the edge of the C interface.
 */
class Reply {
 public:
  Reply() = default;
  Reply(const Reply&) = delete;
  Reply& operator=(const Reply&) = delete;
  ~Reply();

  /** A zeroed T; sized structures get their `size`. */
  template <class T>
  T* make() {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= alignof(std::max_align_t));
    T* t = static_cast<T*>(allocate(sizeof(T)));
    if constexpr (requires { t->size; }) {
      if constexpr (std::is_same_v<decltype(t->size), unsigned>) t->size = sizeof(T);
    }
    return t;
  }
  /** `count` zeroed pointers or numbers. */
  template <class T>
  T* makeArray(std::size_t count) {
    static_assert(std::is_scalar_v<T>);
    return static_cast<T*>(allocate(sizeof(T) * count));  // NOLINT(bugprone-sizeof-expression): of pointers, too
  }
  /** A copy that ends in a zero byte. */
  const char* text(std::string_view from) {
    char* copy = static_cast<char*>(allocate(from.size() + 1));
    if (!from.empty()) std::memcpy(copy, from.data(), from.size());
    return copy;
  }

  /** Hands the root, and all behind it, to the caller. */
  template <class T>
  T* release(T* root) {
    return static_cast<T*>(releaseRoot(root));
  }
  /** haptic_free(). */
  static void free(const void* root);

 private:
  struct Block;
  void* allocate(std::size_t bytes);
  void* releaseRoot(void* root);

  Block* first_ = nullptr;
  Block* last_ = nullptr;
};

}  // namespace hapticd::client
