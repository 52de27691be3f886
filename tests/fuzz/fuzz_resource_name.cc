// Resource names as clients send them: whatever comes in is either refused with a place, or a bounded, printable name
// that is the same when written out and read again.
#include <cstdint>
#include <cstdlib>

#include "daemon/resource/resource_name.h"

namespace {

std::string escaped(const std::string& text) {
  static constexpr char kHex[] = "0123456789abcdef";
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    out += {'%', kHex[byte >> 4], kHex[byte & 15]};
  }
  return out;
}

void require(bool held) {
  if (!held) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace hapticd;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  for (std::size_t count : {1u, 3u, 7u}) {
    if (const auto numbers = parseNumbers(text, count, "value")) require(numbers->size() == count);
  }
  (void)parseBool(text, "value");
  const auto name = parseResourceName(text);
  if (!name) {
    require(!name.error().where.empty() && !name.error().what.empty());
    return 0;
  }
  require(name->element.size() <= kMaxResourceElements);
  std::string again;
  for (const std::string& element : name->element) {
    require(!element.empty());
    for (const char c : element) require(c >= 0x20 && c <= 0x7e);
    again += "/" + escaped(element);
  }
  if (again.empty()) again = "/";
  for (std::size_t i = 0; i < name->query.size(); ++i) {
    again += (i == 0 ? "?" : "&") + escaped(name->query[i].first) + "=" + escaped(name->query[i].second);
  }
  if (again.size() > kMaxResourceName) return 0;
  const auto same = parseResourceName(again);
  require(same.ok() && same->element == name->element && same->query == name->query);
  return 0;
}
