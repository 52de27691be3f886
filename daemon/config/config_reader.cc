// TOML into a Config. The only file that sees toml++, whose exceptions end here.
#define TOML_HEADER_ONLY 0
#include <toml++/toml.h>

#include <algorithm>
#include <optional>
#include <set>

#include "daemon/config/config_schema.h"
#include "daemon/device/finger_words.h"
#include "rt/base/edit_distance.h"

namespace hapticd {
namespace {

std::string inWords(std::string_view name, const toml::source_position& place) {
  return fmt::format("{}:{}:{}", name, place.line, place.column);
}

/** The error that stands first in the file. */
class FirstError {
 public:
  explicit FirstError(std::string_view file) : file_(file) {}

  void add(const toml::source_position& at, std::string what, std::string remedy = {}) {
    if (error_ && !(at < at_)) return;
    at_ = at;
    error_ = Error{ErrorCode::kInvalidArgument, inWords(file_, at), std::move(what), std::move(remedy)};
  }
  [[nodiscard]] const std::optional<Error>& get() const { return error_; }

 private:
  std::string_view file_;
  toml::source_position at_{};
  std::optional<Error> error_;
};

std::string typeName(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::string:
      return "text";
    case toml::node_type::integer:
      return "an integer";
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "a boolean";
    case toml::node_type::array:
      return "an array";
    case toml::node_type::table:
      return "a table";
    default:
      return "a date or time";
  }
}

/** Reads one table: each visit names a key that is allowed there. */
class Reader {
 public:
  Reader(const toml::table& table, std::string path, FirstError& errors)
      : table_(table), path_(std::move(path)), errors_(errors) {}

  void number(std::string_view key, double& value, double least, double most) {
    if (const toml::node* const node = take(key)) readNumber(key, *node, value, least, most);
  }

  void integer(std::string_view key, std::uint32_t& value, std::int64_t least, std::int64_t most) {
    if (const toml::node* const node = take(key)) readInteger(key, *node, value, least, most);
  }

  void flag(std::string_view key, bool& value) {
    const toml::node* const node = take(key);
    if (node == nullptr) return;
    if (!node->is_boolean()) return wrongType(key, *node, "true or false");
    value = node->as_boolean()->get();
  }

  void text(std::string_view key, std::string& value) {
    if (const toml::node* const node = take(key)) readText(key, *node, value);
  }

  void mode(std::string_view key, std::uint32_t& value) {
    const toml::node* const node = take(key);
    if (node == nullptr) return;
    const auto* const integer = node->as_integer();
    if (integer == nullptr) return wrongType(key, *node, "file permissions such as 0o660");
    const bool octal = integer->flags() == toml::value_flags::format_as_octal;
    const std::string given = octal ? fmt::format("0o{:o}", integer->get()) : fmt::format("{}", integer->get());
    if (integer->get() < 0 || integer->get() > 0777) {
      return errors_.add(node->source().begin, fmt::format("{} = {} is not a set of file permissions", key, given),
                         "0o000 to 0o777, in octal");
    }
    if (!octal && integer->get() != 0) {  // 440 is 0o670: more than whoever wrote it means.
      return errors_.add(node->source().begin, fmt::format("{} = {} is not written in octal", key, given),
                         "it must be file permissions such as 0o660");
    }
    value = static_cast<std::uint32_t>(integer->get());
  }

  void level(std::string_view key, log::Level& value) {
    const toml::node* const node = take(key);
    if (node == nullptr) return;
    std::string name;
    if (!readText(key, *node, name)) return;
    const auto parsed = log::parseLevel(name);
    if (!parsed) return errors_.add(node->source().begin, parsed.error().what, parsed.error().remedy);
    value = *parsed;
  }

  void texts(std::string_view key, std::vector<std::string>& values) {
    readArray(key, values, "an array of texts",
              [&](const toml::node& element, std::string& value) { readText(key, element, value); });
  }

  void integers(std::string_view key, std::vector<std::uint32_t>& values, std::int64_t least, std::int64_t most) {
    readArray(key, values, "an array of integers",
              [&](const toml::node& element, std::uint32_t& value) { readInteger(key, element, value, least, most); });
  }

  /** Three numbers along x, y and z. */
  void triple(std::string_view key, std::vector<double>& values, double least, double most) {
    const toml::node* const node = take(key);
    if (node == nullptr) return;
    const toml::array* const array = node->as_array();
    if (array == nullptr) return wrongType(key, *node, "three numbers, [x, y, z]");
    if (array->size() != 3) {
      return errors_.add(node->source().begin, fmt::format("{} has {} numbers", key, array->size()),
                         "it must be three, [x, y, z]");
    }
    for (std::size_t i = 0; i < 3; ++i) readNumber(key, *array->get(i), values[i], least, most);
  }

  template <class Visit>
  void table(std::string_view key, Visit&& visit) {
    const toml::node* const node = take(key);
    if (node == nullptr) return;
    const toml::table* const inner = node->as_table();
    if (inner == nullptr) return wrongType(key, *node, fmt::format("a table, [{}]", key));
    Reader reader(*inner, fmt::format("[{}]", key), errors_);
    visit(reader);
    reader.refuseUnknown();
  }

  template <class Element, class Visit>
  void tables(std::string_view key, std::vector<Element>& elements, Visit&& visit) {
    const toml::node* const node = take(key);
    if (node == nullptr) return;
    const toml::array* const array = node->as_array();
    if (array == nullptr || !array->is_array_of_tables())
      return wrongType(key, *node, fmt::format("an array of tables, [[{}]]", key));
    for (const toml::node& entry : *array) {
      Reader reader(*entry.as_table(), fmt::format("[[{}]]", key), errors_);
      Element element = prototype(static_cast<Element*>(nullptr));
      visit(reader, element);
      reader.refuseUnknown();
      elements.push_back(std::move(element));
    }
  }

  void refuseUnknown() {
    for (const auto& [key, node] : table_) {
      if (known_.count(key.str()) != 0) continue;
      const auto nearest = std::min_element(known_.begin(), known_.end(), [&k = key](auto a, auto b) {
        return editDistance(k.str(), a) < editDistance(k.str(), b);
      });
      const bool near =
          nearest != known_.end() && editDistance(key.str(), *nearest) <= std::max<std::size_t>(2, key.length() / 2);
      std::string remedy;
      if (near) {
        remedy = fmt::format("did you mean \"{}\"?", *nearest);
      } else {
        for (const auto name : known_) remedy += (remedy.empty() ? "known here: " : ", ") + std::string(name);
      }
      errors_.add(key.source().begin,
                  fmt::format("unknown key \"{}\"{}", log::printable(key.str()), path_.empty() ? "" : " in " + path_),
                  std::move(remedy));
    }
  }

  /** New [[device]] entries start from these. */
  const LimitsConfig* device_limits = nullptr;
  /** Where entry i of an array of tables says `inner`; where it begins, if it does not. */
  [[nodiscard]] toml::source_position place(std::string_view key, std::size_t i, std::string_view inner) const {
    const toml::table& entry = *table_.get(key)->as_array()->get(i)->as_table();
    const toml::node* const node = entry.get(inner);
    return (node == nullptr ? static_cast<const toml::node&>(entry) : *node).source().begin;
  }

 private:
  const toml::node* take(std::string_view key) {
    known_.insert(key);
    return table_.get(key);
  }

  void wrongType(std::string_view key, const toml::node& node, std::string_view wanted) {
    errors_.add(node.source().begin, fmt::format("{} is {}", key, typeName(node)),
                fmt::format("it must be {}", wanted));
  }

  void outOfRange(std::string_view key, const toml::node& node, const std::string& value, double least, double most) {
    errors_.add(node.source().begin, fmt::format("{} = {} is out of range", key, value),
                fmt::format("{} to {}", least, most));
  }

  bool readText(std::string_view key, const toml::node& node, std::string& value) {
    if (!node.is_string()) {
      wrongType(key, node, "text in quotes");
      return false;
    }
    value = node.as_string()->get();
    if (value.find('\0') == std::string::npos) return true;
    errors_.add(node.source().begin, fmt::format("{} holds a zero byte", key));
    return false;
  }

  void readNumber(std::string_view key, const toml::node& node, double& value, double least, double most) {
    if (!node.is_number()) return wrongType(key, node, "a number");
    const auto* const integer = node.as_integer();  // toml++ turns none into a double that would be rounded.
    const double read = integer != nullptr ? static_cast<double>(integer->get()) : node.as_floating_point()->get();
    if (!(read >= least && read <= most)) return outOfRange(key, node, fmt::format("{}", read), least, most);
    value = read;
  }

  void readInteger(std::string_view key, const toml::node& node, std::uint32_t& value, std::int64_t least,
                   std::int64_t most) {
    if (!node.is_integer()) return wrongType(key, node, "an integer");
    const std::int64_t read = node.as_integer()->get();
    if (read < least || read > most)
      return outOfRange(key, node, fmt::format("{}", read), static_cast<double>(least), static_cast<double>(most));
    value = static_cast<std::uint32_t>(read);
  }

  template <class Element, class Read>
  void readArray(std::string_view key, std::vector<Element>& values, std::string_view wanted, Read&& read) {
    const toml::node* const node = take(key);
    if (node == nullptr) return;
    const toml::array* const array = node->as_array();
    if (array == nullptr) return wrongType(key, *node, wanted);
    for (const toml::node& element : *array) read(element, values.emplace_back());
  }

  GroupConfig prototype(GroupConfig*) const { return {}; }
  LineConfig prototype(LineConfig*) const { return {}; }
  DeviceConfig prototype(DeviceConfig*) const {
    DeviceConfig device;
    device.limits = *device_limits;
    return device;
  }

  const toml::table& table_;
  std::string path_;
  FirstError& errors_;
  std::set<std::string_view> known_;
};

void checkLines(const Config& c, const Reader& root, FirstError& errors) {
  constexpr std::string_view kRoles[] = {"stop", "deadman", "home", "enable", "heartbeat", "led"};
  constexpr std::string_view kBiases[] = {"as-is", "pull-up", "pull-down", "none"};
  const auto among = [](const auto& known, std::string_view value) {
    return std::find(std::begin(known), std::end(known), value) != std::end(known);
  };
  std::set<std::string> seen;
  for (std::size_t i = 0; i < c.lines.size(); ++i) {
    const LineConfig& line = c.lines[i];
    const auto at = [&](std::string_view key) { return root.place("line", i, key); };
    if (!among(kRoles, line.role)) {
      errors.add(at("role"), fmt::format("a [[line]] has the role \"{}\"", log::printable(line.role)),
                 "stop, deadman, home, enable, heartbeat or led");
    }
    if (!among(kBiases, line.bias)) {
      errors.add(at("bias"), fmt::format("a [[line]] has the bias \"{}\"", log::printable(line.bias)),
                 "as-is, pull-up, pull-down or none");
    }
    if (line.name.empty()) errors.add(at("name"), "a [[line]] has no name", "gpioinfo lists chips and lines");
    if (!seen.insert(line.chip + '\0' + line.name).second)
      errors.add(at("name"), fmt::format("line \"{}\" stands twice", log::printable(line.name)));
  }
}

void checkGroups(const Config& c, const Reader& root, FirstError& errors) {
  std::set<std::string> names, uris;
  for (std::size_t i = 0; i < c.groups.size(); ++i) {
    const GroupConfig& group = c.groups[i];
    const auto at = [&](std::string_view key) { return root.place("group", i, key); };
    if (i == GroupConfig::kMost) {
      errors.add(at({}), fmt::format("there are {} groups", c.groups.size()),
                 fmt::format("a daemon has {} servos at most: put devices together", GroupConfig::kMost));
    }
    if (group.name.empty()) errors.add(at("name"), "a [[group]] has no name", "give it name = \"...\"");
    if (!names.insert(group.name).second)
      errors.add(at("name"), fmt::format("group \"{}\" stands twice", log::printable(group.name)));
    if (group.devices.empty()) {
      errors.add(at("devices"), fmt::format("group \"{}\" has no devices", log::printable(group.name)),
                 "devices = [\"\"] takes the first real device, else the simulator");
    }
    if (group.devices.size() > HD_MAX_DEVICES) {
      errors.add(at("devices"),
                 fmt::format("group \"{}\" has {} devices", log::printable(group.name), group.devices.size()),
                 fmt::format("one servo serves at most {}", HD_MAX_DEVICES));
    }
    for (const std::string& uri : group.devices) {
      if (!uris.insert(uri).second) {
        errors.add(at("devices"), fmt::format("device \"{}\" stands in two places", log::printable(uri)),
                   "a device has one servo");
      }
    }
  }
}

void checkDevices(const Config& c, const Reader& root, FirstError& errors) {
  std::set<std::string> uris;
  for (std::size_t i = 0; i < c.devices.size(); ++i) {
    const auto at = [&](std::string_view key) { return root.place("device", i, key); };
    if (c.devices[i].uri.empty())
      errors.add(at("uri"), "a [[device]] has no uri", "uri = \"sim://falcon\" or a serial number");
    if (!uris.insert(c.devices[i].uri).second)
      errors.add(at("uri"), fmt::format("device \"{}\" stands twice", log::printable(c.devices[i].uri)));
    if (const auto finger = parseFinger(c.devices[i].finger, "finger"); !finger)
      errors.add(at("finger"), "finger: " + log::printable(finger.error().what), finger.error().remedy);
  }
}

/** What no single key can tell. */
void checkTogether(const Config& c, const Reader& root, const toml::table& table, FirstError& errors) {
  const auto place = [&](const char* section, const char* key) {
    const toml::node* const node = table[section][key].node();
    return node == nullptr ? table[section].node()->source().begin : node->source().begin;
  };
  if (c.servo.ingest_priority >= c.servo.servo_priority && table["servo"].node() != nullptr) {
    errors.add(place("servo", "ingest_priority"),
               fmt::format("ingest_priority {} is not below servo_priority {}", c.servo.ingest_priority,
                           c.servo.servo_priority),
               "ingest must never delay the servo");
  }
  const auto absolute = [&](const char* section, const char* key, const std::string& path) {
    if (!path.empty() && path[0] != '/') {
      errors.add(place(section, key), fmt::format("{} = \"{}\" is no absolute path", key, log::printable(path)),
                 "begin it with /: the daemon is started now in one folder, now in another");
    }
  };
  absolute("sockets", "control", c.sockets.control);
  absolute("sockets", "admin", c.sockets.admin);
  absolute("builder", "program", c.builder.program);
  absolute("builder", "cache", c.builder.cache);
  absolute("motions", "folder", c.motions.folder);
  checkGroups(c, root, errors);
  checkLines(c, root, errors);
  checkDevices(c, root, errors);
}

Result<Config> read(std::string_view text, std::string_view name) {
  const toml::table table = toml::parse(text, name);
  FirstError errors(name);
  Config config;
  Reader root(table, {}, errors);
  root.device_limits = &config.limits;
  visitConfig(root, config);
  root.refuseUnknown();
  if (!errors.get()) checkTogether(config, root, table, errors);
  if (errors.get()) return *errors.get();
  return config;
}

}  // namespace

std::string placeInConfig(std::string_view toml, std::string_view name, const char* section, const char* key,
                          std::size_t entry) {
  try {
    const toml::table table = toml::parse(toml, name);
    const auto all = table[section];
    const toml::node* const node = (all.is_array() ? all[entry][key] : all[key]).node();
    return node == nullptr ? std::string(name) : inWords(name, node->source().begin);
  } catch (const std::exception&) {
    return std::string(name);
  }
}

Result<Config> parseConfig(std::string_view toml, std::string_view name) {
  try {
    return read(toml, name);
  } catch (const toml::parse_error& error) {
    return Error{ErrorCode::kInvalidArgument, inWords(name, error.source().begin), log::printable(error.description()),
                 "the file must be TOML, https://toml.io"};
  } catch (const std::exception& error) {
    return Error{ErrorCode::kInternal, std::string(name), log::printable(error.what()), {}};
  }
}

}  // namespace hapticd
