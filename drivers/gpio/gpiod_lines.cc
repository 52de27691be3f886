// Lines over libgpiod 1.6. Its calls stand here alone: 2.x names all of them anew.
#include <gpiod.h>
#include <poll.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "drivers/gpio/lines.h"
#include "drivers/run_out.h"

namespace hapticd {
namespace {

constexpr const char* kConsumer = "hapticd";
constexpr std::size_t kMostLines = 16;

struct CloseChip {
  void operator()(gpiod_chip* chip) const { gpiod_chip_close(chip); }
};

class GpiodLines final : public Lines {
 public:
  Result<void> add(const LineRequest& request);
  [[nodiscard]] int wait(std::int64_t timeout_ns, LineEdge* edges, int most) noexcept override;
  [[nodiscard]] int get(std::size_t line) noexcept override {
    return std::max(gpiod_line_get_value(lines_[line]), kLost);
  }
  [[nodiscard]] bool set(std::size_t line, bool active) noexcept override {
    return gpiod_line_set_value(lines_[line], active ? 1 : 0) == 0;
  }

 private:
  std::vector<std::unique_ptr<gpiod_chip, CloseChip>> chips_;  ///< One for each line; closing gives the line back.
  std::vector<gpiod_line*> lines_;
  std::array<pollfd, kMostLines> polled_{};
  std::array<std::size_t, kMostLines> line_of_{};
  std::size_t inputs_ = 0;
};

Error refused(const LineRequest& request, int number) {
  const std::string where = "line \"" + request.name + "\"" + (request.chip.empty() ? "" : " of " + request.chip);
  if (number == EBUSY) {
    return {ErrorCode::kDeviceBusy, where, "another program holds it", "gpioinfo names it"};
  }
  if (number == EACCES || number == EPERM) {
    return {ErrorCode::kPermissionDenied, where, "hapticd may not open its chip",
            "give /dev/gpiochip* to hapticd: hapticd.toml(5)"};
  }
  const char* const for_want = remedyForWant(number);
  return {ErrorCode::kSystem, where, std::strerror(number), for_want != nullptr ? for_want : ""};
}

Error notFound(const LineRequest& request, const char* what) {
  return {ErrorCode::kNotFound, "line \"" + request.name + "\"", what, "gpioinfo lists chips and lines"};
}

/** A line and its chip, which closes with it. */
struct Found {
  std::unique_ptr<gpiod_chip, CloseChip> chip;
  gpiod_line* line = nullptr;
};

Result<Found> find(const LineRequest& request) {
  Found found;
  errno = 0;
  if (request.chip.empty()) {
    found.line = gpiod_line_find(request.name.c_str());
    if (found.line == nullptr) {
      const bool looked = errno != EACCES && remedyForWant(errno) == nullptr;  // At all chips.
      return looked ? notFound(request, "no chip has a line of that name") : refused(request, errno);
    }
    found.chip.reset(gpiod_line_get_chip(found.line));
    return found;
  }
  found.chip.reset(gpiod_chip_open_lookup(request.chip.c_str()));
  if (found.chip == nullptr) {
    const bool absent = errno == ENOENT || errno == ENODEV || errno == 0;
    return absent ? notFound(request, "there is no such chip") : refused(request, errno);
  }
  found.line = gpiod_chip_find_line(found.chip.get(), request.name.c_str());
  if (found.line == nullptr) return notFound(request, "the chip has no line of that name");
  return found;
}

Result<void> GpiodLines::add(const LineRequest& request) {
  auto found = find(request);
  if (!found) return found.error();
  gpiod_line* const line = found->line;
  chips_.push_back(std::move(found->chip));
  int flags = request.active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0;
  if (request.bias == LineBias::kPullUp) flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP;
  if (request.bias == LineBias::kPullDown) flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN;
  if (request.bias == LineBias::kNone) flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_DISABLE;
  const int done = request.output ? gpiod_line_request_output_flags(line, kConsumer, flags, 0)
                                  : gpiod_line_request_both_edges_events_flags(line, kConsumer, flags);
  if (done != 0) return refused(request, errno);
  if (!request.output) {
    polled_[inputs_] = {gpiod_line_event_get_fd(line), POLLIN | POLLPRI, 0};
    line_of_[inputs_++] = lines_.size();
  }
  lines_.push_back(line);
  return {};
}

int GpiodLines::wait(std::int64_t timeout_ns, LineEdge* edges, int most) noexcept {
  constexpr std::int64_t kSecond = 1'000'000'000;
  const timespec timeout{timeout_ns / kSecond, timeout_ns % kSecond};
  const int ready = ::ppoll(polled_.data(), inputs_, &timeout, nullptr);
  if (ready < 0) return errno == EINTR ? 0 : kLost;
  int found = 0;
  for (std::size_t i = 0; i < inputs_; ++i) {
    if ((polled_[i].revents & (POLLERR | POLLHUP | POLLNVAL)) != 0) return kLost;
    if ((polled_[i].revents & (POLLIN | POLLPRI)) == 0 || found == most) continue;
    gpiod_line_event event;
    if (gpiod_line_event_read_fd(polled_[i].fd, &event) != 0) return kLost;
    edges[found++] = {line_of_[i], event.event_type == GPIOD_LINE_EVENT_RISING_EDGE};
  }
  return found;
}

Result<void> checkCount(std::size_t lines) {
  if (lines <= kMostLines) return {};
  return Error{
      ErrorCode::kInvalidArgument, "[[line]]", "there are more than " + std::to_string(kMostLines) + " lines", {}};
}

}  // namespace

Result<void> findLines(const std::vector<LineRequest>& requests) {
  for (const LineRequest& request : requests) {
    const auto found = find(request);
    if (!found && found.error().code != ErrorCode::kPermissionDenied) return found.error();
  }
  return checkCount(requests.size());
}

Result<std::unique_ptr<Lines>> openLines(const std::vector<LineRequest>& requests) {
  if (auto r = checkCount(requests.size()); !r) return r.error();
  auto lines = std::make_unique<GpiodLines>();
  for (const LineRequest& request : requests) {
    if (auto r = lines->add(request); !r) return r.error();
  }
  return std::unique_ptr<Lines>(std::move(lines));
}

}  // namespace hapticd
