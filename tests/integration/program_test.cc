// The program hapticd: its exit codes, its refusals, its clean end.
#include "tests/integration/program.h"

#include <sys/socket.h>
#include <sys/un.h>

#include <filesystem>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "tests/integration/raw_client.h"

namespace hapticd::test {
namespace {

TEST_F(ProgramTest, ServesRefusesASecondEndsCleanlyAndLeavesNoSocket) {
  Program first(directory, run());
  ASSERT_TRUE(first.says("ready")) << first.output();
  {
    Loop loop;
    RawClient client{loop, socket};
    EXPECT_TRUE(good(loop.call(client.daemon.stateRequest()).getStatus()));
  }
  Program second(directory, run());
  EXPECT_EQ(second.wait(), 5) << second.output();
  EXPECT_NE(second.output().find("another hapticd"), std::string::npos);
  // Sockets of other names in the same folder are not enough: the list of armed devices lies there, too.
  Program third(directory, {"--allow-no-rt", "--socket", directory.path() + "/run/b.sock", "--admin-socket",
                            directory.path() + "/run/b-admin.sock"});
  EXPECT_EQ(third.wait(), 6);
  EXPECT_NE(third.output().find("give this one --socket in one of its own"), std::string::npos) << third.output();
  {
    Loop loop;
    RawClient client{loop, socket};
    EXPECT_TRUE(good(loop.call(client.daemon.stateRequest()).getStatus())) << "the first serves on";
  }
  first.terminate();
  EXPECT_EQ(first.wait(), 0) << first.output();
  EXPECT_NE(access(socket.c_str(), F_OK), 0);
  struct stat folder {};
  ASSERT_EQ(stat((directory.path() + "/run").c_str(), &folder), 0);
  EXPECT_EQ(folder.st_mode & 0777u, 0700u);
}

/** hapticctl doctor looks whether it was changed since, wherever that is run. */
TEST_F(ProgramTest, TellsTheWholePathOfItsConfiguration) {
  const std::string file = directory.path() + "/here.toml";
  std::ofstream(file) << "[servo]\nmissed_limit = 1000\n";
  Program program(directory, run({"--config", std::filesystem::relative(file)}));
  ASSERT_TRUE(program.says("ready")) << program.output();
  Loop loop;
  RawClient client{loop, socket};
  auto hello = client.daemon.helloRequest();
  hello.setProtocolMajor(proto::PROTOCOL_MAJOR);
  const auto answer = loop.call(kj::mv(hello));
  ASSERT_TRUE(good(answer.getStatus()));
  EXPECT_EQ(answer.getInfo().getConfigFile().cStr(), std::filesystem::canonical(file).string());
}

/** Whose terminal is closed, say. */
TEST_F(ProgramTest, AHangUpEndsItInGoodOrder) {
  Program program(directory, run());
  ASSERT_TRUE(program.says("ready")) << program.output();
  program.terminate(SIGHUP);
  EXPECT_EQ(program.wait(), 0) << program.output();
  EXPECT_NE(program.output().find("SIGHUP: stopping"), std::string::npos) << program.output();
}

TEST_F(ProgramTest, UnderNohupItOutlivesItsTerminal) {
  signal(SIGHUP, SIG_IGN);  // Inherited.
  Program program(directory, run());
  signal(SIGHUP, SIG_DFL);
  ASSERT_TRUE(program.says("ready")) << program.output();
  program.terminate(SIGHUP);
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  program.terminate();
  EXPECT_EQ(program.wait(), 0) << program.output();
  EXPECT_EQ(program.output().find("SIGHUP"), std::string::npos) << program.output();
}

TEST_F(ProgramTest, CtrlZDoesNotStopIt) {
  Program program(directory, run());
  ASSERT_TRUE(program.says("ready")) << program.output();
  program.terminate(SIGTSTP);
  program.terminate();
  EXPECT_EQ(program.wait(), 0) << program.output();
}

TEST_F(ProgramTest, ASocketLeftByADeadDaemonIsTakenOver) {
  {
    Program dies(directory, run());
    ASSERT_TRUE(dies.says("ready")) << dies.output();
    dies.terminate(SIGKILL);
    EXPECT_EQ(dies.wait(), -SIGKILL);
  }
  EXPECT_EQ(access(socket.c_str(), F_OK), 0) << "the dead one left it";
  Program next(directory, run());
  EXPECT_TRUE(next.says("ready")) << next.output();
  next.terminate(SIGINT);
  EXPECT_EQ(next.wait(), 0);
}

/** Whose folder was moved away, or removed and made anew. */
TEST_F(ProgramTest, OneThatEndsLeavesAnothersSocketAndLock) {
  const std::string folder = directory.path() + "/run";
  Program first(directory, run());
  ASSERT_TRUE(first.says("ready")) << first.output();
  std::filesystem::rename(folder, folder + "-moved");
  Program second(directory, run());
  ASSERT_TRUE(second.says("ready")) << second.output();
  first.terminate();
  EXPECT_EQ(first.wait(), 0) << first.output();
  for (const char* name : {"control.sock", "admin.sock", "control.sock.lock", "admin.sock.lock"})
    EXPECT_TRUE(std::filesystem::exists(folder + "/" + name)) << name;
  second.terminate();
  EXPECT_EQ(second.wait(), 0) << second.output();
  EXPECT_FALSE(std::filesystem::exists(socket)) << "its own it takes away";
}

TEST_F(ProgramTest, AFileInTheWayIsNotRemoved) {
  const std::string precious = directory.path() + "/notes.txt";
  std::ofstream(precious) << "mine";
  Program program(directory, {"--allow-no-rt", "--socket", precious});
  EXPECT_EQ(program.wait(), 5) << program.output();
  std::string kept;
  std::ifstream(precious) >> kept;
  EXPECT_EQ(kept, "mine");
  EXPECT_NE(access((precious + ".lock").c_str(), F_OK), 0) << "the lock went with the refusal";
}

TEST_F(ProgramTest, LimitsOfNoOpenDeviceAreNamed) {
  const std::string file = directory.path() + "/limits.toml";
  std::ofstream(file) << "[[device]]\nuri = \"sim://default\"\nforce_n = 2\n"
                         "[[device]]\nuri = \"sim://omega3\"\nforce_n = 2\n";
  Program program(directory, run({"--config", file}));
  ASSERT_TRUE(program.says("ready")) << program.output();
  const std::string said = program.output();
  EXPECT_NE(said.find("[[device]] \"sim://omega3\" is none of the open devices"), std::string::npos) << said;
  EXPECT_EQ(said.find("[[device]] \"sim://default"), std::string::npos) << said;
}

TEST_F(ProgramTest, ExitCodesSayWhatIsWrong) {
  const auto code = [&](std::vector<std::string> arguments) {
    Program program(directory, std::move(arguments));
    return program.wait();
  };
  EXPECT_EQ(code({"--version"}), 0);
  EXPECT_EQ(code({"--help"}), 0);
  EXPECT_EQ(code({"--print-config"}), 0);
  EXPECT_EQ(code({"--check-config"}), 0);
  // Whoever writes a configuration to a full disk is told.
  for (const char* ask : {"--version", "--help", "--print-config", "--check-config"}) {
    const std::string command = HAPTICD_PROGRAM + std::string(" ") + ask + " >/dev/full 2>/dev/null";
    EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 6) << ask;
  }
  EXPECT_EQ(code({"--no-such-option"}), 1);
  // Nor does it die of a full disk where its refusal goes.
  EXPECT_EQ(WEXITSTATUS(std::system((HAPTICD_PROGRAM + std::string(" --no-such-option 2>/dev/full")).c_str())), 1);
  for (const char* option : {"--config", "--socket", "--admin-socket", "--device"})
    EXPECT_EQ(code({"--check-config", option, ""}), 1) << option << " of a variable that is not set";
  EXPECT_EQ(code({"--rate", "5"}), 1);
  EXPECT_EQ(code({"--check-config", "--rate", "nan"}), 1);
  for (const char* level : {"loud", ""}) EXPECT_EQ(code({"--check-config", "--log-level", level}), 1) << level;
  std::vector<std::string> named{"--check-config"};
  for (std::size_t i = 0; i <= GroupConfig::kMost; ++i) {
    EXPECT_EQ(code(named), 0) << i << " devices, each with a servo";
    named.insert(named.end(), {"--device", "sim://default?serial=" + std::to_string(i)});
  }
  EXPECT_EQ(code(named), 1);
  EXPECT_EQ(code({"--config", directory.path() + "/missing.toml"}), 2);
  const std::string bad = directory.path() + "/bad.toml";
  std::ofstream(bad) << "[servo]\nrate_zh = 1000\n";
  Program misspelt(directory, {"--check-config", "--config", bad});
  EXPECT_EQ(misspelt.wait(), 2);
  EXPECT_NE(misspelt.output().find("bad.toml:2"), std::string::npos) << misspelt.output();
  for (const auto& [words, place] :
       {std::pair{"[sockets]\ngroup = \"no-such-group\"\n", "bad.toml:2:9: sockets.group: there is no group"},
        {"[builder]\n\nprogram = \"/no/such/builder\"\n", "bad.toml:3:11: hapticd-builder: not found at /no/such"},
        {"[[group]]\nname = \"one\"\ndevices = [\"sim://\"]\n[[group]]\nname = \"two\"\ndevices = [\"sim://falcn\"]\n",
         "bad.toml:6:11: group two \"sim://falcn\": "},
        {"[[group]]\nname = \"one\"\ndevices = [\"sim://\"]\ncpus = [0, 1023]\n", "bad.toml:4:8: group one: cpus: "},
        {"[[device]]\nuri = \"sim://falcn\"\n", "bad.toml:2:7: [[device]] \"sim://falcn\": "}}) {
    std::ofstream(bad, std::ios::trunc) << words;
    Program missing(directory, {"--check-config", "--config", bad});
    EXPECT_EQ(missing.wait(), 2) << "found before a start finds it";
    EXPECT_NE(missing.output().find(place), std::string::npos) << missing.output();
  }
  std::ofstream(bad, std::ios::trunc) << "[sockets]\ngroup = \"no-such-group\"\n";
  Program groupless(directory, {"--config", bad, "--socket", socket});
  EXPECT_EQ(groupless.wait(), 5);
  EXPECT_NE(groupless.output().find("bad.toml:2:9: sockets.group: there is no group"), std::string::npos)
      << groupless.output();
  std::ofstream(bad, std::ios::trunc) << "[[group]]\nname = \"one\"\ndevices = [\"sim://\"]\ncpus = [0]\n";
  EXPECT_EQ(code({"--check-config", "--config", bad}), 0);
  Program unlisted(directory, {"--check-config", "--config", bad, "--device", "sim://falcn"});
  EXPECT_EQ(unlisted.wait(), 2);
  EXPECT_NE(unlisted.output().find("hapticd: --device \"sim://falcn\": "), std::string::npos) << unlisted.output();
  std::ofstream(bad) << "[[line]]\nrole = \"stop\"\nchip = \"no-such-chip\"\nname = \"ESTOP\"\n";
  Program lineless(directory, {"--check-config", "--config", bad});
  EXPECT_EQ(lineless.wait(), 2);
  EXPECT_NE(lineless.output().find("line \"ESTOP\": there is no such chip"), std::string::npos) << lineless.output();
  const std::string longest = "/" + std::string(106, 'x');
  for (const auto& sockets : {"control = '" + longest + "x'", "admin = '" + longest + "x'",
                              std::string("control = '/tmp/one.sock'\nadmin = '/tmp/one.sock'")}) {
    std::ofstream(bad) << "[sockets]\n" << sockets << "\n";
    EXPECT_EQ(code({"--check-config", "--config", bad}), 2) << sockets;
  }
  EXPECT_EQ(code({"--check-config", "--socket", longest, "--admin-socket", "/tmp/one.sock"}), 0);
  EXPECT_EQ(code({"--check-config", "--admin-socket", longest}), 0);
  EXPECT_EQ(code({"--allow-no-rt", "--socket", socket, "--device", "nosuch://thing"}), 4);
  EXPECT_EQ(code({"--allow-no-rt", "--socket", "/" + std::string(200, 'x')}), 5);
}

TEST_F(ProgramTest, AFolderOfMotionsThatIsMissingIsTold) {
  const std::string file = directory.path() + "/motions.toml", folder = directory.path() + "/motions";
  std::ofstream(file) << "[builder]\ncache = \"\"\n[motions]\nfolder = \"" << folder << "\"\n";
  const auto check = [&](const std::string& words) {
    Program program(directory, {"--config", file, "--check-config"});
    EXPECT_EQ(program.wait(), words.empty() ? 0 : 2);
    EXPECT_NE(program.output().find(words), std::string::npos) << program.output();
  };
  check("motions.toml:4:10: folder = \"" + folder + "\": No such file");
  Program daemon(directory, run({"--config", file}));
  ASSERT_TRUE(daemon.says("ready")) << "it runs all the same";
  EXPECT_NE(daemon.output().find("motions.toml:4:10"), std::string::npos) << daemon.output();
  std::ofstream(folder) << "a file";
  check("Not a directory");
  std::filesystem::remove(folder);
  std::filesystem::create_directory(folder);
  check("");
}

TEST_F(ProgramTest, LimitsFindTheirDeviceHoweverItIsSpelt) {
  const auto check = [&](const std::string& toml, std::string& said) {
    const std::string file = directory.path() + "/devices.toml";
    std::ofstream(file) << toml;
    Program program(directory, {"--config", file, "--check-config"});
    const int code = program.wait();
    said = program.output();
    return code;
  };
  std::string said;
  EXPECT_EQ(check("[[device]]\nuri = \"sim://falcn\"\nforce_n = 2\n", said), 2);
  EXPECT_NE(said.find("falcn"), std::string::npos) << said;
  EXPECT_EQ(check("[[group]]\nname = \"a\"\ndevices = [\"sim://default?ratee=1\"]\n", said), 2);
  EXPECT_NE(said.find("did you mean \"rate\""), std::string::npos) << said;
  EXPECT_EQ(check("[[device]]\nuri = \"a-serial-number\"\nforce_n = 2\n", said), 0) << said;
  const std::string once = "[[device]]\nuri = \"sim://falcon\"\nforce_n = 8\n[[device]]\nforce_n = 2\nuri = ";
  EXPECT_EQ(check(once + "\"sim://omega3\"\n", said), 0) << said;
  for (const char* same : {"\"SIM://falcon\"\n", "\"sim://falcon?rate=1000\"\n"}) {
    EXPECT_EQ(check(once + same, said), 2) << said;
    EXPECT_NE(said.find("sim://falcon: it is there twice"), std::string::npos) << said;
  }
  EXPECT_EQ(check("[[group]]\nname = \"a\"\ndevices = [\"sim://falcon\", \"SIM://falcon\"]\n", said), 2)
      << "found before a start finds it";

  const std::string file = directory.path() + "/spelt.toml";
  std::ofstream(file) << "[[device]]\nuri = \"sim://falcon?rate=1000\"\nforce_n = 2\n";  // 1000 is falcon's own rate
  Program program(directory, {"--config", file, "--print-config"});
  EXPECT_EQ(program.wait(), 0);
  EXPECT_NE(program.output().find("uri = \"sim://falcon\""), std::string::npos) << program.output();
}

/** A bound Unix socket; the numbers are far above those that the child is given. */
int boundSocket(const std::string& path, int type) {
  const int fd = ::socket(AF_UNIX, type | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  EXPECT_EQ(bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  const int high = fcntl(fd, F_DUPFD_CLOEXEC, 50);
  close(fd);
  return high;
}

TEST_F(ProgramTest, TellsSystemdReadyStatusWatchdogAndStopping) {
  const std::string path = directory.path() + "/notify";
  const int notify = boundSocket(path, SOCK_DGRAM);
  Program::Surroundings around;
  around.notify_socket = path;
  around.watchdog_us = "300000";
  Program program(directory, run(), around);
  const auto hears = [&](const std::string& what) {
    std::string all;
    for (int i = 0; i < 500; ++i) {
      char text[512] = {};
      const ssize_t n = recv(notify, text, sizeof text - 1, MSG_DONTWAIT);
      if (n > 0) all += std::string(text, static_cast<std::size_t>(n)) + "\n";
      if (all.find(what) != std::string::npos) return true;
      if (n <= 0) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  };
  EXPECT_TRUE(hears("READY=1")) << program.output();
  EXPECT_TRUE(hears("WATCHDOG=1"));
  EXPECT_TRUE(hears("STATUS=sim 1000 Hz"));
  EXPECT_TRUE(hears("WATCHDOG=1")) << "again, while the servo runs";
  program.terminate();
  EXPECT_TRUE(hears("STOPPING=1"));
  EXPECT_EQ(program.wait(), 0);
  close(notify);
}

TEST_F(ProgramTest, ServesTheSocketsSystemdListensOnAndLeavesThem) {
  const std::string control = directory.path() + "/activated.sock";
  const std::string admin = directory.path() + "/activated-admin.sock";
  Program::Surroundings around;
  around.sockets = {boundSocket(control, SOCK_STREAM), boundSocket(admin, SOCK_STREAM)};
  for (const int fd : around.sockets) ASSERT_EQ(listen(fd, 8), 0);
  Program program(directory, {"--allow-no-rt", "--device", "sim://default"}, around);
  ASSERT_TRUE(program.says("ready")) << program.output();
  {
    Loop loop;
    RawClient client{loop, control};
    RawClient administrator{loop, admin};
    for (auto* each : {&client, &administrator}) {
      auto hello = each->daemon.helloRequest();
      hello.setClientName("x");
      hello.setProtocolMajor(proto::PROTOCOL_MAJOR);
      EXPECT_EQ(loop.call(kj::mv(hello)).getInfo().getAdministration(), each == &administrator);
    }
  }
  program.terminate();
  EXPECT_EQ(program.wait(), 0);
  EXPECT_EQ(access(control.c_str(), F_OK), 0) << "systemd's socket is not ours to remove";
  for (const int fd : around.sockets) close(fd);
}

TEST_F(ProgramTest, TakesTheLimitsThatItMayHave) {
  constexpr __rlimit_resource kTaken[] = {RLIMIT_MEMLOCK, RLIMIT_RTPRIO};
  rlimit before[2]{};
  for (int i = 0; i < 2; ++i) {
    ASSERT_EQ(getrlimit(kTaken[i], &before[i]), 0);
    const rlimit lowered{0, before[i].rlim_max};
    ASSERT_EQ(setrlimit(kTaken[i], &lowered), 0);
  }
  const Program program(directory, run());
  for (int i = 0; i < 2; ++i) ASSERT_EQ(setrlimit(kTaken[i], &before[i]), 0);
  ASSERT_TRUE(program.says("ready")) << program.output();
  for (int i = 0; i < 2; ++i) EXPECT_EQ(program.limit(kTaken[i]).rlim_cur, before[i].rlim_max) << kTaken[i];
}

TEST_F(ProgramTest, WithoutRealTimeRightsItRefusesAndNamesTheRemedy) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root to drop rights from";
  ASSERT_EQ(chmod(directory.path().c_str(), 0777), 0);
  const auto at = [&](const char* name) { return directory.path() + "/" + name + "/control.sock"; };
  {
    Program allowed(directory, {"--socket", at("root"), "--device", "sim://default"});
    ASSERT_TRUE(allowed.says("ready")) << "with rights it runs: " << allowed.output();
    allowed.terminate();
    EXPECT_EQ(allowed.wait(), 0);
  }
  Program refused(directory, {"--socket", at("user"), "--device", "sim://default"}, true);
  EXPECT_EQ(refused.wait(), 3) << refused.output();
  EXPECT_NE(refused.output().find("RLIMIT_RTPRIO"), std::string::npos) << refused.output();
  EXPECT_NE(refused.output().find("--allow-no-rt"), std::string::npos) << refused.output();
  Program found(directory, {"--socket", at("found")}, true);  // Whatever device there is.
  EXPECT_EQ(found.wait(), 3) << found.output();
  EXPECT_NE(found.output().find("RLIMIT_RTPRIO"), std::string::npos) << found.output();
  EXPECT_EQ(found.output().find("goes on without"), std::string::npos) << found.output();
  Program told(directory, {"--socket", at("told"), "--device", "sim://default", "--allow-no-rt"}, true);
  EXPECT_TRUE(told.says("ready")) << told.output();
  told.terminate();
  EXPECT_EQ(told.wait(), 0);
  EXPECT_NE(told.output().find("RLIMIT_RTPRIO"), std::string::npos) << told.output();
  EXPECT_EQ(told.output().find("--allow-no-rt"), std::string::npos) << "it was passed: " << told.output();
}

}  // namespace
}  // namespace hapticd::test
