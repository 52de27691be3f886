// The builder's end where there is no memory to tell of it.
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <new>
#include <vector>

#include "daemon/ipc/memfd.h"
#include "daemon/leash/builder_leash.h"
#include "tests/support/shortage.h"

namespace hapticd::test {
namespace {

/** Cancels the job of a builder that has ended, whichever allocation has failed in hearing of that. */
void cancelWhatItHad() {
  BuilderOptions options;
  options.program = "/bin/sleep";  // For as many seconds as it may have bytes.
  const auto upload = Memfd::create("upload", 4096);
  bool struck = true;
  for (std::uint64_t n = 0; struck && n < 100; ++n) {
    SCOPED_TRACE(n);
    auto leash = BuilderLeash::start(options);
    ASSERT_TRUE(leash.ok()) << toString(leash.error());
    const auto job = (*leash)->submit(upload->fd());
    ASSERT_TRUE(job.ok());
    const auto pid = static_cast<id_t>((*leash)->pid());
    ::kill(static_cast<pid_t>(pid), SIGKILL);
    siginfo_t info{};
    ASSERT_EQ(::waitid(P_PID, pid, &info, WEXITED | WNOWAIT), 0);
    Shortage shortage(n);
    BuildReport report;
    try {
      const Shortage::Scope scope(shortage);
      EXPECT_FALSE((*leash)->next(report)) << "it had not begun";
    } catch (const std::bad_alloc&) {
    }
    struck = shortage.struck();
    EXPECT_NE((*leash)->pid(), static_cast<int>(pid)) << "which may be another's now";
    (*leash)->cancel(*job);
    std::vector<ErrorCode> told;
    for (int i = 0; i < 3; ++i) {
      if ((*leash)->next(report)) told.push_back(report.error.code);
    }
    EXPECT_EQ(told, std::vector{ErrorCode::kCancelled});
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_FALSE(struck);
}

/** In a process group of its own: kill() of no process is of the whole group. */
TEST(LeashWithoutMemory, KillsNobodyForABuilderThatHasEnded) {
  const auto inChild = [] {
    ::setpgid(0, 0);
    cancelWhatItHad();
    ::_exit(testing::Test::HasFailure() ? 1 : 0);
  };
  EXPECT_EXIT(inChild(), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace hapticd::test
