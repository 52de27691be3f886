/** @file
 * What the daemon is doing: devices, clients, timing, and its own health checks.
 */
#ifndef HAPTICCLIENT_STATUS_H
#define HAPTICCLIENT_STATUS_H

#include <hapticclient/client.h>
#include <hapticclient/device.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct haptic_device_status {
  uint32_t size;
  uint32_t armed; /**< 1: forces may reach it; also while its driver has not sent the zeros. */
  uint32_t fault; /**< haptic_fault; 0 for none. */
  int32_t lease_pid;
  const char* uri;
  const char* name;
  const char* fault_text;
  const char* lease_holder; /**< Client name, empty if free. */
  const char* group;        /**< Devices of one group share a servo. */
  const char* scheduling;   /**< "SCHED_FIFO 80" or "SCHED_OTHER". */
  double rate_hz;
  double busy;     /**< Part of the period spent in the cycle, median. */
  uint64_t cycles; /**< Of the servo, as the next three: devices of one group have the same. */
  uint64_t missed;
  uint64_t stale; /**< Readings of any of its devices that had not come. */
  uint32_t wake_p99_ns;
  uint32_t reserved;
  const haptic_device_limits* limits;
  haptic_pose pose;
  double force[3]; /**< Sent to the device [N]. */
} haptic_device_status;

typedef struct haptic_client_status {
  uint32_t size;
  int32_t pid;
  uint32_t uid;
  uint32_t lease; /**< 1: holds the lease of its device. */
  uint64_t session;
  const char* name;
  const char* device;
  uint64_t received; /**< Commands taken, by ring and mailboxes; what a newer value replaced before is none. */
  uint64_t rejected;
  uint64_t stale;
  uint32_t models; /**< Local models in force. */
  float fade;      /**< Share factor: 1 alive. */
  int64_t heartbeat_age_ns;
  uint64_t bytes; /**< Locked for this session. */
} haptic_client_status;

typedef struct haptic_status {
  uint32_t size;
  uint32_t device_count;
  uint32_t client_count;
  uint32_t objects;
  uint64_t triangles;
  uint64_t locked_bytes;
  int64_t uptime_ns;
  const haptic_daemon_info* info;
  const haptic_device_status* const* devices;
  const haptic_client_status* const* clients;
} haptic_status;

/** One stage: wake, read, render, guard, write, cycle; and collide, the collide thread's answers beside it. */
typedef struct haptic_histogram {
  uint32_t size;
  uint32_t reserved;
  const char* name;
  uint64_t count;
  uint64_t p50_ns;
  uint64_t p99_ns;
  uint64_t p999_ns;
  uint64_t p9999_ns;
  uint64_t max_ns;
} haptic_histogram;

typedef struct haptic_statistics {
  uint32_t size;
  uint32_t histogram_count;
  const char* uri;
  int64_t period_ns;
  uint64_t cycles;
  uint64_t missed;
  uint64_t overruns;
  uint64_t stale_samples;
  const haptic_histogram* const* histograms;
  uint64_t collide_queries;   /**< Answers of the collide thread on held tools and free objects. */
  uint64_t collide_exhausted; /**< Of them, those whose time or work was not enough: contacts may be missing. */
  uint64_t collide_unsent;    /**< Of them, those that the servo had no room for: it stands or is late. */
} haptic_statistics;

typedef enum haptic_check_state {
  HAPTIC_CHECK_GREEN = 0,
  HAPTIC_CHECK_RED = 1,
  HAPTIC_CHECK_NOT_APPLICABLE = 2
} haptic_check_state;

typedef struct haptic_check {
  uint32_t size;
  uint32_t state; /**< haptic_check_state */
  const char* name;
  const char* detail;
  const char* remedy; /**< The one line that fixes it, when red. */
} haptic_check;

typedef struct haptic_check_list {
  uint32_t size;
  uint32_t count;
  const haptic_check* const* items;
} haptic_check_list;

/** Devices, clients and memory at this moment. Blocks; any thread. */
HAPTIC_API int haptic_get_status(haptic_client* client, haptic_status** status, haptic_error* error);

/**
 * Counters of the device's servo since its start, and histograms since then or their last reset. Null or "": the first
 * open device. `reset` (administration) starts the histograms anew after this answer. Blocks; any thread.
 */
HAPTIC_API int haptic_get_statistics(haptic_client* client, const char* uri, int reset, haptic_statistics** statistics,
                                     haptic_error* error);

/** The checks that only the daemon can make. Blocks; any thread. */
HAPTIC_API int haptic_run_doctor(haptic_client* client, haptic_check_list** checks, haptic_error* error);

#ifdef __cplusplus
}
#endif
#endif /* HAPTICCLIENT_STATUS_H */
