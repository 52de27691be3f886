#include "libclient/src/reply/reply.h"

#include <hapticclient/base.h>

#include <cassert>
#include <cstdlib>
#include <new>

namespace hapticd::client {

/** Precedes every piece; the pieces of a reply form a list from its root. */
struct alignas(std::max_align_t) Reply::Block {
  Block* next;
};

Reply::~Reply() {
  if (first_ != nullptr) free(first_ + 1);
}

void* Reply::allocate(std::size_t bytes) {
  auto* block = static_cast<Block*>(std::calloc(1, sizeof(Block) + bytes));
  if (block == nullptr) throw std::bad_alloc();
  (last_ == nullptr ? first_ : last_->next) = block;
  last_ = block;
  return block + 1;
}

void* Reply::releaseRoot(void* root) {
  assert(root == first_ + 1);
  first_ = last_ = nullptr;
  return root;
}

void Reply::free(const void* root) {
  if (root == nullptr) return;
  auto* block = static_cast<Block*>(const_cast<void*>(root)) - 1;
  while (block != nullptr) {
    Block* next = block->next;
    std::free(block);
    block = next;
  }
}

}  // namespace hapticd::client

extern "C" void haptic_free(const void* result) { hapticd::client::Reply::free(result); }
