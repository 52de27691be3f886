/** @file
 * The control thread's whole state and every rule of who may do what, without the socket: stepped by hand in tests, by
 * the event loop in the daemon.
 */
#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/armed/armed_list.h"
#include "daemon/config/config.h"
#include "daemon/control/clients.h"
#include "daemon/device/device_manager.h"
#include "daemon/device/wanted_groups.h"
#include "daemon/event/event_hub.h"
#include "daemon/log/log.h"
#include "daemon/recorder/recordings.h"
#include "daemon/scene/mesh/mesh_store.h"
#include "daemon/scene/scene_model.h"
#include "daemon/scene/upload/uploads.h"
#include "daemon/session/session_manager.h"
#include "rt/guard/guard.h"

namespace hapticd {

/** What the process knows of itself; for status and doctor. */
struct ProcessFacts {
  std::string config_file;  ///< Its whole path; empty: the embedded default.
  std::string control_socket, admin_socket;
  bool memory_locked = false;
  std::string memory_note;  ///< Why not.
  bool cpu_latency_held = false;
  std::string cpu_latency_note;
};

struct CoreOptions {
  Config config;
  bool threads = true;            ///< False: groups are stepped by hand.
  bool devices_required = false;  ///< One that does not open is an error, not missing.
  std::uint64_t epoch = 0;        ///< Random, never 0.
};

/** How long a device stays listed as armed after it has been switched off: its driver's own thread may be a bit behind.
 */
inline constexpr std::int64_t kListedAfterDisarm_ns = 100'000'000;

/** Since its last session ended: by then every servo that lives has faded its share and lowered the force to zero. */
inline constexpr std::int64_t kLowered_ns = static_cast<std::int64_t>(2e9 * Guard::kLower_s);

/** What a client asks of a tool. */
struct ToolWish {
  std::string object;
  double mass = 0.1;     ///< [kg]
  double stiffness = 0;  ///< Of the coupling, felt in the end [N/m]; 0: the stiffest that is passive.
  bool weighs = false;   ///< The hand carries it where the world has gravity; else its weight is taken off.
  bool direct = false;   ///< No coupling: overlap pushes at the device (rt/body/direct.h).
};

/** Control thread only. */
class Core {
 public:
  static constexpr std::int64_t kArmAnswerNs = 1'000'000'000;
  static constexpr std::int64_t kRoomNs = 500'000'000;
  static constexpr std::int64_t kOffTaken_ns = 100'000'000;  ///< A servo that lives has taken stop and disarm by then.
  static constexpr std::size_t kWishes = 64;  ///< Sessions, or recordings, that may wait; more are refused at once.

  Core(const CoreOptions& options, Clock& clock);
  ~Core();
  Core(const Core&) = delete;
  Core& operator=(const Core&) = delete;

  /**
   * Opens the configured groups and waits until each has had its attempt, WantedGroups::kPatience_ns at most, or until
   * `go_on` says no; what is missing then is tried again by poll(). Errors: of the configuration; kNoRealtime; of a
   * device only where devices are required.
   */
  [[nodiscard]] Result<void> openConfigured(const std::function<bool()>& go_on = {});
  /** Read by every servo; a Panel writes them. */
  [[nodiscard]] SafetyLines& lines() { return lines_; }
  /** Keeps the list of armed devices from now on. Before the first arm(). */
  void keepArmed(ArmedList list) { armed_ = std::move(list); }
  [[nodiscard]] ArmedList& armedList() { return armed_; }
  /**
   * Moves everything on; never blocks. Call every few milliseconds, at once again after busy(). What fails, as for want
   * of memory, keeps nothing else from it, and is thrown in the end.
   */
  void poll();
  /** Orders wait for a servo that has no room at the moment. */
  [[nodiscard]] bool busy() const { return busy_; }
  /** Disarms every device; none can be armed from now on. */
  void beginShutdown();
  /** Nothing that a hand feels is on its way any more, or `since_ns` is half a second ago. */
  [[nodiscard]] bool quiet(std::int64_t since_ns);
  /** The end of every servo; as DeviceManager::closeAll(). No poll() after it. */
  std::vector<std::string> closeAll();
  /** The machine goes to sleep: stops what is armed; nothing can be armed until it is awake again. */
  void setAsleep(bool asleep);
  /** No device is energised, nor was one kListedAfterDisarm_ns ago. */
  [[nodiscard]] bool allOff() const { return listed_.empty(); }

  // Connections.
  [[nodiscard]] Clients& clients() { return clients_; }
  /** As Clients::connect(). */
  [[nodiscard]] Result<std::uint64_t> connect(std::int32_t pid, std::uint32_t uid, bool administration) {
    return clients_.connect(pid, uid, administration);
  }
  void introduce(std::uint64_t connection, std::string name);
  [[nodiscard]] const Client& client(std::uint64_t connection) const;
  /** Ends its sessions, removes its objects, gives back what it held; for want of memory some of it by a later poll().
   */
  void disconnect(std::uint64_t connection) noexcept;

  /**
   * What `edit` orders of the servos is that client's: it counts against its share of what waits for each (Outbox), by
   * which edits are refused.
   */
  template <class Edit>
  auto editFor(std::uint64_t connection, Edit&& edit) {
    struct Giver {
      DeviceManager& devices;
      std::uint64_t before;
      ~Giver() { devices.setGiver(before); }
    } const giver{devices_, devices_.setGiver(connection)};
    return edit();
  }

  // Sessions and leases.
  [[nodiscard]] Result<Session*> openSession(std::string_view uri, std::uint64_t connection, const std::string& name,
                                             std::uint16_t major, std::uint16_t minor);
  /** The same without waiting for the device; `done` is called once, now or by a later poll(): where there is no room
   * before a session that has ended is gone, too, kRoomNs later at most. */
  using SessionDone = std::function<void(Result<Session*>)>;
  void openSession(std::string_view uri, std::uint64_t connection, const std::string& name, std::uint16_t major,
                   std::uint16_t minor, SessionDone done);
  [[nodiscard]] Result<void> acquireLease(std::uint64_t session);
  [[nodiscard]] Result<void> releaseLease(std::uint64_t session);
  /** Takes the lease and arms. `done` is called once, when the servo has answered; a refusal leaves the lease as it
   * was.
   */
  void arm(std::uint64_t session, std::function<void(Result<void>)> done);
  [[nodiscard]] Result<void> disarm(std::uint64_t session);
  /** Anybody; an empty URI stops every device. */
  [[nodiscard]] Result<void> stop(std::string_view uri, std::uint64_t connection);
  [[nodiscard]] Result<GuardLimits> setLimits(std::string_view uri, const GuardLimits& wanted,
                                              std::uint64_t connection);
  /** Of the ball about the device's point [m]. For the lease holder's user, anybody while nobody holds it, and
   * administration. */
  [[nodiscard]] Result<void> setRadius(OpenDevice& device, double radius, const Client& by);
  /** What touches at its point (parseFinger()). Who may: as setRadius. */
  [[nodiscard]] Result<void> setFinger(OpenDevice& device, const SetFinger& finger, const Client& by);
  /** Where it stands in the world. Who may: as setRadius. kWouldBlock while it is armed or its force is being lowered:
   * its hand is elsewhere at once. */
  [[nodiscard]] Result<void> setMount(OpenDevice& device, const Pose& X_WD, const Client& by);
  /** How many metres of the world one of the hand is. As setMount(). A tool is held anew, as stiff as it may be there.
   */
  [[nodiscard]] Result<void> setScale(OpenDevice& device, double scale, const Client& by);
  /** Takes the hand off its point in the world, or lets it come back; `button` does it, too, while pressed (1 is the
   * first, 0 none). Who may: as setRadius. It ends with the lease. */
  [[nodiscard]] Result<void> setClutch(OpenDevice& device, bool held, std::uint32_t button, const Client& by);
  /** Puts an object into the device's hand, in place of what it holds. Who may: as setRadius. Refused for planes,
   * groups, children, deformable meshes and what another hand holds. */
  [[nodiscard]] Result<void> attachTool(OpenDevice& device, const ToolWish& wish, const Client& by);
  /** SceneModel::setShape(), but what is in a hand keeps a shape that can be held, and is held anew as it now is. */
  [[nodiscard]] Result<void> setShape(std::string_view name, const ShapeSpec& shape);
  /** As SceneModel's, but kWouldBlock while it is in a hand, which alone says where it is. */
  [[nodiscard]] Result<void> setPose(std::string_view name, const Pose& X_PO);
  [[nodiscard]] Result<void> setVelocity(std::string_view name, const Twist& V_PO);
  [[nodiscard]] Result<void> detachTool(OpenDevice& device, const Client& by);
  /** A spring [N/rad] that opens the gripper where it is closed further than `width` [rad]. Who may: as setRadius.
   * kUnsupported without a gripper that can push. */
  [[nodiscard]] Result<void> setGrip(OpenDevice& device, double stiffness, double width, const Client& by);
  /** At no client's wish: it stays. */
  [[nodiscard]] Result<OpenDevice*> openDevice(std::string_view uri);
  /**
   * The same for a client. How a real device is driven (firmware, scale of its motors) is the administrator's: a URI
   * with parameters of a device that is not open yet is kPermissionDenied but on the administration socket.
   */
  [[nodiscard]] Result<OpenDevice*> openDevice(std::string_view uri, std::uint64_t connection);
  /** The same without waiting for the device; `done` is called once, now or by a later poll(). */
  void openDevice(std::string_view uri, std::uint64_t connection, DeviceManager::Done done);
  /**
   * Administration; and a client that alone has asked for it, of no hardware and not configured. kDeviceBusy while a
   * session uses a device of its group, kWouldBlock while the force of one is still being lowered; the administrator is
   * held up by the latter for kLowered_ns at most, for a servo that stands still lowers nothing. What only clients that
   * have left had asked for closes by itself, in poll(), once nothing uses it.
   */
  [[nodiscard]] Result<void> closeDevice(std::string_view uri, std::uint64_t connection);
  /**
   * Attempts what is kWouldBlock while the force of a device is being lowered, for it was disarmed or stopped or its
   * session has ended: now and, as long as that is so, in each poll(), kLowered_ns at most, one after the other for
   * each connection. `done` hears the last answer; that of a connection which has left is kTimeout, without another
   * attempt.
   */
  void onceLowered(std::uint64_t connection, std::function<Result<void>()> attempt,
                   std::function<void(const Result<void>&)> done);

  /** Records the device's group; Recordings says who may. */
  [[nodiscard]] Result<Recordings::Started> record(std::string_view uri, std::uint64_t connection);
  /**
   * The same; `done` is called once, now or by a later poll(): where a recording that ends is in the way, when it is
   * over, and where much is deformed, when it has been copied, kRoomNs later at most; where the force of a device that
   * was disarmed is still being lowered, when it is down, kLowered_ns later at most.
   */
  using RecordDone = std::function<void(Result<Recordings::Started>)>;
  void record(std::string_view uri, std::uint64_t connection, RecordDone done);

  /** kQuotaExceeded if that user may not have so many more bytes and triangles. */
  [[nodiscard]] Result<void> checkQuota(std::uint32_t uid, std::uint64_t bytes, std::uint64_t triangles) const;
  [[nodiscard]] std::uint64_t bytesOf(std::uint32_t uid) const;
  [[nodiscard]] std::uint64_t lockedBytes() const;

  [[nodiscard]] DeviceManager& devices() { return devices_; }
  [[nodiscard]] const WantedGroups& wanted() const { return wanted_; }
  [[nodiscard]] SceneModel& scene() { return scene_; }
  [[nodiscard]] MeshStore& meshes() { return meshes_; }
  [[nodiscard]] Uploads& uploads() { return uploads_; }
  [[nodiscard]] SessionManager& sessions() { return sessions_; }
  [[nodiscard]] Recordings& recordings() { return recordings_; }
  [[nodiscard]] EventHub& events() { return events_; }
  [[nodiscard]] const Config& config() const { return options_.config; }
  [[nodiscard]] ProcessFacts& facts() { return facts_; }
  [[nodiscard]] std::uint64_t epoch() const { return options_.epoch; }
  [[nodiscard]] std::int64_t now() { return clock_.now(); }
  [[nodiscard]] std::int64_t started() const { return started_ns_; }

  /** As EventHub::publish(). */
  void publish(EventKind kind, std::string_view device, std::string_view text = {}, std::uint64_t session = 0) noexcept;

 private:
  struct PendingArm {
    std::uint64_t session;
    std::uint64_t ticket;
    std::int64_t since_ns;
    bool took_lease;  ///< For this: it is given back where the device is not armed.
    std::function<void(Result<void>)> done;
  };
  /** A session that waits for room. */
  struct Wish {
    std::string uri;
    std::uint64_t connection;
    std::string name;
    std::int64_t until_ns;
    SessionDone done;
  };
  /** A device on the list of armed ones. */
  struct Listed {
    std::string uri;
    std::uint64_t ticket;     ///< Of the last arm order.
    std::int64_t off_ns = 0;  ///< Since when it is seen switched off; 0: it is not.
  };

  /** Whether forces reach it, or will by an order that is on its way. */
  [[nodiscard]] bool mayBeArmed(const OpenDevice& device) const;
  [[nodiscard]] Result<void> mayBeSetUp(const OpenDevice& device, const std::string& where, const Client& by);
  /** Whether that client may have a device of that URI opened. */
  [[nodiscard]] Result<std::string> mayOpen(std::string_view uri, std::uint64_t connection);
  [[nodiscard]] Result<OpenDevice*> openNow(std::string_view uri, const std::string& within = {},
                                            const DeviceManager::Admission& admission = {});
  [[nodiscard]] DeviceManager::Admission admissionFor(const Client& by) const;
  [[nodiscard]] std::uint64_t heldBytesOf(std::uint32_t uid) const;
  void noteAsker(OpenDevice& device, const Client& by) const;
  /** Whom a device that was asked for is charged to, unless it is free; or null. */
  [[nodiscard]] const Client* payerOf(const OpenDevice& device) const;
  [[nodiscard]] bool mayClose(const OpenDevice& device, std::uint64_t connection) const;
  [[nodiscard]] bool unused(const OpenDevice& device) const;
  /** Why the devices of that group must not close yet. */
  [[nodiscard]] Result<void> mayGo(const GroupLink& link, bool administration);
  /** Disarmed, and what was last sent to it is zero. */
  [[nodiscard]] static bool powerless(const OpenDevice& device);
  /** Switched off, and not known to be powerless yet. */
  [[nodiscard]] bool isLowered(const OpenDevice& device) const;
  Result<void> closeGroupOf(OpenDevice& device);
  void closeUnused();
  [[nodiscard]] Result<Session*> sessionOn(OpenDevice& device, std::uint64_t connection, const std::string& name);
  /** Whether that client may change how a device feels. */
  Result<void> mayChange(const OpenDevice& device, const Client& by);
  /** The lease is free, or this session's own. */
  [[nodiscard]] Result<void> mayHoldLease(std::uint64_t session);
  [[nodiscard]] Result<void> mayArm(OpenDevice& device) const;
  Result<Session*> leaseHolder(std::uint64_t id, const char* to_do);
  void hold(OpenDevice& device, const ToolWish& wish, const ObjectNow& object);
  void holdAnew(OpenDevice& device);
  [[nodiscard]] Result<void> notInHand(std::string_view name, const char* where);
  void tellTool(const std::string& device, const std::string& object, const std::string& what);
  void putAway(const std::string& device, const HeldObject& held);
  [[nodiscard]] Result<void> mayRunServos() const;
  void switchOff(OpenDevice& device, CommandKind kind) noexcept;
  void pollOffs();
  void bypass(OpenDevice& device) noexcept;
  void loseLease(OpenDevice& device, std::string_view why) noexcept;
  struct RecordWish {
    std::string uri;
    std::uint64_t connection;
    std::int64_t since_ns;
    std::int64_t free_ns;  ///< When nothing of its group was armed: from then on it has kRoomNs.
    RecordDone done;
  };
  struct LoweredWish {
    std::uint64_t connection;
    std::int64_t since_ns;
    std::function<Result<void>()> attempt;
    std::function<void(const Result<void>&)> done;
  };
  void fulfil(Wish wish);
  void fulfil(RecordWish wish);
  void fulfil(LoweredWish wish);
  void pollWishes();
  void pollArms();
  /** True when it is answered. `others` wait, too, in their order. */
  bool settle(PendingArm& arm, std::list<PendingArm>& others);
  void refuse(PendingArm& arm) noexcept;
  void pollListed();
  void pollDisarmed();
  /** Of a device that is closed: nothing is on its way to it any more. */
  void tellDisarmed(const std::string& name) noexcept;
  void pollLeft();
  void leave(Client& client);
  void forgetDisarmed(const std::string& name);
  void drain(GroupLink& link);
  void translate(GroupLink& link, const ServoEvent& event);
  void tellMissed(const GroupLink& link, bool last = false);
  void refusedByServo(const std::string& device, const ServoEvent& event, Session* session);
  /** Tells subscribers that something which a client has pushed was refused. */
  void tellRefused(const Session& session, ErrorCode code, const std::string& what, const std::string& object);

  CoreOptions options_;
  Clock& clock_;
  ProcessFacts facts_;
  std::int64_t started_ns_;
  EventHub events_;
  MeshStore meshes_;
  SceneModel scene_;
  SessionManager sessions_;
  Uploads uploads_;
  Recordings recordings_;
  SafetyLines lines_;
  ArmedList armed_;  // before devices_: emptied when they are closed
  std::vector<Listed> listed_;
  std::vector<Event> disarmed_;  ///< To be told when the driver has sent the zeros.
  DeviceManager devices_;        // last: its servos stop before what they read goes
  WantedGroups wanted_;
  Clients clients_;
  // Lists: what waits on goes back without memory.
  std::list<PendingArm> arms_;
  std::list<Wish> wishes_;
  std::list<RecordWish> record_wishes_;
  std::list<LoweredWish> lowered_wishes_;
  std::map<const GroupLink*, std::uint64_t> events_dropped_;
  /** Periods that a servo has missed and nobody was told of yet. */
  struct Missed {
    log::RateLimit told{1'000'000'000, 5};
    std::uint64_t periods = 0;
    ServoEvent last{};
  };
  std::map<const GroupLink*, Missed> missed_;
  log::RateLimit refused_log_{1'000'000'000, 5};
  log::RateLimit overrun_log_{10'000'000'000, 1};
  log::RateLimit stopped_log_{1'000'000'000, 2 * kMaxGroups* kMaxDevices};  ///< All at once, twice.
  log::RateLimit bypassed_log_{1'000'000'000, 5};
  bool busy_ = false;
  bool asleep_ = false;
  bool stopping_ = false;
};

/** "emergency stop", "the hand moved faster than the limit", ... for hd_fault. */
[[nodiscard]] const char* faultText(std::uint32_t fault) noexcept;

}  // namespace hapticd
