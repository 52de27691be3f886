/** @file
 * Answers resource names with JSON: what is behind a path, and what may be written there.
 */
#pragma once

#include <string>
#include <string_view>

#include "daemon/control/core.h"
#include "daemon/resource/json.h"
#include "daemon/resource/resource_name.h"

namespace hapticd {

/** Control thread only; a view over the Core. Errors name the path element at fault and the nearest valid names. */
class ResourceTree {
 public:
  explicit ResourceTree(Core& core) : core_(core) {}

  /** What stands at the path. A folder answers with all that is in it, a property with its value. */
  [[nodiscard]] Result<std::string> get(std::string_view path, const Client& by);
  /** Writes the `value` of the query and answers with the value now in force. */
  [[nodiscard]] Result<std::string> set(std::string_view uri, const Client& by);
  /** Everything. */
  [[nodiscard]] std::string dump();

 private:
  Result<Json> read(const ResourceName& name);
  Result<Json> readObject(const ResourceName& name, std::size_t at, const std::string& object);
  Result<Json> readTree(const ResourceName& name);
  Result<Json> readDevices(const ResourceName& name);
  Result<std::string> setOfDevice(const ResourceName& name, std::string_view value, const Client& by);
  Result<std::string> setOfWorld(const ResourceName& name, std::string_view value);
  Result<Json> readWorld(const ResourceName& name);
  Result<Json> readStatistics(const ResourceName& name);
  Result<Json> readMeshes(const ResourceName& name);
  Result<Json> readTextures(const ResourceName& name);
  /** The object that the elements from `at` on name in the tree, and the element after it. */
  Result<std::pair<std::string, std::size_t>> walk(const ResourceName& name, std::size_t at);

  Core& core_;
};

/** kNotFound at element `i`, naming what is near it. */
[[nodiscard]] Error noSuchElement(const ResourceName& name, std::size_t i, std::vector<std::string> valid);

}  // namespace hapticd
