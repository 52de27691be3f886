/** @file
 * What our own readers of mesh files share.
 */
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace hapticd_mesh_file {

/** All of a file. */
[[nodiscard]] std::string bytesOf(const std::string& path);
/** Whether a file's name ends so, in small letters or capitals. */
[[nodiscard]] bool endsWith(const std::string& path, std::string_view ending);
/** Without a byte order mark, if it begins with one. */
[[nodiscard]] std::string_view withoutMark(std::string_view text);
/** Throws MeshError of a damaged file. */
[[noreturn]] void refuse(const std::string& what);
/** Short, for a terminal. */
[[nodiscard]] std::string shown(std::string_view word, std::size_t most = 20);
/** A to Z alone, whatever the locale. */
[[nodiscard]] std::string lower(std::string_view word);
/** The next word, which `text` loses with what is blank before it; empty: there is none. */
[[nodiscard]] std::string_view takeWord(std::string_view& text);
/** The next line, without its end, which `text` loses. An empty one more stands where a line ends in two bytes. */
[[nodiscard]] std::string_view takeLine(std::string_view& text);
/**
 * A number, with a point or, as programs that heed a language write it, a comma; nothing if it is none. What is too
 * large is infinite.
 */
[[nodiscard]] std::optional<double> numberIn(std::string_view word);

}  // namespace hapticd_mesh_file
