/** @file
 * Work for one of many, on the control thread.
 */
#pragma once

#include <exception>
#include <new>

#include "daemon/log/log.h"

namespace hapticd {

/** What there is no memory for keeps nobody else from his. */
template <class Work>
void inMemory(Work&& work) noexcept {
  try {
    work();
  } catch (const std::bad_alloc&) {  // Whoever waits for it hears so when its answer goes.
  } catch (const std::exception& e) {
    log::error("a defect: {}", log::printable(e.what()));
  }
}

}  // namespace hapticd
