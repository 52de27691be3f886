// What reaches the terminal.
#include "tools/hapticctl/output/output.h"

#include <gtest/gtest.h>

namespace hapticctl {
namespace {

TEST(Printable, LeavesNothingThatSteersATerminal) {
  EXPECT_EQ(printable("a\x1b[31m\x7f\r\t\n"), "a?[31m??\t\n");
  EXPECT_EQ(printable("\xc2\x9b"
                      "31m\xc2\xa0\xc2"),
            "?31m\xc2\xa0\xc2")
      << "U+009B is ESC [ in one character";
  EXPECT_EQ(printable("Gr\xc3\xbc\xc3\x9f"
                      "e"),
            "Gr\xc3\xbc\xc3\x9f"
            "e");
}

}  // namespace
}  // namespace hapticctl
