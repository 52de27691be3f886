/* A plug-in of another version of the interface: haptic-bench must not call into it. */
#include <stdlib.h>

#include "tools/haptic-bench/plugin/haptic_algorithm.h"

const haptic_algorithm* haptic_algorithm_table(void) {
  static const haptic_algorithm table = {.version = HAPTIC_ALGORITHM_VERSION + 1, .bytes = 16, .name = "tomorrow"};
  return &table;
}
