/** @file
 * The recordings of all device groups: who may have one, how it begins and how it ends. docs/recording.md.
 */
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "daemon/device/device_manager.h"
#include "daemon/recorder/recorder.h"
#include "daemon/scene/upload/aside.h"
#include "daemon/session/session_manager.h"

namespace hapticd {

/** Control thread only. */
class Recordings {
 public:
  using Done = std::function<void(const RecordingEnd&)>;

  Recordings(SceneModel& scene, MeshStore& meshes, SessionManager& sessions, bool lock);

  /** The servos have stopped. Gives the readers half a second for the rest. */
  ~Recordings();
  Recordings(const Recordings&) = delete;
  Recordings& operator=(const Recordings&) = delete;

  struct Started {
    std::uint64_t id = 0;
    UniqueFd stream;  ///< To read it from, until its end.
  };
  /**
   * Begins to record the device's group. kPermissionDenied while another user has a session there: a recording holds
   * what every client sends. kAlreadyExists: one a group. kInvalidArgument while a device is armed: the group's cycle
   * starts anew. kWouldBlock where much is deformed for the first time in this instant.
   */
  [[nodiscard]] Result<Started> start(OpenDevice& device, const Client& by, const DeviceManager& devices);
  /**
   * Whether start() keeps nobody waiting: where much has been deformed there, a thread first makes copies of it, into
   * which start() then only has to put what has moved. One group at a time.
   */
  [[nodiscard]] bool ready(OpenDevice& device, const Client& by);
  /** That thread. */
  [[nodiscard]] Aside& copies() { return copies_; }
  /** `done` is called once, from poll(), when all is written, whoever else asked. Unknown ids are done at once. */
  void stop(std::uint64_t id, Done done);
  /** Nobody reads it any more. Where there is no memory to end it a later poll() does. */
  void drop(std::uint64_t id) noexcept;
  /** Whoever is dropped from now on has not left, but is left. */
  void daemonStops() { stopping_ = true; }

  /** A session of that user is about to open there: ends a recording that may not see it. */
  void sessionOpens(const GroupLink& link, std::uint32_t uid);
  /** The group's servo has gone. */
  void groupClosed(const GroupLink& link);
  /** Moves recordings to their end. Call every few milliseconds. */
  void poll();

  [[nodiscard]] std::uint64_t bytesOf(std::uint32_t uid) const;
  [[nodiscard]] std::size_t size() const { return all_.size(); }
  /** Whether that group is recorded. */
  [[nodiscard]] bool of(const GroupLink& link) const;
  /** Whether a recording of that group is coming to its end: soon there is room for another. */
  [[nodiscard]] bool ends(const GroupLink& link) const;

 private:
  struct Recording {
    std::unique_ptr<Recorder> recorder;
    GroupLink* link = nullptr;  ///< Null when it has gone.
    Client by;
    std::string reason;              ///< Why it ends; empty while it goes on.
    std::uint64_t let_go_after = 0;  ///< Servo cycles by when it surely has let go of the log.
    std::int64_t ending_since_ns = 0;
    bool dropped = false;
    std::vector<Done> done;
  };

  void endRecording(Recording& recording, const std::string& reason);
  void endDropped(Recording& recording);
  [[nodiscard]] static bool letGo(const Recording& recording);
  /** All is written, and the servo has let go: only its client's handle is still there. */
  [[nodiscard]] static bool isOver(const Recording& recording);
  void published(CommandSink& sink, const PublishedMesh& mesh);
  /** Of the mesh as it was built; one that is ready, else made now. */
  [[nodiscard]] std::vector<std::byte> copyAsBuilt(const PublishedMesh& mesh, std::span<const std::byte> bytes);
  void forgetCopies();
  Result<void> mayRecord(const OpenDevice& device, const Client& by) const;

  SceneModel& scene_;
  MeshStore& meshes_;
  SessionManager& sessions_;
  bool lock_;
  bool stopping_ = false;
  MonotonicClock clock_;
  std::map<std::uint64_t, Recording> all_;
  std::uint64_t next_ = 1;

  /** As built, by the number of its file. */
  using Copies = std::map<std::uint64_t, std::vector<std::byte>>;
  const GroupLink* copies_for_ = nullptr;  ///< Whose copies are made, or ready.
  std::int64_t copied_ns_ = 0;             ///< Since when they are ready; 0: they are not.
  bool copies_failed_ = false;             ///< For want of something.
  Copies made_;
  Aside copies_;  // last: its thread ends first
};

}  // namespace hapticd
