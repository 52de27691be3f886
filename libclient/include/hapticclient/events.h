/** @file
 * Events: touches, buttons, faults, leases, devices. They come by the socket, not by the servo's rings, so they are
 * prompt (about a millisecond) but not timed; `tick` and `t_ns` say when each happened.
 */
#ifndef HAPTICCLIENT_EVENTS_H
#define HAPTICCLIENT_EVENTS_H

#include <hapticclient/client.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum haptic_event_kind {
  HAPTIC_EVENT_TOUCH = 0,   /**< object: one that the hand begins to touch; of several each has its own event. */
  HAPTIC_EVENT_UNTOUCH = 1, /**< object: one that it touches no more. */
  HAPTIC_EVENT_BUTTON = 2,  /**< value: the button mask now. */
  HAPTIC_EVENT_FAULT = 3,   /**< value: haptic_fault. */
  HAPTIC_EVENT_ARMED = 4,
  HAPTIC_EVENT_DISARMED = 5,
  HAPTIC_EVENT_LEASE_LOST = 6,
  HAPTIC_EVENT_LEASE_TAKEN = 7,
  HAPTIC_EVENT_DEVICE_ADDED = 8,
  HAPTIC_EVENT_DEVICE_REMOVED = 9,
  HAPTIC_EVENT_OVERRUN = 10, /**< A few a second; value: periods missed since the last. */
  HAPTIC_EVENT_CLIENT_JOINED = 11,
  HAPTIC_EVENT_CLIENT_LEFT = 12,
  HAPTIC_EVENT_MODEL_EXPIRED = 13, /**< Eight a second of a session; value: model slot; text: "(12 suppressed)". */
  HAPTIC_EVENT_OBJECT_CHANGED = 14,
  HAPTIC_EVENT_REFUSED = 15, /**< Of session's pushes, a few a second; value: haptic_error_code; text: what and why. */
  HAPTIC_EVENT_KINDS = 16
} haptic_event_kind;

/** Texts end in a zero byte and are cut to fit. */
typedef struct haptic_event {
  uint32_t size; /**< sizeof(haptic_event), set by you. */
  uint32_t kind; /**< haptic_event_kind; a newer daemon may send others. */
  int64_t t_ns;  /**< CLOCK_MONOTONIC. */
  uint64_t tick;
  uint64_t session;
  uint64_t lost;  /**< Events lost since the subscription began, here and in the daemon. */
  uint32_t value; /**< See haptic_event_kind. */
  uint32_t reserved;
  double point[3]; /**< In the world [m]. */
  double force;    /**< That the surface asks for [N]; a hand that is not armed feels none of it. */
  char device[64];
  char object[64];
  char text[256];
} haptic_event;

/** To be filled: haptic_events_next() refuses one without its size (HAPTIC_INVALID_ARGUMENT). */
#define HAPTIC_EVENT_INIT \
  { sizeof(haptic_event), 0, 0, 0, 0, 0, 0, 0, {0, 0, 0}, 0, "", "", "" }

/** A subscription. */
typedef struct haptic_events haptic_events;

/** Called on the library's thread: be short, and call nothing of this library that blocks. What it throws goes no
 * further than the event. */
typedef void (*haptic_event_callback)(const haptic_event* event, void* user);

typedef struct haptic_events_options {
  uint32_t size;
  uint32_t kinds;    /**< 1 << haptic_event_kind each; 0: all. */
  uint32_t capacity; /**< Of the queue; when full the oldest is dropped and counted. 0: 1024. */
  uint32_t reserved;
  haptic_event_callback callback; /**< If not null, events go there and not to the queue. */
  void* user;
} haptic_events_options;

#define HAPTIC_EVENTS_OPTIONS_INIT \
  { sizeof(haptic_events_options), 0, 0, 0, NULL, NULL }

/** "touch", "untouch", ... for a kind; "unknown" for others. Any thread, servo-safe. */
HAPTIC_API const char* haptic_event_name(uint32_t kind);

/** Subscribes. `options` may be null. Close it before haptic_disconnect() or after; both are fine. Blocks; any thread.
 */
HAPTIC_API int haptic_events_open(haptic_client* client, const haptic_events_options* options, haptic_events** events,
                                  haptic_error* error);

/**
 * Takes the oldest event. Waits at most `timeout_ns` (0: not at all; negative: for ever). HAPTIC_TIMEOUT when none
 * came, HAPTIC_DISCONNECTED when none is left and the daemon is gone. Any thread; a callback may not wait
 * (HAPTIC_INVALID_ARGUMENT).
 */
HAPTIC_API int haptic_events_next(haptic_events* events, haptic_event* event, int64_t timeout_ns);

/**
 * A descriptor that polls readable while the queue holds events. Do not read or close it. That the daemon has gone it
 * does not tell: a loop that waits on it alone looks at haptic_connected() from time to time.
 */
HAPTIC_API int haptic_events_fd(const haptic_events* events);

/** Unsubscribes and frees; its callback is not running any more when this returns. Null is allowed. */
HAPTIC_API void haptic_events_close(haptic_events* events);

#ifdef __cplusplus
}
#endif
#endif /* HAPTICCLIENT_EVENTS_H */
