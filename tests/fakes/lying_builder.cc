// A builder that answers its first job with a lie, and all others with a refusal. Its argument, the memory it may have,
// says which lie.
#include <unistd.h>

#include <cstdlib>

#include "daemon/ipc/builder_protocol.h"
#include "daemon/ipc/memfd.h"
#include "rt/base/error.h"

using namespace hapticd;

namespace {

BuilderFrame frame(BuilderFrameKind kind, std::uint64_t job) {
  BuilderFrame out;
  out.head.kind = kind;
  out.head.job = job;
  return out;
}

void refuse(std::uint64_t job) {
  BuilderFrame refusal = frame(BuilderFrameKind::kFailed, job);
  refusal.head.error = static_cast<std::uint32_t>(ErrorCode::kBadMesh);
  refusal.text[1] = "an honest answer";
  (void)sendFrame(kBuilderSocket, refusal, -1, false);
}

/** Until it is killed. */
void talk(std::uint64_t job) {
  BuilderFrame progress = frame(BuilderFrameKind::kProgress, job);
  progress.text[0] = "talking";
  for (int i = 0; i < 3; ++i) (void)::fork();  // Together they talk faster than anybody reads.
  while (sendFrame(kBuilderSocket, progress, -1, false) == FrameIo::kOk) {
  }
}

/** When it is too late: all that a job brings, and then once more of a job that is over. */
void bring(std::uint64_t job) {
  BuilderFrame order;
  while (receiveFrame(kBuilderSocket, order, false) == FrameIo::kOk && order.head.kind != BuilderFrameKind::kCancel) {
  }
  const auto part = Memfd::create("part", 4096);
  for (const BuilderFrameKind kind : {BuilderFrameKind::kVolume, BuilderFrameKind::kDone, BuilderFrameKind::kDone})
    (void)sendFrame(kBuilderSocket, frame(kind, job), part->fd(), false);
}

void lie(int which, std::uint64_t job) {
  if (which == 1) return talk(job);
  if (which == 3) return bring(job);
  (void)sendFrame(kBuilderSocket, frame(static_cast<BuilderFrameKind>(99), job), -1, false);
  refuse(job);
}

}  // namespace

int main(int argc, char** argv) {
  const int which = argc > 1 ? std::atoi(argv[1]) : 0;
  BuilderFrame order;
  while (receiveFrame(kBuilderSocket, order, false) == FrameIo::kOk) {
    if (order.head.kind != BuilderFrameKind::kBuild) continue;
    if (order.head.job == 1) {
      lie(which, order.head.job);
    } else {
      refuse(order.head.job);
    }
  }
  return 0;
}
