/** @file
 * Errors, versions and ownership: the ground that the other headers of the C interface stand on.
 *
 * Every function that can fail returns an int: HAPTIC_OK or another haptic_error_code. Functions that are not
 * servo-safe also fill an optional haptic_error with the place, the fault and the remedy.
 *
 * Structures that may grow start with `size`. What you hand in: set `size` to sizeof of it; older, shorter ones are
 * accepted. What you are handed by pointer: its `size` tells how much of it this library filled; it is yours until
 * haptic_free(). Structures without `size` mirror shared memory and keep their layout as long as the library's name
 * ends in .so.1.
 */
#ifndef HAPTICCLIENT_BASE_H
#define HAPTICCLIENT_BASE_H

#include <stddef.h>
#include <stdint.h>

#define HAPTIC_API __attribute__((visibility("default")))

#ifdef __cplusplus
extern "C" {
#endif

#define HAPTIC_VERSION_MAJOR 0
#define HAPTIC_VERSION_MINOR 1
#define HAPTIC_VERSION_PATCH 0

/** Kinds of refusal. Numbers never change meaning; a newer daemon may send numbers that are not listed here. */
typedef enum haptic_error_code {
  HAPTIC_OK = 0,
  HAPTIC_INVALID_ARGUMENT = 1,  /**< A value is malformed, not finite or out of range. */
  HAPTIC_NOT_FOUND = 2,         /**< No object, device, mesh or path of that name. */
  HAPTIC_ALREADY_EXISTS = 3,    /**< The name is taken. */
  HAPTIC_PERMISSION_DENIED = 4, /**< The caller may not do this on this socket. */
  HAPTIC_QUOTA_EXCEEDED = 5,    /**< A quota of the user, or what there is for all, is used up. */
  HAPTIC_VERSION_MISMATCH = 6,  /**< Client and daemon speak different versions. */
  HAPTIC_LEASE_REQUIRED = 7,    /**< Only the holder of the device lease may do this. */
  HAPTIC_LEASE_HELD = 8,        /**< Another client holds the device lease. */
  HAPTIC_FAULT_LATCHED = 10,    /**< A fault is latched; clear its cause and arm again. */
  HAPTIC_DEVICE_GONE = 11,      /**< The device is unplugged or does not answer. */
  HAPTIC_DEVICE_BUSY = 12,      /**< Another program or driver owns the device. */
  HAPTIC_STILL_MAPPED = 13,     /**< The upload is still mapped writable. */
  HAPTIC_BAD_MESH = 14,         /**< The mesh cannot be rendered as it is. */
  HAPTIC_BAD_SNAPSHOT = 15,     /**< A built model is damaged or of another version. */
  HAPTIC_BUILDER_FAILED = 16,   /**< The builder process crashed or ran out of memory. */
  HAPTIC_WOULD_BLOCK = 17,      /**< A queue is full, nothing is there yet, or what the text names is in the way. */
  HAPTIC_DISCONNECTED = 18,     /**< The daemon is not there or has restarted. */
  HAPTIC_NO_REALTIME = 19,      /**< Real-time rights are missing. */
  HAPTIC_SYSTEM = 20,           /**< The operating system refused. */
  HAPTIC_UNSUPPORTED = 21,      /**< This device or build cannot do that. */
  HAPTIC_TIMEOUT = 22,          /**< No answer in time. */
  HAPTIC_CANCELLED = 23,        /**< Cancelled by the caller. */
  HAPTIC_INTERNAL = 24          /**< A defect in hapticd; please report it. */
} haptic_error_code;

/** What went wrong. Texts are UTF-8, end in a zero byte and are cut to fit. Untouched by a call that succeeds. */
typedef struct haptic_error {
  uint32_t size;    /**< sizeof(haptic_error), set by you; 0 leaves the structure alone. */
  int32_t code;     /**< The value that the call returned. */
  char where[256];  /**< The field, file and line, index or path at fault. */
  char what[512];   /**< What is wrong there. */
  char remedy[512]; /**< What to do about it. */
} haptic_error;

#define HAPTIC_ERROR_INIT                    \
  {                                          \
    sizeof(haptic_error), 0, {0}, {0}, { 0 } \
  }

/** "HAPTIC_NOT_FOUND" for a code; "HAPTIC_UNKNOWN" for one that is not in the list. Any thread, servo-safe. */
HAPTIC_API const char* haptic_error_name(int code);
/** One English sentence for a code. Any thread, servo-safe. */
HAPTIC_API const char* haptic_error_text(int code);
/** Version of the library that is loaded, as "0.1.0". Any thread, servo-safe. */
HAPTIC_API const char* haptic_version(void);
/** Gives back any result that a function of this library returned by pointer. Any thread; null is allowed. */
HAPTIC_API void haptic_free(const void* result);
/** CLOCK_MONOTONIC now [ns]: the clock of all times here. Any thread, servo-safe. */
HAPTIC_API int64_t haptic_now_ns(void);

/** A text of `length` bytes; a zero byte follows. */
typedef struct haptic_text {
  uint32_t size;
  uint32_t reserved;
  uint64_t length;
  const char* text;
} haptic_text;

/** Place and orientation: metres, and a unit quaternion w, x, y, z. */
typedef struct haptic_pose {
  double p[3];
  double q[4];
} haptic_pose;

/** What a surface feels like. */
typedef struct haptic_material {
  double stiffness;        /**< [N/m] */
  double damping;          /**< [N s/m], while in contact */
  double friction_static;  /**< mu_s */
  double friction_dynamic; /**< mu_d, at most mu_s */
} haptic_material;

#ifdef __cplusplus
}
#endif
#endif /* HAPTICCLIENT_BASE_H */
