#include "daemon/builder/sandbox.h"

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <initializer_list>
#include <vector>

#include "daemon/ipc/unique_fd.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define HAPTICD_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define HAPTICD_SANITIZED 1
#endif
#endif

namespace hapticd {
namespace {

#if defined(__x86_64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
#elif defined(__riscv) && __riscv_xlen == 64
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_RISCV64;
#else
constexpr std::uint32_t kArchitecture = 0;  // no filter: the rest of the sandbox stays
#endif

constexpr int kAllowed[] = {
    // its socket
    SYS_recvmsg, SYS_sendmsg, SYS_ppoll, SYS_close,
#ifdef SYS_poll
    SYS_poll,
#endif
    // memory
    SYS_mmap, SYS_munmap, SYS_mremap, SYS_mprotect, SYS_madvise, SYS_brk, SYS_memfd_create, SYS_ftruncate, SYS_fcntl,
#ifdef SYS_newfstatat
    SYS_newfstatat,
#endif
    SYS_fstat, SYS_futex, SYS_getrandom,
    // figures
    SYS_clock_gettime, SYS_getrusage,
    // its end, in order or not
    SYS_exit, SYS_exit_group, SYS_rt_sigreturn, SYS_rt_sigprocmask, SYS_rt_sigaction, SYS_getpid, SYS_gettid, SYS_write,
    SYS_restart_syscall};

/** With threads: they may still be beginning. */
constexpr int kAllowedWithThreads[] = {
#ifdef SYS_rseq
    SYS_rseq,
#endif
    SYS_set_robust_list, SYS_sched_yield, SYS_sched_getaffinity};

[[maybe_unused]] Result<void> filterSystemCalls(SandboxThreads threads) {
  if (kArchitecture == 0) return {};
  std::vector<sock_filter> program;
  const auto load = [&](std::size_t offset) {
    program.push_back(BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset)));
  };
  load(offsetof(seccomp_data, arch));
  program.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kArchitecture, 1, 0));
  program.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS));
  load(offsetof(seccomp_data, nr));
  const auto allow = [&](int number) {
    program.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(number), 0, 1));
    program.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
  };
  // Half an argument that must be so; all these machines have the low one first.
  struct Half {
    std::size_t argument;
    std::size_t high;
    std::uint32_t value;
  };
  const auto allowWith = [&](int number, std::initializer_list<Half> halves) {
    const auto length = static_cast<std::uint8_t>(3 * halves.size() + 1);
    program.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(number), 0, length));
    for (const Half& half : halves) {
      load(offsetof(seccomp_data, args) + 8 * half.argument + 4 * half.high);
      program.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, half.value, 1, 0));
      program.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS));
    }
    program.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
  };
  // Its own signals, as abort() sends them, and its own limits, to be read: those of others would stop the daemon.
  allowWith(SYS_tgkill, {{0, 0, static_cast<std::uint32_t>(::getpid())}});
  allowWith(SYS_prlimit64, {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}});
  for (const int number : kAllowed) allow(number);
  if (threads == SandboxThreads::kAll)
    for (const int number : kAllowedWithThreads) allow(number);
  program.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS));
  const sock_fprog filter{static_cast<unsigned short>(program.size()), program.data()};
  if (threads == SandboxThreads::kNone) {
    if (::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) != 0) return systemError("sandbox", "seccomp", errno);
    return {};
  }
  const long failed = ::syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_TSYNC, &filter);
  if (failed != 0) return systemError("sandbox", "seccomp of all threads", failed > 0 ? EBUSY : errno);
  return {};
}

Result<void> limit(decltype(RLIMIT_AS) what, const char* name, std::uint64_t most) {
  rlimit present{};
  if (::getrlimit(what, &present) != 0) return systemError(name, "getrlimit", errno);
  const rlim_t lower = most < present.rlim_max ? most : present.rlim_max;
  const rlimit wanted{lower, lower};
  if (::setrlimit(what, &wanted) != 0) return systemError(name, "setrlimit", errno);
  return {};
}

/** A service has its daemon spared where memory is short (OOMScoreAdjust=), and this process has that from it. */
void goFirstWhereMemoryIsShort() {
  constexpr const char kScore[] = "500";
  const UniqueFd file(::open("/proc/self/oom_score_adj", O_RDWR | O_CLOEXEC));
  char present[16] = {};
  if (::read(file.get(), present, sizeof present - 1) <= 0 || std::atoi(present) >= std::atoi(kScore)) return;
  (void)!::pwrite(file.get(), kScore, sizeof kScore - 1, 0);
}

}  // namespace

bool sandboxIsComplete() {
#ifdef HAPTICD_SANITIZED
  return false;
#else
  return kArchitecture != 0;
#endif
}

Result<void> enterSandbox(std::uint64_t memory_bytes, SandboxThreads threads) {
  if (::prctl(PR_SET_PDEATHSIG, SIGKILL) != 0) return systemError("sandbox", "PR_SET_PDEATHSIG", errno);
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return systemError("sandbox", "PR_SET_NO_NEW_PRIVS", errno);
  if (auto set = limit(RLIMIT_CORE, "RLIMIT_CORE", 0); !set) return set;
  if (auto set = limit(RLIMIT_RTPRIO, "RLIMIT_RTPRIO", 0); !set) return set;
  if (auto set = limit(RLIMIT_NOFILE, "RLIMIT_NOFILE", 16); !set) return set;
  (void)::setpriority(PRIO_PROCESS, 0, 10);  // a courtesy, as the next: a filter of the service may forbid it
  goFirstWhereMemoryIsShort();
#ifndef HAPTICD_SANITIZED
  if (auto set = limit(RLIMIT_AS, "RLIMIT_AS", memory_bytes); !set) return set;
  return filterSystemCalls(threads);
#else
  (void)memory_bytes;
  (void)threads;
  return {};
#endif
}

}  // namespace hapticd
