/** @file
 * The devices the daemon has open, each with its short name, its limits and its lease.
 */
#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/device/device_closer.h"
#include "daemon/device/device_opener.h"
#include "daemon/device/group_link.h"
#include "daemon/scene/scene_model.h"
#include "daemon/scene/upload/aside.h"
#include "drivers/registry.h"
#include "rt/cycle/mount.h"

namespace hapticd {

/** The tool in a device's hand. */
struct HeldObject {
  std::string object;  ///< Name, empty: none.
  std::uint32_t id = 0;
  double mass = 0;              ///< [kg]
  double stiffness = 0;         ///< Of the coupling in the end [N/m].
  double wished_stiffness = 0;  ///< As ToolWish says it [N/m].
  bool shows_torque = false;
  bool weighs = false;
  bool direct = false;
  std::string note;  ///< What it cannot do, and the remedy; may be empty.
};

/** The spring on a device's gripper axis. */
struct Grip {
  double stiffness = 0;  ///< [N/rad]
  double width = 0;      ///< [rad]
};

/** A device in use. */
struct OpenDevice {
  std::string name;  ///< Short, unique in this daemon.
  GroupLink* link = nullptr;
  std::uint32_t index = 0;          ///< In the group.
  GuardLimits limits;               ///< In force.
  GuardLimits maxima;               ///< The device's own.
  double radius = 0;                ///< Of the ball about its point [m].
  Mount mount;                      ///< Where it stands in the world, and how large.
  bool clutch_held = false;         ///< By a client's word; a button may hold it, too.
  std::uint32_t clutch_button = 0;  ///< That holds it while pressed: 1 is the first, 0 none.
  HeldObject tool;
  Grip grip;
  SetFinger finger{};                 ///< What touches at its point; law 0: a point or ball.
  std::uint64_t lease = 0;            ///< Session that holds it, 0 if free.
  std::uint32_t sessions = 0;         ///< Sessions on it, those included that fade.
  std::int64_t left_ns = 0;           ///< When a session on it last ended.
  std::int64_t bypassed_ns = 0;       ///< Since when the order to switch it off waited for which it was made safe.
  std::vector<std::string> aliases;   ///< Other texts by which it was opened.
  bool asked_for = false;             ///< Open because somebody asked, not by the configuration.
  bool kept = false;                  ///< An administrator has asked for it: it stays when those who asked have left.
  bool free = false;                  ///< Nobody is charged for what it holds: an administrator had it first.
  std::vector<std::uint64_t> askers;  ///< Connections that have asked for it and are still there.

  /** As a device that can do that. */
  void wear(const SetFinger& wanted, const DeviceInfo& able) {
    finger = wanted;
    finger.device = index;
    finger.shows_moment = able.actuated_rotation && able.max_torque > 0 ? 1 : 0;
  }
  /** Tells the servo. */
  void applyRadius() const {
    (void)link->post(makeCommand(CommandKind::kDeviceRadius, DeviceRadius{index, 0, radius}));
  }
  /** Tells the servo. */
  void applyFinger() const { (void)link->post(makeCommand(CommandKind::kSetFinger, finger)); }
  /** Tells the servo of the scale alone: a clutch may have moved the place since it was last told of here. */
  void applyScale() const {
    SetMount order = mount.order(index);
    order.keeps_place = 1;
    (void)link->post(makeCommand(CommandKind::kSetMount, order));
  }
  /** Tells the servo. */
  void applyMount() const { (void)link->post(makeCommand(CommandKind::kSetMount, mount.order(index))); }
  /** Tells the servo. */
  void applyClutch() const {
    (void)link->post(
        makeCommand(CommandKind::kSetClutch, SetClutch{index, clutch_held ? 1u : 0u, clutch_button, 0, {}}));
  }
  /** If a client's word holds it; tells the servo. */
  void releaseClutch() {
    if (!clutch_held) return;
    clutch_held = false;
    try {
      applyClutch();
    } catch (const std::bad_alloc&) {
      clutch_held = true;
      throw;
    }
  }
  [[nodiscard]] const DeviceInfo& info() const { return link->group().device(index).info(); }
  [[nodiscard]] const Device& device() const { return link->group().device(index); }
};

/** Control thread only. */
class DeviceManager {
 public:
  /** Makes a device of a URI or serial; tests put their own here. */
  using Factory = std::function<Result<std::unique_ptr<Device>>(std::string_view)>;
  /** What is attached. */
  using Finder = std::function<std::vector<DeviceFound>()>;

  DeviceManager(const Config& config, Clock& clock, MeshStore& meshes, SceneModel& scene, bool threads);
  ~DeviceManager();
  void setFactory(Factory factory) {
    setFactory([make = std::move(factory)](std::string_view uri, const std::string&) { return make(uri); });
  }
  /** As makeDevice(). */
  using Maker = std::function<Result<std::unique_ptr<Device>>(std::string_view uri, const std::string& within)>;
  void setFactory(Maker maker) {
    make_ = std::move(maker);
    choose_ = {};
  }
  /** As chooseDevice(). Without one the factory knows of itself what is meant. */
  using Chooser = std::function<Result<std::string>(std::string_view, const std::vector<DeviceFound>&)>;
  void setChooser(Chooser chooser) { choose_ = std::move(chooser); }
  void setFinder(Finder finder) { find_ = std::move(finder); }
  [[nodiscard]] Result<std::unique_ptr<Device>> make(std::string_view uri) const { return make_(uri, {}); }
  [[nodiscard]] std::vector<DeviceFound> attached() const { return find_(); }
  /**
   * The canonical URI of what a text stands for, if that is known without looking at the buses: a serial number is
   * known from what a look has just told, and of the real device that is being asked for.
   */
  [[nodiscard]] Result<std::string> recognise(std::string_view text) const;
  /** Whether recognise() would know more of serial numbers if somebody had looked. */
  [[nodiscard]] bool hasNotLooked() const { return choose_ && found_ == nullptr; }
  /** Is called for each device that was opened without waiting, before those who wait for it. */
  void onOpened(std::function<void(OpenDevice&)> told) { on_opened_ = std::move(told); }
  /**
   * Is asked before open(uri, done) opens what is not open: which device the text ("": any) stands for, by its
   * canonical URI; the text itself if it has no opinion. It may begin to open that device's group.
   */
  using Advice = std::function<Result<std::string>(const std::string& canonical)>;
  void onAsked(Advice advice) { advice_ = std::move(advice); }
  /** For which connection orders are given from now on, to every servo; 0: for the daemon. Gives the one before. */
  std::uint64_t setGiver(std::uint64_t connection) { return std::exchange(giver_, connection); }
  /** For every group opened from now on. */
  void setLines(SafetyLines& lines) { lines_ = &lines; }

  /** Opens the devices of a group and starts its servo. All or nothing. */
  [[nodiscard]] Result<void> openGroup(const GroupConfig& group);
  /**
   * The same without waiting: `done` is called now or by a later poll(). Groups that are begun before others have ended
   * are opened side by side; whether the devices open or not, it counts (their servo starts, `done` is called) only
   * once `turn` says so, if there is one.
   */
  using GroupDone = std::function<void(Result<void>)>;
  using Turn = std::function<bool()>;
  void openGroup(const GroupConfig& group, GroupDone done, Turn turn = {});
  /** For `done`: which device of the group did not open, as the group names it; empty: it was not one of them. */
  [[nodiscard]] const std::string& culprit() const { return culprit_; }
  /** Whether a device that has opened may be had by whoever asked for it; else it is closed again, and has no servo. */
  using Admission = std::function<Result<void>(const Device&)>;
  /**
   * By URI, serial or name. What is open is answered as it is; else it becomes a group of its own. Waits for it. With
   * `within`, motions that it names must lie in that folder.
   */
  [[nodiscard]] Result<OpenDevice*> open(std::string_view uri, const std::string& within = {},
                                         const Admission& admission = {});
  /**
   * The same without waiting: `done` is called now if there is nothing to wait for, else once by a later poll(). For a
   * serial, or any device, it looks aside for what there is, as found(). Who asks meanwhile for a device that is being
   * opened waits for the same, kMostWaiting at most; it lives if any of them may have it, and each hears whether he
   * may.
   */
  using Done = std::function<void(Result<OpenDevice*>)>;
  void open(std::string_view uri, Done done, const std::string& within = {}, Admission admission = {});
  static constexpr std::size_t kMostWaiting = 256;  ///< As many as there are connections; more are refused at once.
  void poll();
  /** Devices that are being opened. */
  [[nodiscard]] std::size_t opening() const { return opening_.size(); }
  /**
   * Ends the servo of a group that is to be closed; nobody may use it from then on. kTimeout when it does not come back
   * from a device's driver: then safe() was called for its devices, and they stay open.
   */
  [[nodiscard]] Result<void> endServo(GroupLink& link);
  /**
   * Closes the device and those that share its servo. Refused while any of them has a session; as endServo(). A driver
   * that does not return from closing is left to it: the device is no longer here, but cannot be opened again until
   * it has returned; the answer names such devices.
   */
  [[nodiscard]] Result<std::vector<std::string>> close(OpenDevice& device);

  /** Whether it was closed, but its driver has not let go of it. */
  [[nodiscard]] bool isClosing(const std::string& canonical) const { return closer_.has(canonical); }

  /** By short name, URI, serial or the text it was opened by; "" is the first device. kNotFound lists the names. */
  [[nodiscard]] Result<OpenDevice*> find(std::string_view text);
  [[nodiscard]] OpenDevice* at(const GroupLink& link, std::uint32_t index);
  [[nodiscard]] const std::vector<std::unique_ptr<OpenDevice>>& devices() const { return devices_; }
  [[nodiscard]] const std::vector<std::unique_ptr<GroupLink>>& links() const { return links_; }
  [[nodiscard]] std::vector<std::string> names() const;
  /**
   * What is found but not open: looked for aside, for buses take their time, and told by a later poll(). Who asks while
   * somebody looks hears of the next look, together with all who do; kMostWaiting at most wait for looks.
   */
  using Found = std::function<void(const Result<std::vector<DeviceInfo>>&)>;
  void found(Found done);
  [[nodiscard]] bool realtime() const;
  /** Why not, when realtime() is false. */
  [[nodiscard]] std::string schedulingNote() const;

  /**
   * Stops every servo; devices are safe and closed, those too that are being opened. But those of which a driver does
   * not return: they are safe, named, and what their threads may touch stays until this is destroyed, which waits for
   * them.
   */
  std::vector<std::string> closeAll();
  /** Longest wait for a servo, and for a driver that closes: both together within a third of the watchdog's time. */
  static constexpr std::int64_t kEnd_ns = 300'000'000;

 private:
  /** Who waits for a device. */
  struct Asker {
    Done done;
    Admission admission;
    Result<void> may{};
  };
  /** A device that is being opened, and who waits for it. */
  struct Opening {
    std::string canonical;
    std::vector<std::string> texts;  ///< By which it was asked for.
    std::list<Asker> waiting;
  };
  /** A group on its way: its devices are opened one after the other. */
  struct GroupOpening {
    GroupConfig group;
    std::vector<std::unique_ptr<Device>> closed, open;
    std::vector<std::string> canonical;
    GroupDone done;
    Turn turn;
    std::list<Asker> asker;  ///< Who had it begun; none: the configuration.
    bool ended = false;      ///< All are open, or one has failed.
    Result<void> devices;    ///< How.
    std::string culprit;     ///< Which has failed.
  };
  [[nodiscard]] Result<std::vector<std::unique_ptr<Device>>> makeGroup(const GroupConfig& group,
                                                                       const std::string& where,
                                                                       const std::string& within = {});
  [[nodiscard]] Result<void> openGroup(const GroupConfig& group, const std::string& within, const Admission& admission);
  void begin(const GroupConfig& group, std::vector<std::unique_ptr<Device>> made, GroupDone done, Turn turn,
             std::list<Asker> asker = {});
  void openNext(GroupOpening& opening);
  [[nodiscard]] bool readyFor(const GroupOpening& opening);
  void finish(GroupOpening& opening);
  [[nodiscard]] static Result<void> admit(const Device& device, std::list<Asker>& askers);
  void takeOpening(const std::string& canonical, std::list<Opening>& to) noexcept;
  bool waitFor(const std::string& canonical, std::string_view text, Done& done, Admission& admission);
  [[nodiscard]] Result<void> adopt(const GroupConfig& group, std::vector<std::unique_ptr<Device>>& opened);
  [[nodiscard]] Result<void> show(GroupLink& link);
  void tellStart(OpenDevice& device, GroupLink& link) const;
  [[nodiscard]] GroupConfig groupOf(std::string_view uri);
  [[nodiscard]] Result<void> roomForGroup(const std::string& where) const;
  [[nodiscard]] const DeviceConfig* entryOf(const DeviceInfo& info) const;
  /** All but the devices' limits. */
  GroupOptions options(const GroupConfig& group, const std::vector<std::unique_ptr<Device>>& devices) const;
  std::string shortName(const DeviceInfo& info, const std::vector<std::string>& taken) const;
  [[nodiscard]] static Error tooManyWait(const std::string& where, const char* what);
  [[nodiscard]] Result<void> notClosing(const std::string& canonical) const;
  void keepThings(GroupLink& link);
  std::vector<std::string> letGo(GroupLink& link);
  void closeUnused(std::vector<std::unique_ptr<Device>>& devices);
  OpenDevice* lookUp(std::string_view text);

  const Config& config_;
  Clock& clock_;
  MeshStore& meshes_;
  SceneModel& scene_;
  bool threads_;
  Maker make_;
  Finder find_;
  Chooser choose_;
  Advice advice_;
  std::function<void(OpenDevice&)> on_opened_;
  SafetyLines* lines_ = nullptr;
  std::uint64_t giver_ = 0;  // before links_, which look at it
  std::vector<std::unique_ptr<GroupLink>> links_;
  std::vector<std::unique_ptr<OpenDevice>> devices_;
  std::uint32_t next_group_ = 1;
  std::list<Opening> opening_;
  using Looked = std::function<void(const Result<std::vector<DeviceFound>>&)>;
  void look(Looked done);
  void look();
  [[nodiscard]] bool hasLooked(std::int64_t most_ns);
  void openChosen(std::string_view serial, Done done, const std::string& within, Admission admission);
  /** What recognise() knows serial numbers of; until this goes. */
  struct Known {
    Known(DeviceManager& manager, const std::vector<DeviceFound>* found) : of(manager) { of.found_ = found; }
    ~Known() { of.found_ = nullptr; }
    Known(const Known&) = delete;
    Known& operator=(const Known&) = delete;
    DeviceManager& of;
  };
  [[nodiscard]] Result<std::string> advised(const std::string& canonical, const Device* made);
  bool isConfigured(const std::string& canonical, const Device* made, std::string_view text, Done& done,
                    Admission& admission);

  std::list<Looked> ask_, asked_;                    ///< To be told of the next look, and of the one under way.
  const std::vector<DeviceFound>* found_ = nullptr;  ///< While there is a Known.
  bool looking_ = false;
  std::list<GroupOpening> groups_opening_;  ///< In the order in which they were begun; each stays where it is.
  std::string culprit_;
  DeviceCloser closer_;
  DeviceOpener opener_;  // here: its threads end before what they use goes
  Aside finder_;         // last: its thread ends first
};

}  // namespace hapticd
