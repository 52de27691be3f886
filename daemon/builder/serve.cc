#include "daemon/builder/serve.h"

#include "daemon/builder/build.h"
#include "daemon/ipc/builder_protocol.h"

namespace hapticd {
namespace {

class Server {
 public:
  explicit Server(int socket) : socket_(socket) {}

  int run() {
    while (exit_ < 0) {
      BuilderFrame frame;
      switch (receiveFrame(socket_, frame, false)) {
        case FrameIo::kOk:
          handle(frame);
          break;
        case FrameIo::kClosed:
          return 0;
        default:
          return 1;
      }
    }
    return exit_;
  }

 private:
  void handle(BuilderFrame& frame) {
    if (frame.head.kind == BuilderFrameKind::kCancel) return;  // of a job that is done already
    if (frame.head.kind != BuilderFrameKind::kBuild || !frame.fd.valid()) {
      exit_ = 1;
      return;
    }
    job_ = frame.head.job;
    stage_ = nullptr;
    fraction_ = -1;
    BuildMonitor monitor;
    monitor.progress = [this](float fraction, const char* stage) { return progress(fraction, stage); };
    // From this message on a death is the job's.
    auto built = progress(0, "starting") ? build(std::move(frame.fd), monitor)
                                         : Result<BuiltSnapshot>(Error{ErrorCode::kCancelled, "build", {}, {}});
    if (exit_ >= 0) return;
    if (built) {
      for (const std::string& note : monitor.notes) send({head(BuilderFrameKind::kNote), {note}, {}}, -1);
      if (built->volume.valid()) send({head(BuilderFrameKind::kVolume), {}, {}}, built->volume.fd());
      BuilderFrame done{head(BuilderFrameKind::kDone), {}, {}};
      done.head.stats = built->stats;
      send(done, built->memfd.fd());
    } else {
      const Error& error = built.error();
      BuilderFrame failed{head(BuilderFrameKind::kFailed), {error.where, error.what, error.remedy}, {}};
      failed.head.error = static_cast<std::uint32_t>(error.code);
      send(failed, -1);
    }
  }

  static Result<BuiltSnapshot> build(UniqueFd upload_fd, BuildMonitor& monitor) {
    auto upload = Memfd::adopt(std::move(upload_fd));
    if (!upload) return upload.error();
    // Without the seal a client could change numbers after they were checked.
    if (const auto sealed = upload->requireSeals(Seals::kFrozen); !sealed) return sealed.error();
    auto mapping = upload->map(Memfd::Access::kRead);
    if (!mapping) return mapping.error();
    return buildSnapshot(mapping->bytes(), monitor);
  }

  [[nodiscard]] BuilderFrameHead head(BuilderFrameKind kind) const {
    BuilderFrameHead h;
    h.kind = kind;
    h.job = job_;
    return h;
  }

  void send(const BuilderFrame& frame, int fd) {
    if (sendFrame(socket_, frame, fd, false) != FrameIo::kOk) exit_ = 0;
  }

  /** Reports every hundredth and each new stage, and looks whether the job is cancelled. */
  bool progress(float fraction, const char* stage) {
    if (stage != stage_ || fraction >= fraction_ + 0.01f) {
      stage_ = stage;
      fraction_ = fraction;
      BuilderFrame frame{head(BuilderFrameKind::kProgress), {stage}, {}};
      frame.head.fraction = fraction;
      if (sendFrame(socket_, frame, -1, true) == FrameIo::kClosed) exit_ = 0;  // no room: the next one will do
    }
    BuilderFrame order;
    for (;;) {
      switch (receiveFrame(socket_, order, true)) {
        case FrameIo::kOk:
          if (order.head.kind != BuilderFrameKind::kCancel) exit_ = 1;
          if (order.head.job == job_) return false;
          break;
        case FrameIo::kLater:
          return exit_ < 0;
        case FrameIo::kClosed:
          exit_ = 0;
          return false;
        case FrameIo::kBad:
        case FrameIo::kNoDescriptor:
          exit_ = 1;
          return false;
      }
    }
  }

  int socket_;
  int exit_ = -1;
  std::uint64_t job_ = 0;
  const char* stage_ = nullptr;
  float fraction_ = -1;
};

}  // namespace

int serveBuilds(int socket) { return Server(socket).run(); }

}  // namespace hapticd
