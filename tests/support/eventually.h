/** @file
 * Waiting for what another thread or process does.
 */
#pragma once

#include <chrono>
#include <thread>

namespace hapticd::test {

/** Whether `condition` holds within a minute, for builders give way to all else; it is asked every two milliseconds. */
template <class Condition>
bool eventually(Condition&& condition) {
  for (int i = 0; i < 30000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return false;
}

}  // namespace hapticd::test
