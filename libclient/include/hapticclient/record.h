/** @file
 * Recordings of a device: everything that enters its servo and what comes out, as a stream of bytes to be kept.
 * haptic-bench replays and exports them.
 */
#ifndef HAPTICCLIENT_RECORD_H
#define HAPTICCLIENT_RECORD_H

#include <hapticclient/client.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A recording under way. */
typedef struct haptic_recording haptic_recording;

/** How a recording ended. */
typedef struct haptic_recording_end {
  uint32_t size;
  uint32_t reserved;
  uint64_t cycles;    /**< Servo cycles in it. */
  uint64_t lost;      /**< Cycles after them: the stream was read too slowly, or not to its end. */
  const char* reason; /**< "stopped": by haptic_recording_stop(); else what ended it, in words. */
} haptic_recording_end;

/**
 * Begins to record the device and those that share its servo; an empty URI is the first device. It must not be armed:
 * a recording begins with the servo's cycle made anew; one that is being disarmed is waited for. Takes the
 * administration connection where another user has a session on it (HAPTIC_PERMISSION_DENIED). HAPTIC_ALREADY_EXISTS:
 * it is being recorded. Blocks; any thread.
 */
HAPTIC_API int haptic_recording_start(haptic_client* client, const char* uri, haptic_recording** recording,
                                      haptic_error* error);

/**
 * The stream: read it and write what comes to a file as it is, until its end. Who reads too slowly ends the recording
 * after some seconds. Belongs to the recording: do not close it.
 */
HAPTIC_API int haptic_recording_fd(const haptic_recording* recording);

/**
 * Ends it and waits until all is in the stream: go on reading meanwhile, on another thread. Also says how a recording
 * ended that has ended by itself. `end` (haptic_free()) may be null. Blocks; any thread.
 */
HAPTIC_API int haptic_recording_stop(haptic_recording* recording, haptic_recording_end** end, haptic_error* error);

/** Ends it, if it has not ended, and frees it. Null is allowed. */
HAPTIC_API void haptic_recording_close(haptic_recording* recording);

#ifdef __cplusplus
}
#endif
#endif /* HAPTICCLIENT_RECORD_H */
