/** @file
 * The connection to the daemon: making it, what it can tell, and what happens when the daemon goes.
 *
 * Each connection has one thread of its own (the library's thread). It does all socket work and sends the heartbeats of
 * the sessions. Functions marked "blocks" wait for the daemon's answer, at most the connection's timeout (5 s unless
 * set), then give HAPTIC_TIMEOUT. They may be called from any thread, but not from a callback.
 *
 * When the daemon dies or restarts, calls give HAPTIC_DISCONNECTED; nothing is freed under you. haptic_reconnect()
 * makes the connection again, haptic_session_reopen() each session; subscriptions come back by themselves.
 *
 * fork(): handles belong to the process that made them. In the child every call gives HAPTIC_DISCONNECTED, the shared
 * memory is not mapped and the socket is closed; connect anew there. Threads and exec need no care.
 * dlclose(): once loaded the library stays, for its threads run in it; connections go on until they are ended.
 */
#ifndef HAPTICCLIENT_CLIENT_H
#define HAPTICCLIENT_CLIENT_H

#include <hapticclient/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A connection. */
typedef struct haptic_client haptic_client;

/** Bits of haptic_connect_options.flags. */
typedef enum haptic_connect_flag {
  HAPTIC_CONNECT_ADMINISTRATION = 1 << 0 /**< Use the administration socket (admin.sock instead of control.sock). */
} haptic_connect_flag;

typedef struct haptic_connect_options {
  uint32_t size;
  uint32_t flags;     /**< haptic_connect_flag */
  const char* socket; /**< Path, or null to search; empty is refused. */
  const char* name;   /**< How the daemon calls you in its lists; null: the program's name. */
  int64_t timeout_ns; /**< For this and later calls; 0: 5 s. */
} haptic_connect_options;

#define HAPTIC_CONNECT_OPTIONS_INIT \
  { sizeof(haptic_connect_options), 0, NULL, NULL, 0 }

typedef struct haptic_daemon_info {
  uint32_t size;
  int32_t pid;
  uint32_t protocol_major;
  uint32_t protocol_minor;
  uint64_t epoch;          /**< Drawn at the daemon's start; a new one means a restarted daemon. */
  uint32_t administration; /**< 1: this connection came by the administration socket. */
  uint32_t realtime;       /**< 1: the servo runs under real-time scheduling. */
  int64_t started_ns;      /**< [CLOCK_MONOTONIC] */
  const char* version;
  const char* scheduling_note; /**< Why not, when realtime is 0. */
  const char* socket;          /**< The path this connection uses. */
  const char* config_file;     /**< Its whole path; empty: the embedded default. */
} haptic_daemon_info;

/**
 * Connects and checks versions. Without `socket` it takes $HAPTICD_SOCKET if set, else the first that answers of
 * $XDG_RUNTIME_DIR/hapticd/control.sock and /run/hapticd/control.sock. With the administration flag the last part of
 * every searched path is admin.sock. `options` may be null. Blocks.
 *
 * HAPTIC_DISCONNECTED: nobody answers (`where` lists the paths tried). HAPTIC_TIMEOUT: a daemon is there and says
 * nothing; the next, which has other devices, is not asked. HAPTIC_VERSION_MISMATCH: another major version.
 */
HAPTIC_API int haptic_connect(const haptic_connect_options* options, haptic_client** client, haptic_error* error);

/**
 * Ends the connection: subscriptions end, sessions lose their share of the force and their lease. Session, upload and
 * subscription handles stay yours to close. No other call on this connection may be running. Null is allowed.
 */
HAPTIC_API void haptic_disconnect(haptic_client* client);

/** 1 while the connection stands. Any thread, servo-safe. */
HAPTIC_API int haptic_connected(const haptic_client* client);

/**
 * Makes a lost connection again by the search of haptic_connect(), and renews subscriptions: if one is refused, that is
 * the error, and the connection stays lost. A standing one is left alone. HAPTIC_DISCONNECTED while the daemon is not
 * there: try again. Blocks; no session of this connection may be in use by another thread meanwhile, except for reading
 * and pushing.
 */
HAPTIC_API int haptic_reconnect(haptic_client* client, haptic_error* error);

/** Sets the timeout of later calls [ns]; 0: 5 s; whoever would wait for ever waits a year. Any thread. */
HAPTIC_API int haptic_set_timeout(haptic_client* client, int64_t timeout_ns);

/** What the daemon said of itself when the connection was made. Does not block; any thread. */
HAPTIC_API int haptic_get_daemon_info(haptic_client* client, haptic_daemon_info** info, haptic_error* error);

/**
 * Reads a resource (/objects/C/pos, /_objects/A/B/C, /devices/NAME, /statistics; / lists where names begin): JSON.
 * Blocks; any thread.
 */
HAPTIC_API int haptic_get(haptic_client* client, const char* path, haptic_text** json, haptic_error* error);

/**
 * Changes a resource: /objects/C/pos?value=1,2,3. `json`, if not null, receives the value now in force. Blocks; any
 * thread.
 */
HAPTIC_API int haptic_set(haptic_client* client, const char* uri, haptic_text** json, haptic_error* error);

/** The configuration in force, as TOML. Blocks; any thread. */
HAPTIC_API int haptic_get_configuration(haptic_client* client, haptic_text** toml, haptic_error* error);

/** Everything the daemon knows, as JSON, for bug reports. Blocks; any thread. */
HAPTIC_API int haptic_get_dump(haptic_client* client, haptic_text** json, haptic_error* error);

#ifdef __cplusplus
}
#endif
#endif /* HAPTICCLIENT_CLIENT_H */
