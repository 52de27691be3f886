// The builder as a process: its work, its death, its limits.
#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "daemon/builder/sandbox.h"
#include "daemon/ipc/volume_memory.h"
#include "daemon/leash/builder_leash.h"
#include "daemon/leash/find_builder.h"
#include "tests/unit/builder/built.h"

namespace hapticd::test {
namespace {

BuilderOptions options() {
  BuilderOptions o;
  o.program = HAPTICD_TEST_BUILDER;
  return o;
}

Memfd frozen(const std::vector<std::byte>& bytes) {
  auto memfd = Memfd::create("upload", bytes.size());
  EXPECT_TRUE(memfd.ok());
  {
    auto mapping = memfd->map(Memfd::Access::kWrite);
    EXPECT_TRUE(mapping.ok());
    std::memcpy(mapping->data(), bytes.data(), bytes.size());
  }
  EXPECT_TRUE(memfd->seal(Seals::kFrozen).ok());
  return std::move(*memfd);
}

/** Waits on fd() as the control thread's loop does. Gives up after a minute. */
bool nextBlocking(BuilderLeash& leash, BuildReport& report) {
  for (int i = 0; i < 600; ++i) {
    if (leash.next(report)) return true;
    pollfd poll{leash.fd(), POLLIN, 0};
    ::poll(&poll, 1, 100);
  }
  ADD_FAILURE() << "no report";
  return false;
}

/** The last report of a job; progress on the way is checked. */
BuildReport outcome(BuilderLeash& leash, std::uint64_t job) {
  BuildReport report;
  float last = 0;
  while (nextBlocking(leash, report)) {
    EXPECT_EQ(report.job, job);
    if (report.kind != BuildReport::Kind::kProgress) return report;
    EXPECT_GE(report.fraction, last);
    EXPECT_LE(report.fraction, 1.0f);
    EXPECT_FALSE(report.stage.empty());
    last = report.fraction;
  }
  return {};
}

std::uint64_t submit(BuilderLeash& leash, const Memfd& upload) {
  auto job = leash.submit(upload.fd());
  EXPECT_TRUE(job.ok());
  return *job;
}

class Leash : public testing::Test {
 protected:
  void SetUp() override {
    auto started = BuilderLeash::start(options());
    ASSERT_TRUE(started.ok()) << toString(started.error());
    leash_ = std::move(*started);
  }
  std::unique_ptr<BuilderLeash> leash_;
};

TEST_F(Leash, BuildsAMeshAndReportsRepairs) {
  const Memfd good = frozen(upload(torus(300, 200).soup(), HD_MESH_DEFORMABLE));
  const BuildReport done = outcome(*leash_, submit(*leash_, good));
  ASSERT_EQ(done.kind, BuildReport::Kind::kDone) << toString(done.error);
  EXPECT_EQ(done.stats.triangles, 120'000u);
  ASSERT_EQ(done.notes.size(), 1u);
  EXPECT_EQ(done.notes[0], "welded 360000 vertices into 60000 of equal place");
  EXPECT_GT(done.stats.peak_bytes, done.stats.bytes);
  auto opened = openSnapshot(std::move(const_cast<BuildReport&>(done).snapshot), true);
  ASSERT_TRUE(opened.ok()) << toString(opened.error());
  EXPECT_EQ(opened->view.triangle_count, 120'000u);
  EXPECT_EQ(opened->view.deform.source_count, 360'000u);
}

TEST_F(Leash, BuildsTheVolumeOfAMeshBesideIt) {
  BuildReport done = outcome(*leash_, submit(*leash_, frozen(volumeUpload(torus(60, 40), 0.002f))));
  ASSERT_EQ(done.kind, BuildReport::Kind::kDone) << toString(done.error);
  EXPECT_EQ(done.stats.triangles, 4'800u);
  ASSERT_TRUE(done.volume.valid());
  auto opened = openVolume(std::move(done.volume), true);
  ASSERT_TRUE(opened.ok()) << toString(opened.error());
  EXPECT_EQ(opened->view.voxel, 0.002f);
  // 2 pi^2 R r^2, less what chords cut off.
  const double volume = 2 * std::numbers::pi * std::numbers::pi * 0.05 * 0.02 * 0.02;
  EXPECT_NEAR(opened->view.mass.volume, volume, 0.01 * volume);
  EXPECT_FALSE(done.notes.empty());
  BuildReport plain = outcome(*leash_, submit(*leash_, frozen(upload(cube()))));
  EXPECT_FALSE(plain.volume.valid()) << "of the job before";
}

TEST_F(Leash, VolumesThatCannotBeAreRefusedInWords) {
  const auto refused = [&](const UploadMesh& mesh, float voxel_m, std::uint32_t flags, ErrorCode code,
                           const char* words) {
    const BuildReport failed = outcome(*leash_, submit(*leash_, frozen(volumeUpload(mesh, voxel_m, flags))));
    EXPECT_EQ(failed.kind, BuildReport::Kind::kFailed);
    EXPECT_EQ(failed.error.code, code) << toString(failed.error);
    EXPECT_NE(toString(failed.error).find(words), std::string::npos) << toString(failed.error);
  };
  refused(terrain(8, 1), 0.002f, 0, ErrorCode::kBadMesh, "the surface is open there");
  refused(cube(), 0, 0, ErrorCode::kInvalidArgument, "a voxel of 0 m");
  refused(cube(), NAN, 0, ErrorCode::kInvalidArgument, "a voxel of nan m");
  refused(cube(), 0.002f, HD_MESH_DEFORMABLE, ErrorCode::kUnsupported, "deformable");
  refused(cube(), 2e-6f, 0, ErrorCode::kInvalidArgument, "MB to build, more than the");
  EXPECT_EQ(leash_->restarts(), 0u) << "a refusal is no crash";
}

TEST_F(Leash, AVolumeUnderWayCanBeCancelled) {
  const std::uint64_t job = submit(*leash_, frozen(volumeUpload(torus(200, 100), 0.0003f)));
  BuildReport report;
  while (nextBlocking(*leash_, report) && report.kind == BuildReport::Kind::kProgress && report.fraction < 0.15f) {
  }
  leash_->cancel(job);
  const BuildReport failed = outcome(*leash_, job);
  EXPECT_EQ(failed.kind, BuildReport::Kind::kFailed);
  EXPECT_EQ(failed.error.code, ErrorCode::kCancelled);
  EXPECT_EQ(leash_->restarts(), 0u) << "it listened";
}

TEST_F(Leash, RefusalsCrossTheProcessBoundaryWithTheirText) {
  UploadMesh mesh = cube();
  mesh.triangles[4][1] = 77;
  const BuildReport failed = outcome(*leash_, submit(*leash_, frozen(upload(mesh))));
  ASSERT_EQ(failed.kind, BuildReport::Kind::kFailed);
  EXPECT_EQ(failed.error.code, ErrorCode::kBadMesh);
  EXPECT_EQ(failed.error.where, "triangle 4");
  EXPECT_EQ(leash_->restarts(), 0u) << "a bad mesh is no crash";
}

TEST_F(Leash, JobsKeepTheirOrder) {
  const Memfd a = frozen(upload(torus(100, 100))), b = frozen(upload(cube()));
  const std::uint64_t first = submit(*leash_, a), second = submit(*leash_, b);
  EXPECT_EQ(outcome(*leash_, first).stats.triangles, 20'000u);
  EXPECT_EQ(outcome(*leash_, second).stats.triangles, 12u);
  BuildReport report;
  EXPECT_FALSE(leash_->next(report));
}

/** Jobs of two floods, and one who comes last; one that is given up leaves the others' turns. */
TEST_F(Leash, EachClientHasItsTurn) {
  const Memfd mesh = frozen(upload(cube()));
  const auto submitFor = [&](std::uint64_t client) { return *leash_->submit(mesh.fd(), client); };
  const auto under_way = submitFor(1), a1 = submitFor(1), a2 = submitFor(1);
  const auto given_up = submitFor(2), b1 = submitFor(2), b2 = submitFor(2), mine = submitFor(3);
  leash_->cancel(given_up);
  EXPECT_EQ(outcome(*leash_, given_up).error.code, ErrorCode::kCancelled);
  for (const std::uint64_t job : {under_way, a1, b1, mine, a2, b2})
    EXPECT_EQ(outcome(*leash_, job).kind, BuildReport::Kind::kDone);
}

TEST_F(Leash, AnUploadThatCanStillChangeIsRefused) {
  auto memfd = Memfd::create("upload", upload(cube()).size());
  ASSERT_TRUE(memfd->seal(Seals::kFixedSize).ok());
  const BuildReport failed = outcome(*leash_, submit(*leash_, *memfd));
  EXPECT_EQ(failed.error.code, ErrorCode::kPermissionDenied);
}

/** Waits until the builder is at work on that job. */
void awaitProgress(BuilderLeash& leash, std::uint64_t job) {
  BuildReport report;
  ASSERT_TRUE(nextBlocking(leash, report));
  ASSERT_EQ(report.job, job);
  ASSERT_EQ(report.kind, BuildReport::Kind::kProgress);
}

TEST_F(Leash, AKilledBuilderFailsItsJobAndTheNextOneRuns) {
  const Memfd large = frozen(upload(torus(1000, 500))), small = frozen(upload(cube()));
  const int pid = leash_->pid();
  const std::uint64_t victim = submit(*leash_, large), next = submit(*leash_, small);
  awaitProgress(*leash_, victim);
  ASSERT_EQ(::kill(pid, SIGKILL), 0);
  const BuildReport failed = outcome(*leash_, victim);
  EXPECT_EQ(failed.kind, BuildReport::Kind::kFailed);
  EXPECT_EQ(failed.error.code, ErrorCode::kBuilderFailed);
  EXPECT_EQ(failed.error.what, "the builder died of signal 9 (SIGKILL)");
  EXPECT_EQ(outcome(*leash_, next).kind, BuildReport::Kind::kDone);
  EXPECT_EQ(leash_->restarts(), 1u);
  EXPECT_NE(leash_->pid(), pid);
}

TEST_F(Leash, ABuilderThatDiesBeforeItBeginsCostsNoJob) {
  const int pid = leash_->pid();
  ASSERT_EQ(::kill(pid, SIGSTOP), 0);
  const std::uint64_t job = submit(*leash_, frozen(upload(cube())));
  ASSERT_EQ(::kill(pid, SIGKILL), 0);
  EXPECT_EQ(outcome(*leash_, job).kind, BuildReport::Kind::kDone);
  EXPECT_EQ(leash_->restarts(), 1u);
}

TEST_F(Leash, AProgramThatIsNoBuilderIsFoundOutBeforeThereIsAMesh) {
  EXPECT_EQ(outcome(*leash_, submit(*leash_, frozen(upload(cube())))).kind, BuildReport::Kind::kDone);
  EXPECT_EQ(leash_->trouble(), "");
  const auto ended = [](BuilderLeash& leash) {
    BuildReport report;
    for (int i = 0; i < 1000 && leash.pid() != 0; ++i) {
      EXPECT_FALSE(leash.next(report));
      pollfd poll{leash.fd(), POLLIN, 0};
      ::poll(&poll, 1, 10);
    }
    return leash.pid() == 0;
  };
  ASSERT_EQ(::kill(leash_->pid(), SIGKILL), 0);
  ASSERT_TRUE(ended(*leash_));
  EXPECT_EQ(leash_->trouble(), "") << "it has built, and can be started again";

  BuilderOptions other = options();
  other.program = "/bin/true";
  const auto idle = BuilderLeash::start(other);
  ASSERT_TRUE(idle.ok()) << toString(idle.error());
  ASSERT_TRUE(ended(**idle));
  EXPECT_EQ((*idle)->trouble(), "the builder ended with status 0");
}

TEST_F(Leash, AResultForWhichThereIsNoDescriptorCostsItsJobAndNotTheBuilder) {
  const Memfd mesh = frozen(upload(cube()));
  const int pid = leash_->pid();
  rlimit all{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &all), 0);
  const std::uint64_t lost = submit(*leash_, mesh);
  const rlimit few{3, all.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &few), 0);
  const BuildReport failed = outcome(*leash_, lost);
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &all), 0);
  EXPECT_EQ(failed.kind, BuildReport::Kind::kFailed);
  EXPECT_EQ(toString(failed.error),
            "build: recvmsg: Too many open files (end clients, or raise LimitNOFILE= or ulimit -n)");
  EXPECT_EQ(outcome(*leash_, submit(*leash_, mesh)).kind, BuildReport::Kind::kDone);
  EXPECT_EQ(leash_->pid(), pid);
}

TEST_F(Leash, CrashesInARowSlowTheRestarts) {
  const Memfd mesh = frozen(upload(torus(1000, 500)));
  for (int i = 0; i < 3; ++i) {
    const std::uint64_t job = submit(*leash_, mesh);
    awaitProgress(*leash_, job);
    ASSERT_EQ(::kill(leash_->pid(), SIGKILL), 0);
    ASSERT_EQ(outcome(*leash_, job).error.code, ErrorCode::kBuilderFailed);
  }
  const Memfd little = frozen(upload(cube()));  // Builders give way to whoever else computes on a busy machine.
  const std::uint64_t job = submit(*leash_, little);
  EXPECT_EQ(leash_->pid(), 0) << "not yet: 200 ms after the third crash";
  EXPECT_EQ(outcome(*leash_, job).kind, BuildReport::Kind::kDone);
}

TEST_F(Leash, CancelledJobsSaySo) {
  const Memfd mesh = frozen(upload(torus(300, 300)));
  ASSERT_EQ(::kill(leash_->pid(), SIGSTOP), 0);
  const std::uint64_t running = submit(*leash_, mesh), waiting = submit(*leash_, mesh);
  leash_->cancel(waiting);
  EXPECT_EQ(outcome(*leash_, waiting).error.code, ErrorCode::kCancelled);
  leash_->cancel(running);
  leash_->cancel(running);
  leash_->cancel(999);
  ASSERT_EQ(::kill(leash_->pid(), SIGCONT), 0);
  EXPECT_EQ(outcome(*leash_, running).error.code, ErrorCode::kCancelled);
  EXPECT_EQ(outcome(*leash_, submit(*leash_, mesh)).kind, BuildReport::Kind::kDone) << "the same builder goes on";
  EXPECT_EQ(leash_->restarts(), 0u);
}

TEST(LeashLimits, AJobThatTakesTooLongIsEnded) {
  BuilderOptions o = options();
  o.job_timeout_ns = 50'000'000;
  auto leash = BuilderLeash::start(o);
  ASSERT_TRUE(leash.ok());
  const Memfd mesh = frozen(upload(cube()));
  ASSERT_EQ(::kill((*leash)->pid(), SIGSTOP), 0);
  const BuildReport failed = outcome(**leash, submit(**leash, mesh));
  EXPECT_EQ(failed.error.code, ErrorCode::kBuilderFailed);
  EXPECT_EQ(failed.error.what, "the build took longer than 0.05 s");
}

/** A builder that means harm, as one that a mesh has taken over might: lying_builder.cc. */
struct Liar {
  explicit Liar(int lie) {
    BuilderOptions o = options();
    o.program = HAPTICD_TEST_LYING_BUILDER;
    o.memory_bytes = static_cast<std::uint64_t>(lie);
    auto started = BuilderLeash::start(o);
    EXPECT_TRUE(started.ok());
    leash = std::move(*started);
  }
  std::unique_ptr<BuilderLeash> leash;
};

TEST(LeashLiar, OneThatTalksOnAndOnHoldsNobodyUp) {
  Liar liar(1);
  const Memfd mesh = frozen(upload(cube()));
  const std::uint64_t first = submit(*liar.leash, mesh), second = submit(*liar.leash, mesh);
  BuildReport report;
  int progress = 0;
  // As the control thread does: until there is nothing more, and it must always end.
  while (nextBlocking(*liar.leash, report) && report.kind == BuildReport::Kind::kProgress) {
    ASSERT_LT(++progress, 100'000) << "nobody else is served meanwhile";
  }
  EXPECT_EQ(report.job, first);
  EXPECT_EQ(report.error.what, "the builder broke its protocol");
  EXPECT_EQ(outcome(*liar.leash, second).error.what, "an honest answer") << "of the builder after it";
}

TEST(LeashLiar, WhatItSaysAfterBreakingTheProtocolCountsNoMore) {
  for (int i = 0; i < 20; ++i) {
    Liar liar(2);
    const Memfd mesh = frozen(upload(cube()));
    const std::uint64_t first = submit(*liar.leash, mesh), second = submit(*liar.leash, mesh);
    EXPECT_EQ(outcome(*liar.leash, first).error.what, "the builder broke its protocol");
    ASSERT_EQ(outcome(*liar.leash, second).error.what, "an honest answer") << "no builder that dies is given a job";
  }
}

/** Whoever has large memory to close knows where there is time for it. */
TEST(LeashLiar, WhatComesOfACancelledJobIsHandedOn) {
  Liar liar(3);
  std::vector<UniqueFd> spent;
  liar.leash->onSpent([&](UniqueFd file) { spent.push_back(std::move(file)); });
  const std::uint64_t job = submit(*liar.leash, frozen(upload(cube())));
  liar.leash->cancel(job);
  EXPECT_EQ(outcome(*liar.leash, job).error.code, ErrorCode::kCancelled);
  BuildReport report;
  for (int i = 0; i < 100 && spent.size() < 4; ++i) {
    pollfd poll{liar.leash->fd(), POLLIN, 0};
    ::poll(&poll, 1, 100);
    EXPECT_FALSE(liar.leash->next(report));
  }
  EXPECT_EQ(spent.size(), 4u) << "the upload, the volume, the snapshot, and one of a job that is over";
  for (const UniqueFd& file : spent) EXPECT_TRUE(file.valid());
}

TEST(LeashLimits, MemoryBeyondTheLimitIsAnErrorOfTheJob) {
  if (!sandboxIsComplete()) GTEST_SKIP() << "sanitizers need the address space";
  BuilderOptions o = options();
  o.memory_bytes = 64'000'000;
  auto leash = BuilderLeash::start(o);
  ASSERT_TRUE(leash.ok());
  EXPECT_EQ(outcome(**leash, submit(**leash, frozen(upload(torus(50, 50))))).kind, BuildReport::Kind::kDone);
  const BuildReport failed = outcome(**leash, submit(**leash, frozen(upload(torus(1000, 400)))));
  EXPECT_EQ(failed.error.code, ErrorCode::kBuilderFailed);
  EXPECT_NE(failed.error.what.find("64000000 bytes"), std::string::npos) << failed.error.what;
  EXPECT_EQ(outcome(**leash, submit(**leash, frozen(upload(cube())))).kind, BuildReport::Kind::kDone)
      << "it outlives the shortage";
}

TEST(LeashLimits, ItHoldsOneSocketAndNoPrivilege) {
  auto leash = BuilderLeash::start(options());
  ASSERT_TRUE(leash.ok());
  // A finished job proves that the sandbox stands.
  ASSERT_EQ(outcome(**leash, submit(**leash, frozen(upload(cube())))).kind, BuildReport::Kind::kDone);
  const std::string process = "/proc/" + std::to_string((*leash)->pid());
  const auto highest = [&] {
    int fd = 0;
    for (const auto& entry : std::filesystem::directory_iterator(process + "/fd"))
      fd = std::max(fd, std::stoi(entry.path().filename()));
    return fd;
  };
  for (int i = 0; i < 200 && highest() > 3; ++i) ::usleep(10'000);  // it may still be closing what it sent
  EXPECT_EQ(highest(), 3);
  std::ifstream status(process + "/status");
  std::string text((std::istreambuf_iterator<char>(status)), {});
  EXPECT_NE(text.find("NoNewPrivs:\t1"), std::string::npos);
  EXPECT_EQ(text.find("Seccomp:\t2") != std::string::npos, sandboxIsComplete());
  int score = 0;
  std::ifstream(process + "/oom_score_adj") >> score;
  EXPECT_GE(score, 500) << "where memory is short it goes, and not whoever is there beside it";
  std::ifstream environment(process + "/environ");
  EXPECT_EQ(environment.get(), std::ifstream::traits_type::eof());
}

TEST(LeashLimits, TheBuilderEndsWithItsLeash) {
  auto leash = BuilderLeash::start(options());
  ASSERT_TRUE(leash.ok());
  const int pid = (*leash)->pid();
  ASSERT_EQ(::kill(pid, 0), 0);
  leash->reset();
  EXPECT_EQ(::kill(pid, 0), -1);
  EXPECT_EQ(errno, ESRCH);
}

TEST(LeashLimits, AMissingProgramIsAnError) {
  BuilderOptions o = options();
  o.program = "/nonexistent/hapticd-builder";
  const auto leash = BuilderLeash::start(o);
  ASSERT_FALSE(leash.ok());
  EXPECT_EQ(leash.error().code, ErrorCode::kBuilderFailed);
  EXPECT_EQ(findBuilder(o.program).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(*findBuilder(HAPTICD_TEST_BUILDER), HAPTICD_TEST_BUILDER);
}

/** Runs `body` in a child behind the sandbox; its wait status. */
template <class Body>
int statusInSandbox(Body&& body) {
  const pid_t child = ::fork();
  if (child == 0) {
    if (!enterSandbox(std::uint64_t{1} << 40)) ::_exit(3);
    ::_exit(body());
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return status;
}

TEST(Sandbox, OpensNoFileStartsNoProcess) {
  if (!sandboxIsComplete()) GTEST_SKIP() << "no filter under sanitizers";
  const auto makesMemory = [] { return Memfd::create("test", 4096)->map(Memfd::Access::kWrite).ok() ? 0 : 1; };
  const int allowed = statusInSandbox(makesMemory);
  ASSERT_TRUE(WIFEXITED(allowed) && WEXITSTATUS(allowed) == 0) << "what the builder needs passes";
  const auto killed = [](int status) { return WIFSIGNALED(status) && WTERMSIG(status) == SIGSYS; };
  EXPECT_TRUE(killed(statusInSandbox([] { return ::open("/dev/null", O_RDONLY); })));
  EXPECT_TRUE(killed(statusInSandbox([] { return ::socket(AF_INET, SOCK_STREAM, 0); })));
  EXPECT_TRUE(killed(statusInSandbox([] { return static_cast<int>(::fork()); })));
  EXPECT_TRUE(killed(statusInSandbox([] { return ::execl("/bin/true", "true", nullptr); })));
  EXPECT_TRUE(killed(statusInSandbox([] { return ::getppid(); })));
}

/** Whoever takes it over is still of the daemon's user. */
TEST(Sandbox, ReachesNoOtherProcess) {
  if (!sandboxIsComplete()) GTEST_SKIP() << "no filter under sanitizers";
  const auto endedBy = [](int status) { return WIFSIGNALED(status) ? WTERMSIG(status) : 0; };
  const pid_t parent = ::getpid();
  EXPECT_EQ(endedBy(statusInSandbox([&] { return ::kill(parent, 0); })), SIGSYS);
  const auto signals = [](pid_t process) { return static_cast<int>(::syscall(SYS_tgkill, process, process, 0)); };
  EXPECT_EQ(endedBy(statusInSandbox([&] { return signals(parent); })), SIGSYS);
  EXPECT_EQ(statusInSandbox([&] { return signals(::getpid()); }), 0);
  rlimit limit{};
  const auto reads = [&](pid_t process) { return ::prlimit(process, RLIMIT_NOFILE, nullptr, &limit); };
  EXPECT_EQ(endedBy(statusInSandbox([&] { return reads(parent); })), SIGSYS);
  EXPECT_EQ(statusInSandbox([&] { return reads(0); }), 0);
  const auto sets = [&](pid_t process) { return ::prlimit(process, RLIMIT_CORE, &limit, nullptr); };
  for (const pid_t process : {0, parent}) {
    EXPECT_EQ(endedBy(statusInSandbox([&] { return sets(process); })), SIGSYS) << process;
  }
  EXPECT_EQ(endedBy(statusInSandbox([]() -> int { std::abort(); })), SIGABRT) << "its own end is told as what it is";
}

}  // namespace
}  // namespace hapticd::test
