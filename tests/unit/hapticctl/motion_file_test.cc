// Motions from CSV: columns by name, straight between rows, errors with file and line.
#include "tools/hapticctl/file/motion_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/support/process/temporary_directory.h"
#include "tools/hapticctl/failure.h"

namespace hapticctl {
namespace {

using ::testing::DoubleEq;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class MotionFileTest : public ::testing::Test {
 protected:
  Motion read(const std::string& text) {
    std::ofstream(directory_ / "m.csv") << text;
    return Motion::read((directory_ / "m.csv").string());
  }
  std::string refusal(const std::string& text) {
    try {
      (void)read(text);
    } catch (const Failure& failure) {
      EXPECT_EQ(failure.exit, kExitFile);
      return failure.where.substr(failure.where.rfind('/') + 1) + ": " + failure.what;
    }
    return "not refused";
  }
  hapticd::test::TemporaryDirectory temporary_;
  const std::filesystem::path directory_ = temporary_.path();
};

TEST_F(MotionFileTest, GoesStraightBetweenRowsAndHoldsTheEnds) {
  const Motion motion = read("# drawn\r\nz,other,t_s,px,y\r\n0,9,5,1,0\r\n\r\n2,9,7,3,-4\r\n");
  EXPECT_EQ(motion.duration(), 2);
  EXPECT_THAT(motion.at(-1), ElementsAre(1, 0, 0));
  EXPECT_THAT(motion.at(0.5), ElementsAre(DoubleEq(1.5), DoubleEq(-1), DoubleEq(0.5)));
  EXPECT_THAT(motion.at(2), ElementsAre(3, -4, 2));
  EXPECT_THAT(motion.at(99), ElementsAre(3, -4, 2));
  EXPECT_EQ(read("\xef\xbb\xbft,x,y,z\n0,0,0,0\n3,0,0,0\n").duration(), 3) << "as a spreadsheet and the daemon have it";
  EXPECT_EQ(read("\"t\", \"x\",\"y\",\"z\"\n\"0\",\"0\",\"0\",\"0\"\r\n\"3\",\"0\",\"0\",\"0\"\r\n").duration(), 3)
      << "and others";
}

TEST_F(MotionFileTest, TakesTheUnitBehindAName) {
  const Motion motion = read("t_ms,px_mm,y_m,z\n500,0,0,0\n2500,20,1,2\n");
  EXPECT_THAT(motion.duration(), DoubleEq(2));
  EXPECT_THAT(motion.at(2), ElementsAre(DoubleEq(0.02), 1, 2));
  EXPECT_EQ(read("t_ns,time,x,y,z\n7,0,0,0,0\n9,3,0,0,0\n").duration(), 3) << "no unit of ours: another column";
  EXPECT_EQ(refusal("t,x_inch,y,z\n0,0,0,0\n1,0,0,0\n"), "m.csv:1: no column 'x'");
}

TEST_F(MotionFileTest, NeedsNoHeaderAsTheSimulatedDeviceNeedsNone) {
  EXPECT_EQ(read("0,0,0,0\n3,1,2,3\n").duration(), 3);
  EXPECT_THAT(read("0,0,0,0\n3,1,2,3\n").at(3), ElementsAre(1, 2, 3));
  EXPECT_THAT(read("0,0,0,0,1,0,0,0\n3,1,2,3,1,0,0,0\n").at(3), ElementsAre(1, 2, 3));
  EXPECT_EQ(refusal("0,0,0,0,1\n1,0,0,0,1\n"), "m.csv:1: no column 't'");
}

// A recording's export; it was said that time does not rise.
TEST_F(MotionFileTest, IsOfOneDevice) {
  EXPECT_EQ(refusal("device,t,x,y,z\n1,0,0,0,0\n0,0,1,1,1\n1,1,0,0,0\n0,1,1,1,1\n"),
            "m.csv:3: it is of another device than the first row");
  EXPECT_EQ(read("t,x,y,z,device\n0,0,0,0,1\n3,0,0,0,1\n").duration(), 3);
}

TEST_F(MotionFileTest, NamesLineAndColumn) {
  EXPECT_EQ(refusal("t,x,y\n0,0,0\n"), "m.csv:1: no column 'z'");
  EXPECT_EQ(refusal("t;x;y;z\n0;0;0;0\n"), "m.csv:1: semicolons part its columns");
  EXPECT_EQ(refusal("0\t0\t0\t0\n"), "m.csv:1: tabs part its columns");
  EXPECT_EQ(refusal("t,x,y,z\n0,0,0,0\n1,0,nan,0\n"), "m.csv:3: 'nan' in column 'y' is not a finite number");
  EXPECT_EQ(refusal("t,x,y,z\n0,0,0,0\n1,0\n"), "m.csv:3: it ends before column 'y'");
  EXPECT_EQ(refusal("t,x,y,z\n1,0,0,0\n1,0,0,0\n"), "m.csv:3: time does not rise");
  EXPECT_EQ(refusal("t,x,y,z\n0,0,0,0\n1,2,-10.5,0\n"), "m.csv:3: -10.5 in column 'y' is more than 10 m");
  EXPECT_EQ(refusal("t,x,y,z\n-1e307,0,0,0\n1e308,0,0,0\n"), "m.csv:3: time is too far from the first");
  EXPECT_EQ(refusal("t,x,y,z\n1,0,0,0\n"), "m.csv: holds fewer than two rows");
  EXPECT_EQ(refusal("HRBLOCK1\x01,\n"), "m.csv: is a recording, not rows of text");
  EXPECT_THROW((void)Motion::read((directory_ / "none.csv").string()), Failure);
  EXPECT_THROW((void)Motion::read("/dev/zero"), Failure) << "a line without an end";
}

}  // namespace
}  // namespace hapticctl
