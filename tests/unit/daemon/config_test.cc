#include "daemon/config/config.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>

namespace hapticd {
namespace {

Error refused(std::string_view text) {
  auto config = parseConfig(text, "f");
  EXPECT_FALSE(config.ok()) << text;
  return config.ok() ? Error{} : config.error();
}

TEST(Config, EmptyFileIsTheDefault) {
  const auto config = parseConfig("", "f");
  ASSERT_TRUE(config.ok());
  EXPECT_EQ(*config, Config{});
}

TEST(Config, UnknownKeysNameLineColumnAndTheNearestKey) {
  const Error key = refused("[servo]\nrate_hz = 2000\n  ingest_prio = 5\n");
  EXPECT_EQ(toString(key), "f:3:3: unknown key \"ingest_prio\" in [servo] (did you mean \"ingest_priority\"?)");
  EXPECT_EQ(refused("[servos]\n").remedy, "did you mean \"servo\"?");
  EXPECT_EQ(refused("x = 1\n").where, "f:1:1");
  EXPECT_EQ(refused("[log]\nverbosity = 3\n").remedy, "known here: level") << "nothing is near";
  EXPECT_EQ(refused("[[group]]\nname='a'\ndevices=['']\nrat_hz=1000").where, "f:4:1");
}

TEST(Config, WrongTypesAreNamed) {
  EXPECT_EQ(toString(refused("[servo]\nrate_hz = \"fast\"\n")), "f:2:11: rate_hz is text (it must be a number)");
  EXPECT_EQ(refused("[servo]\nallow_no_rt = 1\n").remedy, "it must be true or false");
  EXPECT_EQ(refused("servo = 3\n").remedy, "it must be a table, [servo]");
  EXPECT_EQ(refused("[group]\nname = 'x'\n").remedy, "it must be an array of tables, [[group]]");
  EXPECT_EQ(refused("group = [1]\n").remedy, "it must be an array of tables, [[group]]");
  EXPECT_EQ(refused("[sockets]\ncontrol = \"a\\u0000b\"\n").what, "control holds a zero byte");
  EXPECT_EQ(refused("[sockets]\nmode = '0660'\n").remedy, "it must be file permissions such as 0o660");
  EXPECT_EQ(refused("[[group]]\ndevices = 3\n").remedy, "it must be an array of texts");
  EXPECT_EQ(refused("[[group]]\ncpus = 3\n").remedy, "it must be an array of integers");
  EXPECT_EQ(refused("[log]\nlevel = 'loud'\n").remedy, "one of trace, debug, info, warn, error, off");
  EXPECT_EQ(refused("[servo]\nservo_priority = 80.5\n").what, "servo_priority is a number");
}

TEST(Config, RangesAreNamed) {
  EXPECT_EQ(toString(refused("[servo]\nrate_hz = 9000\n")), "f:2:11: rate_hz = 9000 is out of range (1000 to 4000)");
  EXPECT_EQ(refused("[limits]\nforce_n = nan\n").what, "force_n = nan is out of range");
  EXPECT_EQ(refused("[limits]\nforce_n = -1\n").what, "force_n = -1 is out of range");
  EXPECT_EQ(refused("[limits]\nforce_n = 9007199254740994\n").what, "force_n = 9007199254740994 is out of range");
  EXPECT_EQ(refused("[servo]\nservo_priority = 99\n").what, "servo_priority = 99 is out of range");
  EXPECT_EQ(refused("[quotas]\nsessions = 99999999999999\n").what, "sessions = 99999999999999 is out of range");
  EXPECT_EQ(refused("[[device]]\nuri = 'x'\nradius_m = 0.2\n").remedy, "0 to 0.1");
  EXPECT_EQ(refused("[[device]]\nuri = 'x'\nmount_m = [0, 0, 101]\n").remedy, "-100 to 100");
  EXPECT_EQ(refused("[[device]]\nuri = 'x'\nmount_m = [0, 0, 101]\n").where, "f:3:18");
  EXPECT_EQ(refused("[[device]]\nuri = 'x'\nmount_m = [0, 0]\n").what, "mount_m has 2 numbers");
  EXPECT_EQ(refused("[[device]]\nuri = 'x'\nmount_m = 0.1\n").remedy, "it must be three numbers, [x, y, z]");
  EXPECT_EQ(refused("[[device]]\nuri = 'x'\nmount_deg = [0, '90', 0]\n").what, "mount_deg is text");
  EXPECT_EQ(refused("[[device]]\nuri = 'x'\nmount_deg = [0, nan, 0]\n").what, "mount_deg = nan is out of range");
  EXPECT_EQ(refused("[[device]]\nuri = 'x'\nfinger = 'wet'\n").what, "finger: 'wet' says nothing of a finger");
  EXPECT_EQ(refused("[[device]]\nuri = 'x'\nfinger = 'soft,arm=1'\n").remedy, "0 to 0.1 m");
  EXPECT_EQ(refused("[[device]]\nuri = 'x'\nfinger = 'soft,arm=6mm'\n").what,
            "finger: arm: '6mm' is not a finite number");
  EXPECT_EQ(refused("[sockets]\nmode = 0o7777\n").what, "mode = 0o7777 is not a set of file permissions");
  EXPECT_EQ(refused("[sockets]\nmode = 660\n").what, "mode = 660 is not a set of file permissions");
  EXPECT_EQ(toString(refused("[sockets]\nmode = 432\n")),
            "f:2:8: mode = 432 is not written in octal (it must be file permissions such as 0o660)");
}

TEST(Config, TheFirstErrorOfTheFileIsReported) {
  EXPECT_EQ(refused("[servo]\nrate_hz = 1\n[guard]\npassivity = 2\n[log]\nlevel = 3\n").where, "f:2:11");
}

TEST(Config, ValuesThatDoNotFitTogetherAreRefused) {
  EXPECT_EQ(refused("[servo]\ningest_priority = 80\n").where, "f:2:19");
  EXPECT_EQ(refused("[servo]\nservo_priority = 10\n").what, "ingest_priority 70 is not below servo_priority 10");
  EXPECT_EQ(refused("[[group]]\nname='a'\ndevices=['x']\n[[group]]\nname='a'\ndevices=['y']").what,
            "group \"a\" stands twice");
  EXPECT_EQ(refused("[[group]]\nname='a'\ndevices=['x','x']").what, "device \"x\" stands in two places");
  EXPECT_EQ(refused("[[group]]\nname='a'\ndevices=['1','2','3','4','5']").remedy, "one servo serves at most 4");
  EXPECT_EQ(refused("[[group]]\nname='a'").what, "group \"a\" has no devices");
  EXPECT_TRUE(parseConfig("[[group]]\nname='a'\ndevices=['1','2','3','4']", "f").ok());
  std::string groups;
  for (const char name : std::string("12345678"))
    groups += fmt::format("[[group]]\nname='{0}'\ndevices=['{0}']\n", name);
  EXPECT_TRUE(parseConfig(groups, "f").ok());
  const Error ninth = refused(groups + "[[group]]\nname='9'\ndevices=['9']\n");
  EXPECT_EQ(ninth.where + ": " + ninth.what, "f:25:1: there are 9 groups") << "it would be tried for ever";
  EXPECT_EQ(refused("[[group]]\ndevices=['x']").what, "a [[group]] has no name");
  EXPECT_EQ(refused("[[device]]\nforce_n=1").what, "a [[device]] has no uri");
  EXPECT_EQ(refused("[[device]]\nuri='x'\n[[device]]\nuri='x'").what, "device \"x\" stands twice");
  EXPECT_TRUE(parseConfig("[[group]]\nname='a'\ndevices=['x']\n[[device]]\nuri='x'", "f").ok());
}

TEST(Config, WhatDoesNotFitIsToldWhereItsKeyStands) {
  for (const auto& [words, where] :
       {std::pair{"[[device]]\nuri = 'x'\n\nfinger = 'wet'\n", "f:4:10"},
        {"[[device]]\nuri='x'\n[[device]]\nforce_n = 1\nuri='x'\n", "f:5:5"},
        {"[[group]]\nname='a'\ndevices=['x']\n[[group]]\ndevices=['y']\nname='a'\n", "f:6:6"},
        {"[[group]]\nname='a'\ndevices=['x']\n[[group]]\nname='b'\ndevices=['x']\n", "f:6:9"},
        {"[[group]]\nname='a'\n", "f:1:1"},
        {"[[line]]\nname = 'A'\nrole = 'stopp'\n", "f:3:8"},
        {"[[line]]\nrole = 'stop'\nname = 'A'\nbias = 'up'\n", "f:4:8"}})
    EXPECT_EQ(refused(words).where, where) << words;
}

TEST(Config, FilesAndFoldersAreNamedFromTheRoot) {
  EXPECT_EQ(
      toString(refused("[builder]\nvdb = true\ncache = 'volumes'\n")),
      "f:3:9: cache = \"volumes\" is no absolute path (begin it with /: the daemon is started now in one folder, now "
      "in another)");
  EXPECT_EQ(refused("motions.folder = './motions'\n").where, "f:1:18");
  EXPECT_EQ(refused("[sockets]\ncontrol = 'run/control.sock'\n").where, "f:2:11");
  EXPECT_EQ(refused("[sockets]\nadmin = 'admin.sock'\n").what, "admin = \"admin.sock\" is no absolute path");
  EXPECT_EQ(refused("[builder]\nprogram = '~/hapticd-builder'\n").where, "f:2:11");
  for (const char* good :
       {"[builder]\ncache = ''\nprogram = ''\n[motions]\nfolder = ''\n[sockets]\ncontrol = ''\nadmin = ''\n",
        "[motions]\nfolder = '/no/such/one'\n"})
    EXPECT_TRUE(parseConfig(good, "f").ok()) << good;
}

TEST(Config, PlacesOfValues) {
  EXPECT_EQ(placeInConfig("[motions]\n\n  folder = '/m'\n", "f", "motions", "folder"), "f:3:12");
  EXPECT_EQ(placeInConfig("[motions]\n", "f", "motions", "folder"), "f");
  EXPECT_EQ(placeInConfig("[mot", "f", "motions", "folder"), "f");
  EXPECT_EQ(placeInConfig("[[group]]\n[[group]]\nname = 'b'\n", "f", "group", "name", 1), "f:3:8");
  EXPECT_EQ(placeInConfig("[[group]]\n", "f", "group", "name", 1), "f");
}

TEST(Config, BadTomlIsRefusedWithItsPlace) {
  const Error error = refused("[log]\nlevel = \n");
  EXPECT_EQ(error.code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(error.where.substr(0, 4), "f:2:");
  EXPECT_EQ(refused("[a").code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(refused("a = '\xff'").code, ErrorCode::kInvalidArgument);
}

TEST(Config, ReadsGroupsDevicesAndLimits) {
  const auto config = parseConfig(R"(
[limits]
force_n = 5
torque_nm = 0.25
[[group]]
name = "desk"
devices = ["sim://falcon", "touch-123"]
rate_hz = 2000
cpus = [1]
[[device]]
uri = "touch-123"
force_n = 3.3
radius_m = 0.0015
mount_m = [0.25, -0.1, 0]
mount_deg = [0, 0, 90]
scale = 2.5
clutch_button = 2
finger = "hertz,cue=1"
)",
                                  "f");
  ASSERT_TRUE(config.ok()) << toString(config.error());
  const auto groups = config->effectiveGroups();
  ASSERT_EQ(groups.size(), 1u);
  EXPECT_EQ(groups[0].name, "desk");
  EXPECT_EQ(groups[0].devices, (std::vector<std::string>{"sim://falcon", "touch-123"}));
  EXPECT_EQ(groups[0].rate_hz, 2000);
  EXPECT_EQ(groups[0].cpus, std::vector<std::uint32_t>{1});
  EXPECT_EQ(config->limits.force_n, 5);
  const DeviceConfig* const touch = config->entryOf("touch://0", "touch-123");
  ASSERT_NE(touch, nullptr);
  EXPECT_EQ(touch->limits.force_n, 3.3);
  EXPECT_EQ(touch->limits.torque_nm, 0.25) << "not given: as [limits]";
  EXPECT_EQ(touch->radius_m, 0.0015);
  EXPECT_EQ(touch->mount_m, (std::vector<double>{0.25, -0.1, 0}));
  EXPECT_EQ(touch->mount_deg, (std::vector<double>{0, 0, 90}));
  EXPECT_EQ(touch->scale, 2.5);
  EXPECT_EQ(touch->clutch_button, 2u);
  EXPECT_EQ(touch->finger, "hertz,cue=1");
  EXPECT_EQ(config->entryOf("sim://falcon", ""), nullptr);
}

TEST(Config, ReadsLinesAndRefusesThoseThatMeanNothing) {
  const auto config = parseConfig("[[line]]\nrole = \"stop\"\nname = \"ESTOP\"\nactive_low = true\n", "f");
  ASSERT_TRUE(config.ok()) << toString(config.error());
  ASSERT_EQ(config->lines.size(), 1u);
  EXPECT_EQ(config->lines[0], (LineConfig{"stop", "", "ESTOP", true, "as-is", 1}));
  EXPECT_EQ(refused("[[line]]\nrole = \"stopp\"\nname = \"A\"\n").what, "a [[line]] has the role \"stopp\"");
  EXPECT_EQ(refused("[[line]]\nrole = \"stop\"\n").what, "a [[line]] has no name");
  EXPECT_EQ(refused("[[line]]\nrole = \"led\"\nname = \"A\"\nbias = \"up\"\n").what, "a [[line]] has the bias \"up\"");
  const std::string one = "[[line]]\nrole = \"stop\"\nname = \"A\"\n";
  EXPECT_EQ(refused(one + one).what, "line \"A\" stands twice");
  EXPECT_TRUE(parseConfig(one + one + "chip = \"gpiochip1\"\n", "f").ok()) << "of another chip";
}

TEST(Config, WithoutGroupsThereIsOneDefaultGroup) {
  const auto groups = Config{}.effectiveGroups();
  ASSERT_EQ(groups.size(), 1u);
  EXPECT_EQ(groups[0].devices, std::vector<std::string>{""});
  EXPECT_EQ(groups[0].rate_hz, 1000);
}

TEST(Config, WritesWhatItReads) {
  Config config;
  config.servo.rate_hz = 1333.25;
  config.guard.passivity = false;
  config.log.level = log::Level::kDebug;
  config.sockets.control = "/run/\"odd\\ näme\"\n\x7f";
  config.sockets.mode = 0640;
  config.quotas.memory_mb = 0.1 + 64;
  config.groups.push_back({"a", {"sim://falcon?x=1", "s"}, 4000, {0, 1}});
  config.devices.emplace_back();
  config.devices[0].uri = "s";
  config.devices[0].limits.force_n = 1.0 / 3;
  config.devices[0].radius_m = 0.01 / 3;
  config.devices[0].mount_m = {0.1 / 3, -99.5, 1e-7};
  config.devices[0].mount_deg = {0, -90, 360};
  config.devices[0].scale = 1 / 3.0;
  config.devices[0].clutch_button = 32;
  config.devices[0].finger = "soft,cue=2";
  config.lines.push_back({"stop", "gpiochip0", "E \"STOP\"", true, "pull-up", 0.5});
  const auto again = parseConfig(toToml(config), "f");
  ASSERT_TRUE(again.ok()) << toString(again.error()) << toToml(config);
  EXPECT_EQ(*again, config);
  config.groups[0].rate_hz = 0;  // As where the file gives none.
  const auto filled = parseConfig(toToml(config), "f");
  ASSERT_TRUE(filled.ok()) << toString(filled.error());
  EXPECT_EQ(filled->groups[0].rate_hz, 1333.25);
  const auto plain = parseConfig(toToml(Config{}), "f");
  ASSERT_TRUE(plain.ok());
  EXPECT_EQ(*plain, Config{});
}

TEST(Config, TheShippedFileIsTheEmbeddedDefaultAndNamesEveryKey) {
  const std::string path = HAPTICD_SOURCE_DIR "/systemd/hapticd.toml";
  const auto loaded = loadConfig(path, {});
  ASSERT_TRUE(loaded.ok()) << toString(loaded.error());
  EXPECT_EQ(loaded->config, Config{});
  std::ifstream file(path);
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  Config full;  // with one of each array of tables, so that their keys count too
  full.groups.push_back({"a", {"x"}, 0, {}});
  full.devices.emplace_back();
  full.devices[0].uri = "x";
  full.lines.push_back({"stop", "c", "n"});
  std::istringstream written(toToml(full));
  std::size_t keys = 0;
  std::string section;
  std::size_t begin = 0;
  for (std::string line; std::getline(written, line);) {
    if (line.empty()) continue;
    if (line[0] == '[') {
      section = line;
      begin = std::min(text.find("\n" + section), text.find("\n# " + section));
      EXPECT_NE(begin, std::string::npos) << section << " is not in the file";
      continue;
    }
    ++keys;
    const std::string key = line.substr(0, line.find(" = ")) + " = ";
    // A [[device]]'s limits are explained at [limits]; elsewhere each key stands in its own section.
    const std::size_t from = section == "[[device]]" && key != "uri = " && key != "radius_m = " &&
                                     !key.starts_with("mount") && key != "finger = " && key != "scale = " &&
                                     key != "clutch_button = "
                                 ? text.find("\n[limits]")
                                 : begin;
    const std::size_t end = std::min(text.find("\n[", from + 2), text.find("\n# [[", from + 2));
    EXPECT_NE(text.substr(from, end - from).find(key), std::string::npos) << section << " " << key;
  }
  EXPECT_GT(keys, 45u);
}

class ConfigSearch : public testing::Test {
 protected:
  void SetUp() override {
    char name[] = "/tmp/hapticd-config-XXXXXX";
    ASSERT_NE(::mkdtemp(name), nullptr);
    directory_ = name;
    ASSERT_EQ(::mkdir((directory_ + "/etc").c_str(), 0700), 0);
    ASSERT_EQ(::mkdir((directory_ + "/user").c_str(), 0700), 0);
    ASSERT_EQ(::mkdir((directory_ + "/user/hapticd").c_str(), 0700), 0);
  }
  void TearDown() override {
    for (const char* path : {"/etc/hapticd.toml", "/user/hapticd/hapticd.toml", "/own.toml"})
      ::unlink((directory_ + path).c_str());
    for (const char* path : {"/etc", "/user/hapticd", "/user", ""}) ::rmdir((directory_ + path).c_str());
  }
  std::string write(const std::string& path, const std::string& text) {
    std::ofstream(directory_ + path) << text;
    return directory_ + path;
  }
  std::string directory_;
};

TEST_F(ConfigSearch, OptionThenVariableThenServiceThenHome) {
  ConfigEnvironment environment{"", "", directory_ + "/user"};
  auto loaded = loadConfig("", environment);
  ASSERT_TRUE(loaded.ok());
  EXPECT_EQ(loaded->file, "");
  EXPECT_TRUE(loadConfig("", {"", "", "/dev/null/.config"}).ok()) << "as of a user without a home";
  const std::string home = write("/user/hapticd/hapticd.toml", "[servo]\nrate_hz = 1001\n");
  const std::string etc = write("/etc/hapticd.toml", "[servo]\nrate_hz = 1002\n");
  const std::string own = write("/own.toml", "[servo]\nrate_hz = 1003\n");
  EXPECT_EQ(loadConfig("", environment)->file, home);
  environment.configuration_directory = directory_ + "/no-such-folder";
  EXPECT_EQ(loadConfig("", environment)->file, "") << "a service does not read what its user has at home";
  environment.configuration_directory = directory_ + "/etc";
  EXPECT_EQ(loadConfig("", environment)->file, etc);
  environment.hapticd_config = own;
  EXPECT_EQ(loadConfig("", environment)->config.servo.rate_hz, 1003);
  EXPECT_EQ(loadConfig(home, environment)->config.servo.rate_hz, 1001);
}

TEST_F(ConfigSearch, HomeIsWhereXdgNamesNone) {
  const char* const home = ::getenv("HOME");
  const std::string before = home == nullptr ? "" : home;
  ::setenv("HOME", "/nowhere/somebody", 1);
  ::unsetenv("XDG_CONFIG_HOME");
  EXPECT_EQ(ConfigEnvironment::fromProcess().config_home, "/nowhere/somebody/.config");
  ::setenv("XDG_CONFIG_HOME", "/elsewhere", 1);
  EXPECT_EQ(ConfigEnvironment::fromProcess().config_home, "/elsewhere");
  ::unsetenv("XDG_CONFIG_HOME");
  if (home != nullptr) ::setenv("HOME", before.c_str(), 1);
}

TEST_F(ConfigSearch, OfAServiceWithFoldersFromADropInTheUnitsCounts) {
  const std::string etc = write("/etc/hapticd.toml", "");
  ::setenv("CONFIGURATION_DIRECTORY", (directory_ + "/etc:" + directory_ + "/user").c_str(), 1);
  const ConfigEnvironment environment = ConfigEnvironment::fromProcess();
  ::unsetenv("CONFIGURATION_DIRECTORY");
  EXPECT_EQ(loadConfig("", environment)->file, etc);
  EXPECT_EQ(serviceFolder("CONFIGURATION_DIRECTORY"), "");
}

TEST_F(ConfigSearch, APipeIsReadToItsEndAndOneThatNobodyWritesIsEmpty) {
  const std::string pipe = directory_ + "/own.toml";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(loadConfig(pipe, {})->config, Config{});
  const int end = ::open(pipe.c_str(), O_RDWR | O_CLOEXEC);
  std::thread writer([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));  // As in: hapticd --config <(sed ... FILE)
    EXPECT_GT(::write(end, "[servo]\nrate_hz = 2000\n", 23), 0);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    ::close(end);
  });
  const auto loaded = loadConfig(pipe, {});
  writer.join();
  ASSERT_TRUE(loaded.ok()) << toString(loaded.error());
  EXPECT_EQ(loaded->config.servo.rate_hz, 2000);
}

TEST_F(ConfigSearch, ANamedFileMustExistAndBeSane) {
  const auto missing = loadConfig(directory_ + "/own.toml", {});
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(missing.error().where, directory_ + "/own.toml");
  EXPECT_FALSE(loadConfig(directory_, {}).ok()) << "a directory";
  EXPECT_EQ(loadConfig("/dev/zero", {}).error().code, ErrorCode::kInvalidArgument);
  const std::string bad = write("/own.toml", "[servo]\nrate_hz = 1\n");
  EXPECT_EQ(loadConfig(bad, {}).error().where, bad + ":2:11");
}

}  // namespace
}  // namespace hapticd
