/** @file
 * libhapticclient for C++20: handles that end with their scope, value-or-error results, spans. Header-only over the C
 * interface, whose headers tell units, frames, threads and errors.
 *
 *     auto client = haptic::Client::connect();
 *     if (!client) return std::cerr << client.error().message() << '\n', 1;
 *     auto session = client->openSession();
 *     if (session) if (auto sample = session->latest()) std::cout << sample->p[2] << " m\n";
 */
#pragma once

#if __cplusplus <= 201703L
#error "hapticclient.hpp needs C++20: -std=c++20, or CXX_STANDARD 20; the C interface is hapticclient.h"
#endif

#include <hapticclient/hapticclient.h>

#include <chrono>
#include <cstdint>
#include <hapticclient/events.hpp>
#include <hapticclient/recording.hpp>
#include <hapticclient/result.hpp>
#include <hapticclient/scene.hpp>
#include <hapticclient/session.hpp>
#include <memory>
#include <string>

namespace haptic {

/** Where and how to connect; the defaults search as haptic_connect() tells. */
struct ConnectOptions {
  std::string socket{};
  std::string name{};
  bool administration = false;
  std::chrono::nanoseconds timeout{};  ///< Zero: 5 s.
};

/** A connection to the daemon. It ends with this, whatever was made through it and is still there. */
class Client {
 public:
  explicit Client(haptic_client* handle) : handle_(handle, haptic_disconnect) {}

  Client(Client&&) noexcept = default;
  Client& operator=(Client&&) noexcept = default;

  static Result<Client> connect(const ConnectOptions& options = {}) {
    haptic_connect_options c = HAPTIC_CONNECT_OPTIONS_INIT;
    c.flags = options.administration ? std::uint32_t{HAPTIC_CONNECT_ADMINISTRATION} : 0u;
    c.socket = detail::orNull(options.socket);
    c.name = detail::orNull(options.name);
    c.timeout_ns = options.timeout.count();
    haptic_client* handle = nullptr;
    auto done = detail::run([&](auto* e) { return haptic_connect(&c, &handle, e); });
    if (!done) return done.error();
    return Client(handle);
  }

  [[nodiscard]] bool connected() const noexcept { return haptic_connected(get()) != 0; }
  Result<void> reconnect() {
    return detail::run([&](auto* e) { return haptic_reconnect(get(), e); });
  }
  Result<void> setTimeout(std::chrono::nanoseconds timeout) {
    return detail::fromCode(haptic_set_timeout(get(), timeout.count()));
  }
  [[nodiscard]] Result<Reply<haptic_daemon_info>> daemon() const {
    return detail::ask<haptic_daemon_info>([&](auto** out, auto* e) { return haptic_get_daemon_info(get(), out, e); });
  }

  [[nodiscard]] Result<Reply<haptic_device_list>> devices() const {
    return detail::ask<haptic_device_list>([&](auto** out, auto* e) { return haptic_device_list_all(get(), out, e); });
  }
  /** Empty: the first open device; if none is open, the first real one, else the simulator. */
  Result<Reply<haptic_device_info>> openDevice(const std::string& uri = {}) {
    return detail::ask<haptic_device_info>(
        [&](auto** out, auto* e) { return haptic_device_open(get(), uri.c_str(), out, e); });
  }
  Result<void> closeDevice(const std::string& uri) {
    return detail::run([&](auto* e) { return haptic_device_close(get(), uri.c_str(), e); });
  }
  /** Empty: every device. */
  Result<void> stop(const std::string& uri = {}) {
    return detail::run([&](auto* e) { return haptic_stop(get(), uri.c_str(), e); });
  }
  /** NaN leaves a limit as it is; gives the limits in force. */
  Result<haptic_device_limits> setLimits(const std::string& uri, haptic_device_limits limits) {
    haptic_device_limits in_force{};
    limits.size = in_force.size = sizeof limits;
    auto done =
        detail::run([&](auto* e) { return haptic_device_set_limits(get(), uri.c_str(), &limits, &in_force, e); });
    if (!done) return done.error();
    return in_force;
  }

  [[nodiscard]] Result<Reply<haptic_status>> status() const {
    return detail::ask<haptic_status>([&](auto** out, auto* e) { return haptic_get_status(get(), out, e); });
  }
  Result<Reply<haptic_statistics>> statistics(const std::string& uri = {}, bool reset = false) {
    return detail::ask<haptic_statistics>(
        [&](auto** out, auto* e) { return haptic_get_statistics(get(), uri.c_str(), reset ? 1 : 0, out, e); });
  }
  [[nodiscard]] Result<Reply<haptic_check_list>> doctor() const {
    return detail::ask<haptic_check_list>([&](auto** out, auto* e) { return haptic_run_doctor(get(), out, e); });
  }

  /** A resource as JSON. */
  [[nodiscard]] Result<std::string> get(const std::string& path) const {
    return detail::askText([&](auto** out, auto* e) { return haptic_get(get(), path.c_str(), out, e); });
  }
  /** "/objects/C/pos?value=1,2,3"; gives the value in force as JSON. */
  Result<std::string> set(const std::string& uri) {
    return detail::askText([&](auto** out, auto* e) { return haptic_set(get(), uri.c_str(), out, e); });
  }
  [[nodiscard]] Result<std::string> configuration() const {
    return detail::askText([&](auto** out, auto* e) { return haptic_get_configuration(get(), out, e); });
  }
  [[nodiscard]] Result<std::string> dump() const {
    return detail::askText([&](auto** out, auto* e) { return haptic_get_dump(get(), out, e); });
  }

  Result<Session> openSession(const std::string& uri = {}, const std::string& name = {}) {
    haptic_session_options o = HAPTIC_SESSION_OPTIONS_INIT;
    o.uri = detail::orNull(uri);
    o.name = detail::orNull(name);
    haptic_session* handle = nullptr;
    auto done = detail::run([&](auto* e) { return haptic_session_open(get(), &o, &handle, e); });
    if (!done) return done.error();
    return Session(handle);
  }
  /** Empty: the first device. It must not be armed. */
  Result<Recording> record(const std::string& uri = {}) {
    haptic_recording* handle = nullptr;
    auto done = detail::run([&](auto* e) { return haptic_recording_start(get(), uri.c_str(), &handle, e); });
    if (!done) return done.error();
    return Recording(handle);
  }
  [[nodiscard]] Scene scene() const noexcept { return Scene(handle_); }
  /** `kinds`: 1 << haptic_event_kind each, 0 for all. */
  Result<Events> subscribe(std::uint32_t kinds = 0, std::uint32_t capacity = 0) {
    haptic_events_options o = HAPTIC_EVENTS_OPTIONS_INIT;
    o.kinds = kinds;
    o.capacity = capacity;
    haptic_events* handle = nullptr;
    auto done = detail::run([&](auto* e) { return haptic_events_open(get(), &o, &handle, e); });
    if (!done) return done.error();
    return Events(handle);
  }

  /** The handle of the C interface; still owned here. */
  [[nodiscard]] haptic_client* get() const noexcept { return handle_.get(); }

 private:
  std::shared_ptr<haptic_client> handle_;  ///< Owned here alone; scenes and objects see whether it is still there.
};

}  // namespace haptic
