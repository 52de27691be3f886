// client.h and status.h.
#include <errno.h>

#include <algorithm>
#include <string_view>

#include "libclient/src/api/call.h"
#include "libclient/src/connection/loop.h"
#include "libclient/src/reply/convert.h"

using hapticd::client::Connection;
using hapticd::client::Failure;
using hapticd::client::Link;
using hapticd::client::Reply;
namespace client = hapticd::client;

namespace {

/** The last reference may go on the library's own thread (in a callback), which cannot wait for itself. */
void destroy(Connection* connection) {
  if (!connection->ownProcess()) return;  // its thread is in the parent
  if (connection->onOwnThread()) {
    std::thread([connection] { delete connection; }).detach();
  } else {
    delete connection;
  }
}

/** Bytes of the UTF-8 character (RFC 3629) that `s` begins with; 0 if there is none, or it is a control character. */
std::size_t characterIn(std::string_view s) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(s[i]); };
  const std::size_t n = byte(0) < 0x80         ? 1
                        : byte(0) >> 5 == 0x6  ? 2
                        : byte(0) >> 4 == 0xe  ? 3
                        : byte(0) >> 3 == 0x1e ? 4
                                               : 0;
  if (n == 0 || n > s.size()) return 0;
  constexpr std::uint32_t kLeast[] = {0, 0x20, 0xa0, 0x800, 0x10000};
  std::uint32_t code = n == 1 ? byte(0) : byte(0) & (0x7fu >> n);
  for (std::size_t i = 1; i < n; ++i) {
    if (byte(i) >> 6 != 2) return 0;
    code = code << 6 | (byte(i) & 0x3fu);
  }
  const bool surrogate = code >= 0xd800 && code < 0xe000;
  return code < kLeast[n] || code == 0x7f || surrogate || code > 0x10ffff ? 0 : n;
}

/** The program's own name as the daemon takes one, whatever its file is called. */
std::string programName() {
  constexpr std::size_t kMost = 64;  // Of a client's name in the daemon.
  std::string name;
  for (std::string_view rest = program_invocation_short_name; !rest.empty();) {
    const std::size_t n = characterIn(rest);
    const std::string_view next = n == 0 ? "?" : rest.substr(0, n);
    if (name.size() + next.size() > kMost) break;
    name += next;
    rest.remove_prefix(std::max<std::size_t>(n, 1));
  }
  return name;
}

haptic_text* toText(Reply& memory, capnp::Text::Reader from) {
  auto* to = memory.make<haptic_text>();
  to->length = from.size();
  to->text = memory.text({from.cStr(), from.size()});
  return to;
}

}  // namespace

extern "C" {

int haptic_connect(const haptic_connect_options* options, haptic_client** c, haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    if (c == nullptr) return client::badArgument("client", "is null");
    haptic_connect_options full = HAPTIC_CONNECT_OPTIONS_INIT;
    if (options != nullptr) {
      const std::size_t minimum = offsetof(haptic_connect_options, socket);
      if (Failure bad = client::readSized(options, full, minimum, "haptic_connect_options")) return bad;
    }
    if ((full.flags & ~std::uint32_t{HAPTIC_CONNECT_ADMINISTRATION}) != 0) {
      return {HAPTIC_UNSUPPORTED, "haptic_connect_options.flags", "has bits that are not defined", {}};
    }
    // As of a variable that is not set: a search would find a daemon that was not meant.
    if (full.socket != nullptr && full.socket[0] == '\0')
      return client::badArgument("haptic_connect_options.socket", "is empty", "name a socket, or none to search");
    Connection::Options o;
    if (full.socket != nullptr) o.socket = full.socket;
    o.name = full.name == nullptr ? programName() : full.name;
    o.administration = (full.flags & HAPTIC_CONNECT_ADMINISTRATION) != 0;
    o.timeout_ns = full.timeout_ns;
    auto made = std::make_unique<haptic_client>();
    made->connection = std::shared_ptr<Connection>(new Connection(std::move(o)), destroy);
    if (Failure failure = made->connection->start()) return failure;
    if (Failure failure = made->connection->connect()) return failure;
    *c = made.release();
    return {};
  });
}

void haptic_disconnect(haptic_client* c) {
  if (c == nullptr) return;
  c->connection->disconnect();
  delete c;
}

int haptic_connected(const haptic_client* c) {
  return c != nullptr && c->connection->ownProcess() && c->connection->connected() ? 1 : 0;
}

int haptic_reconnect(haptic_client* c, haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    if (c == nullptr) return client::badArgument("client", "is null");
    return c->connection->connect();
  });
}

int haptic_set_timeout(haptic_client* c, int64_t timeout_ns) {
  if (c == nullptr || timeout_ns < 0) return HAPTIC_INVALID_ARGUMENT;
  c->connection->setTimeout(timeout_ns);
  return HAPTIC_OK;
}

int haptic_get_daemon_info(haptic_client* c, haptic_daemon_info** info, haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    if (c == nullptr) return client::badArgument("client", "is null");
    if (info == nullptr) return client::badArgument("info", "is null");
    if (Failure failure = c->connection->foreign()) return failure;
    Reply memory;
    *info = memory.release(client::convert(c->connection->info(), memory));
    return {};
  });
}

int haptic_get(haptic_client* c, const char* path, haptic_text** json, haptic_error* error) {
  if (path == nullptr) return client::refuse(error, "path", "is null");
  return client::query(
      c, json, error,
      [&](Link& link) {
        auto request = link.daemon.getRequest();
        request.setPath(path);
        return request;
      },
      [](auto& results, Reply& memory) { return toText(memory, results.getJson()); });
}

int haptic_set(haptic_client* c, const char* uri, haptic_text** json, haptic_error* error) {
  if (uri == nullptr) return client::refuse(error, "uri", "is null");
  return client::queryIfWanted(
      c, json, error,
      [&](Link& link) {
        auto request = link.daemon.setRequest();
        request.setUri(uri);
        return request;
      },
      [](auto& results, Reply& memory) { return toText(memory, results.getJson()); });
}

int haptic_get_configuration(haptic_client* c, haptic_text** toml, haptic_error* error) {
  return client::query(
      c, toml, error, [](Link& link) { return link.daemon.configurationRequest(); },
      [](auto& results, Reply& memory) { return toText(memory, results.getToml()); });
}

int haptic_get_dump(haptic_client* c, haptic_text** json, haptic_error* error) {
  return client::query(
      c, json, error, [](Link& link) { return link.daemon.dumpRequest(); },
      [](auto& results, Reply& memory) { return toText(memory, results.getJson()); });
}

int haptic_get_status(haptic_client* c, haptic_status** status, haptic_error* error) {
  return client::query(
      c, status, error, [](Link& link) { return link.daemon.stateRequest(); },
      [&](auto& results, Reply& memory) { return client::convert(results.getState(), c->connection->info(), memory); });
}

int haptic_get_statistics(haptic_client* c, const char* uri, int reset, haptic_statistics** statistics,
                          haptic_error* error) {
  return client::query(
      c, statistics, error,
      [&](Link& link) {
        auto request = link.daemon.statisticsRequest();
        request.setUri(client::orEmpty(uri));
        request.setReset(reset != 0);
        return request;
      },
      [](auto& results, Reply& memory) { return client::convert(results.getStatistics(), memory); });
}

int haptic_run_doctor(haptic_client* c, haptic_check_list** checks, haptic_error* error) {
  return client::query(
      c, checks, error, [](Link& link) { return link.daemon.doctorRequest(); },
      [](auto& results, Reply& memory) { return client::convert(results.getChecks(), memory); });
}

int haptic_device_list_all(haptic_client* c, haptic_device_list** devices, haptic_error* error) {
  return client::query(
      c, devices, error, [](Link& link) { return link.daemon.listDevicesRequest(); },
      [](auto& results, Reply& memory) { return client::convert(results.getDevices(), memory); });
}

int haptic_device_open(haptic_client* c, const char* uri, haptic_device_info** device, haptic_error* error) {
  return client::queryIfWanted(
      c, device, error,
      [&](Link& link) {
        auto request = link.daemon.openDeviceRequest();
        request.setUri(client::orEmpty(uri));
        return request;
      },
      [](auto& results, Reply& memory) { return client::convert(results.getDevice(), memory); });
}

}  // extern "C"
