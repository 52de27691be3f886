/** @file
 * Trajectories from files: what is read is what was written, and every fault has its place.
 */
#include "tools/haptic-bench/trajectory/file_reader.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/process/temporary_directory.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/trajectory/registry.h"

namespace haptic_bench {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

Trajectory parse(const std::string& text, const FileOptions& options = {}) {
  return readColumns(Table::parse(text, "test.csv", options.columns), options, makeModel("plane"), {1000});
}

std::string refusal(const std::string& text, const FileOptions& options = {}) {
  try {
    (void)parse(text, options);
  } catch (const Failure& failure) {
    return failure.what();
  }
  ADD_FAILURE() << "read: " << text;
  return "";
}

TEST(TrajectoryFiles, CsvWithTruthAndUnits) {
  const Trajectory in = parse(
      "\xef\xbb\xbft_ms,px_mm,py_mm,pz_mm,fx,fy,fz,proxy_x,proxy_y,proxy_z,note\n# made by hand\n"
      "10, 1,2,-3, 0,0,3, .001,.002,0, 7\r\n\n11,1,2,-4,0,0,4,.001,.002,0,7");
  ASSERT_EQ(in.samples.size(), 2u);
  EXPECT_TRUE(in.force_known && in.proxy_known);
  EXPECT_DOUBLE_EQ(in.samples[1].t_s, 0.001);
  EXPECT_LT((in.samples[1].hip - Vec3(0.001, 0.002, -0.004)).norm(), 1e-15);
  EXPECT_EQ(in.samples[0].force, Vec3(0, 0, 3));
  EXPECT_EQ(in.samples[0].proxy, Vec3(0.001, 0.002, 0));
  EXPECT_GT(in.start.z(), 0) << "from outside";
  const Trajectory free = parse("t,x,y,z,proxy_x,proxy_y,proxy_z\n0,0,0,-0.01,0,0,-0.01\n");
  EXPECT_EQ(free.start, Vec3(0, 0, -0.01)) << "but where the hand is known to be in it and to touch nothing";
}

TEST(TrajectoryFiles, WhatHapticctlMonitorWritesIsRead) {
  const Trajectory in = parse(
      "t_s,tick,t_ns,px,py,pz,qw,qx,qy,qz,vx,vy,vz,fx,fy,fz,proxy_x,proxy_y,proxy_z,gripper_rad,buttons,flags\n"
      "0.000000,7,1234567890123,0.01,0.02,-0.001,1,0,0,0,0,0,0,0,0,1,0.01,0.02,0,0,0,1\n"
      "0.001000,8,1234568890456,0.02,0.02,-0.001,1,0,0,0,0,0,0,0,0,1,0.02,0.02,0,0,0,1\n");
  EXPECT_NEAR(in.samples[1].t_s, 1000333e-9, 1e-12) << "nanoseconds go before rounded seconds";
  EXPECT_EQ(in.samples[1].hip, Vec3(0.02, 0.02, -0.001));
  EXPECT_TRUE(in.force_known && in.proxy_known);
}

// Its times went back and forth, and which device was meant could not be said.
TEST(TrajectoryFiles, OfTwoDevicesInOneFileOneIsTaken) {
  const std::string text =
      "device,t_s,px,py,pz\n0,0,1,0,0.5\n1,0,2,0,0.5\n0,0.001,3,0,0.5\n1,0.001,4,0,0.5\n1,0.002,6,0,0.5\n";
  EXPECT_EQ(parse(text).samples.size(), 2u);
  EXPECT_EQ(parse(text).samples[1].hip.x(), 3);
  FileOptions second;
  second.device = 1;
  ASSERT_EQ(parse(text, second).samples.size(), 3u);
  EXPECT_EQ(parse(text, second).samples[2].hip.x(), 6);
  second.device = 2;
  EXPECT_THAT(refusal(text, second), HasSubstr("no row of device 2"));
  second.device = 1;
  EXPECT_THAT(refusal(text + "0,0.002,7,0,0.5\n1,0.001,8,0,0.5\n", second), HasSubstr("line 8: time goes from"));
}

// The option was refused for files of columns before they were read.
TEST(TrajectoryFiles, EachDeviceOfAnExportCanBeChosen) {
  const hapticd::test::TemporaryDirectory directory;
  const std::string path = directory.path() + "/two.csv", plain = directory.path() + "/one.csv";
  std::ofstream(path) << "device,t_s,px,py,pz\n0,0,1,0,0.5\n1,0,2,0,0.5\n0,0.001,3,0,0.5\n1,0.001,4,0,0.5\n";
  std::ofstream(plain) << "t_s,px,py,pz\n0,1,0,0.5\n";
  FileOptions second;
  second.device = 1;
  const Trajectory in = makeTrajectory(path, makeModel("plane"), {1000}, second);
  ASSERT_EQ(in.samples.size(), 2u);
  EXPECT_EQ(in.samples[1].hip.x(), 4);
  EXPECT_THAT(in.name, HasSubstr("--device 1"));
  EXPECT_THAT([&] { (void)makeTrajectory(plain, makeModel("plane"), {1000}, second); },
              ThrowsMessage<Failure>(HasSubstr("one.csv, which has no column device")));
}

// One row without a position made the file unreadable, whichever device's it was.
TEST(TrajectoryFiles, AFailedDeviceOfAnExportIsNowhere) {
  const std::string text =
      "device,t,px,py,pz,enabled,ramping\n0,0,1,0,0.5,1,0\n1,0,nan,nan,nan,0,0\n0,0.001,nan,nan,-nan,0,0\n"
      "1,0.001,3,0,0.5,1,0\n0,0.002,2,0,0.5,1,0\n";
  ASSERT_EQ(parse(text).samples.size(), 2u);
  EXPECT_EQ(parse(text).samples[1].hip.x(), 2);
  EXPECT_EQ(parse(text).samples[1].t_s, 0.002);
  FileOptions second;
  second.device = 1;
  ASSERT_EQ(parse(text, second).samples.size(), 1u);
  EXPECT_THAT(refusal("device,t,px,py,pz\n0,0,1,0,0.5\n0,0.001,1,nan,0.5\n1,0,nan,0,0.5\n"),
              HasSubstr("line 3, column 4 (py): it is not a finite number"))
      << "what is no export has no such rows";
  EXPECT_EQ(parse("device,t,px,py,pz\n0,0,1,0,0.5\n1,0.001,1,nan,slow\n").samples.size(), 1u);
  EXPECT_EQ(parse("t,x,y,z,enabled\n0,0,0,1,yes\n").samples.size(), 1u) << "a column of somebody else";
  EXPECT_THAT(refusal("t,px,py,pz,enabled\n0,0,nan,0,0\n"), HasSubstr("no row of it has a number in column py"));
  EXPECT_THAT(refusal("t,px,py,pz,enabled\n0,0,0,0,0\n0.001,0,,0,0\n"),
              HasSubstr("line 3, column 3 (py): there is no"));
  EXPECT_THAT(refusal("t,px,py,pz,enabled\n0,0,0,0,0\n0.001,0,slow,0,0\n"), HasSubstr("line 3, column 3 (py)"));
}

TEST(TrajectoryFiles, WhatADeviceThatIsOffWasSentIsNotJudged) {
  // As hapticctl monitor writes it: off, ramping (flags 3), armed (1; 9 in contact).
  const Trajectory in = parse(
      "t_s,px,py,pz,fx,fy,fz,armed,flags\n0,0,0,-0.001,0,0,0,0,0\n0.001,0,0,-0.001,0,0,0.5,1,3\n"
      "0.002,0,0,-0.001,0,0,1,1,9\n0.003,0,0,-0.001,0,0,1,1,1\n");
  EXPECT_TRUE(in.force_known);
  EXPECT_FALSE(in.samples[0].judged);
  EXPECT_FALSE(in.samples[1].judged);
  EXPECT_TRUE(in.samples[2].judged && in.samples[3].judged);
  const Trajectory off = parse("t,x,y,z,fx,fy,fz,judged\n0,0,0,-0.001,0,0,0,0\n0.001,0,0,-0.001,0,0,1,1\n");
  EXPECT_TRUE(!off.samples[0].judged && off.samples[1].judged) << "as --samples writes it";
  const Trajectory out = parse("t,x,y,z,fn,judged\n0,0,0,0,0.2,0\n0.001,0,0,0,1,1\n", {"", true, 0, 0});
  EXPECT_TRUE(!out.samples[0].judged && out.samples[1].judged) << "on the surface too";
  EXPECT_TRUE(parse("t,x,y,z,fx,fy,fz,flags\n0,0,0,-0.001,0,0,1,3\n").samples[0].judged) << "flags of somebody else";
}

TEST(TrajectoryFiles, WhySamplesAreNotJudgedIsTold) {
  const auto told = [](const std::string& text) {
    Trajectory in = parse(text);
    testing::internal::CaptureStderr();
    countJudged(in);
    return testing::internal::GetCapturedStderr();
  };
  const std::string off = told("t,x,y,z,fx,fy,fz,judged\n0,0,0,-0.001,0,0,0,0\n0.001,0,0,-0.001,0,0,1,0\n");
  EXPECT_NE(off.find("0 of 2 samples are judged, as its column judged says\n"), std::string::npos) << off;
  const std::string resting = told("t,x,y,z,fx,fy,fz,armed\n0,0,0,-0.001,0,0,0,0\n0.001,0,0,-0.001,0,0,1,0\n");
  EXPECT_NE(resting.find("in which the device was armed and its ramp over (arm it"), std::string::npos) << resting;
}

TEST(TrajectoryFiles, TrajWithNamedColumnsIsPressedIn) {
  const FileOptions options{"-,t,x,y,z,fn_mN", true, 0, 0};
  const Trajectory in = parse("9 0.0 0.01 0 0 500\n9  0.1\t0.02 0 0 -3\n", options);
  EXPECT_LT((in.samples[0].hip - Vec3(0.01, 0, -0.0005)).norm(), 1e-12) << "along the plane's normal";
  EXPECT_LT((in.samples[0].force - Vec3(0, 0, 0.5)).norm(), 1e-12);
  EXPECT_EQ(in.samples[1].force, Vec3(0, 0, 0)) << "a surface does not pull";
  const Trajectory given = parse("t,x,y,z,nx,ny,nz,fx,fy,fz\n0,0,0,0,1,0,0,2,5,5\n", {"", true, 0, 0});
  EXPECT_LT((given.samples[0].hip - Vec3(-0.002, 0, 0)).norm(), 1e-12);
  EXPECT_EQ(parse("x,y,z\n1,1,1\n2,2,2\n", {"", false, 500, 0}).samples[1].t_s, 0.002);
}

TEST(TrajectoryFiles, AnOutTrajectoryLiesOnTheSurface) {
  FileOptions out;
  out.out = true;
  for (const char* normals : {"", ",nx,ny,nz"}) {
    const std::string upward = normals[0] == 0 ? "" : ",0,0,1", head = std::string("t,x,y,z,fn") + normals + "\n";
    const auto file = [&](double z) {
      return head + "0,0,0," + std::to_string(z) + ",1" + upward + "\n0.001,0.01,0," + std::to_string(z) + ",1" +
             upward;
    };
    EXPECT_EQ(parse(file(0.002), out).samples.size(), 2u) << "a scan is never exact";
    EXPECT_DOUBLE_EQ(parse(file(0.002), out).start.z(), 0.003) << "1 N at 1000 N/m above";
    EXPECT_DOUBLE_EQ(parse(file(-0.0004), out).start.z(), 0.0006);
    EXPECT_DOUBLE_EQ(parse(file(-0.002), out).start.z(), 0.001) << "the hand comes from outside all the same";
    EXPECT_THAT(refusal(file(0.04), out),
                HasSubstr("test.csv: its positions lie 40 mm rms off the surface of a mesh of "
                          "141 mm (in the model's frame"));
  }
}

TEST(TrajectoryFiles, FaultsNameFileLineAndColumn) {
  EXPECT_THAT(refusal(""), HasSubstr("test.csv: there are no rows"));
  EXPECT_THAT(refusal("t,x,y,z\n"), HasSubstr("no rows"));
  EXPECT_THAT(refusal("0,1,2,3\n"), HasSubstr("line 1: there are numbers"));
  EXPECT_THAT(refusal("t,x,y\n0,0,0\n"), HasSubstr("no column z"));
  EXPECT_THAT(refusal("t,x,y,z\n0,0,0,0\n1,0,nan,0\n"), HasSubstr("line 3, column 3 (y)"));
  EXPECT_THAT(refusal("t,x,y,z\n0,0,0,0\n1,0,inf,0\n"), HasSubstr("line 3, column 3 (y)"));
  EXPECT_THAT(refusal("t,x,y,z\n0,0,+-1,0\n"), HasSubstr("line 2, column 3 (y)"));
  EXPECT_THAT(refusal("t,x,y,z\n0,0,,0\n"), HasSubstr("line 2, column 3 (y): there is no number"));
  EXPECT_THAT(refusal("t,x,y,z\n0,0,0\n"), HasSubstr("line 2: it has 3 columns, 4 have names"));
  EXPECT_THAT(refusal("t,x,y,z\n0,0,0,0\n# remark\n2,0,0,0\n1,0,0,0\n"),
              HasSubstr("line 5: time goes from 2 s to 1 s"));
  EXPECT_THAT(refusal("t,x,y,z\n0,0,0,0\n1,0,0,0\n2,0,0,0\n33,0,0,0\n"), HasSubstr("line 5: a gap of 31 s"));
  EXPECT_THAT(refusal("t,x,y,z\n0,0,0,0\n1000000,0,0,0\n2000000,0,0,0\n"), HasSubstr("line 4: the times span 2e+06 s"));
  EXPECT_THAT(refusal("t_ns,x,y,z\n0,0,0,0\n0.001,0,0,0\n0.002,0,0,0\n"), HasSubstr("line 4: 3 rows span 2e-12 s"));
  EXPECT_THAT(refusal("t,x,px,y,z\n0,0,0,0,0\n"), HasSubstr("the same quantity"));
  EXPECT_THAT(refusal("t,x,y,z,fx\n0,0,0,0,0\n"), HasSubstr("no column fy"));
  EXPECT_THAT(refusal("t,x,y,z\n0,0,300,0\n"), HasSubstr("300 m away"));
  EXPECT_THAT(refusal("t,x,y,z\n0,0,0,0\n", {"", true, 0, 0}), HasSubstr("no column fn"));
  EXPECT_THAT(refusal("t,x,y,z,nx,ny,nz,fn\n0,0,0,0,0,0,2,1\n", {"", true, 0, 0}), HasSubstr("line 2: the normal"));
  EXPECT_THAT(refusal(std::string(1000, ',')), HasSubstr("test.csv, line 1: there are 1001 columns"));
  EXPECT_THAT(refusal("0\n", {std::string(1000, ','), false, 0, 0}), HasSubstr("--columns: there are 1001 columns"));
  EXPECT_EQ(parse("t,x,y,z\n0,0,0,0\n1,0,0,0\n2,0,0,0\n33,0,0,0\n", {"", false, 0, 40}).samples.size(), 4u);
}

TEST(TrajectoryFiles, TextThatNobodyAsksForIsPassedOver) {
  const Trajectory in = parse("t,x,y,z,\"what, and why\",end\n0,0,0,1,\"slow, at first\",nan\n1,0,0,2,fast,\n");
  EXPECT_EQ(in.samples[1].hip, Vec3(0, 0, 2));
  EXPECT_FALSE(in.force_known);
  const FileOptions named{"t,x,y,z,-", false, 0, 0};
  EXPECT_EQ(parse("0,0,0,1,slow\n1,0,0,2,fast\n", named).samples.size(), 2u);
  EXPECT_THAT(refusal("t,x,y,z,proxy_x,proxy_y,proxy_z\n0,0,0,1,0,0,slow\n"), HasSubstr("line 2, column 7 (proxy_z)"));
}

TEST(TrajectoryFiles, GivenNamesStandInForThoseOfTheFile) {
  const FileOptions named{"t,x_mm,y,z,-", false, 0, 0};
  const auto in =
      parse("# a robot's log\ntime [s],\"pos x [mm]\",infinity y,z up,note\n0,5,0,1,slow\n1,6,0,2,fast\n", named);
  ASSERT_EQ(in.samples.size(), 2u);
  EXPECT_DOUBLE_EQ(in.samples[1].hip.x(), 0.006);
  EXPECT_THAT(refusal("t,x,y,z,note\nt,x,y,z,note\n0,0,0,1,a\n", named), HasSubstr("line 2, column 1")) << "once";
}

TEST(TrajectoryFiles, FaultsComeWithWhatToDo) {
  EXPECT_THAT(refusal("t;x;y;z\n0;0;0;1\n"), HasSubstr("line 1: semicolons part its columns"));
  EXPECT_THAT(refusal("t;x;y;z\n0;0;0;0,01\n"), HasSubstr("line 1: semicolons part its columns"));
  EXPECT_THAT(refusal("t,x,y,z\r0,0,0,0\r"), HasSubstr("line 1: carriage returns alone part its lines"));
  EXPECT_EQ(parse("t,x,y,z\r\r\n0,0,0,0\r\r\n").samples.size(), 1u) << "as a text file written twice as one";
  EXPECT_THAT(refusal("t,x,y,1\n0,0,0,1\n", {"t,x,y,z", false, 0, 0}), HasSubstr("without --columns"));
  EXPECT_THAT(refusal("nan,nan,inf,nan\n0,0,0,1\n", {"t,x,y,z", false, 0, 0}), HasSubstr("line 1")) << "no names";
  EXPECT_THAT(refusal("time [s],nanos\n0,1\n", {"t,x,y,z", false, 0, 0}), HasSubstr("line 2: it has 2 columns"));
  EXPECT_THAT(refusal("t,x,y,z,fn\n0,0,0,0,-1\n1,0,0,0,-2\n", {"", true, 0, 0}), HasSubstr("no force in it presses"));
  EXPECT_THAT(refusal("t,x,y,z\n0,0,0,0\n5,0,0,0\n", {"", false, 0, 1}), HasSubstr("line 3: a gap of 5 s"));
}

TEST(TrajectoryFiles, WhatIsNoTextAndWhatIsTooLongIsRefused) {
  EXPECT_THAT(refusal(std::string("t\0,\0x\0,\0y\0,\0z\0\n\0", 16)), HasSubstr("no plain text")) << "UTF-16";
  std::string rows = "x,y,z\n";
  for (std::size_t i = 0; i <= Table::kMaxRows; ++i) rows += "0 0 0\n";
  EXPECT_THAT(refusal(rows, {"", false, 1000, 0}), HasSubstr("line 10000002: there are more than 10000000 rows"));
}

TEST(TrajectoryFiles, AFolderIsCalledOne) {
  const hapticd::test::TemporaryDirectory directory;
  EXPECT_THAT([&] { (void)Table::read(directory.path(), ""); }, ThrowsMessage<Failure>(HasSubstr(": it is a folder")));
}

TEST(TrajectoryFiles, ABallComesFromWhereItTouchesNothing) {
  Surface ball{1000};
  ball.radius = 0.004;
  for (const double z : {0.001, 0.0, -0.001}) {
    const Trajectory in = readColumns(Table::parse(fmt::format("t,x,y,z\n0,0.01,0.01,{}\n", z), "test.csv", ""), {},
                                      makeModel("plane"), ball);
    EXPECT_NEAR(in.start.z(), 0.004 + (0.004 - z), 1e-9) << "as far above the touch as the hand is below it";
  }
}

TEST(TrajectoryFiles, OptionsThatWouldDoNothingAreRefused) {
  const Model model = makeModel("plane");
  const FileOptions idle[] = {
      {"t,x,y,z", false, 0, 0}, {"", true, 0, 0}, {"", false, 2000, 0}, {"", false, 0, 1}, {"", false, 0, 0, 1}};
  for (const FileOptions& file : idle) EXPECT_THROW((void)makeTrajectory("lissajous", model, {1000}, file), Failure);
  EXPECT_THROW((void)makeTrajectory("profile:seconds=3", makeModel("ridge"), {1000}), Failure);
  const hapticd::test::TemporaryDirectory directory;
  const std::string path = directory.path() + "/way.csv";
  std::ofstream(path) << "t,x,y,z\n0,0,0,0.001\n9,0,0,0.001\n";
  EXPECT_EQ(makeTrajectory(path, model, {1000}, {"", false, 500, 0}).duration_s(), 0.002);
  EXPECT_THROW((void)makeTrajectory(path, model, {1000}, {"", false, 500, 1}), Failure) << "--rate makes no gap";
}

TEST(TrajectoryFiles, AreFoundByTheirKind) {
  const hapticd::test::TemporaryDirectory directory;
  const std::string path = directory.path() + "/path.traj";
  std::ofstream(path) << "0 0 0 0\n0.001 0 0 0\n";
  EXPECT_EQ(makeTrajectory(path, makeModel("plane"), {1000}, {"t,x,y,z", false, 0, 0}).samples.size(), 2u);
  const std::string loud = directory.path() + "/PATH.CSV", other = directory.path() + "/path.xyz";
  std::ofstream(loud) << "t,x,y,z\n0,0,0,0\n";
  EXPECT_EQ(makeTrajectory(loud, makeModel("plane"), {1000}).samples.size(), 1u);
  std::ofstream(other) << "";
  EXPECT_THAT([&] { (void)makeTrajectory(other, makeModel("plane"), {1000}); },
              ThrowsMessage<Failure>(HasSubstr("neither a recording nor")));
  EXPECT_THROW((void)makeTrajectory(directory.path() + "/none.csv", makeModel("plane"), {1000}), Failure);
  EXPECT_THROW((void)makeTrajectory(directory.path() + "/none.xyz", makeModel("plane"), {1000}), Failure);
}

}  // namespace
}  // namespace haptic_bench
