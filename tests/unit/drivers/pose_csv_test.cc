#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <clocale>
#include <csignal>
#include <filesystem>
#include <fstream>

#include "drivers/pose_file.h"
#include "tests/support/process/no_descriptors.h"
#include "tests/support/process/temporary_directory.h"

namespace hapticd {
namespace {

Result<std::shared_ptr<const PoseTrack>> loadPoseCsv(const std::string& path, const std::string& within = {}) {
  const auto file = PoseFile::open(path, within);
  if (!file) return file.error();
  return file->read(std::atomic<bool>(false));
}

using ::testing::HasSubstr;

std::shared_ptr<const PoseTrack> good(std::string_view text) {
  Result<std::shared_ptr<const PoseTrack>> track = parsePoseCsv(text, "test.csv");
  if (track.ok()) return *track;
  ADD_FAILURE() << toString(track.error());
  return *parsePoseCsv("0,0,0,0\n1,0,0,0\n", "stand-in");
}

std::string refusal(std::string_view text) {
  Result<std::shared_ptr<const PoseTrack>> track = parsePoseCsv(text, "test.csv");
  EXPECT_FALSE(track.ok()) << text;
  return track.ok() ? "" : toString(track.error());
}

TEST(PoseCsv, ReadsRowsWithoutAHeader) {
  const auto track = good("0,0.01,0.02,0.03\r\n# a comment\n\n 0.5 , 1e-2,\t-0.02,0\n");
  ASSERT_EQ(track->rows().size(), 2u);
  EXPECT_EQ(track->rows()[0].p, Vec3(0.01, 0.02, 0.03));
  EXPECT_EQ(track->rows()[1].p, Vec3(0.01, -0.02, 0));
  EXPECT_EQ(track->rows()[1].t_s, 0.5);
  EXPECT_FALSE(track->hasRotation());
}

TEST(PoseCsv, TakesNumbersWithAPlus) {
  const auto track = good("+0.0,+1e-2,-0.02,+0\n+5.0e-01,0,0,0\n");
  ASSERT_EQ(track->rows().size(), 2u);
  EXPECT_EQ(track->rows()[0].p, Vec3(0.01, -0.02, 0));
  EXPECT_EQ(track->rows()[1].t_s, 0.5);
  for (const char* const wrong : {"0,+,0,0\n", "0,+-1,0,0\n", "0,++1,0,0\n", "0,+inf,0,0\n"})
    EXPECT_THAT(refusal(wrong), HasSubstr("x is not a finite number")) << wrong;
}

TEST(PoseCsv, FindsColumnsByName) {
  const auto track = good(
      "tick,t_ns,device,px,py,pz,fx,qx,qy,qz,qw,buttons,gripper_rad,note\n"
      "1,4000000000000000001,0,0.01,0.02,0.03,9,0,0,0,1.5,0,0.1,start\n"
      "2,4000000000001000001,0,0.02,0.02,0.03,9,0,0,1,1,5,0.2,\n");
  ASSERT_EQ(track->rows().size(), 2u);
  EXPECT_EQ(track->rows()[0].t_s, 0);
  EXPECT_DOUBLE_EQ(track->rows()[1].t_s, 1e-3) << "nanoseconds since boot keep their last digit";
  EXPECT_TRUE(track->hasRotation() && track->hasButtons() && track->hasGripper());
  EXPECT_NEAR(track->rows()[1].q.z(), std::sqrt(0.5), 1e-15);
  EXPECT_EQ(track->rows()[1].buttons, 5u);
}

TEST(PoseCsv, ReadsWhatMonitorWrites) {
  const auto track = good(
      "t_s,tick,t_ns,px,py,pz,qw,qx,qy,qz,vx,vy,vz,fx,fy,fz,proxy_x,proxy_y,proxy_z,gripper_rad,buttons,flags\n"
      "0.000000,7,1234567890123,0.01,0.02,0.03,1,0,0,0,0,0,0,0,0,0,0,0,0,0,0,1\n"
      "0.001000,8,1234568890456,0.02,0.02,0.03,1,0,0,0,0,0,0,0,0,0,0,0,0,0,0,1\n");
  ASSERT_EQ(track->rows().size(), 2u);
  EXPECT_DOUBLE_EQ(track->rows()[1].t_s, 1000333e-9) << "nanoseconds go before rounded seconds";
  EXPECT_EQ(track->rows()[1].p.x(), 0.02);
  EXPECT_FALSE(track->hasRotation() || track->hasButtons() || track->hasGripper());
  EXPECT_DOUBLE_EQ(good("t_ns,x,y,z,t_s\n5,0,0,0,1\n9,0,0,0,2\n")->rows()[1].t_s, 4e-9);
  EXPECT_THAT(refusal("t_s,x,y,z,t\n0,0,0,0,0\n"), HasSubstr("a second column for t"));
  EXPECT_THAT(refusal("t_ns,x,y,z,t_s,time_ns\n0,0,0,0,0,0\n"), HasSubstr("a second column for t"));
}

TEST(PoseCsv, TakesTheUnitBehindAName) {
  const auto track = good("time_ms,px_mm,y_m,z_um\n500,0,0,0\n2500,20,1,-30\n");
  const auto besides = good("t,t_ms,x,y,z,x_mm\n0,5,0,0,0,7\n2,9,0.01,0,0,8\n");
  EXPECT_EQ(besides->duration(), 2);
  EXPECT_EQ(besides->rows()[1].p.x(), 0.01) << "the same in another unit is passed over";
  EXPECT_DOUBLE_EQ(track->duration(), 2);
  EXPECT_LT((track->rows()[1].p - Vec3(0.02, 1, -30e-6)).norm(), 1e-15);
  EXPECT_DOUBLE_EQ(good("t_ms,x,y,z,t_ns\n0,0,0,0,0\n9,0,0,0,2\n")->duration(), 2e-9);
  EXPECT_THAT(refusal("t,x_inch,y,z\n0,0,0,0\n"), HasSubstr("no column x"));
  EXPECT_THAT(refusal("t,x_mm,y,z,x\n0,0,0,0,0\n"), HasSubstr("a second column for x"));
  EXPECT_THAT(refusal("t,x_mm,y,z\n0,10001,0,0\n"), HasSubstr("10.001 m is more than 10 m"));
}

TEST(PoseCsv, QuotedHeaderByteOrderMarkAndMissingLastNewline) {
  const auto track = good("\xef\xbb\xbf\"time_s\",\"x\",\"y\",\"z\"\n1,1,2,3\n2,1,2,4");
  ASSERT_EQ(track->rows().size(), 2u);
  EXPECT_EQ(track->rows()[1].t_s, 1);
}

TEST(PoseCsv, FieldsMayStandInQuotes) {
  for (const char* const header : {"", "\"t\",\"x\",\"y\",\"z\"\r\n"}) {
    const auto track = good(header + std::string("\"1\",\"1\", \"2\" ,\"3\"\r\n\"2.5\",\"1\",\" 2\",\"4\"\r\n"));
    ASSERT_EQ(track->rows().size(), 2u);
    EXPECT_EQ(track->rows()[1].t_s, 1.5);
    EXPECT_EQ(track->rows()[1].p, Vec3(1, 2, 4));
  }
  EXPECT_THAT(refusal("0,0,0,\"\n"), HasSubstr("line 1, column 4"));
}

// A recording's export; it was said that the time does not rise.
TEST(PoseCsv, IsOfOneDevice) {
  EXPECT_THAT(refusal("device,t,x,y,z\n1,0,0,0,0\n0,0,1,1,1\n"),
              HasSubstr("line 3, column 1: this row is of another device than the first"));
  EXPECT_EQ(good("t,x,y,z,device\n0,0,0,0,1\n3,0,0,0,1\n")->rows().size(), 2u);
}

TEST(PoseCsv, TheLocaleChangesNothing) {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8"}) {
    if (std::setlocale(LC_ALL, name) == nullptr) continue;
    EXPECT_EQ(good("0,0.5,0,0\n")->rows()[0].p.x(), 0.5);
  }
  std::setlocale(LC_ALL, before.c_str());
}

TEST(PoseCsv, FaultsNameFileLineAndColumn) {
  EXPECT_THAT(refusal(""), HasSubstr("no rows"));
  EXPECT_THAT(refusal("t,x,y,z\n"), HasSubstr("test.csv, line 1: there are no rows"));
  EXPECT_THAT(refusal("0,0,0,0\n1,0,zero,0\n"), HasSubstr("test.csv, line 2, column 3: y is not a finite number"));
  EXPECT_THAT(refusal("0,0,0,0\n1,0,,0\n"), HasSubstr("line 2, column 3: there is no number"));
  EXPECT_THAT(refusal("0,0,0,nan\n"), HasSubstr("line 1, column 4"));
  EXPECT_THAT(refusal("0,0,0,1e999\n"), HasSubstr("line 1, column 4"));
  EXPECT_THAT(refusal("0,0,0,0\n0,0,0,0\n"), HasSubstr("line 2, column 1: the time does not rise"));
  EXPECT_THAT(refusal("0,0,0,0\n1,0,0\n"), HasSubstr("3 columns where the first line has 4"));
  EXPECT_THAT(refusal("0,0,0\n"), HasSubstr("3 columns without a header"));
  EXPECT_THAT(refusal("0,12,0,0\n"), HasSubstr("column 2: 12 m is more than 10 m"));
  EXPECT_THAT(refusal("0,0,0,0,0,0,0,0\n"), HasSubstr("column 5: qw,qx,qy,qz is not a unit quaternion"));
  EXPECT_THAT(refusal("t,x,y\n0,0,0\n"), HasSubstr("no column z"));
  EXPECT_THAT(refusal("t;x;y;z\n0;0;0;0\n"), HasSubstr("semicolons part its columns"));
  EXPECT_THAT(refusal("0,1;0,2;0,0;0,0\n"), HasSubstr("semicolons part its columns"));
  EXPECT_THAT(refusal("t\tx\ty\tz\n0\t0\t0\t0\n"), HasSubstr("tabs part its columns"));
  EXPECT_THAT(refusal("t,x,y,z,px\n0,0,0,0,0\n"), HasSubstr("column 5: a second column for x"));
  EXPECT_THAT(refusal("t,x,y,z,qw\n0,0,0,0,1\n"), HasSubstr("no column qx"));
  EXPECT_THAT(refusal("t,x,y,z,buttons\n0,0,0,0,-1\n"), HasSubstr("column 5: buttons"));
  EXPECT_THAT(refusal("t,x,y,z,buttons\n0,0,0,0,1.5\n"), HasSubstr("column 5: buttons"));
  for (const char* const time : {"0.5", "1e9", "-1", "9223372036854775808"}) {
    EXPECT_THAT(refusal(fmt::format("t_ns,x,y,z\n{},0,0,0\n", time)),
                HasSubstr("line 2, column 1: the time is no whole number of nanoseconds"));
  }
  EXPECT_THAT(refusal("x,y,z,t,gripper\n0,0,0,0,-11\n"), HasSubstr("line 2, column 5: -11 rad is more than 10 rad"));
  EXPECT_THAT(refusal(std::string(1000, ',')), HasSubstr("more than 256 columns"));
}

TEST(PoseCsv, OfARecordingIsToldHowToMakeRowsOfIt) {
  EXPECT_THAT(refusal(std::string_view("HRBLOCK1\0\0\0\0,", 13)), HasSubstr("haptic-bench replay FILE --export"));
}

TEST(PoseCsv, NoPoseOrSpeedOfAFileIsBeyondNumbers) {
  EXPECT_THAT(refusal("0,0,0,0\n1e-310,0.1,0,0\n"), HasSubstr("line 2, column 1: the time does not rise"));
  EXPECT_THAT(refusal("t,x,y,z,gripper\n0,0,0,0,1e308\n"), HasSubstr("column 5"));
  const auto track = good("t,x,y,z,gripper,qw,qx,qy,qz\n0,-10,-10,-10,10,1,0,0,0\n2e-12,10,10,10,-10,0,1,0,0\n");
  for (const double t_s : {0.0, 1e-12, 1.0}) {
    const PoseOnTrack pose = track->at(t_s, false);
    EXPECT_TRUE(pose.p.allFinite() && pose.v.allFinite() && pose.w.allFinite() && std::isfinite(pose.gripper_rad));
  }
}

TEST(PoseCsv, WhatAFileHoldsIsNotToldToWhoNamedIt) {
  EXPECT_THAT(refusal("t,x,y,z\n0,secret,0,0\n"), ::testing::Not(HasSubstr("secret")));
  EXPECT_THAT(refusal("secret:x:0\n"), ::testing::Not(HasSubstr("secret")));
}

TEST(PoseCsv, WithoutDescriptorsItSaysSoAndNotWhoMayRead) {
  const test::TemporaryDirectory directory;
  const std::string path = directory.path() + "/there.csv";
  std::ofstream(path) << "0,0,0,0\n";
  for (const std::string& within : {std::string(), directory.path()}) {
    const test::NoDescriptors none;
    const Error error = loadPoseCsv(path, within).error();
    EXPECT_EQ(error.code, ErrorCode::kSystem);
    EXPECT_THAT(error.remedy, HasSubstr("LimitNOFILE"));
  }
  EXPECT_TRUE(loadPoseCsv(path).ok());
}

/** Whoever owns a file may have a lease on it, and who opens it waits for 45 s by default. */
TEST(PoseCsv, AFileThatSomebodyHasALeaseOnIsNotWaitedFor) {
  const test::TemporaryDirectory directory;
  const std::string path = directory.path() + "/leased.csv";
  std::ofstream(path) << "0,0,0,0\n";
  const int lease = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  const auto before = std::signal(SIGIO, SIG_IGN);
  ASSERT_EQ(::fcntl(lease, F_SETLEASE, F_WRLCK), 0);
  EXPECT_EQ(loadPoseCsv(path).error().where, path);
  ASSERT_EQ(::fcntl(lease, F_SETLEASE, F_UNLCK), 0);
  EXPECT_TRUE(loadPoseCsv(path).ok());
  ::close(lease);
  std::signal(SIGIO, before);
}

TEST(PoseCsv, FilesThatAreNotFilesAreRefused) {
  const test::TemporaryDirectory directory;
  EXPECT_EQ(loadPoseCsv(directory.path() + "/none.csv").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(loadPoseCsv(directory.path()).error().code, ErrorCode::kInvalidArgument);
  const std::string fifo = directory.path() + "/fifo";
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  EXPECT_EQ(loadPoseCsv(fifo).error().code, ErrorCode::kInvalidArgument) << "and it does not hang";
  const std::string huge = directory.path() + "/huge.csv";
  std::ofstream(huge) << "0,0,0,0\n";
  std::filesystem::resize_file(huge, PoseTrack::kMaxFileBytes + 1);
  EXPECT_EQ(loadPoseCsv(huge).error().code, ErrorCode::kQuotaExceeded);
}

TEST(PoseCsv, OfAFolderIsWhatLiesThereWhateverLinksLeadThere) {
  namespace fs = std::filesystem;
  const test::TemporaryDirectory directory;
  const std::string root = directory.path(), folder = root + "/open";
  fs::create_directories(folder + "/below");
  for (const char* file : {"/secret.csv", "/openness.csv", "/open/motion.csv", "/open/below/deep.csv"})
    std::ofstream(root + file) << "0,0,0,0\n";
  fs::create_symlink(root + "/secret.csv", folder + "/out.csv");
  fs::create_symlink(folder + "/motion.csv", root + "/in.csv");
  fs::create_directory_symlink(root, folder + "/up");
  fs::create_directory_symlink(folder, root + "/folder");
  for (const std::string& within : {folder, root + "/folder", folder + "/"}) {
    for (const char* good :
         {"/open/motion.csv", "/open/below/deep.csv", "/in.csv", "/folder/motion.csv", "/open/up/in.csv"})
      EXPECT_TRUE(loadPoseCsv(root + good, within).ok()) << good;
    for (const char* bad :
         {"/secret.csv", "/openness.csv", "/open/out.csv", "/open/up/secret.csv", "/open/../secret.csv"})
      EXPECT_EQ(loadPoseCsv(root + bad, within).error().code, ErrorCode::kPermissionDenied) << bad;
  }
  EXPECT_EQ(loadPoseCsv(folder + "/motion.csv", root + "/none").error().code, ErrorCode::kPermissionDenied);
  EXPECT_TRUE(loadPoseCsv(root + "/secret.csv", "/").ok());
}

// Whoever may not name it does not learn whether it exists, nor what it is.
TEST(PoseCsv, OfWhatLiesElsewhereNothingIsTold) {
  namespace fs = std::filesystem;
  const test::TemporaryDirectory directory;
  const std::string root = directory.path(), folder = root + "/open";
  fs::create_directories(folder + "/below");
  fs::create_directory(root + "/house");
  std::ofstream(root + "/secret.csv") << "0,0,0,0\n";
  const auto toldOf = [&](const std::string& path) {
    const auto track = loadPoseCsv(path, folder);
    if (track) return "it is read: " + path;
    Error error = track.error();
    EXPECT_EQ(error.where, path);
    error.where.clear();
    return toString(error);
  };
  for (const char* target : {"/secret.csv", "/none.csv", "/house", "/house/none.csv", "/secret.csv/none"}) {
    fs::remove(folder + "/link");
    fs::create_symlink(root + target, folder + "/link");
    for (const std::string& path : {folder + "/link", root + target, folder + "/.." + target})
      EXPECT_EQ(toldOf(path), toldOf(root + "/secret.csv")) << path;
  }
  fs::create_directory_symlink(root, folder + "/up");
  EXPECT_EQ(toldOf(folder + "/up/none.csv"), toldOf(folder + "/up/secret.csv"));
  // Nor by a way that leads past it into the folder.
  std::ofstream(folder + "/motion.csv") << "0,0,0,0\n";
  for (const char* past : {"/house", "/none", "/secret.csv", "/open"}) {
    for (const char* name : {"/motion.csv", "/none.csv"})
      EXPECT_EQ(toldOf(root + past + "/../open" + name), toldOf(root + "/secret.csv")) << past << name;
  }
  // Nor by one that begins there, or ends.
  const fs::path here = fs::current_path();
  fs::current_path(folder + "/below");
  EXPECT_EQ(toldOf("../motion.csv"), toldOf(root + "/secret.csv"));
  fs::current_path(here);
  fs::create_directory(folder + "/below/deep");
  EXPECT_EQ(toldOf(folder + "/below/deep/.."), toldOf(root + "/secret.csv"));
  std::ofstream(folder + "/a..b.csv") << "0,0,0,0\n";
  EXPECT_TRUE(loadPoseCsv(folder + "/a..b.csv", folder).ok());
  // Of what it may name, all.
  for (const std::string& inside : {folder, folder + "/below", folder + "/up/open"}) {
    EXPECT_EQ(loadPoseCsv(inside + "/none.csv", folder).error().code, ErrorCode::kNotFound) << inside;
  }
  EXPECT_EQ(loadPoseCsv(folder + "/below", folder).error().code, ErrorCode::kInvalidArgument);
}

TEST(PoseTrack, RunsStraightBetweenRowsAndHitsThem) {
  const auto track =
      good("10,0,0,0,1,0,0,0\n11,0.1,0,0,0.7071067811865476,0,0,0.7071067811865476\n13,0.1,0.2,0,1,0,0,0\n");
  for (const PoseRow& row : track->rows()) {
    EXPECT_LT((track->at(row.t_s, false).p - row.p).norm(), 1e-15);
    EXPECT_LT(track->at(row.t_s, false).q.angularDistance(row.q), 1e-12);
  }
  const PoseOnTrack middle = track->at(0.5, false);
  EXPECT_LT((middle.p - Vec3(0.05, 0, 0)).norm(), 1e-15);
  EXPECT_LT((middle.v - Vec3(0.1, 0, 0)).norm(), 1e-15);
  EXPECT_NEAR(2 * std::atan2(middle.q.z(), middle.q.w()), EIGEN_PI / 4, 1e-12);
  EXPECT_NEAR(middle.w.z(), EIGEN_PI / 2, 1e-12);
  EXPECT_LT((track->at(2, false).v - Vec3(0, 0.1, 0)).norm(), 1e-15);
}

TEST(PoseTrack, HoldsItsEndsOrStartsAgain) {
  const auto track = good("0,0,0,0\n2,0.2,0,0\n");
  EXPECT_EQ(track->at(-1, false).p.x(), 0);
  EXPECT_EQ(track->at(-1, true).p.x(), 0);
  EXPECT_EQ(track->at(5, false).p.x(), 0.2);
  EXPECT_EQ(track->at(5, false).v, Vec3(Vec3::Zero()));
  EXPECT_NEAR(track->at(5, true).p.x(), 0.1, 1e-12);
  const auto single = good("3,0.1,0,0\n");
  for (const double t : {-1.0, 0.0, 1e6}) {
    EXPECT_EQ(single->at(t, false).p.x(), 0.1);
    EXPECT_EQ(single->at(t, true).p.x(), 0.1);
  }
}

}  // namespace
}  // namespace hapticd
