#include "drivers/vendor/helper_protocol.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "drivers/vendor/shared_link.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kMagic = 0x56504148;  // "HAPV"
constexpr std::size_t kMostText = 512;
constexpr int kTexts = 5, kNumbers = 40;

struct Head {
  std::uint32_t magic, protocol, memory_bytes, generation;
};
struct RequestFrame {
  Head head;
  char uri[kMostHelperUri + 1];
};
struct AnswerFrame {
  Head head;
  std::uint32_t code, flags;
  char where[kMostText], what[kMostText], remedy[kMostText];
  char text[kTexts][kMostText];
  double number[kNumbers];
};

Head head(std::uint32_t generation) { return {kMagic, kHelperProtocol, sizeof(SharedLinkMemory), generation}; }
bool fits(const Head& h) {
  return h.magic == kMagic && h.protocol == kHelperProtocol && h.memory_bytes == sizeof(SharedLinkMemory);
}

void put(char (&to)[kMostText], const std::string& text) {
  const std::size_t size = std::min(text.size(), kMostText - 1);
  std::memcpy(to, text.data(), size);
  to[size] = '\0';
}
std::string get(const char (&from)[kMostText]) {
  std::string text(from, strnlen(from, kMostText));
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  return text;
}

/** What a device tells only when it is open, field by field: the same order on both sides. */
template <class Info, class Text, class Number, class Flag>
void eachField(Info& info, Text text, Number number, Flag flag) {
  for (auto* t : {&info.model, &info.manufacturer, &info.serial, &info.firmware, &info.driver_version}) text(*t);
  for (auto* n :
       {&info.max_force, &info.continuous_force, &info.max_torque, &info.max_gripper_force, &info.max_stiffness,
        &info.max_damping, &info.workspace_radius, &info.gripper_max_angle, &info.position_resolution,
        &info.rotation_resolution, &info.force_resolution, &info.native_rate_hz, &info.latency_s}) {
    number(*n);
  }
  for (auto* v : {&info.workspace_lower, &info.workspace_upper, &info.max_workspace_lower, &info.max_workspace_upper}) {
    for (int i = 0; i < 3; ++i) number((*v)[i]);
  }
  for (auto* f : {&info.sensed_position, &info.sensed_rotation, &info.sensed_gripper, &info.actuated_position,
                  &info.actuated_rotation, &info.actuated_gripper, &info.left_hand, &info.right_hand, &info.has_brakes,
                  &info.has_watchdog, &info.has_deadman, &info.has_velocity_limit}) {
    flag(*f);
  }
}

Error failed(const char* call, int number) {
  return {ErrorCode::kSystem, "hapticd-vendor", std::string(call) + ": " + std::strerror(number), {}};
}

Error otherBuild(const char* what) {
  return {ErrorCode::kVersionMismatch, "hapticd-vendor", what, "install both from one package"};
}

Result<void> sendWhole(int socket, const void* bytes, std::size_t size, int descriptor) {
  iovec piece{const_cast<void*>(bytes), size};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  msghdr message{};
  message.msg_iov = &piece;
  message.msg_iovlen = 1;
  if (descriptor >= 0) {
    message.msg_control = control;
    message.msg_controllen = sizeof control;
    cmsghdr* const with = CMSG_FIRSTHDR(&message);
    with->cmsg_level = SOL_SOCKET;
    with->cmsg_type = SCM_RIGHTS;
    with->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(with), &descriptor, sizeof descriptor);
  }
  ssize_t sent = 0;
  do {
    sent = ::sendmsg(socket, &message, MSG_NOSIGNAL);
  } while (sent < 0 && errno == EINTR);
  if (sent == static_cast<ssize_t>(size)) return {};
  return failed("sendmsg", sent < 0 ? errno : EMSGSIZE);
}

}  // namespace

Result<void> sendRequest(int socket, const HelperRequest& request, int memory) {
  RequestFrame frame{};
  frame.head = head(request.generation);
  if (request.uri.size() > kMostHelperUri) {
    return Error{ErrorCode::kInvalidArgument, "device URI", "it is too long", "at most 4096 bytes"};
  }
  std::memcpy(frame.uri, request.uri.data(), request.uri.size());
  return sendWhole(socket, &frame, sizeof frame, memory);
}

Result<HelperRequest> receiveRequest(int socket, int& memory) {
  memory = -1;
  RequestFrame frame{};
  iovec piece{&frame, sizeof frame};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  msghdr message{};
  message.msg_iov = &piece;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  ssize_t got = 0;
  do {
    got = ::recvmsg(socket, &message, MSG_CMSG_CLOEXEC);
  } while (got < 0 && errno == EINTR);
  if (got < 0) return failed("recvmsg", errno);
  const cmsghdr* const with = CMSG_FIRSTHDR(&message);
  if (with != nullptr && with->cmsg_level == SOL_SOCKET && with->cmsg_type == SCM_RIGHTS &&
      with->cmsg_len == CMSG_LEN(sizeof(int))) {
    std::memcpy(&memory, CMSG_DATA(with), sizeof memory);
  }
  if (memory < 0) return otherBuild("the daemon is of another build");
  return decodeRequest({reinterpret_cast<const std::uint8_t*>(&frame), static_cast<std::size_t>(got)});
}

Result<HelperRequest> decodeRequest(std::span<const std::uint8_t> bytes) {
  RequestFrame frame{};
  if (bytes.size() == sizeof frame) std::memcpy(&frame, bytes.data(), sizeof frame);
  if (!fits(frame.head)) return otherBuild("the daemon is of another build");
  return HelperRequest{std::string(frame.uri, strnlen(frame.uri, kMostHelperUri)), frame.head.generation};
}

Result<void> sendAnswer(int socket, const HelperAnswer& answer) {
  AnswerFrame frame{};
  frame.head = head(0);
  if (!answer.opened) {
    const Error& error = answer.opened.error();
    frame.code = static_cast<std::uint32_t>(error.code);
    put(frame.where, error.where);
    put(frame.what, error.what);
    put(frame.remedy, error.remedy);
  }
  int texts = 0, numbers = 0, flags = 0;
  eachField(
      answer.info, [&](const std::string& text) { put(frame.text[texts++], text); },
      [&](double number) { frame.number[numbers++] = number; },
      [&](bool flag) { frame.flags |= flag ? 1u << flags : 0u, ++flags; });
  return sendWhole(socket, &frame, sizeof frame, -1);
}

Result<HelperAnswer> receiveAnswer(int socket, int wait_ms) {
  pollfd look{socket, POLLIN, 0};
  int ready = 0;
  do {
    ready = ::poll(&look, 1, wait_ms);
  } while (ready < 0 && errno == EINTR);
  if (ready == 0) {
    return Error{ErrorCode::kTimeout, "hapticd-vendor", "the vendor's library does not open the device in time",
                 "is it plugged in and switched on? journalctl -u 'hapticd-vendor@*' has what the library says"};
  }
  AnswerFrame frame{};
  ssize_t got = 0;
  do {
    got = ::recv(socket, &frame, sizeof frame, 0);
  } while (got < 0 && errno == EINTR);
  if (got <= 0) {
    return Error{ErrorCode::kDeviceGone, "hapticd-vendor", "it ended while it opened the device",
                 "the vendor's library may have crashed: journalctl -u 'hapticd-vendor@*'"};
  }
  return decodeAnswer({reinterpret_cast<const std::uint8_t*>(&frame), static_cast<std::size_t>(got)});
}

Result<HelperAnswer> decodeAnswer(std::span<const std::uint8_t> bytes) {
  AnswerFrame frame{};
  if (bytes.size() == sizeof frame) std::memcpy(&frame, bytes.data(), sizeof frame);
  if (!fits(frame.head)) return otherBuild("it is of another build");
  HelperAnswer answer;
  if (frame.code != 0) {
    // Whatever number it says: one of ours.
    const auto known = static_cast<ErrorCode>(std::min(frame.code, 0xFFFFu));
    const auto code = describe(known) == describe(static_cast<ErrorCode>(0xFFFF)) ? ErrorCode::kInternal : known;
    answer.opened = Error{code, get(frame.where), get(frame.what), get(frame.remedy)};
  }
  int texts = 0, numbers = 0, flags = 0;
  bool finite = true;
  eachField(
      answer.info, [&](std::string& text) { text = get(frame.text[texts++]); },
      [&](double& number) { finite = std::isfinite(number = frame.number[numbers++]) && finite; },
      [&](bool& flag) { flag = (frame.flags >> flags++ & 1u) != 0; });
  if (finite || !answer.opened) return answer;
  return Error{ErrorCode::kInternal, "hapticd-vendor", "it tells figures of the device that are no numbers", {}};
}

}  // namespace hapticd
