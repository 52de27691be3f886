#include "tools/hapticctl/daemon.h"

#include <fmt/format.h>

#include <string_view>

#include "tools/hapticctl/failure.h"

namespace hapticctl {
namespace {

/** "NOT_FOUND" from "HAPTIC_NOT_FOUND": the name in proto/errors.h. */
std::string codeName(int code) {
  std::string_view name = haptic_error_name(code);
  if (name.starts_with("HAPTIC_")) name.remove_prefix(7);
  return std::string(name);
}

Failure failure(int code, const haptic_error& error) {
  Failure out;
  out.exit = code == HAPTIC_DISCONNECTED ? kExitDisconnected : kExitRefused;
  out.code = codeName(code);
  out.where = error.where;
  out.what = error.what[0] != '\0' ? error.what : haptic_error_text(code);
  out.remedy = error.remedy;
  // The library's remedy is a programmer's.
  if (code == HAPTIC_DISCONNECTED && (out.remedy.empty() || out.remedy.starts_with("call haptic_reconnect()"))) {
    out.where.clear();
    out.what = haptic_error_text(code);
    out.remedy = "see why it ended: journalctl -u hapticd";
  }
  return out;
}

}  // namespace

void check(int code, const haptic_error& error) {
  if (code != HAPTIC_OK) throw failure(code, error);
}

Daemon::Daemon(const Globals& globals) {
  haptic_connect_options options = HAPTIC_CONNECT_OPTIONS_INIT;
  options.flags = globals.admin ? HAPTIC_CONNECT_ADMINISTRATION : 0;
  options.socket = globals.socket.empty() ? nullptr : globals.socket.c_str();
  options.name = "hapticctl";
  options.timeout_ns = static_cast<std::int64_t>(globals.timeout_s * 1e9);
  haptic_error error = HAPTIC_ERROR_INIT;
  haptic_client* client = nullptr;
  const int code = haptic_connect(&options, &client, &error);
  client_.reset(client);
  if (code == HAPTIC_OK) return;
  Failure out = failure(code, error);
  if (code == HAPTIC_DISCONNECTED || code == HAPTIC_SYSTEM || code == HAPTIC_TIMEOUT ||
      code == HAPTIC_PERMISSION_DENIED || code == HAPTIC_NOT_FOUND) {
    out.exit = kExitNoDaemon;
    if (error.remedy[0] == '\0') {
      out.remedy =
          "start it (systemctl start hapticd, or /usr/sbin/hapticd --allow-no-rt to try it), or name its socket with "
          "--socket";
    }
  }
  if (code == HAPTIC_INVALID_ARGUMENT) out.exit = kExitUsage;  // Of the socket's name: nobody was asked.
  throw out;
}

Session::Session(const Daemon& daemon, const std::string& device) {
  haptic_session_options options = HAPTIC_SESSION_OPTIONS_INIT;
  std::string uri = device;
  if (uri.empty()) {
    const auto devices = daemon.ask<haptic_device_list>(haptic_device_list_all);
    if (devices->count > 0 && devices->items[0]->open != 0) uri = devices->items[0]->uri;
  }
  options.uri = uri.c_str();
  haptic_error error = HAPTIC_ERROR_INIT;
  haptic_session* session = nullptr;
  try {
    check(haptic_session_open(daemon.client(), &options, &session, &error), error);
  } catch (Failure& failure) {  // Which tells what URIs of each driver look like.
    if (failure.code == "NOT_FOUND" && failure.what.starts_with("no device has that name"))
      failure.remedy = "hapticctl list shows them; a URI opens one, as sim://omega3";
    throw;
  }
  session_.reset(session);
  haptic_session_info* info = nullptr;
  check(haptic_session_describe(session, &info, &error), error);
  info_.reset(info);
}

const haptic_device_info& findDevice(const haptic_device_list& devices, const std::string& wanted) {
  std::string names;
  for (std::uint32_t i = 0; i < devices.count; ++i) {
    const haptic_device_info& device = *devices.items[i];
    if (wanted.empty() || wanted == device.uri || wanted == device.name ||
        (device.serial[0] != '\0' && wanted == device.serial)) {
      return device;
    }
    names += (names.empty() ? "" : ", ") + std::string(device.name[0] != '\0' ? device.name : device.uri);
  }
  throw Failure{kExitRefused, wanted, "no such device",
                names.empty() ? "the daemon sees none; hapticctl doctor tells why" : "there is: " + names, "NOT_FOUND"};
}

std::string deviceUri(const Daemon& daemon, const std::string& wanted) {
  if (wanted.empty()) return {};
  const auto devices = daemon.ask<haptic_device_list>(haptic_device_list_all);
  return findDevice(*devices, wanted).uri;
}

const char* faultName(std::uint32_t fault) {
  switch (fault) {
    case HAPTIC_FAULT_NONE:
      return "none";
    case HAPTIC_FAULT_STOP_LINE:
      return "emergency stop";
    case HAPTIC_FAULT_NOT_FINITE:
      return "not finite";
    case HAPTIC_FAULT_VELOCITY:
      return "velocity";
    case HAPTIC_FAULT_DEVICE_LOST:
      return "device lost";
    case HAPTIC_FAULT_DEVICE_ERROR:
      return "device error";
    case HAPTIC_FAULT_DEADMAN:
      return "dead-man switch";
    case HAPTIC_FAULT_OVERRUN:
      return "overrun";
    case HAPTIC_FAULT_ENERGY:
      return "energy";
    default:
      return "unknown";
  }
}

}  // namespace hapticctl
