/** @file
 * The list of devices that the daemon may have energised: a file, so that somebody else can bring them to zero when the
 * daemon is dead (hapticd-safe).
 *
 * One URI a line. Each keeps its place in the file while it is armed; then spaces stand there, which the next one that
 * fits takes: every change is one write, a daemon killed at any instant leaves whole lines, and the list stays as short
 * as whoever reads it expects. In a file that somebody has removed or edited places are given anew. The daemon holds a
 * lock on the file while it lives.
 */
#pragma once

#include <map>
#include <string>
#include <vector>

#include "daemon/ipc/unique_fd.h"

namespace hapticd {

/** Control thread only. */
class ArmedList {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{1} << 20;  ///< Nobody reads on; a list is some hundred bytes.

  /** A list that keeps nothing: for tests, and where there is no folder to write to. */
  ArmedList() = default;
  /**
   * Opens or makes `path` and locks it. kDeviceBusy when another process holds it. What a dead daemon has left there is
   * in left(), and stays in the file until settle() or clear().
   */
  [[nodiscard]] static Result<ArmedList> open(const std::string& path);
  ArmedList(ArmedList&&) = default;
  ArmedList& operator=(ArmedList&&) = default;
  /** Devices are closed by now: none of them is listed any more. What is left and not settled is. */
  ~ArmedList();

  /**
   * Where somebody has removed the file, its folder too, put another there or edited it: writes anew what is armed and
   * what is left; lines of others stay. True when it did. Call it now and then. kSystem, kDeviceBusy: it is lost still.
   */
  [[nodiscard]] Result<bool> keep();
  /** Before the device is energised. kSystem when it cannot be written, or found by its name: then it must not be. */
  [[nodiscard]] Result<void> add(const std::string& uri);
  /** After it has been switched off. */
  void remove(const std::string& uri);
  /** One that was left is at zero. The others stay: somebody is to try again. */
  void settle(const std::string& uri);
  /** Takes away all, and what was left. */
  void clear();
  /** Each once, in the order of the file. */
  [[nodiscard]] std::vector<std::string> left() const;
  [[nodiscard]] bool has(const std::string& uri) const;

 private:
  /** Opens or makes the file, and locks it. */
  [[nodiscard]] static Result<UniqueFd> lock(const std::string& path);

  [[nodiscard]] bool writeAt(long offset, const std::string& text);
  [[nodiscard]] long end() const { return static_cast<long>(text_.size()); }
  /** Where blank lines have so many bytes, their ends included; else the end. */
  [[nodiscard]] long roomFor(std::size_t bytes) const;
  /** keep() of a file that is there: true where it was edited. Before any place is relied on. */
  [[nodiscard]] Result<bool> mend();
  /** To the end of a file with the text `there`, where `places` are ours already. */
  [[nodiscard]] Result<void> writeAnew(int file, std::string there, std::map<std::string, long> places);

  UniqueFd file_;
  std::string path_;
  std::string text_;                       ///< Of the file, as we have left it.
  std::map<std::string, long> places_;     ///< Of what is armed, where it stands.
  std::multimap<std::string, long> left_;  ///< By URI, where it stands.
};

/** URIs of a list's text; blank lines are left out. Text that ends without a line's end lost nothing: it is a URI too.
 */
[[nodiscard]] std::vector<std::string> armedIn(std::string_view text);

}  // namespace hapticd
