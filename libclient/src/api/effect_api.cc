// effect.h: written as the text of one resource, so that the daemon takes all of it or nothing.
#include <hapticclient/effect.h>

#include <cctype>
#include <cmath>
#include <cstring>
#include <iterator>
#include <string>
#include <utility>

#include "libclient/src/connection/connection.h"
#include "libclient/src/reply/failure.h"

using hapticd::client::Failure;
using hapticd::client::Link;
namespace client = hapticd::client;

namespace {

constexpr const char* kKinds[] = {"none", "force", "viscous", "friction", "vibration", "guide"};
constexpr std::uint32_t kMostPoints = 32;

Failure write(const haptic_effect& e, std::string& text) {
  if (e.kind >= std::size(kKinds))
    return client::badArgument("haptic_effect.kind", "is " + std::to_string(e.kind), "give a haptic_effect_kind");
  text += kKinds[e.kind];
  const std::pair<const char*, double> numbers[] = {{"force", e.force},     {"stiffness", e.stiffness},
                                                    {"damping", e.damping}, {"reach", e.reach},
                                                    {"hz", e.hz},           {"duration_s", e.duration_s}};
  for (const auto& [name, value] : numbers) {
    if (!std::isfinite(value))
      return client::badArgument(std::string("haptic_effect.") + name, "is not finite", "check how it was computed");
    text.append(",").append(name).append("=").append(client::textOf(value));
  }
  text += ",path=";
  if (e.path_count == 0) {
    text += "none";
    return {};
  }
  if (e.path == nullptr) return client::badArgument("haptic_effect.path", "is null");
  if (e.path_count < 2 || e.path_count > kMostPoints) {
    return client::badArgument("haptic_effect.path_count", "is " + std::to_string(e.path_count),
                               "a path has 2 to 32 points; a longer one is made of several objects");
  }
  for (std::uint32_t i = 0; i < 3 * e.path_count; ++i) {
    if (!std::isfinite(e.path[i])) {
      return client::badArgument("haptic_effect.path, point " + std::to_string(i / 3), "is not finite",
                                 "check how it was computed");
    }
    if (i > 0) text += ",";
    text += client::textOf(static_cast<double>(static_cast<float>(e.path[i])));  // The servo has it as a float.
  }
  return {};
}

/** A name may hold anything; only what the daemon knows gets so far as to be found. */
std::string encoded(const char* name) {
  constexpr char kDigits[] = "0123456789ABCDEF";
  std::string out;
  for (const char* c = name; *c != 0; ++c) {
    const auto byte = static_cast<unsigned char>(*c);
    if (std::isalnum(byte) != 0 || std::strchr("_.-", *c) != nullptr) {
      out += *c;
    } else {
      out.append({'%', kDigits[byte >> 4], kDigits[byte & 15]});
    }
  }
  return out;
}

}  // namespace

extern "C" int haptic_object_set_effect(haptic_client* c, const char* name, const haptic_effect* effect,
                                        haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    if (c == nullptr) return client::badArgument("client", "is null");
    if (name == nullptr || *name == 0) return client::badArgument("name", name == nullptr ? "is null" : "is empty");
    haptic_effect full = HAPTIC_EFFECT_INIT;
    if (Failure bad = client::readSized(effect, full, offsetof(haptic_effect, force), "haptic_effect")) return bad;
    if (Failure bad = client::checkReserved(full.reserved, "haptic_effect.reserved")) return bad;
    std::string uri = "/objects/" + encoded(name) + "/effect?value=";
    if (Failure bad = write(full, uri)) return bad;
    return client::callDaemon(*c->connection, [&](Link& link) {
      auto request = link.daemon.setRequest();
      request.setUri(uri);
      return request;
    });
  });
}
