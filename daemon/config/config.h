/** @file
 * The configuration: a TOML file (systemd/hapticd.toml is the complete, commented default) into plain values.
 *
 * A value the file does not name keeps the default below. Unknown keys, wrong types and values out of range are refused
 * with file, line and column; nothing of a refused file is used. Names end in their unit when it is not SI-base.
 */
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/log/log.h"
#include "rt/base/error.h"

namespace hapticd {

/** Bounds for one device; as GuardLimits. The device's own maxima bind as well, whichever is lower. */
struct LimitsConfig {
  /** What may be said, here and while it runs. */
  struct Range {
    double least, most;
  };
  static constexpr Range kForce{0, 200}, kTorque{0, 50}, kGripperForce{0, 200};  ///< [N], [N m], [N]
  /** A force that may hardly fall stays with the hand, whatever it has come from. */
  static constexpr Range kForceSlew{1, 1e6}, kTorqueSlew{0.1, 1e6};  ///< [N/s], [N m/s]
  static constexpr Range kVelocity{0.01, 50}, kPower{0, 1000};       ///< [m/s], [W]

  double force_n = 10.0;
  double torque_nm = 0.5;
  double gripper_force_n = 8.0;
  double force_slew_n_per_s = 5000.0;
  double torque_slew_nm_per_s = 250.0;
  double velocity_m_per_s = 3.0;  ///< Above it the guard latches.
  double power_w = 20.0;
  double active_power_w = 5.0;

  bool operator==(const LimitsConfig&) const = default;
};

/** Devices that share one servo. */
struct GroupConfig {
  static constexpr std::size_t kMost = 8;  ///< Groups of one daemon.

  std::string name;
  std::vector<std::string> devices;  ///< URIs or serials. An empty one: first real device, else the simulator.
  double rate_hz = 0;                ///< 0: as servo.rate_hz.
  std::vector<std::uint32_t> cpus;   ///< Where its servo runs; empty: anywhere.

  bool operator==(const GroupConfig&) const = default;
};

/** What holds for the device of one URI or serial. */
struct DeviceConfig {
  static constexpr double kMostRadius = 0.1;    ///< [m]
  static constexpr double kMostDistance = 100;  ///< From the world's origin, by axis [m].
  static constexpr double kLeastScale = 0.01, kMostScale = 100;

  std::string uri;
  LimitsConfig limits;
  double radius_m = 0;  ///< Of the ball about its point that touches when the daemon starts; 0: a point.
  /** Where it stands when the daemon starts: place [m], and turns about the world's x, then y, then z [deg]. */
  std::vector<double> mount_m = {0, 0, 0}, mount_deg = {0, 0, 0};
  double scale = 1;                 ///< Metres of the world for one of the hand, when the daemon starts.
  std::uint32_t clutch_button = 0;  ///< Takes the hand off its point while pressed; 1 is the first, 0 none does.
  std::string finger;               ///< What touches, in the words of parseFinger(); empty: a point or ball.

  bool operator==(const DeviceConfig&) const = default;
};

/** One GPIO line of the panel; daemon/panel says what each role does. */
struct LineConfig {
  std::string role;  ///< stop, deadman, home, enable, heartbeat or led.
  std::string chip;  ///< Name, label or path; empty: whichever has a line of that name.
  std::string name;
  bool active_low = false;
  std::string bias = "as-is";  ///< as-is, pull-up, pull-down or none.
  double debounce_ms = 1;

  bool operator==(const LineConfig&) const = default;
};

struct Config {
  struct Log {
    log::Level level = log::Level::kInfo;
    bool operator==(const Log&) const = default;
  } log;

  struct Sockets {
    std::string control;        ///< Empty: $XDG_RUNTIME_DIR/hapticd/control.sock, or /run/hapticd/ for a service.
    std::string admin;          ///< Empty: admin.sock beside it.
    std::string group;          ///< Group of the control socket; empty: as it is.
    std::uint32_t mode = 0660;  ///< Of the control socket.
    std::uint32_t admin_mode = 0600;
    bool operator==(const Sockets&) const = default;
  } sockets;

  struct Servo {
    double rate_hz = 1000.0;  ///< 1000 to 4000.
    std::uint32_t servo_priority = 80;
    std::uint32_t ingest_priority = 70;
    std::uint32_t gpio_priority = 85;
    bool allow_no_rt = false;  ///< Run without real-time scheduling; every status then says so.
    bool lock_memory = true;
    bool hold_cpu_latency = true;     ///< Keep /dev/cpu_dma_latency open at 0.
    std::uint32_t missed_limit = 50;  ///< Periods missed at once that latch a fault.
    bool operator==(const Servo&) const = default;
  } servo;

  struct Guard {
    double arm_ramp_ms = 2000.0;
    double small_force_n = 0.2;  ///< The ramp starts once the force asked for is below this ...
    std::uint32_t small_force_ticks = 4;
    double device_stale_ms = 20.0;  ///< Device silent for so long: fault.
    bool passivity = true;
    double motor_heating_s = 30.0;  ///< Time constant of the motors' heating; 0: no estimate.
    bool operator==(const Guard&) const = default;
  } guard;

  LimitsConfig limits;  ///< Of every device that has no entry of its own.

  struct Sessions {
    double loss_fade_ms = 50.0;          ///< A lost client's force is gone after this.
    double stale_after_ms = 200.0;       ///< Heartbeat older than this: the client counts as lost.
    std::uint32_t budget_per_tick = 16;  ///< Commands taken from one client per tick.
    double max_ahead_s = 10.0;           ///< Commands for a tick further ahead are refused.
    std::uint32_t event_buffer = 1024;   ///< Events kept for a slow listener before some are lost.
    bool operator==(const Sessions&) const = default;
  } sessions;

  /** What one user may have at a time. Root and the daemon's own user have the same. */
  struct Quotas {
    std::uint32_t sessions = 8;
    double memory_mb = 256.0;  ///< Locked for sessions, uploads and meshes [10^6 bytes].
    std::uint32_t objects = 128;
    std::uint32_t triangles = 4'000'000;
    bool operator==(const Quotas&) const = default;
  } quotas;

  struct Builder {
    std::string program;  ///< Empty: found beside hapticd or in its libexec directory.
    double memory_mb = 2048.0;
    double timeout_s = 60.0;
    std::string cache;         ///< Where built volumes are kept; empty: in systemd's state directory, if it gave one.
    double cache_mb = 4096.0;  ///< Most on disk [10^6 bytes]; 0: none is kept.
    bool vdb = true;           ///< Each as an OpenVDB file too, if hapticd-builder-vdb is there.
    bool operator==(const Builder&) const = default;
  } builder;

  /** Recorded motions: replay://, and sim:// with motion=csv. */
  struct Motions {
    std::string folder;  ///< What lies in it every client may name; empty: none but the administrator's.
    bool operator==(const Motions&) const = default;
  } motions;

  std::vector<GroupConfig> groups;    ///< Empty: one group "default" of one device, found by itself.
  std::vector<DeviceConfig> devices;  ///< What holds for particular devices.

  std::vector<LineConfig> lines;  ///< Of the panel.

  /** Groups as they are to be opened: never empty, rate_hz filled in. */
  [[nodiscard]] std::vector<GroupConfig> effectiveGroups() const;
  /** The entry of a device known by its URI and serial; null: there is none. */
  [[nodiscard]] const DeviceConfig* entryOf(std::string_view uri, std::string_view serial) const;

  bool operator==(const Config&) const = default;
};

/** kInvalidArgument with "`name`:line:column" and, for an unknown key, the nearest known one. Never throws. Fuzzed. */
[[nodiscard]] Result<Config> parseConfig(std::string_view toml, std::string_view name);

/**
 * "`name`:line:column" of a value in a text that parseConfig() took; `name` if it does not stand there. Of an array of
 * tables, such as [[group]], in the one with that index.
 */
[[nodiscard]] std::string placeInConfig(std::string_view toml, std::string_view name, const char* section,
                                        const char* key, std::size_t entry = 0);

/** Every value, as TOML that parseConfig() reads back to an equal Config. */
[[nodiscard]] std::string toToml(const Config& config);

/** A configuration and where it came from. */
struct LoadedConfig {
  Config config;
  std::string file;  ///< Empty: the embedded default.
  std::string text;  ///< Of the file.

  /** Where a value stands in the file, as placeInConfig(); empty: there is no file. */
  [[nodiscard]] std::string place(const char* section, const char* key, std::size_t entry = 0) const;
};

/** What it names and the disk lacks: a folder of motions. Nothing that keeps the daemon from its work. */
[[nodiscard]] Result<void> checkFolders(const LoadedConfig& loaded);

/**
 * What systemd made for the service and names in $RUNTIME_DIRECTORY, $STATE_DIRECTORY or $CONFIGURATION_DIRECTORY: the
 * first, which is the unit's, where a drop-in adds others. Empty: nothing.
 */
[[nodiscard]] std::string serviceFolder(const char* variable);

/** Variables of the environment that matter, so that tests need not change it. */
struct ConfigEnvironment {
  std::string hapticd_config;           ///< $HAPTICD_CONFIG
  std::string configuration_directory;  ///< $CONFIGURATION_DIRECTORY: set by systemd for the service.
  std::string config_home;              ///< $XDG_CONFIG_HOME, else $HOME/.config
  [[nodiscard]] static ConfigEnvironment fromProcess();
};

/**
 * The file given by --config, else $HAPTICD_CONFIG (both must exist), else hapticd.toml of the first of
 * $CONFIGURATION_DIRECTORY (a service: /etc/hapticd) or $XDG_CONFIG_HOME/hapticd that has one, else the embedded
 * default. kNotFound or kInvalidArgument name the file.
 */
[[nodiscard]] Result<LoadedConfig> loadConfig(const std::string& option,
                                              const ConfigEnvironment& environment = ConfigEnvironment::fromProcess());

}  // namespace hapticd
