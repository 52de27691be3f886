// Who may say how a real device is driven.
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <future>
#include <thread>
#include <utility>

#include "tests/session/bench.h"
#include "tests/session/still_device.h"
#include "tests/support/eventually.h"

namespace hapticd::test {
namespace {

/** What comes of opening it. */
ErrorCode codeOf(Bench& bench, const char* uri, std::uint64_t connection) {
  const auto opened = bench.core.openDevice(uri, connection);
  return opened ? ErrorCode::kOk : opened.error().code;
}

TEST(Hardware, ItsParametersAreTheAdministrators) {
  Bench bench;
  const char* tuned = "falcon://default?counts_per_nm=40000";
  EXPECT_EQ(codeOf(bench, tuned, bench.connection), ErrorCode::kPermissionDenied);
  EXPECT_EQ(bench.core.openSession(tuned, bench.connection, "tester", HD_SHM_MAJOR, HD_SHM_MINOR).error().code,
            ErrorCode::kPermissionDenied);
  EXPECT_EQ(bench.core.devices().devices().size(), 1u);

  EXPECT_EQ(codeOf(bench, "falcon://default", bench.connection), ErrorCode::kOk);
  EXPECT_EQ(codeOf(bench, "sim://default?mass=0.3", bench.connection), ErrorCode::kOk) << "a simulator cannot hurt";
  EXPECT_EQ(codeOf(bench, tuned, bench.administration), ErrorCode::kOk);
  EXPECT_EQ(codeOf(bench, tuned, bench.connection), ErrorCode::kOk)
      << "it is open already, as the administrator wants it";
}

/** The administrator has said how; who says nothing gets it so. */
TEST(Hardware, IsTheSameDeviceHoweverItIsDriven) {
  Bench bench;
  bench.core.devices().setFinder([] {
    std::vector<DeviceFound> found(2);
    found[0].info.uri = "falcon://EMU1";
    found[1].info.uri = "falcon://EMU2";
    return found;
  });
  const auto opened = bench.core.openDevice("falcon://EMU1?counts_per_nm=12000", bench.administration);
  ASSERT_TRUE(opened.ok());
  const auto again = bench.core.openDevice("falcon://EMU1", bench.connection);
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(*again, *opened);
  std::vector<DeviceInfo> found;
  bench.core.devices().found([&](const Result<std::vector<DeviceInfo>>& looked) { found = looked.value(); });
  EXPECT_TRUE(eventually([&] {
    bench.core.poll();
    return !found.empty();
  }));
  ASSERT_EQ(found.size(), 1u) << "what is open is not there once more";
  EXPECT_EQ(found[0].uri, "falcon://EMU2");
}

/** Nobody waits for a bus that takes its time, but whoever asks what is on it; and it is looked at for all at once. */
TEST(Hardware, IsLookedForAside) {
  Bench bench;
  std::promise<void> go;
  std::atomic<int> looks = 0;
  bench.core.devices().setFinder([&, wait = go.get_future().share()] {
    wait.wait();
    std::vector<DeviceFound> found(1);
    found[0].info.uri = "falcon://EMU" + std::to_string(++looks);
    return found;
  });
  std::vector<std::string> heard;
  const auto ask = [&] {
    bench.core.devices().found(
        [&](const Result<std::vector<DeviceInfo>>& looked) { heard.push_back(looked.value().front().uri); });
  };
  for (int i = 0; i < 4; ++i) ask();
  Session* const session = bench.live();
  EXPECT_TRUE(bench.arm(session->id).ok()) << "all else goes on";
  EXPECT_TRUE(heard.empty());
  go.set_value();
  EXPECT_TRUE(eventually([&] {
    bench.core.poll();
    return heard.size() == 4;
  }));
  EXPECT_EQ(heard, (std::vector<std::string>{"falcon://EMU1", "falcon://EMU2", "falcon://EMU2", "falcon://EMU2"}))
      << "what somebody plugs in before he asks is seen";
  EXPECT_EQ(looks, 2);
}

/** A look at the buses that finds that, once it may go on. */
void stand(DeviceManager& devices, std::promise<void>& go, std::vector<DeviceFound> found) {
  devices.setChooser(chooseDevice);
  devices.setFinder([wait = go.get_future().share(), found = std::move(found)] {
    wait.wait();
    return found;
  });
}

/** Else who asks again and again, of a bus that stands, fills the memory. */
TEST(Hardware, ManyWaitForALookAndNotAnyNumber) {
  Bench bench;
  DeviceManager& devices = bench.core.devices();
  std::promise<void> go;
  stand(devices, go, std::vector<DeviceFound>(1));
  constexpr std::size_t kTooMany = 3;
  std::size_t heard = 0, refused = 0;
  const auto count = [&](const auto& answer) {
    ++heard;
    refused += !answer && answer.error().code == ErrorCode::kQuotaExceeded ? 1 : 0;
  };
  for (std::size_t i = 0; i < DeviceManager::kMostWaiting + kTooMany; ++i) {
    if (i % 2 == 0) devices.found([&](const Result<std::vector<DeviceInfo>>& found) { count(found); });
    if (i % 2 == 1) bench.core.openDevice("S1", bench.connection, [&](const Result<OpenDevice*>& d) { count(d); });
  }
  EXPECT_EQ(heard, kTooMany) << "at once";
  EXPECT_EQ(refused, kTooMany);
  Session* const session = bench.live();
  EXPECT_TRUE(bench.arm(session->id).ok());
  EXPECT_TRUE(bench.core.disarm(session->id).ok());
  EXPECT_TRUE(bench.core.stop("", bench.connection).ok());
  go.set_value();
  EXPECT_TRUE(eventually([&] {
    bench.core.poll();
    return heard == DeviceManager::kMostWaiting + kTooMany;
  }));
  EXPECT_EQ(refused, kTooMany);
}

/** Whoever names a serial number, or no device, waits for the buses, and nobody with him; no group is missing here. */
TEST(Hardware, OfASerialNumberIsLookedForAside) {
  Bench bench;
  DeviceManager& devices = bench.core.devices();
  std::promise<void> go;
  std::vector<DeviceFound> found(2);
  found[0].info.uri = "test://of-no-serial";
  found[1].info.uri = "test://by-serial";
  found[1].info.serial = "S1";
  found[1].real = true;
  stand(devices, go, std::move(found));
  std::vector<std::string> answers;
  const auto ask = [&](const char* text) {
    bench.core.openDevice(text, bench.connection, [&](const Result<OpenDevice*>& device) {
      answers.push_back(device ? device.value()->info().uri : device.error().what);
    });
  };
  const auto answered = [&](std::size_t many) {
    return eventually([&] {
      bench.core.poll();
      return answers.size() == many;
    });
  };
  ask("S1");
  ask("S2");
  Session* const session = bench.live();
  EXPECT_TRUE(bench.arm(session->id).ok()) << "all else goes on";
  EXPECT_TRUE(answers.empty());
  go.set_value();
  ASSERT_TRUE(answered(2));
  std::ranges::sort(answers);
  EXPECT_EQ(answers, (std::vector<std::string>{"no device has that name or serial number", "test://by-serial"}));
  ask("S1");
  ASSERT_EQ(answers.size(), 3u) << "it is open";

  bench.core.sessions().end(session->id, "the test");
  bench.step(400);
  for (const char* uri : {"test://first", "test://by-serial"})
    ASSERT_TRUE(bench.core.closeDevice(uri, bench.administration).ok());
  ask("");
  EXPECT_EQ(answers.size(), 3u);
  ASSERT_TRUE(answered(4));
  EXPECT_EQ(answers.back(), "test://by-serial") << "the first that is real";
}

/** A bus that stands does not hold the end of the daemon up; nor is anything opened of what it tells then. */
TEST(Hardware, IsLookedForNoLongerThanTheDaemonWaitsAtItsEnd) {
  std::promise<void> go;
  Bench bench;
  bench.core.devices().setChooser(chooseDevice);
  bench.core.devices().setFinder([wait = go.get_future().share()] {
    wait.wait();
    std::vector<DeviceFound> found(1);
    found[0].info.uri = "test://by-serial";
    found[0].info.serial = "S1";
    return found;
  });
  int told = 0;
  bench.core.devices().found([&](const Result<std::vector<DeviceInfo>>&) { ++told; });
  bench.core.openDevice("S1", bench.connection, [&](const Result<OpenDevice*>&) { ++told; });
  const std::size_t made = bench.scripted.size();
  EXPECT_EQ(bench.core.closeAll(), std::vector<std::string>{"the look for devices"});
  EXPECT_EQ(told, 0);
  go.set_value();
  EXPECT_TRUE(eventually([&] { return bench.core.closeAll().empty(); }));
  EXPECT_EQ(told, 0);
  EXPECT_EQ(bench.scripted.size(), made);
}

/** Opening it writes to a line that the client might not write to itself, whatever hangs on that. */
TEST(Hardware, SoIsTheSerialLineThatItHangsOn) {
  Bench bench;
  const std::uint64_t stranger = *bench.core.connect(1, 61'000, false),
                      own = *bench.core.connect(2, ::geteuid(), false);
  EXPECT_EQ(codeOf(bench, "pantograph:///dev/ttyACM0", stranger), ErrorCode::kPermissionDenied);
  EXPECT_EQ(bench.core.openSession("pantograph:///dev/ttyACM0", stranger, "s", HD_SHM_MAJOR, HD_SHM_MINOR).error().code,
            ErrorCode::kPermissionDenied);
  EXPECT_EQ(bench.core.devices().devices().size(), 1u);
  EXPECT_EQ(codeOf(bench, "pantograph:///dev/ttyACM0", bench.administration), ErrorCode::kOk);
  EXPECT_EQ(codeOf(bench, "pantograph:///dev/ttyACM0", stranger), ErrorCode::kOk) << "it is open already";
  EXPECT_EQ(codeOf(bench, "pantograph:///dev/ttyACM1", stranger), ErrorCode::kPermissionDenied);
  EXPECT_EQ(codeOf(bench, "pantograph:///dev/ttyACM1", own), ErrorCode::kOk) << "the daemon's own user";
}

/** The board does not tell what arm hangs on it, and the motors are scaled by that. */
TEST(Hardware, SoIsTheModelThatABoardDrives) {
  Bench bench;
  const std::uint64_t stranger = *bench.core.connect(1, 61'000, false),
                      own = *bench.core.connect(2, ::geteuid(), false);
  for (const char* usual : {"woodyhid://default", "woodyhid://woodenhaptics_v2015"})
    EXPECT_EQ(codeOf(bench, usual, stranger), ErrorCode::kOk) << usual;
  EXPECT_EQ(codeOf(bench, "woodyhid://polhem_v3", stranger), ErrorCode::kPermissionDenied);
  EXPECT_EQ(codeOf(bench, "woodyhid://polhem_v3", own), ErrorCode::kOk) << "the daemon's own user";
  EXPECT_EQ(codeOf(bench, "woodyhid://polhem_v3", stranger), ErrorCode::kOk) << "it is open already";
  EXPECT_EQ(codeOf(bench, "woodyhid://woodenhaptics_v2019", stranger), ErrorCode::kPermissionDenied);
  EXPECT_EQ(codeOf(bench, "woodyhid://woodenhaptics_v2019", bench.administration), ErrorCode::kOk);
}

class Unplugged final : public StillDevice {
 public:
  explicit Unplugged(std::string_view uri) : StillDevice("unplugged", std::string(uri)) {}
  Result<void> open() override { return silence(); }
  void giveUp() noexcept override {}
  void close() noexcept override {}
};

/** Who asks for what the configuration wants and is not there is told why it is not there. */
TEST(Hardware, WhatIsConfiguredIsTheAdministratorsWishWhileItIsMissing) {
  ManualClock clock{1'000'000'000};
  CoreOptions options;
  options.config = Bench::relaxed();
  options.threads = false;
  options.epoch = 42;
  const std::string wishes[] = {"falcon://default?counts_per_nm=40000", "replay:///no/such/motion.csv",
                                "pantograph:///dev/ttyACM0"};
  for (const std::string& uri : wishes) options.config.groups.push_back({uri, {uri}, 1000, {}});
  Core core(options, clock);
  core.devices().setFactory([](std::string_view uri) -> Result<std::unique_ptr<Device>> {
    return std::unique_ptr<Device>(std::make_unique<Unplugged>(uri));
  });
  ASSERT_TRUE(core.openConfigured([] { return false; }).ok());
  const std::uint64_t stranger = *core.connect(1, 61'000, false);
  const auto answer = [&](const std::string& uri) {
    std::optional<ErrorCode> code;
    core.openDevice(uri, stranger, [&](const auto& device) { code = device ? ErrorCode::kOk : device.error().code; });
    for (int i = 0; i < 5000 && !code; ++i) {
      core.poll();
      ::usleep(1000);
    }
    return code;
  };
  for (const std::string& uri : wishes) EXPECT_EQ(answer(uri), ErrorCode::kDeviceGone) << uri;
  EXPECT_EQ(answer("falcon://default"), ErrorCode::kDeviceGone) << "the same device: not opened past its group";
  EXPECT_EQ(answer("falcon://default?counts_per_nm=1"), ErrorCode::kPermissionDenied);
  EXPECT_EQ(answer("replay:///no/such/other.csv"), ErrorCode::kPermissionDenied);
  EXPECT_EQ(answer("pantograph:///dev/ttyACM1"), ErrorCode::kPermissionDenied);
}

class NamedFiles : public ::testing::Test {
 protected:
  NamedFiles() {
    namespace fs = std::filesystem;
    fs::create_directories(root_ + "/open");
    for (const char* file : {"/secret.csv", "/open/motion.csv", "/openness.csv"})
      std::ofstream(root_ + file) << "0,0,0,0\n1,0.01,0,0\n";
    fs::create_symlink(root_ + "/secret.csv", root_ + "/open/way_out.csv");
  }
  ~NamedFiles() override { std::filesystem::remove_all(root_); }
  ErrorCode opened(Bench& bench, const std::string& uri, std::uint64_t connection) {
    const auto device = bench.core.openDevice(uri, connection);
    return device ? ErrorCode::kOk : device.error().code;
  }
  static Config withFolder(const std::string& folder) {
    Config config = Bench::relaxed();
    config.motions.folder = folder;
    return config;
  }
  std::string root_ = ::testing::TempDir() + "hapticd-named-" + std::to_string(::getpid());
};

TEST_F(NamedFiles, AreTheAdministratorsAndTheDaemonsOwnUsers) {
  Bench bench;
  const std::uint64_t stranger = *bench.core.connect(1, 61'000, false);
  for (const std::string& uri :
       {"replay://" + root_ + "/secret.csv", "sim://default?motion=csv&file=" + root_ + "/secret.csv",
        std::string("replay:///etc/shadow")}) {
    EXPECT_EQ(opened(bench, uri, stranger), ErrorCode::kPermissionDenied) << uri;
    EXPECT_EQ(bench.core.openSession(uri, stranger, "s", HD_SHM_MAJOR, HD_SHM_MINOR).error().code,
              ErrorCode::kPermissionDenied);
  }
  EXPECT_EQ(opened(bench, "sim://default?motion=circle", stranger), ErrorCode::kOk);
  const std::uint64_t own = *bench.core.connect(2, ::geteuid(), false);
  EXPECT_EQ(opened(bench, "replay://" + root_ + "/open/motion.csv", own), ErrorCode::kOk);
  EXPECT_EQ(opened(bench, "replay://" + root_ + "/secret.csv", bench.administration), ErrorCode::kOk);
  EXPECT_EQ(opened(bench, "replay://" + root_ + "/secret.csv", stranger), ErrorCode::kOk) << "it is open already";
}

TEST_F(NamedFiles, OfTheFolderAreEverybodys) {
  Bench bench(withFolder(root_ + "/open"));
  bench.core.devices().setFactory(makeDevice);
  const std::uint64_t stranger = *bench.core.connect(1, 61'000, false);
  std::string told;
  for (const char* out : {"/secret.csv", "/no/such.csv", "/open/../secret.csv", "/open/../open/motion.csv",
                          "/open/way_out.csv", "/openness.csv", "/open/../open/.."}) {
    Error error = bench.core.openDevice("replay://" + root_ + out, stranger).error();
    EXPECT_EQ(error.code, ErrorCode::kPermissionDenied) << out;
    EXPECT_EQ(std::exchange(error.where, {}), root_ + out);
    if (told.empty()) told = toString(error);
    EXPECT_EQ(toString(error), told) << out << ": of what is there nothing is told";
  }
  EXPECT_EQ(opened(bench, "replay://" + root_ + "/open/motion.csv", stranger), ErrorCode::kOk);
  Bench nowhere(withFolder(root_ + "/nowhere"));
  nowhere.core.devices().setFactory(makeDevice);
  const std::uint64_t other = *nowhere.core.connect(1, 61'000, false);
  EXPECT_EQ(opened(nowhere, "replay://" + root_ + "/nowhere/motion.csv", other), ErrorCode::kPermissionDenied);
}

/** Reading takes seconds: it is the opener's, and the control thread has only looked whether it may be. */
TEST_F(NamedFiles, AreReadAsideFromTheControlThread) {
  std::ofstream(root_ + "/open/bad.csv") << "0,0,0,0\nbad\n";
  Bench bench(withFolder(root_ + "/open"));
  bench.core.devices().setFactory(makeDevice);
  const std::uint64_t stranger = *bench.core.connect(1, 61'000, false);
  const auto answer = [&](const std::string& uri, bool at_once) {
    std::optional<Error> error;
    bench.core.openDevice(uri, stranger, [&](const Result<OpenDevice*>& device) {
      error = device ? Error{ErrorCode::kOk, {}, {}, {}} : device.error();
    });
    EXPECT_EQ(error.has_value(), at_once) << uri;
    for (int i = 0; i < 5000 && !error; ++i) {
      bench.step(1);
      ::usleep(1000);
    }
    return error ? *error : Error{ErrorCode::kTimeout, {}, {}, {}};
  };
  for (const char* form : {"replay://{}", "sim://default?motion=csv&file={}"}) {
    const auto of = [&](const char* file) { return fmt::format(fmt::runtime(form), root_ + file); };
    EXPECT_NE(answer(of("/open/bad.csv"), false).where.find("line 2"), std::string::npos);
    EXPECT_EQ(answer(of("/open/motion.csv"), false).code, ErrorCode::kOk);
    EXPECT_EQ(answer(of("/secret.csv"), true).code, ErrorCode::kPermissionDenied);
  }
}

/** What is read is what was judged, although a client turns its link about meanwhile. */
TEST_F(NamedFiles, AreReadWhereTheyWereFound) {
  namespace fs = std::filesystem;
  const std::string link = root_ + "/link.csv", next = root_ + "/next.csv";
  const std::string targets[] = {root_ + "/secret.csv", root_ + "/open/motion.csv"};
  std::ofstream(targets[0]) << "secret:x\n";  // An error of its first line tells that it was read.
  std::ofstream(targets[1]) << "0,0,0,0\nbad\n";
  fs::create_symlink(targets[1], link);
  Bench bench(withFolder(root_ + "/open"));
  bench.core.devices().setFactory(makeDevice);
  const std::uint64_t stranger = *bench.core.connect(1, 61'000, false);
  std::atomic<bool> done{false};
  std::thread turner([&] {
    for (unsigned i = 0; !done; ++i) {
      fs::create_symlink(targets[i % 2], next);
      fs::rename(next, link);
    }
  });
  int read = 0, refused = 0;
  for (int i = 0; i < 3000; ++i) {
    const Error error = bench.core.openDevice("replay://" + link, stranger).error();
    (error.code == ErrorCode::kPermissionDenied ? refused : read) += 1;
    EXPECT_EQ(error.where.find("line 1"), std::string::npos) << "at attempt " << i;
  }
  done = true;
  turner.join();
  EXPECT_GT(read, 0);
  EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace hapticd::test
