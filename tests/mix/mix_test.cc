// Whatever clients may do, all at once and for as long as is asked, on a real daemon: it stays, and nothing of them
// does.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <list>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/mix/mixed_client.h"
#include "tests/mix/rude_peer.h"
#include "tests/support/eventually.h"
#include "tests/support/for_seeds.h"
#include "tests/support/process/child_process.h"
#include "tests/support/process/daemon_fixture.h"

namespace hapticd::test {
namespace {

constexpr std::size_t kMostChildren = 7;

/** HAPTICD_MIX_SECONDS for a soak. */
std::chrono::seconds duration() {
  const char* const asked = std::getenv("HAPTICD_MIX_SECONDS");
  return std::chrono::seconds(asked != nullptr ? std::strtol(asked, nullptr, 10) : 6);
}

/** HAPTICD_PROGRAM: one built otherwise. */
std::string programOfDaemon() {
  const char* const other = std::getenv("HAPTICD_PROGRAM");
  return other != nullptr ? other : HAPTICD_PROGRAM;
}

class Mix {
 public:
  Mix(std::uint32_t seed, bool daemon_dies) : random_(seed), daemon_dies_(daemon_dies) {}

  [[nodiscard]] DaemonFixture& daemon() { return daemon_; }

  /** Clients come, are stopped, continued and killed, and at last all are gone. What one said that it should not. */
  std::string run(std::chrono::steady_clock::time_point until) {
    while (said_.empty() && daemon_.running() && std::chrono::steady_clock::now() < until) {
      if (clients_.size() < kMostChildren) begin();
      tease(*std::next(clients_.begin(), random_.below(static_cast<std::ptrdiff_t>(clients_.size()))));
      reap(false);
      if (daemon_dies_ && random_.once(40)) {
        if (random_.once(2)) {
          daemon_.kill();
        } else {
          said_ += daemon_.stop();
        }
        (void)daemon_.start();
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(random_.below(80)));
    }
    reap(true);
    return said_;
  }

 private:
  struct Client {
    std::unique_ptr<ChildProcess> process;
    bool honest = true;
  };

  void begin() {
    const std::uint32_t seed = random_.below(1u << 31);
    const std::string control = daemon_.socket(), admin = daemon_.adminSocket();
    const int kind = random_.below(8);
    if (kind == 0) {
      clients_.push_back({std::make_unique<ChildProcess>([=](auto) { beRude(control, seed); }), false});
    } else if (kind == 1) {
      clients_.push_back({std::make_unique<ChildProcess>([=](auto) { scribble(control, seed); }), false});
    } else {
      clients_.push_back({std::make_unique<ChildProcess>([=](auto say) {
        const std::string defect = MixedClient(control, admin, seed).run();
        if (!defect.empty()) say("seed " + std::to_string(seed) + ": " + defect);
      })});
    }
  }

  void tease(const Client& client) {
    switch (random_.below(12)) {
      case 0:
        return client.process->signal(SIGSTOP);
      case 1:
      case 2:
        return client.process->signal(SIGCONT);
      case 3:
        return client.process->signal(SIGKILL);
      default:
        return;
    }
  }

  void reap(bool all) {
    for (auto client = clients_.begin(); client != clients_.end();) {
      if (all) client->process->signal(SIGKILL);
      const bool over = all || client->process->over();
      if (over && client->honest) {
        const std::string end = client->process->all();
        if (!end.empty() && end != "killed by signal 9") said_ += end + "\n";
      }
      client = over ? clients_.erase(client) : std::next(client);
    }
  }

  DaemonFixture daemon_{{.program = programOfDaemon(),
                         .device = "",
                         .config =
                             "[guard]\narm_ramp_ms = 100\ndevice_stale_ms = 1000\n"
                             "[quotas]\nsessions = 14\n"
                             "[[group]]\nname = \"pair\"\n"
                             "devices = [\"sim://default?dof=6&serial=one\", \"sim://omega3?motion=tap\"]\n"
                             "[[group]]\nname = \"fast\"\ndevices = [\"sim://touch?serial=two\"]\nrate_hz = 2000\n"}};
  Random random_;
  const bool daemon_dies_;
  std::list<Client> clients_;
  std::string said_;
};

std::ptrdiff_t descriptors(pid_t pid) {
  const std::filesystem::directory_iterator all("/proc/" + std::to_string(pid) + "/fd");
  return std::distance(begin(all), end(all));
}

constexpr const char* kConfigured[] = {"sim://default?dof=6&serial=one", "sim://omega3?motion=tap",
                                       "sim://touch?serial=two"};

/** Closes what was not configured, removes what was to be kept; what there is then, as text. */
std::string tidied(DaemonFixture& daemon) {
  auto client = haptic::Client::connect({daemon.adminSocket(), "tidy", true, std::chrono::seconds(20)});
  if (!client) return client.error().message();
  for (const char* uri : kConfigured) (void)client->openDevice(uri);
  haptic::Scene scene = client->scene();
  const auto objects = scene.list();
  for (std::uint32_t i = 0; objects && i < (*objects)->count; ++i)
    (void)scene.remove((*objects)->items[i]->object->name);
  const auto meshes = scene.meshes();
  for (std::uint32_t i = 0; meshes && i < (*meshes)->count; ++i) (void)scene.dropMesh((*meshes)->items[i]->id);
  const auto textures = scene.textures();
  for (std::uint32_t i = 0; textures && i < (*textures)->count; ++i) (void)scene.dropTexture((*textures)->items[i]->id);
  const auto status = client->status();
  if (!status) return status.error().message();
  std::vector<std::string> there;
  for (std::uint32_t i = 0; i < (*status)->device_count; ++i) {
    const std::string uri = (*status)->devices[i]->uri;
    there.push_back(uri);
    if (std::find(std::begin(kConfigured), std::end(kConfigured), uri) == std::end(kConfigured))
      (void)client->closeDevice(uri);
  }
  std::sort(there.begin(), there.end());  // In whatever order they were opened again.
  return fmt::format("{}; {} sessions, {} objects, {} bytes locked, {} descriptors", fmt::join(there, " "),
                     (*status)->client_count, (*status)->objects, (*status)->locked_bytes, descriptors(daemon.pid()));
}

void expectNothingStays(bool daemon_dies) {
  forSeeds(1, [=](std::uint32_t seed) {
    Mix mix(seed, daemon_dies);
    DaemonFixture& daemon = mix.daemon();
    ASSERT_TRUE(daemon.running()) << daemon.log();
    const std::string before = tidied(daemon);
    EXPECT_EQ(mix.run(std::chrono::steady_clock::now() + duration()), "");
    ASSERT_TRUE(daemon.running()) << daemon.log();
    std::string after;
    EXPECT_TRUE(eventually([&] { return (after = tidied(daemon)) == before; })) << after << "\nbefore: " << before;
    EXPECT_EQ(daemon.stop(), "");
    if (testing::Test::HasFailure()) std::fputs(daemon.log().c_str(), stderr);
  });
}

TEST(Mix, OfWhateverClientsDoAllAtOnceNothingStays) { expectNothingStays(false); }

TEST(Mix, NorWhereTheDaemonIsKilledOrStoppedAndStartedAgain) { expectNothingStays(true); }

}  // namespace
}  // namespace hapticd::test
