/** @file
 * A daemon of scripted answers on a socket of its own, for what a real one does not do on command: refuse, dawdle,
 * vanish. It shares the schema and the rings with the library and nothing else.
 */
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "proto/shm_layout.h"

namespace hapticd::test {

/** What the fake shall do; set before start or by FakeDaemon::script(). */
struct Script {
  std::uint16_t protocol_major = 1;
  std::uint64_t epoch = 1;
  bool administration = false;
  std::string device = "sim://one";           ///< What it opens for whatever is no URI.
  bool dawdle = false;                        ///< Never answers listDevices(), nor arm().
  std::uint16_t refuse_arm = 0;               ///< A code for arm().
  std::uint16_t refuse_subscribe = 0;         ///< A code for subscribe().
  std::uint16_t layout_major = HD_SHM_MAJOR;  ///< Written to the regions.
  int still_mapped = 0;                       ///< So many commits are refused as still mapped.
  std::string bad_mesh;                       ///< If not empty, commits are refused with it.
  std::vector<float> progress;                ///< Reported by each commit.
  bool never_build = false;                   ///< Commits do not end.
};

/** What the fake has seen. */
struct Seen {
  std::vector<std::string> calls;
  std::string client_name;
  std::vector<std::byte> upload;  ///< As committed.
  int cancelled_uploads = 0;
  int open_sessions = 0;
  int subscriptions = 0;
  std::uint32_t kinds = 0;
};

/** Serves from a thread of its own until it is destroyed. */
class FakeDaemon {
 public:
  explicit FakeDaemon(std::string path, Script script = {});
  ~FakeDaemon();

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] Seen seen();
  void script(const std::function<void(Script&)>& change);
  /** The regions of the session opened last. Null before. */
  hd_region_a* regionA();
  hd_region_b* regionB();
  /** Sends events of these values to every subscriber, `lost` before them. Returns when they were taken. */
  void send(const std::vector<std::uint32_t>& values, std::uint64_t lost = 0);

  struct Inside;

 private:
  std::string path_;
  std::unique_ptr<Inside> inside_;
};

}  // namespace hapticd::test
