// Projects of InVesalius (.inv3): a tar of property lists and the matrix of the scan.
#include <fmt/core.h>

#include <map>
#include <pugixml.hpp>

#include "tools/hapticctl-import/format/image_file.h"

namespace hapticctl_import {
namespace {

/** The files of a ustar archive by their names without folders; views into it. */
std::map<std::string, std::string_view> filesOf(std::string_view tar) {
  std::map<std::string, std::string_view> files;
  std::size_t at = 0;
  while (at + 512 <= tar.size() && tar[at] != '\0') {
    const std::string_view head = tar.substr(at, 512);
    const std::string_view whole = head.substr(0, 100);
    const std::string name(whole.substr(0, whole.find('\0')));
    std::uint64_t bytes = 0;
    for (const char c : head.substr(124, 12)) {
      if (c == ' ' || c == '\0') continue;
      if (c < '0' || c > '7') throw ImportError("archive", "a size in it is no number", "is it whole?");
      bytes = bytes * 8 + static_cast<std::uint64_t>(c - '0');
    }
    at += 512;
    if (bytes > tar.size() - at) throw ImportError(name, "is cut short", "fetch the file again");
    files[name.substr(name.rfind('/') + 1)] = tar.substr(at, bytes);
    at += (bytes + 511) / 512 * 512;
  }
  return files;
}

/** The value after a key of a property list's dictionary; empty if there is none. */
pugi::xml_node valueOf(const pugi::xml_node& dictionary, std::string_view key) {
  for (const pugi::xml_node k : dictionary.children("key")) {
    if (k.child_value() == key) {
      pugi::xml_node value = k.next_sibling();
      while (value && value.type() != pugi::node_element) value = value.next_sibling();
      return value;
    }
  }
  return {};
}

std::string listOf(const pugi::xml_node& array) {
  std::string text;
  for (const pugi::xml_node entry : array.children()) text += std::string(entry.child_value()) + " ";
  return text;
}

}  // namespace

bool isInvesalius(std::string_view bytes) { return bytes.size() > 512 && bytes.substr(257, 5) == "ustar"; }

Image parseInvesalius(std::string_view tar) {
  const auto files = filesOf(tar);
  const auto list = files.find("main.plist");
  if (list == files.end()) throw ImportError("archive", "has no main.plist", "it is no project of InVesalius");
  pugi::xml_document document;
  if (const auto parsed = document.load_buffer(list->second.data(), list->second.size()); !parsed)
    throw ImportError("main.plist", parsed.description(), "is it whole?");
  const pugi::xml_node project = document.child("plist").child("dict"), matrix = valueOf(project, "matrix");
  const auto data = files.find(valueOf(matrix, "filename").child_value());
  if (data == files.end()) throw ImportError("main.plist", "names no matrix that is there", "is it whole?");
  const auto sample = sampleOf(valueOf(matrix, "dtype").child_value());
  if (!sample) throw ImportError("dtype", "is not known", "export the image from InVesalius");
  Image image;
  image.format = "InVesalius project";
  const auto shape = sizesIn(listOf(valueOf(matrix, "shape")), "shape");  // z, y, x
  const auto step = numbersIn(listOf(valueOf(project, "spacing")), "spacing", 3);
  for (std::size_t k = 0; k < 3; ++k) {
    image.size[k] = shape[2 - k];
    image.step[k][k] = step[k];
  }
  decode(data->second, *sample, false, image);
  checkPlace(image);
  return image;
}

}  // namespace hapticctl_import
