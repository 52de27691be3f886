/** @file
 * logind as far as programs hear of sleep from it, at the other end of a socket pair: no bus between, all in one
 * thread.
 */
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <systemd/sd-bus.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <string>

#include "daemon/ipc/unique_fd.h"

namespace hapticd::test {

class FakeLogind {
 public:
  /** A new connection to it, as sd_bus_open_system(). */
  int open(sd_bus** client) {
    int end[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, end) != 0) return -errno;
    const sd_id128_t id = {.bytes = {1}};
    sd_bus* server = nullptr;
    int r = begin(&server, end[0]);
    if (r >= 0) r = sd_bus_set_server(server, 1, id);
    if (r >= 0) r = sd_bus_set_anonymous(server, 1);
    if (r >= 0) r = sd_bus_add_filter(server, nullptr, onCall, this);
    if (r >= 0) r = sd_bus_start(server);
    bus_.reset(server);
    if (r >= 0) r = begin(client, end[1]);
    if (r >= 0) r = sd_bus_set_anonymous(*client, 1);
    return r >= 0 ? sd_bus_start(*client) : r;
  }
  void step() {
    while (bus_ && sd_bus_process(bus_.get(), nullptr) > 0) {
    }
  }
  /** Tells everyone. */
  void prepareForSleep(bool asleep, const char* sender = "org.freedesktop.login1") {
    sd_bus_message* signal = nullptr;
    ASSERT_GE(sd_bus_message_new_signal(bus_.get(), &signal, "/org/freedesktop/login1",
                                        "org.freedesktop.login1.Manager", "PrepareForSleep"),
              0);
    ASSERT_GE(sd_bus_message_append(signal, "b", static_cast<int>(asleep)), 0);
    ASSERT_GE(sd_bus_message_set_sender(signal, sender), 0);
    ASSERT_GE(sd_bus_send(bus_.get(), signal, nullptr), 0);
    sd_bus_message_unref(signal);
  }
  /** Whether the lock last given is still held. */
  [[nodiscard]] bool held() const {
    char byte;
    return lock_.valid() && read(lock_.get(), &byte, 1) < 0 && errno == EAGAIN;
  }
  /** Ends the connection. */
  void leave() { bus_.reset(); }

  std::string asked;     ///< What the lock last asked for was to be, and by whom.
  int locks = 0;         ///< Given.
  bool refuses = false;  ///< Nobody gets one.

 private:
  struct Close {
    void operator()(sd_bus* bus) const { sd_bus_flush_close_unref(bus); }
  };

  static int begin(sd_bus** bus, int fd) {
    int r = sd_bus_new(bus);
    if (r >= 0) r = sd_bus_set_fd(*bus, fd, fd);
    return r >= 0 ? sd_bus_negotiate_fds(*bus, 1) : r;
  }

  static int onCall(sd_bus_message* call, void* self, sd_bus_error*) {
    auto& logind = *static_cast<FakeLogind*>(self);
    if (sd_bus_message_is_method_call(call, "org.freedesktop.login1.Manager", "Inhibit") <= 0) return 0;
    const char *what = "", *who = "", *why = "", *mode = "";
    if (sd_bus_message_read(call, "ssss", &what, &who, &why, &mode) < 0) return 0;
    logind.asked = std::string(what) + " by " + who + ", " + mode;
    if (logind.refuses) return sd_bus_reply_method_errorf(call, SD_BUS_ERROR_ACCESS_DENIED, "Permission denied");
    int end[2];
    if (pipe2(end, O_NONBLOCK | O_CLOEXEC) != 0) return -errno;
    const UniqueFd given(end[1]);
    logind.lock_.reset(end[0]);
    ++logind.locks;
    return sd_bus_reply_method_return(call, "h", given.get());
  }

  std::unique_ptr<sd_bus, Close> bus_;
  UniqueFd lock_;
};

}  // namespace hapticd::test
