/** @file
 * Where a command makes a file, and what is in it then.
 */
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "tests/support/process/temporary_directory.h"

namespace hapticctl {

class MadeFileTest : public ::testing::Test {
 protected:
  void hold(const std::string& text) const { std::ofstream(path_) << text; }
  /** What is in it, or "none". */
  [[nodiscard]] std::string held() const {
    std::stringstream text;
    text << std::ifstream(path_).rdbuf();
    return std::filesystem::exists(path_) ? text.str() : "none";
  }

  hapticd::test::TemporaryDirectory folder_;
  const std::string path_ = folder_.path() + "/file";
};

}  // namespace hapticctl
