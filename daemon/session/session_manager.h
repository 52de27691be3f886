/** @file
 * The sessions of all clients, stepped through their lives without ever waiting for a client or a servo.
 */
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/session/session.h"

namespace hapticd {

/** Control thread only. */
class SessionManager {
 public:
  static constexpr std::int64_t kHandshakeNs = 5'000'000'000;  ///< Longest from the offer to mapped().

  struct Options {
    std::uint64_t epoch = 0;
    std::uint32_t per_user = 8;
    bool must_lock = true;
  };

  /** What the owner is told. */
  struct Hooks {
    std::function<void(Session&)> ending;  ///< The client is gone; its lease is to be taken back. Must not throw.
    std::function<Result<void>(std::uint32_t uid, std::uint64_t bytes)> quota;
    std::function<void(const Session&, ErrorCode, const std::string& what)> refused;  ///< Something that it pushed.
  };

  SessionManager(const Options& options, Hooks hooks) : options_(options), hooks_(std::move(hooks)) {}
  ~SessionManager();

  /** Offers the regions of a new session. The client then maps them and calls mapped() within kHandshakeNs. */
  [[nodiscard]] Result<Session*> open(OpenDevice& device, const Client& client, std::int64_t now_ns);
  [[nodiscard]] Result<void> mapped(std::uint64_t id);
  /** The client is gone or is to go. Unknown ids are ignored. Where there is no memory it ends all the same. */
  void end(std::uint64_t id, std::string_view why) noexcept;
  void endAllOf(std::uint64_t connection, std::string_view why) noexcept;

  /** Steps every session: reports of ingest, time-outs, fades, freeing. Call every few milliseconds. */
  void poll(std::int64_t now_ns);
  /** One report of a group's ingest. */
  void report(GroupLink& link, const IngestReport& report);

  /** Still in use by its client, or null. */
  [[nodiscard]] Session* find(std::uint64_t id);
  /** Whether a client still has a session on it; one that has ended and only fades does not count. */
  [[nodiscard]] bool inUse(const OpenDevice& device) const;
  /**
   * Takes the sessions of a group that have ended but whose servo does not let them go. The servo may still write
   * their regions: drop them once its threads are joined.
   */
  using Ended = std::vector<std::unique_ptr<Session>>;
  [[nodiscard]] Ended takeEnded(const GroupLink& link);
  [[nodiscard]] Session* bySlot(const GroupLink& link, std::uint32_t slot);
  /** Sessions in any state, by rising id. */
  [[nodiscard]] std::vector<Session*> all() const;
  [[nodiscard]] std::uint64_t bytesOf(std::uint32_t uid) const;
  [[nodiscard]] std::uint64_t bytes() const;
  [[nodiscard]] std::uint32_t countOf(std::uint32_t uid) const;
  /** Whether a session of that user, or on that group, has ended and is not gone yet. */
  [[nodiscard]] bool anyEnds(std::uint32_t uid, const GroupLink& link) const;
  [[nodiscard]] bool empty() const { return sessions_.empty(); }

 private:
  /** True when the session is over and its memory can go. */
  bool step(Session& session, std::int64_t now_ns);
  /** Orders the servo to give its slot back. */
  static void postFree(Session& session);

  Options options_;
  Hooks hooks_;
  std::map<std::uint64_t, std::unique_ptr<Session>> sessions_;
  std::uint64_t next_id_ = 1;
};

}  // namespace hapticd
