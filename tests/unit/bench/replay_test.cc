// Exports of a recording hold its numbers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <span>
#include <sstream>

#include "daemon/recording/writer.h"
#include "proto/shm_layout.h"
#include "tests/support/process/temporary_directory.h"
#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/replay/tape.h"

namespace haptic_bench {
namespace {

using ::testing::StartsWith;
using ::testing::ThrowsMessage;

using hapticd::RecordedCycle;

constexpr int kCycles = 9000;  ///< More than two chunks.

/** Two devices; the first moves along x and is pushed along z. */
void writeRecording(const std::string& path) {
  std::ofstream file(path, std::ios::binary);
  hapticd::RecordingWriter writer([&](std::span<const std::byte> bytes) {
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    return true;
  });
  hapticd::RecordingHeader header;
  header.devices = {{"left", "sim://a", "A"}, {"right", "sim://b", "B"}};
  header.start.config.device_count = 2;
  header.program = "1.2", header.build = "b", header.instructions = "i";
  header.started_ns = 1'700'000'000'250'000'000;
  (void)writer.header(header);
  const auto cycle = std::make_unique<RecordedCycle>();
  for (int i = 0; i < kCycles; ++i) {
    cycle->input.tick = static_cast<std::uint64_t>(i) + 1;
    cycle->input.now_ns = 5'000'000'000 + i * std::int64_t{1'000'000};
    cycle->input.device[0].fresh = i % 10 != 9;
    cycle->input.device[0].p.x() = 0.1 * i / kCycles;
    cycle->sent[0].force.z() = i / 3.0;
    cycle->sent[0].enabled = true;
    cycle->sent[1].torque.y() = -i;
    (void)writer.cycle(*cycle);
  }
  (void)writer.end("stopped", 0);
}

std::unique_ptr<hapticd::Replayer> replay(const std::string& path) { return orFail(hapticd::Replayer::open(path)); }

std::vector<double> readSet(hid_t file, const std::string& name, int width) {
  const hid_t set = H5Dopen2(file, name.c_str(), H5P_DEFAULT);
  EXPECT_GE(set, 0) << name;
  const hid_t space = H5Dget_space(set);
  hsize_t size[2] = {};
  EXPECT_EQ(H5Sget_simple_extent_dims(space, size, nullptr), 2);
  EXPECT_EQ(size[1], static_cast<hsize_t>(width));
  std::vector<double> out(size[0] * size[1]);
  EXPECT_GE(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, out.data()), 0);
  H5Sclose(space);
  H5Dclose(set);
  return out;
}

TEST(Replay, Hdf5HoldsEveryCycleOfEachDevice) {
  const hapticd::test::TemporaryDirectory directory;
  const std::string in = directory.path() + "/a.hrec", out = directory.path() + "/a.h5";
  writeRecording(in);
  exportHdf5(*replay(in), in, out);
  const hid_t file = H5Fopen(out.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  ASSERT_GE(file, 0);
  const auto p = readSet(file, "device0/p", 3), f = readSet(file, "device0/f", 3), t = readSet(file, "device0/t", 1),
             torque = readSet(file, "device1/torque", 3);
  ASSERT_EQ(p.size(), 3u * kCycles);
  for (std::size_t i = 0; i < kCycles; ++i) {
    const auto n = static_cast<double>(i);
    ASSERT_EQ(p[3 * i], 0.1 * n / kCycles);
    ASSERT_EQ(f[3 * i + 2], n / 3.0);
    ASSERT_NEAR(t[i], n * 1e-3, 1e-12);
    ASSERT_EQ(torque[3 * i + 1], -n);
  }
  const auto attribute = [&](const char* of, const char* name, hid_t type, void* value) {
    const hid_t found = H5Aopen_by_name(file, of, name, H5P_DEFAULT, H5P_DEFAULT);
    EXPECT_GE(H5Aread(found, type, value), 0) << of << " " << name;
    H5Aclose(found);
  };
  double period_s = 0, started_s = 0;
  attribute("/", "period_s", H5T_NATIVE_DOUBLE, &period_s);
  attribute("/", "started_unix_s", H5T_NATIVE_DOUBLE, &started_s);
  EXPECT_EQ(period_s, 1e-3);
  EXPECT_DOUBLE_EQ(started_s, 1'700'000'000.25);
  const auto words = [&](const char* of, const char* name) {
    const hid_t found = H5Aopen_by_name(file, of, name, H5P_DEFAULT, H5P_DEFAULT), type = H5Aget_type(found);
    std::string text(H5Tget_size(type), '?');
    EXPECT_GE(H5Aread(found, type, text.data()), 0);
    H5Tclose(type);
    H5Aclose(found);
    return std::string(text.c_str());
  };
  EXPECT_EQ(words("/", "program"), "hapticd 1.2");
  EXPECT_EQ(words("/", "build"), "b");
  EXPECT_EQ(words("/", "instructions"), "i");
  EXPECT_EQ(words("device0", "name") + words("device1", "uri") + words("device1", "model"), "leftsim://bB");
  EXPECT_EQ(words("device0/f", "unit"), "N");
  H5Fclose(file);
}

TEST(Replay, CsvReadsBackAsItWas) {
  const hapticd::test::TemporaryDirectory directory;
  const std::string in = directory.path() + "/a.hrec", out = directory.path() + "/a.csv";
  writeRecording(in);
  exportCsv(*replay(in), in, out);
  std::ifstream file(out);
  std::string line;
  ASSERT_TRUE(std::getline(file, line));
  std::vector<std::string> names;
  for (std::stringstream s(line); std::getline(s, line, ',');) names.push_back(line);
  const auto column = [&](const char* name) { return std::find(names.begin(), names.end(), name) - names.begin(); };
  int rows = 0;
  while (std::getline(file, line)) {
    std::vector<double> values;
    for (std::stringstream s(line); std::getline(s, line, ',');) values.push_back(std::stod(line));
    ASSERT_EQ(values.size(), names.size());
    if (values[0] == 0) {
      ASSERT_EQ(values[static_cast<std::size_t>(column("fz"))], (rows / 2) / 3.0);
    }
    ++rows;
  }
  EXPECT_EQ(rows, 2 * kCycles);
}

TEST(Replay, EachColumnIsItsOwnNumber) {
  hapticd::DeviceSample sample{};
  sample.fresh = true;
  sample.gripper_rad = 0.25;
  sample.buttons = 6;
  sample.status = 5;
  hapticd::DeviceCommand sent{};
  sent.enabled = true;
  sent.force = hapticd::Vec3(1, 2, 3);
  sent.torque = hapticd::Vec3(4, 5, 6);
  sent.gripper_force = 0.5;
  hapticd::DeviceOutput replayed{};
  replayed.pose = {hapticd::Vec3(7, 8, 9), hapticd::Quat(0.1, 0.7, 0.5, 0.5)};
  replayed.velocity = {hapticd::Vec3(10, 11, 12), hapticd::Vec3(13, 14, 15)};
  replayed.contact.proxy = hapticd::Vec3(16, 17, 18);
  replayed.contact.depth = 19;
  replayed.contact.object = 20;
  replayed.guard.flags = HD_SAMPLE_RAMPING;
  replayed.guard.fault = 21;
  replayed.guard.energy = -22;
  const hapticd::Mount mount({hapticd::Vec3(1, 1, 1), hapticd::Quat(std::sqrt(0.5), 0, 0, std::sqrt(0.5))});
  const auto told = [&] {
    const Row row{23, 24.5, &sample, &sent, &replayed, &mount};
    std::map<std::string, double> all;
    for (const haptic_bench::Column& column : columns()) {
      double values[4] = {};
      column.get(row, values);
      for (int i = 0; i < column.width; ++i) all[columnName(column, i)] = std::round(values[i] * 1e12) / 1e12;
    }
    return all;
  };
  // A quarter turn about z: the device's x is the world's y.
  std::map<std::string, double> wanted = {{"tick", 23},
                                          {"t", 24.5},
                                          {"fresh", 1},
                                          {"px", 7},
                                          {"py", 8},
                                          {"pz", 9},
                                          {"qw", 0.1},
                                          {"qx", 0.7},
                                          {"qy", 0.5},
                                          {"qz", 0.5},
                                          {"vx", 10},
                                          {"vy", 11},
                                          {"vz", 12},
                                          {"wx", 13},
                                          {"wy", 14},
                                          {"wz", 15},
                                          {"gripper", 0.25},
                                          {"buttons", 6},
                                          {"status", 5},
                                          {"enabled", 1},
                                          {"ramping", 1},
                                          {"fx", -2},
                                          {"fy", 1},
                                          {"fz", 3},
                                          {"tx", -5},
                                          {"ty", 4},
                                          {"tz", 6},
                                          {"depth", 19},
                                          {"gripper_force", 0.5},
                                          {"proxy_x", 16},
                                          {"proxy_y", 17},
                                          {"proxy_z", 18},
                                          {"object", 20},
                                          {"fault", 21},
                                          {"energy", -22}};
  EXPECT_EQ(told(), wanted);
  sample.fresh = sent.enabled = false;
  replayed.guard.flags = ~std::uint32_t{HD_SAMPLE_RAMPING};
  replayed.contact.object = 0;  // Then the proxy is the hand's.
  for (const char* none : {"fresh", "enabled", "ramping", "object"}) wanted[none] = 0;
  wanted["proxy_x"] = 7, wanted["proxy_y"] = 8, wanted["proxy_z"] = 9;
  EXPECT_EQ(told(), wanted);
}

TEST(Replay, ABrokenRecordingLeavesNoHalfOfAnExport) {
  const hapticd::test::TemporaryDirectory directory;
  const std::string in = directory.path() + "/a.hrec";
  writeRecording(in);
  std::fstream file(in, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(static_cast<std::streamoff>(std::filesystem::file_size(in) * 3 / 4));
  file << "spoilt";
  file.close();
  for (const char* kind : {".csv", ".h5"}) {
    const std::string out = directory.path() + "/out" + kind;
    CLI::App app;
    haptic_bench::Run chosen;
    addReplay(app, chosen);
    app.parse("replay " + in + " --export " + out);
    EXPECT_THAT([&] { (void)chosen({}); }, ThrowsMessage<Failure>(StartsWith(in))) << kind;
  }
  int files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(directory.path())) ++files;
  EXPECT_EQ(files, 1) << "the recording alone";
}

TEST(Replay, ARecordingIsNotWrittenOver) {
  const hapticd::test::TemporaryDirectory directory;
  const std::string in = directory.path() + "/a.csv", link = directory.path() + "/b.h5";
  writeRecording(in);
  std::filesystem::create_symlink(in, link);
  const std::uintmax_t size = std::filesystem::file_size(in);
  for (const std::string& out : {in, link}) {
    CLI::App app;
    haptic_bench::Run chosen;
    addReplay(app, chosen);
    app.parse("replay " + in + " --export " + out);
    EXPECT_THROW((void)chosen({}), Failure);
    EXPECT_EQ(std::filesystem::file_size(in), size);
  }
}

TEST(Replay, AFileThatCannotBeMadeIsNamed) {
  const hapticd::test::TemporaryDirectory directory;
  const std::string in = directory.path() + "/a.hrec";
  writeRecording(in);
  EXPECT_THROW(exportCsv(*replay(in), in, directory.path() + "/none/a.csv"), Failure);
  EXPECT_THROW(exportHdf5(*replay(in), in, directory.path() + "/none/a.h5"), Failure);
}

TEST(Replay, AFileThatMayNotGrowIsRefusedAndTheProgramEndsWell) {
  const hapticd::test::TemporaryDirectory directory;
  const std::string in = directory.path() + "/a.hrec", out = directory.path() + "/a.h5";
  writeRecording(in);
  const auto exportAndEnd = [&] {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit small{20480, 20480};
    setrlimit(RLIMIT_FSIZE, &small);
    try {
      exportHdf5(*replay(in), in, out);
    } catch (const Failure&) {
      std::exit(7);  // With what the HDF5 library does then.
    }
    std::exit(0);
  };
  EXPECT_EXIT(exportAndEnd(), testing::ExitedWithCode(7), "");
}

}  // namespace
}  // namespace haptic_bench
