/** @file
 * What haptic-emu checks of its command line before it plays anything.
 */
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "tools/haptic-emu/fault.h"
#include "tools/options/number.h"

namespace haptic_emu {

using hapticd_options::within;

/** KIND@FROM+LENGTH. */
inline CLI::Validator isFault() {
  return CLI::Validator(
      [](std::string& text) -> std::string {
        const auto fault = parseFault(text);
        return fault ? std::string() : toString(fault.error());
      },
      "");
}

}  // namespace haptic_emu
