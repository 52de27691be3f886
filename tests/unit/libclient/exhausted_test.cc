// A program that may have no more threads or descriptors: connecting is refused, and leaves it as it was.
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <sys/epoll.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <string_view>

#include "tests/unit/libclient/fixture.h"

namespace {

std::atomic<bool> watch_no_more{false};

}  // namespace

/** In place of the C library's: refuses as the kernel does beyond /proc/sys/fs/epoll/max_user_watches. */
extern "C" __attribute__((visibility("default"))) int epoll_ctl(int epoll, int operation, int fd, epoll_event* event) {
  char name[16] = "";
  pthread_getname_np(pthread_self(), name, sizeof name);
  if (watch_no_more && operation == EPOLL_CTL_ADD && std::string_view(name) == "hapticclient") {
    errno = ENOSPC;
    return -1;
  }
  return static_cast<int>(syscall(SYS_epoll_ctl, epoll, operation, fd, event));
}

namespace hapticd::test {
namespace {

/** Neither a blocked signal nor another handler is left behind. */
bool signalsAreMine() {
  sigset_t blocked;
  struct sigaction pipe {};
  return pthread_sigmask(SIG_SETMASK, nullptr, &blocked) == 0 && sigismember(&blocked, SIGINT) == 0 &&
         sigismember(&blocked, SIGTERM) == 0 && sigaction(SIGPIPE, nullptr, &pipe) == 0 && pipe.sa_handler == SIG_DFL;
}

/** Exit status of a child that runs `body` with signals as a program finds them. */
template <class Body>
int inChild(Body&& body) {
  const pid_t child = fork();
  if (child == 0) {
    struct sigaction standard {};
    standard.sa_handler = SIG_DFL;
    sigaction(SIGPIPE, &standard, nullptr);
    _exit(body());
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/** 0 if a connection is refused with that remedy, and nothing of the program's is touched. */
int refusedWith(const char* remedy) {
  const auto client = haptic::Client::connect({"/nowhere/control.sock", "tester", false, std::chrono::seconds(1)});
  if (client) return 1;
  if (client.code() != HAPTIC_SYSTEM) return 2;
  if (client.error().remedy.find(remedy) == std::string::npos) return 3;
  return signalsAreMine() ? 0 : 4;
}

TEST(Exhausted, WithoutAThreadConnectingIsRefusedAndBlocksNoSignal) {
  EXPECT_EQ(inChild([] {
              const rlimit none{1, 1};
              if (geteuid() == 0 && setresuid(65534, 65534, 65534) != 0) return 10;
              if (setrlimit(RLIMIT_NPROC, &none) != 0) return 11;
              return refusedWith("ulimit -u");
            }),
            0);
}

TEST(Exhausted, WithoutADescriptorConnectingIsRefusedAndBlocksNoSignal) {
  EXPECT_EQ(inChild([] {
              const rlimit few{16, 16};
              if (setrlimit(RLIMIT_NOFILE, &few) != 0) return 10;
              while (open("/dev/null", O_RDONLY | O_CLOEXEC) >= 0) {
              }
              return refusedWith("ulimit -n");
            }),
            0);
}

TEST_F(WithClient, ASocketThatCannotBeWatchedIsARefusalAndNotTheProgramsEnd) {
  restart(2);
  watch_no_more = true;
  const auto refused = client_->reconnect();
  watch_no_more = false;
  EXPECT_EQ(refused.code(), HAPTIC_SYSTEM);
  EXPECT_NE(refused.error().remedy.find("descriptors"), std::string::npos) << refused.error().message();
  EXPECT_FALSE(client_->connected());
  const auto back = client_->reconnect();
  EXPECT_TRUE(back) << back.error().message();
}

}  // namespace
}  // namespace hapticd::test
