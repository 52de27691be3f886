#include "tests/support/shortage.h"

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace hapticd::test {
namespace {

thread_local Shortage* t_shortage = nullptr;
std::atomic<std::int64_t> g_allocations{0};

void* allocated(std::size_t size, std::size_t alignment) noexcept {
  if (t_shortage != nullptr && t_shortage->strikes()) return nullptr;
  void* const memory = alignment <= alignof(std::max_align_t)
                           ? std::malloc(size)
                           : std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (memory != nullptr) g_allocations.fetch_add(1, std::memory_order_relaxed);
  return memory;
}

void* orThrow(void* memory) {
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

void giveBack(void* memory) noexcept {
  if (memory != nullptr) g_allocations.fetch_sub(1, std::memory_order_relaxed);
  std::free(memory);
}

}  // namespace

Shortage::Scope::Scope(Shortage& shortage) noexcept : before_(t_shortage) { t_shortage = &shortage; }
Shortage::Scope::~Scope() { t_shortage = before_; }

bool Shortage::strikes() noexcept {
  if (struck_) return lasts_ == Lasts::kOn;
  if (left_-- != 0) return false;
  struck_ = true;
  return true;
}

std::int64_t allocations() noexcept { return g_allocations.load(std::memory_order_relaxed); }

}  // namespace hapticd::test

using hapticd::test::allocated;
using hapticd::test::giveBack;
using hapticd::test::orThrow;

// The other forms are defined in terms of these.
void* operator new(std::size_t size) { return orThrow(allocated(size, 0)); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return orThrow(allocated(size, static_cast<std::size_t>(alignment)));
}
void operator delete(void* memory) noexcept { giveBack(memory); }
void operator delete(void* memory, std::size_t) noexcept { giveBack(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { giveBack(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { giveBack(memory); }
