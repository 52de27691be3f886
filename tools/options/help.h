/** @file
 * Help on a terminal: what is longer than a line goes on below where its description began.
 */
#pragma once

#include <sys/ioctl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <sstream>
#include <string>
#include <string_view>

namespace hapticd_options {

/** The text of CLI11 for so many columns, broken at blanks. */
inline std::string wrapped(std::string_view text, std::size_t columns) {
  constexpr std::size_t kDescriptions = 30;  // CLI11's column of them.
  std::string out;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string line(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::size_t indent = line.starts_with("  ") ? kDescriptions : 0;
    while (line.size() > columns) {
      const std::size_t blank = line.rfind(' ', columns);
      if (blank == std::string::npos || blank <= indent) break;
      out += line.substr(0, line.find_last_not_of(' ', blank) + 1) + "\n";
      line.replace(0, blank + 1, indent, ' ');
    }
    out += line + "\n";
  }
  return out;
}

/** What CLI11 has to say when parsing ended without a fault (help, version), as it fits standard output. */
inline std::string helpOf(const CLI::App& app, const CLI::ParseError& end) {
  std::ostringstream text;
  app.exit(end, text, text);
  winsize size{};
  const bool terminal = ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0;
  return terminal ? wrapped(text.str(), size.ws_col > 0 ? size.ws_col : 80) : text.str();
}

}  // namespace hapticd_options
