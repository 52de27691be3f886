/* 01: connect, open a session with a device and read where the hand is. Nothing is energised.
 *
 *   ./01-state [DEVICE]      DEVICE by URI or serial; without it the first open one, or a real one, or the simulator
 */
#include <hapticclient/hapticclient.h>
#include <stdio.h>
#include <time.h>

static int fail(const haptic_error* error) {
  fprintf(stderr, "%s: %s (%s)\n", error->where, error->what, error->remedy);
  return 1;
}

int main(int argc, char** argv) {
  haptic_error error = HAPTIC_ERROR_INIT;
  haptic_client* client = NULL;
  if (haptic_connect(NULL, &client, &error) != HAPTIC_OK) return fail(&error);

  haptic_session_options options = HAPTIC_SESSION_OPTIONS_INIT;
  if (argc > 1) options.uri = argv[1];
  haptic_session* session = NULL;
  if (haptic_session_open(client, &options, &session, &error) != HAPTIC_OK) {
    haptic_disconnect(client);
    return fail(&error);
  }

  uint64_t first = 0, last = 0;
  for (int i = 0; i < 20; ++i) {
    const struct timespec pause = {0, 50000000};
    nanosleep(&pause, NULL);
    haptic_sample sample;
    if (haptic_session_latest(session, &sample) != HAPTIC_OK) continue; /* no sample stands yet */
    printf("tick %llu  p = %+.4f %+.4f %+.4f m  v = %+.3f %+.3f %+.3f m/s\n", (unsigned long long)sample.tick,
           sample.p[0], sample.p[1], sample.p[2], sample.v[0], sample.v[1], sample.v[2]);
    if (first == 0) first = sample.tick;
    last = sample.tick;
  }
  printf("the servo ran %llu cycles meanwhile\n", (unsigned long long)(last - first));

  haptic_session_close(session);
  haptic_disconnect(client);
  return last > first ? 0 : 1;
}
