#include "tools/haptic-emu/uhid.h"

#include <fcntl.h>
#include <linux/input.h>
#include <linux/uhid.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>

#include "rt/base/clock.h"

namespace haptic_emu {
namespace {

bool readable(int fd) {
  pollfd one{fd, POLLIN, 0};
  return ::poll(&one, 1, 0) == 1 && (one.revents & POLLIN) != 0;
}

/** The kernel fills up what is missing at the end with zeros. */
bool send(int fd, const uhid_event& event) { return ::write(fd, &event, sizeof event) >= 0; }

void copyText(const std::string& text, std::uint8_t* to, std::size_t room) {
  std::memcpy(to, text.data(), std::min(text.size(), room - 1));  // NOLINT(bugprone-not-null-terminated-result)
}

/** hidraw hands on what programs write, a leading 0 included where reports have no ID. */
std::span<const std::uint8_t> withoutZeroId(const std::uint8_t* data, std::size_t size) {
  size = std::min<std::size_t>(size, UHID_DATA_MAX);
  return size > 0 && data[0] == 0 ? std::span(data + 1, size - 1) : std::span(data, size);
}

}  // namespace

bool UhidLink::plugIn() {
  const auto event = std::make_unique<uhid_event>();
  std::memset(event.get(), 0, sizeof *event);
  event->type = UHID_CREATE2;
  uhid_create2_req& create = event->u.create2;
  copyText(identity_.name, create.name, sizeof create.name);
  copyText("haptic-emu", create.phys, sizeof create.phys);
  copyText(identity_.serial, create.uniq, sizeof create.uniq);
  const HidModel::Bytes& descriptor = model_.descriptor();
  create.rd_size = static_cast<std::uint16_t>(std::min<std::size_t>(descriptor.size(), sizeof create.rd_data));
  std::memcpy(create.rd_data, descriptor.data(), create.rd_size);
  create.bus = BUS_USB;
  create.vendor = identity_.vendor;
  create.product = identity_.product;
  plugged_ = send(fd_, *event);
  return plugged_;
}

void UhidLink::unplug() {
  if (!plugged_) return;
  const auto event = std::make_unique<uhid_event>();
  std::memset(event.get(), 0, sizeof *event);
  event->type = UHID_DESTROY;
  (void)send(fd_, *event);
  plugged_ = opened_ = false;
}

bool UhidLink::pump(std::int64_t now_ns) {
  constexpr int kMostEvents = 64;
  model_.advance(now_ns);
  if (plugged_ && !model_.plugged()) unplug();
  if (!plugged_) {
    if (!model_.plugged()) return true;
    if (!plugIn()) return false;
  }
  const auto event = std::make_unique<uhid_event>();
  for (int i = 0; i < kMostEvents && readable(fd_); ++i) {
    std::memset(event.get(), 0, sizeof *event);
    if (::read(fd_, event.get(), sizeof *event) <= 0 || !take(*event)) return false;
  }
  for (int i = 0; i < kMostEvents; ++i) {
    const auto report = model_.in();
    if (!report) break;
    if (!opened_) continue;  // Nobody listens.
    std::memset(event.get(), 0, sizeof *event);
    event->type = UHID_INPUT2;
    event->u.input2.size = static_cast<std::uint16_t>(std::min<std::size_t>(report->size(), UHID_DATA_MAX));
    std::memcpy(event->u.input2.data, report->data(), event->u.input2.size);
    if (!send(fd_, *event)) return false;
  }
  return true;
}

bool UhidLink::take(const uhid_event& event) {
  const auto set = [this](std::uint8_t kind, const std::uint8_t* data, std::size_t size) {
    const auto report = withoutZeroId(data, size);
    return kind == UHID_FEATURE_REPORT ? model_.setFeature(report) : model_.out(report);
  };
  const auto answer = std::make_unique<uhid_event>();
  std::memset(answer.get(), 0, sizeof *answer);
  switch (event.type) {
    case UHID_OPEN:
    case UHID_CLOSE:
      opened_ = event.type == UHID_OPEN;
      return true;
    case UHID_OUTPUT:
      (void)set(event.u.output.rtype, event.u.output.data, event.u.output.size);
      return true;
    case UHID_SET_REPORT: {
      const uhid_set_report_req& asked = event.u.set_report;
      answer->type = UHID_SET_REPORT_REPLY;
      answer->u.set_report_reply.id = asked.id;
      answer->u.set_report_reply.err = set(asked.rtype, asked.data, asked.size) ? 0 : EPIPE;
      return send(fd_, *answer);
    }
    case UHID_GET_REPORT: {
      const uhid_get_report_req& asked = event.u.get_report;
      const auto report = asked.rtype == UHID_FEATURE_REPORT ? model_.getFeature(asked.rnum) : std::nullopt;
      uhid_get_report_reply_req& reply = answer->u.get_report_reply;
      answer->type = UHID_GET_REPORT_REPLY;
      reply.id = asked.id;
      reply.err = report ? 0 : EPIPE;
      if (report) {
        reply.size = static_cast<std::uint16_t>(std::min<std::size_t>(report->size(), sizeof reply.data));
        std::memcpy(reply.data, report->data(), reply.size);
      }
      return send(fd_, *answer);
    }
    default:
      return true;
  }
}

hapticd::Result<void> playToUhid(HidModel& model, const HidIdentity& identity, const std::atomic<bool>& stop,
                                 const std::function<void(std::int64_t now_ns)>& each) {
  using hapticd::Error;
  using hapticd::ErrorCode;
  constexpr const char* kNode = "/dev/uhid";
  constexpr std::int64_t kTurn_ns = 250'000;
  const int fd = ::open(kNode, O_RDWR | O_CLOEXEC);
  if (fd < 0) {
    const int refused = errno;
    return Error{refused == EACCES || refused == EPERM ? ErrorCode::kPermissionDenied : ErrorCode::kSystem, kNode,
                 std::strerror(refused), "as root: modprobe uhid"};
  }
  hapticd::MonotonicClock clock;
  UhidLink link(fd, model, identity);
  hapticd::Result<void> result;
  for (std::int64_t next_ns = clock.now(); !stop.load(); next_ns += kTurn_ns) {
    clock.sleepUntil(next_ns);
    each(clock.now());
    if (link.pump(clock.now())) continue;
    result = Error{ErrorCode::kSystem, kNode, std::strerror(errno), ""};
    break;
  }
  link.unplug();
  ::close(fd);
  return result;
}

}  // namespace haptic_emu
