/** @file
 * A session's recording as a trajectory.
 */
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include "daemon/recording/writer.h"
#include "tests/support/process/temporary_directory.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/replay/tape.h"
#include "tools/haptic-bench/trajectory/recording_reader.h"
#include "tools/haptic-bench/trajectory/registry.h"
#include "tools/haptic-bench/trial/trial.h"

namespace haptic_bench {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;
using ::testing::ThrowsMessage;

/** A hand that comes down and goes 1 mm deep along a plane, pushed with 2 N once the device is armed, until it fails.
 */
void writeSession(const std::string& path, int cycles, int armed_at = 0, double first_z = 0.001,
                  const hapticd::Pose& stands = {}, int fails_at = 1'000'000, std::uint64_t lost = 0) {
  std::ofstream file(path, std::ios::binary);
  hapticd::RecordingWriter writer([&file](std::span<const std::byte> bytes) {
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    return static_cast<bool>(file);
  });
  hapticd::RecordingHeader header;
  header.devices.resize(1);
  header.start.config.device_count = 1;
  header.start.orders.push_back(hapticd::makeCommand(hapticd::CommandKind::kSetMount, hapticd::Mount(stands).order(0)));
  ASSERT_TRUE(writer.header(header));
  const auto cycle = std::make_unique<hapticd::RecordedCycle>();
  for (int i = 0; i < cycles; ++i) {
    cycle->input.tick = static_cast<std::uint64_t>(100 + i);
    cycle->input.now_ns = 7'000'000'000 + 1'000'000 * i;
    cycle->input.device[0].p = Vec3(1e-5 * i, 0, i == 0 ? first_z : -0.001);
    if (i >= fails_at) cycle->input.device[0].p.setConstant(std::nan(""));
    cycle->sent[0].enabled = i >= armed_at;
    cycle->sent[0].force = Vec3(0, 0, i >= armed_at ? 2 : 0);
    ASSERT_TRUE(writer.cycle(*cycle));
  }
  ASSERT_TRUE(writer.end("test", lost));
}

TEST(RecordedSessions, AreTrajectories) {
  const hapticd::test::TemporaryDirectory directory;
  const std::string path = directory.path() + "/session";
  writeSession(path, 300);
  const Trajectory in = makeTrajectory(path, makeModel("plane"), {1000});
  ASSERT_EQ(in.samples.size(), 300u);
  EXPECT_TRUE(in.force_known);
  EXPECT_FALSE(in.proxy_known);
  EXPECT_DOUBLE_EQ(in.samples[299].t_s, 0.299);
  EXPECT_EQ(in.samples[10].hip, Vec3(1e-4, 0, -0.001));
  EXPECT_EQ(in.samples[10].force, Vec3(0, 0, 2));
  FileOptions second;
  second.device = 1;
  EXPECT_THROW((void)makeTrajectory(path, makeModel("plane"), {1000}, second), Failure);
}

TEST(RecordedSessions, OfADeviceThatFailedAreReadAsTheirExportIs) {
  const hapticd::test::TemporaryDirectory directory;
  const std::string path = directory.path() + "/session";
  writeSession(path, 300, 0, 0.001, {}, 290);
  const Model plane = makeModel("plane");
  const Trajectory in = makeTrajectory(path, plane, {1000});
  ASSERT_EQ(in.samples.size(), 290u);
  exportCsv(*orFail(hapticd::Replayer::open(path)), path, path + ".csv");
  const Trajectory exported = makeTrajectory(path + ".csv", plane, {1000});
  ASSERT_EQ(exported.samples.size(), in.samples.size());
  EXPECT_EQ(exported.samples.back().hip, in.samples.back().hip);
  writeSession(path, 300, 0, 0.001, {}, 0);
  exportCsv(*orFail(hapticd::Replayer::open(path)), path, path + ".csv");
  for (const std::string& file : {path, path + ".csv"}) {
    EXPECT_THAT([&] { (void)makeTrajectory(file, plane, {1000}); },
                ThrowsMessage<Failure>(HasSubstr("a session in which the device worked")));
  }
}

TEST(RecordedSessions, BeginWithoutContactsAsTheyDid) {
  const hapticd::test::TemporaryDirectory directory;
  const std::string path = directory.path() + "/session";
  writeSession(path, 300, 0, -0.002);
  const Model plane = makeModel("plane");
  const Trajectory in = makeTrajectory(path, plane, {1000});
  EXPECT_EQ(in.start, in.samples[0].hip) << "below the plane";
  for (const Answer& answer : runTrial("ours", plane, in, {1000}, 1).answers) ASSERT_FALSE(answer.touches);
}

TEST(RecordedSessions, WhatWasNotPushedIsNotJudged) {
  const hapticd::test::TemporaryDirectory directory;
  const std::string path = directory.path() + "/session";
  writeSession(path, 300, 100);
  const Model plane = makeModel("plane");
  const Surface surface{2000};
  const Trajectory in = makeTrajectory(path, plane, surface);
  ASSERT_EQ(in.samples.size(), 300u) << "the hand's way is whole";
  EXPECT_FALSE(in.samples[99].judged);
  EXPECT_TRUE(in.samples[100].judged);
  exportCsv(*orFail(hapticd::Replayer::open(path)), path, path + ".csv");
  const Trajectory exported = makeTrajectory(path + ".csv", plane, surface);
  ASSERT_EQ(exported.samples.size(), in.samples.size());
  for (std::size_t i = 0; i < in.samples.size(); ++i)
    ASSERT_EQ(exported.samples[i].judged, in.samples[i].judged) << "nor of its export, " << i;
  const Outcome outcome = runTrial("ours", plane, in, surface, 1);
  const Accuracy accuracy = judge(in, outcome.answers, 0.001);
  EXPECT_LT(accuracy.force_mse, 1e-12) << "2 N at 1 mm, which a device that is off does not push";
  EXPECT_LT(std::abs(accuracy.energy_error), 1e-12);
  const Trajectory twice = atSpeed(in, 2);
  EXPECT_FALSE(twice.samples[49].judged);
  EXPECT_TRUE(twice.samples[51].judged);
  writeSession(path, 300, 300);
  EXPECT_FALSE(makeTrajectory(path, plane, surface).force_known);
}

// A run over a part of a session looked like one over the whole.
TEST(RecordedSessions, WhatLacksAtTheEndIsTold) {
  const hapticd::test::TemporaryDirectory directory;
  const std::string path = directory.path() + "/session";
  const auto told = [&](const auto& read) {
    testing::internal::CaptureStderr();
    read();
    return testing::internal::GetCapturedStderr();
  };
  const auto way = [&] { (void)makeTrajectory(path, makeModel("plane"), {1000}); };
  const auto model = [&] { EXPECT_THROW((void)makeModel(path), Failure) << "there is no mesh"; };
  writeSession(path, 300);
  EXPECT_EQ(told(way), "");
  EXPECT_EQ(told(model), "");
  writeSession(path, 300, 0, 0.001, {}, 1'000'000, 7);
  const std::string lost = told(way);
  EXPECT_EQ(lost, "haptic-bench: " + path +
                      ": the last 7 cycles of it were lost; what is used are the 300 cycles before (0.300 s)\n");
  writeSession(path, 290, 290, 0.001, {}, 1'000'000, 8);  // Never armed: it looks for meshes to the end.
  EXPECT_THAT(told(model),
              HasSubstr(path + ": the last 8 cycles of it were lost; what is used are the 290 cycles before"));
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 1);
  const std::string cut = told(way);
  EXPECT_THAT(cut, HasSubstr(path + ": it is cut off; what is used are the 290 cycles before (0.290 s)"));
  EXPECT_THAT(told(way), Not(HasSubstr("cut off"))) << "but once";
}

TEST(RecordedSessions, DamageIsNamedAndACutIsBorne) {
  const hapticd::test::TemporaryDirectory directory;
  const std::string path = directory.path() + "/session";
  writeSession(path, 300);
  const auto size = std::filesystem::file_size(path);
  std::filesystem::resize_file(path, size / 2);
  const Trajectory cut = makeTrajectory(path, makeModel("plane"), {1000});
  EXPECT_GT(cut.samples.size(), 0u);
  EXPECT_LT(cut.samples.size(), 300u);
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(static_cast<std::streamoff>(size / 4));
  file.write("damage", 6);
  file.close();
  EXPECT_THAT([&] { (void)makeTrajectory(path, makeModel("plane"), {1000}); },
              ThrowsMessage<Failure>(StartsWith(path + ": block ")));
  std::filesystem::resize_file(path, 100);
  EXPECT_THAT([&] { (void)makeTrajectory(path, makeModel("plane"), {1000}); },
              ThrowsMessage<Failure>(StartsWith(path + ": block 0 ")));
}

/** Both are of the world, where the scene is. */
TEST(RecordedSessions, OfADeviceThatStandsElsewhereAreWhereItStood) {
  const hapticd::test::TemporaryDirectory directory;
  const std::string path = directory.path() + "/session";
  const hapticd::Pose stands{{1, 2, 3}, hapticd::Quat(Eigen::AngleAxisd(M_PI_2, Vec3::UnitX()))};
  writeSession(path, 30, 0, 0.001, stands);
  const Trajectory in = readRecordedSession(path, 0);
  EXPECT_LT((in.samples[10].hip - Vec3(1 + 1e-4, 2.001, 3)).norm(), 1e-12);
  EXPECT_LT((in.samples[10].force - Vec3(0, -2, 0)).norm(), 1e-12);
  const auto replayer = hapticd::Replayer::open(path);
  ASSERT_TRUE(replayer.ok());
  exportCsv(**replayer, path, directory.path() + "/rows.csv");
  std::ifstream file(directory.path() + "/rows.csv");
  std::string names, row;
  for (int i = 0; i < 11 && std::getline(file, i == 0 ? names : row); ++i) {
  }
  const auto column = [&](const std::string& name) {
    std::istringstream head(names), numbers(row);
    for (std::string each, number; std::getline(head, each, ',') && std::getline(numbers, number, ',');)
      if (each == name) return std::stod(number);
    ADD_FAILURE() << name << " is not in " << names;
    return 0.0;
  };
  EXPECT_NEAR(column("px"), 1 + 9e-5, 1e-9);
  EXPECT_NEAR(column("py"), 2.001, 1e-9);
  EXPECT_NEAR(column("proxy_y"), 2.001, 1e-9);
  EXPECT_NEAR(column("fy"), -2, 1e-9);
  EXPECT_NEAR(column("fz"), 0, 1e-9);
  EXPECT_NEAR(column("qx"), std::sqrt(0.5), 1e-9);
}

}  // namespace
}  // namespace haptic_bench
