// What reaches the terminal.
#include "tools/hapticctl/output/output.h"

#include <gtest/gtest.h>

#include "tools/hapticctl/failure.h"
#include "tools/options/help.h"

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

/** The name of a parameter says nothing to who reads a sentence; a program looks for it. */
TEST(Report, OfWhatIsMissingTellsAProgramWhichParameter) {
  const auto told = [](const Failure& failure, bool json) {
    testing::internal::CaptureStderr();
    report(failure, json);
    return testing::internal::GetCapturedStderr();
  };
  const Failure missing{kExitRefused, "name", "there is no object 'x'", {}, "NOT_FOUND"};
  EXPECT_EQ(told(missing, false), "hapticctl: there is no object 'x'\n");
  EXPECT_EQ(told(missing, true),
            R"({"error":{"code":"NOT_FOUND","where":"name","what":"there is no object 'x'","remedy":""}})"
            "\n");
  const Failure denied{kExitRefused, "name", "'x' belongs to user 7", {}, "PERMISSION_DENIED"};
  EXPECT_EQ(told(denied, false), "hapticctl: name: 'x' belongs to user 7\n");
}

TEST(Help, GoesOnBelowItsDescriptionWhereALineIsFull) {
  const std::string text =
      "Usage: hapticctl\n  --points MM Needs: --voxel  How far apart they shall be\n"
      "                              else a voxel\nAlso --json, and others\n";
  EXPECT_EQ(hapticd_options::wrapped(text, 80), text);
  EXPECT_EQ(hapticd_options::wrapped(text, 48),
            "Usage: hapticctl\n  --points MM Needs: --voxel  How far apart they\n"
            "                              shall be\n"
            "                              else a voxel\nAlso --json, and others\n");
  EXPECT_EQ(hapticd_options::wrapped("Also --json, and others\n", 12), "Also --json,\nand others\n");
  EXPECT_EQ(hapticd_options::wrapped("aaaaaaaaaaaaaaaa\n", 8), "aaaaaaaaaaaaaaaa\n") << "no blank, no break";
}

TEST(Table, LeavesOutSpareColumnsWhereThereIsNoRoom) {
  Table table({{"NAME"}, {"FORCE N", true, 2}, {"RATE Hz", true, 1}, {"STATE"}});
  table.row({"falcon", "0.00", "1000", "armed"});
  const std::string all = "NAME    FORCE N  RATE Hz  STATE\nfalcon     0.00     1000  armed\n";
  EXPECT_EQ(table.text(), all) << "nothing is left out of a file or a pipe";
  EXPECT_EQ(table.text(31), all) << "as wide as it is";
  EXPECT_EQ(table.text(30), "NAME    RATE Hz  STATE\nfalcon     1000  armed\n");
  EXPECT_EQ(table.text(21), "NAME    STATE\nfalcon  armed\n");
  EXPECT_EQ(table.text(1), "NAME    STATE\nfalcon  armed\n") << "what it is about stays";
}

}  // namespace
}  // namespace hapticctl
