// The list of armed devices on disk, and what is done with it when its daemon is dead.
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>

#include <algorithm>
#include <fstream>
#include <optional>
#include <random>
#include <set>
#include <sstream>

#include "daemon/armed/armed_list.h"
#include "daemon/armed/make_safe.h"
#include "drivers/registry.h"
#include "tests/support/process/no_descriptors.h"
#include "tests/support/process/temporary_directory.h"
#include "tests/support/seeds.h"

namespace hapticd::test {
namespace {

using Uris = std::vector<std::string>;

class ArmedFile : public testing::Test {
 protected:
  [[nodiscard]] std::string path() const { return folder_.path() + "/armed"; }
  [[nodiscard]] std::string text() const {
    std::stringstream out;
    out << std::ifstream(path()).rdbuf();
    return out.str();
  }
  [[nodiscard]] ArmedList open() const {
    auto list = ArmedList::open(path());
    EXPECT_TRUE(list.ok()) << toString(list.error());
    return list ? std::move(*list) : ArmedList();
  }
  TemporaryDirectory folder_;
};

TEST_F(ArmedFile, StandsOnDiskWhileArmedAndNoLonger) {
  ArmedList list = open();
  ASSERT_TRUE(list.add("falcon://1").ok());
  ASSERT_TRUE(list.add("sim://omega3").ok());
  EXPECT_EQ(armedIn(text()), (Uris{"falcon://1", "sim://omega3"}));
  list.remove("falcon://1");
  EXPECT_EQ(armedIn(text()), Uris{"sim://omega3"});
  EXPECT_FALSE(list.has("falcon://1"));
  ASSERT_TRUE(list.add("falcon://1").ok());
  EXPECT_EQ(armedIn(text()), (Uris{"falcon://1", "sim://omega3"})) << "at its place again";
}

/** Whoever reads it reads so much of it: devices that were armed once must not push out those that are. */
TEST_F(ArmedFile, StaysShortWhateverWasArmed) {
  std::mt19937 random(seedOf(9));
  ArmedList list = open();
  std::set<std::string> armed;
  const auto uri = [&](int number) {
    return "sim://" + std::to_string(number) + std::string(2000 + random() % 2000, 'x');
  };
  std::uint64_t written = 0;
  for (int i = 0; written < 3 * ArmedList::kMostBytes; ++i) {
    const bool adds = armed.empty() || (armed.size() < 32 && random() % 2 == 0);
    if (adds) {
      const std::string one = uri(i);
      ASSERT_TRUE(list.add(one).ok());
      armed.insert(one);
      written += one.size();
    } else {
      const std::string one = *std::next(armed.begin(), static_cast<long>(random() % armed.size()));
      list.remove(one);
      armed.erase(one);
    }
    if (i % 16 != 0) continue;
    const Uris there = armedIn(text());
    ASSERT_EQ(std::set<std::string>(there.begin(), there.end()), armed) << i;
    ASSERT_EQ(there.size(), armed.size());
    ASSERT_LT(text().size(), ArmedList::kMostBytes / 2);
  }
}

TEST_F(ArmedFile, NothingIsArmedThatNobodyWouldReadOf) {
  std::ofstream(path()) << std::string(ArmedList::kMostBytes - 10, 'x') << '\n';
  ArmedList list = open();
  EXPECT_TRUE(list.add("sim://x").ok()) << "there is room for it";
  const auto refused = list.add("sim://y");
  ASSERT_FALSE(refused.ok());
  EXPECT_FALSE(refused.error().remedy.empty());
  EXPECT_FALSE(list.has("sim://y"));
  list.remove("sim://x");
  EXPECT_TRUE(list.add("sim://y").ok()) << "in its place";
  ASSERT_EQ(armedIn(text()).back(), "sim://y");
}

TEST_F(ArmedFile, AnEndEmptiesItAndADeathDoesNot) {
  { ASSERT_TRUE(open().add("falcon://1").ok()); }
  EXPECT_EQ(text(), "");
  std::ofstream(path()) << "falcon://1\n          \nsim://x\n";  // as a death leaves it
  ArmedList list = open();
  EXPECT_EQ(list.left(), (Uris{"falcon://1", "sim://x"}));
  ASSERT_TRUE(list.add("woodyhid://2").ok());
  EXPECT_EQ(armedIn(text()), (Uris{"falcon://1", "sim://x", "woodyhid://2"})) << "what was left stays until cleared";
  list.clear();
  EXPECT_EQ(text(), "");
  EXPECT_TRUE(list.left().empty());
}

TEST_F(ArmedFile, WhatWasLeftStaysUntilItIsSettled) {
  std::ofstream(path()) << "sim://x\nfalcon://1\nsim://x\nwoodyhid://2";
  for (int i = 0; i < 2; ++i) {
    ArmedList list = open();
    EXPECT_EQ(list.left(), (Uris{"sim://x", "falcon://1", "woodyhid://2"})) << "each once";
    ASSERT_TRUE(list.add("pantograph://3").ok());
  }
  EXPECT_EQ(armedIn(text()), (Uris{"sim://x", "falcon://1", "sim://x", "woodyhid://2"})) << "its own is closed";
  {
    ArmedList list = open();
    list.settle("sim://x");
    EXPECT_EQ(list.left(), (Uris{"falcon://1", "woodyhid://2"}));
    ASSERT_TRUE(list.add("woodyhid://2").ok());
    list.remove("woodyhid://2");  // Its daemon has it now, and has switched it off.
    EXPECT_EQ(armedIn(text()), Uris{"falcon://1"});
    ASSERT_EQ(std::remove(path().c_str()), 0);
    ASSERT_TRUE(list.keep().ok());
    EXPECT_EQ(armedIn(text()), Uris{"falcon://1"});
    list.settle("falcon://1");
    EXPECT_TRUE(list.left().empty());
  }
  EXPECT_EQ(text(), "");
}

/** As a full disk may leave it. */
TEST_F(ArmedFile, ALineCutShortStaysALineOfItsOwn) {
  std::ofstream(path()) << "sim://x\nfalcon://1";
  ArmedList list = open();
  ASSERT_TRUE(list.add("woodyhid://2").ok());
  EXPECT_EQ(armedIn(text()), (Uris{"sim://x", "falcon://1", "woodyhid://2"}));
  list.remove("woodyhid://2");
  EXPECT_EQ(armedIn(text()), (Uris{"sim://x", "falcon://1"}));
}

TEST_F(ArmedFile, WhoeverLivesHoldsIt) {
  const ArmedList daemon = open();
  const auto second = ArmedList::open(path());
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, ErrorCode::kDeviceBusy);
}

/** Whoever looks for what a dead daemon had armed goes by its name. */
TEST_F(ArmedFile, WhatSomebodyRemovedIsWrittenAnewWithItsFolder) {
  TemporaryDirectory parent;
  const std::string folder = parent.path() + "/run", path = folder + "/armed";
  const auto read = [&] {
    std::stringstream out;
    out << std::ifstream(path).rdbuf();
    return armedIn(out.str());
  };
  ASSERT_TRUE(std::filesystem::create_directory(folder));
  auto list = ArmedList::open(path);
  ASSERT_TRUE(list.ok());
  for (const char* uri : {"falcon://1", "sim://off", "woodyhid://2"}) ASSERT_TRUE(list->add(uri).ok());
  list->remove("sim://off");
  auto kept = list->keep();
  EXPECT_TRUE(kept.ok() && !*kept) << "it is there";
  for (const bool by_adding : {false, true}) {
    std::filesystem::remove_all(folder);
    if (by_adding) {
      EXPECT_TRUE(list->add("sim://x").ok());
    } else {
      kept = list->keep();
      EXPECT_TRUE(kept.ok() && *kept);
    }
    EXPECT_EQ(read(),
              by_adding ? (Uris{"falcon://1", "woodyhid://2", "sim://x"}) : (Uris{"falcon://1", "woodyhid://2"}));
    EXPECT_EQ(ArmedList::open(path).error().code, ErrorCode::kDeviceBusy) << "and locked";
  }
  list->remove("falcon://1");
  EXPECT_EQ(read(), (Uris{"woodyhid://2", "sim://x"})) << "each at its new place";
}

/** By an editor that writes into the file itself: what stood behind has moved. */
TEST_F(ArmedFile, WhatSomebodyEditsIsMendedBeforeAPlaceIsReliedOn) {
  std::ofstream(path()) << "woodyhid://gone\n";
  ArmedList list = open();
  for (const char* uri : {"sim://a", "falcon://long/one", "sim://b"}) ASSERT_TRUE(list.add(uri).ok());
  std::ofstream(path()) << "sim://a\nfalcon://long/one\nsim://b\n";
  auto kept = list.keep();
  EXPECT_TRUE(kept.ok() && *kept);
  EXPECT_EQ(armedIn(text()), (Uris{"sim://a", "falcon://long/one", "sim://b", "woodyhid://gone"}));
  kept = list.keep();
  EXPECT_TRUE(kept.ok() && !*kept) << "once";
  std::ofstream(path()) << "falcon://long/one\nsim://b\nsim://another's";
  list.remove("sim://a");
  EXPECT_EQ(armedIn(text()), (Uris{"falcon://long/one", "sim://b", "sim://another's", "woodyhid://gone"}));
  std::ofstream(path()) << "";
  ASSERT_TRUE(list.add("sim://c").ok());
  Uris all = armedIn(text());
  std::sort(all.begin(), all.end());
  EXPECT_EQ(all, (Uris{"falcon://long/one", "sim://another's", "sim://b", "sim://c", "woodyhid://gone"}));
  EXPECT_EQ(list.left(), (Uris{"sim://another's", "woodyhid://gone"}));
}

TEST_F(ArmedFile, WhatAnotherPutThereStaysBesideIt) {
  {
    ArmedList list = open();
    ASSERT_TRUE(list.add("falcon://1").ok());
    ASSERT_EQ(std::remove(path().c_str()), 0);
    std::ofstream(path()) << "another's";
    ASSERT_TRUE(list.keep().ok());
    EXPECT_EQ(armedIn(text()), (Uris{"another's", "falcon://1"}));
  }
  EXPECT_EQ(armedIn(text()), Uris{"another's"}) << "who ends has closed no more than its own";
}

TEST_F(ArmedFile, WhatIsNotFoundUnderItsNameListsNothing) {
  ArmedList list = open();
  ASSERT_TRUE(list.add("falcon://1").ok());
  ASSERT_EQ(std::remove(path().c_str()), 0);
  ASSERT_TRUE(std::filesystem::create_directory(path()));  // Nothing can be written there.
  EXPECT_EQ(list.keep().error().code, ErrorCode::kSystem);
  const auto refused = list.add("sim://x");
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kSystem);
  EXPECT_FALSE(refused.error().remedy.empty());
  EXPECT_FALSE(list.has("sim://x"));
  EXPECT_FALSE(list.add("falcon://1").ok()) << "armed again within the 100 ms that it stays listed";
  EXPECT_TRUE(list.has("falcon://1")) << "it may be on still";
  ASSERT_TRUE(std::filesystem::remove(path()));
  {  // A daemon that lives has it.
    const ArmedList another = open();
    EXPECT_EQ(list.keep().error().code, ErrorCode::kDeviceBusy);
    EXPECT_FALSE(list.add("sim://x").ok());
  }
  EXPECT_TRUE(list.add("sim://x").ok());
  EXPECT_EQ(armedIn(text()), (Uris{"falcon://1", "sim://x"}));
}

TEST_F(ArmedFile, WhatHasRunOutIsNoWantOfRights) {
  const NoDescriptors none;
  const auto list = ArmedList::open(path());
  ASSERT_FALSE(list.ok());
  EXPECT_NE(list.error().remedy.find("LimitNOFILE"), std::string::npos) << list.error().remedy;
}

TEST_F(ArmedFile, AFolderThatIsNotThereIsAnError) {
  EXPECT_EQ(ArmedList::open(folder_.path() + "/no/armed").error().code, ErrorCode::kSystem);
}

/** After every single change the file says what is armed, and it does not grow with use. */
TEST_F(ArmedFile, AnySequenceOfChangesReadsBack) {
  std::mt19937 random(seedOf(7));
  ArmedList list = open();
  std::map<std::string, bool> armed;
  for (int i = 0; i < 8; ++i) armed["sim://" + std::string(static_cast<std::size_t>(1 + i * 3), 'a')] = false;
  for (int step = 0; step < 500; ++step) {
    auto it = std::next(armed.begin(), static_cast<long>(random() % armed.size()));
    it->second = random() % 2 == 0;
    if (it->second) {
      ASSERT_TRUE(list.add(it->first).ok());
    } else {
      list.remove(it->first);
    }
    Uris expected;
    for (const auto& [uri, on] : armed) {
      if (on) expected.push_back(uri);
    }
    Uris read = armedIn(text());
    std::sort(read.begin(), read.end());
    ASSERT_EQ(read, expected);
  }
  EXPECT_LE(text().size(), 8 * (6 + 22 + 1));
}

/** Whatever somebody does to the file in between, after each change of ours it says all that is armed. */
TEST_F(ArmedFile, AnySequenceOfChangesAndEditsListsWhatIsArmed) {
  std::mt19937 random(seedOf(8));
  ArmedList list = open();
  std::map<std::string, bool> armed;
  for (int i = 0; i < 6; ++i) armed["sim://" + std::string(static_cast<std::size_t>(1 + i * 3), 'a')] = false;
  for (int step = 0; step < 500; ++step) {
    if (random() % 3 == 0) {
      Uris lines = armedIn(text());
      std::shuffle(lines.begin(), lines.end(), random);
      if (!lines.empty() && random() % 2 == 0) lines.pop_back();
      if (random() % 4 == 0) lines.clear();
      std::ofstream file(path());
      for (const std::string& line : lines) file << line << (random() % 4 == 0 ? "\n\n" : "\n");
    }
    auto it = std::next(armed.begin(), static_cast<long>(random() % armed.size()));
    it->second = random() % 2 == 0;
    if (it->second) {
      ASSERT_TRUE(list.add(it->first).ok());
    } else {
      list.remove(it->first);
    }
    Uris expected, read = armedIn(text());
    for (const auto& [uri, on] : armed) {
      if (on) expected.push_back(uri);
    }
    std::sort(read.begin(), read.end());
    ASSERT_EQ(read, expected) << "at step " << step;
  }
  EXPECT_EQ(text().find('\0'), std::string::npos);
}

TEST(MakeSafe, CallsEachListedDeviceAndNoOther) {
  TemporaryDirectory folder;
  const auto results = makeSafe({"a", "b"}, [&](const std::string& uri) -> Result<void> {
    std::ofstream(folder.path() + "/" + uri) << "zero";
    return {};
  });
  ASSERT_EQ(results.size(), 2u);
  for (const MadeSafe& device : results) {
    EXPECT_TRUE(device.ok);
    EXPECT_EQ(device.text, "");
    EXPECT_TRUE(std::filesystem::exists(folder.path() + "/" + device.uri));
  }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 2);
  EXPECT_TRUE(makeSafe({}, zeroDevice).empty());
}

/** One that hangs and one that crashes: the others are served, and the whole ends in its time. */
TEST(MakeSafe, NeitherHangNorCrashKeepsTheOthersFromIt) {
  const auto one = [](const std::string& uri) -> Result<void> {
    if (uri == "hangs") ::pause();
    if (uri == "crashes") ::abort();
    if (uri == "throws") throw std::runtime_error("a library's own");
    if (uri == "refuses") return Error{ErrorCode::kDeviceGone, uri, "unplugged", {}};
    return {};
  };
  const auto results = makeSafe({"hangs", "crashes", "throws", "refuses", "last"}, one, std::chrono::milliseconds(300));
  ASSERT_EQ(results.size(), 5u);
  EXPECT_EQ(results[0].text, "it did not answer in time");
  EXPECT_NE(results[1].text.find("signal 6"), std::string::npos) << results[1].text;
  EXPECT_EQ(results[2].text, "a library's own");
  EXPECT_NE(results[3].text.find("unplugged"), std::string::npos);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_FALSE(results[i].ok);
  EXPECT_TRUE(results[4].ok);
}

/** One that does not die when it is killed, as in a transfer that the kernel never ends: here a tracer keeps it. */
TEST_F(ArmedFile, OneThatTheKernelHoldsIsLeftBehindWithoutTheList) {
  const std::string held = folder_.path() + "/held", let_go = folder_.path() + "/let go";
  const auto one = [&](const std::string& uri) -> Result<void> {
    if (uri != "held") return {};
    ::prctl(PR_SET_PTRACER, PR_SET_PTRACER_ANY);
    const pid_t self = ::getpid();
    if (::fork() == 0) {
      if (::ptrace(PTRACE_SEIZE, self, nullptr, nullptr) == 0) std::ofstream(held) << "held";
      ::sleep(10);
      std::ofstream(let_go) << "let go";
      ::_exit(0);
    }
    ::pause();
    return {};
  };
  std::optional<ArmedList> list(open());
  const auto results = makeSafe({"held", "last"}, one, std::chrono::milliseconds(500));
  list.reset();
  if (!std::filesystem::exists(held)) GTEST_SKIP() << "no process may trace another here";
  EXPECT_FALSE(std::filesystem::exists(let_go));
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[0].text, "it did not answer in time");
  EXPECT_TRUE(results[1].ok);
  const auto again = ArmedList::open(path());
  EXPECT_TRUE(again.ok()) << toString(again.error()) << ": whoever is left behind must not keep the next from it";
}

TEST(MakeSafe, ASchemeThatNobodyKnowsIsAnError) {
  EXPECT_TRUE(zeroDevice("sim://default").ok());
  EXPECT_TRUE(zeroDevice("replay:///x.csv").ok());
  EXPECT_EQ(zeroDevice("nosuch://1").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(zeroDevice("half a li").error().code, ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace hapticd::test
