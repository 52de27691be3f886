/** @file
 * Devices: what there is, what each can do, opening, limits and the stop.
 */
#ifndef HAPTICCLIENT_DEVICE_H
#define HAPTICCLIENT_DEVICE_H

#include <hapticclient/client.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum haptic_calibration {
  HAPTIC_CALIBRATION_NOT_NEEDED = 0,
  HAPTIC_CALIBRATION_NEEDED = 1,
  HAPTIC_CALIBRATION_RUNNING = 2,
  HAPTIC_CALIBRATION_DONE = 3
} haptic_calibration;

/** Bits of haptic_device_info.abilities. */
typedef enum haptic_ability {
  HAPTIC_SENSES_POSITION = 1 << 0,
  HAPTIC_SENSES_ROTATION = 1 << 1,
  HAPTIC_SENSES_GRIPPER = 1 << 2,
  HAPTIC_ACTUATES_POSITION = 1 << 3,
  HAPTIC_ACTUATES_ROTATION = 1 << 4,
  HAPTIC_ACTUATES_GRIPPER = 1 << 5,
  HAPTIC_LEFT_HAND = 1 << 6,
  HAPTIC_RIGHT_HAND = 1 << 7,
  HAPTIC_HAS_BRAKES = 1 << 8,
  HAPTIC_HAS_WATCHDOG = 1 << 9,
  HAPTIC_HAS_DEADMAN = 1 << 10,
  HAPTIC_HAS_VELOCITY_LIMIT = 1 << 11
} haptic_ability;

/**
 * The field's usual data sheet of a device. 0 (NaN for the temperature) where unknown. Of the device, not of the world:
 * without its mount and scale (docs/mount.md).
 */
typedef struct haptic_device_info {
  uint32_t size;
  uint32_t open;      /**< 1: the daemon has opened it. */
  uint32_t abilities; /**< haptic_ability */
  uint32_t buttons;
  uint32_t calibration; /**< haptic_calibration */
  uint32_t reserved;
  const char* uri;  /**< Canonical: opens this device and no other. */
  const char* name; /**< Short, unique in the daemon: /devices/NAME. */
  const char* model;
  const char* manufacturer;
  const char* serial;
  const char* firmware;
  const char* driver;
  const char* driver_version;
  const char* calibration_style; /**< "none", "encoder reset", "auto" or "inkwell". */
  double max_force;              /**< Peak [N]. */
  double continuous_force;       /**< [N] */
  double max_torque;             /**< [N m] */
  double max_gripper_force;      /**< [N] */
  double max_stiffness;          /**< Closed loop at 1 kHz [N/m]. */
  double max_angular_stiffness;  /**< [N m/rad] */
  double max_gripper_stiffness;  /**< [N/m] */
  double max_damping;            /**< [N s/m] */
  double max_angular_damping;    /**< [N m s/rad] */
  double workspace_radius;       /**< [m] */
  double workspace_lower[3];     /**< Usable box [m]. */
  double workspace_upper[3];
  double max_workspace_lower[3]; /**< Reachable box [m]. */
  double max_workspace_upper[3];
  double gripper_max_angle;   /**< [rad] */
  double position_resolution; /**< [m] */
  double rotation_resolution; /**< [rad] */
  double force_resolution;    /**< [N] */
  double native_rate_hz;
  double apparent_mass;    /**< [kg] */
  double viscous_friction; /**< [N s/m] */
  double coulomb_friction; /**< [N] */
  double max_velocity;     /**< [m/s] */
  double temperature_c;    /**< Hottest motor. */
  const char* problem;     /**< Why it is not open although the daemon was told to open it; "" otherwise. */
} haptic_device_info;

typedef struct haptic_device_list {
  uint32_t size;
  uint32_t count;
  const haptic_device_info* const* items;
} haptic_device_list;

/** Limits of a device: they bind the sum of all clients. Of the device, not of the world, as haptic_device_info. */
typedef struct haptic_device_limits {
  uint32_t size;
  uint32_t reserved;
  double force;         /**< [N] */
  double torque;        /**< [N m] */
  double force_slew;    /**< [N/s] */
  double torque_slew;   /**< [N m/s] */
  double velocity;      /**< [m/s]: beyond it the guard latches. */
  double power;         /**< [W] delivered to the hand. */
  double active_power;  /**< [W]: budget of sources declared active. */
  double gripper_force; /**< [N] */
} haptic_device_limits;

/** Open devices first, then those found, then those that are configured and missing (`problem`). Blocks; any thread. */
HAPTIC_API int haptic_device_list_all(haptic_client* client, haptic_device_list** devices, haptic_error* error);

/**
 * Opens a device by URI, name or serial number. Null or "": the first open device; if none is open, the first real one,
 * else the simulator. Opening what is open answers with it. A simulated one that is not configured closes when all
 * clients that have opened it, or a session on it, have disconnected, unless an administrator is among them. `device`
 * may be null. Blocks; any thread.
 */
HAPTIC_API int haptic_device_open(haptic_client* client, const char* uri, haptic_device_info** device,
                                  haptic_error* error);

/**
 * Closes a device and those that share its servo. HAPTIC_DEVICE_BUSY while a session uses one of them. Waits for the
 * force of the last one to be lowered, a second or so; after two it is HAPTIC_WOULD_BLOCK or, for an administrator,
 * closed whatever its servo does. Administration; but a simulated one that is not configured may be closed by a client
 * that alone has asked for it, of those that are still there, unless an administrator ever has. Blocks; any thread.
 */
HAPTIC_API int haptic_device_close(haptic_client* client, const char* uri, haptic_error* error);

/** Zero force at once, latched until armed again. Null or "" stops every device. Anybody may. Blocks; any thread. */
HAPTIC_API int haptic_stop(haptic_client* client, const char* uri, haptic_error* error);

/**
 * Changes limits of a device. A NaN leaves that limit as it is; NaN in all of them only asks. Lowering takes the lease
 * holder's user or administration, raising takes administration. `in_force`, if not null, receives the limits that hold
 * now: set its `size`. Blocks; any thread.
 */
HAPTIC_API int haptic_device_set_limits(haptic_client* client, const char* uri, const haptic_device_limits* limits,
                                        haptic_device_limits* in_force, haptic_error* error);

#ifdef __cplusplus
}
#endif
#endif /* HAPTICCLIENT_DEVICE_H */
