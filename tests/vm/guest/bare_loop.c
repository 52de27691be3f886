// The loop that the servo is compared with: bare_loop RATE_HZ SECONDS. Waits for absolute deadlines at SCHED_FIFO 80
// with its memory locked, does nothing else, and prints how late it woke as JSON [ns].
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>

static int compare(const void* a, const void* b) {
  const long x = *(const long*)a, y = *(const long*)b;
  return (x > y) - (x < y);
}

int main(int argc, char** argv) {
  const long rate = argc == 3 ? atol(argv[1]) : 0;
  const long count = argc == 3 ? rate * atol(argv[2]) : 0;
  if (rate <= 0 || count <= 0) return 2;
  long* late = malloc((size_t)count * sizeof *late);
  if (late == NULL) return 3;
  memset(late, 0, (size_t)count * sizeof *late);
  const struct sched_param priority = {.sched_priority = 80};
  if (mlockall(MCL_CURRENT) != 0 || sched_setscheduler(0, SCHED_FIFO, &priority) != 0) return 4;
  struct timespec due, now;
  clock_gettime(CLOCK_MONOTONIC, &due);
  for (long i = 0; i < count; ++i) {
    due.tv_nsec += 1000000000 / rate;
    if (due.tv_nsec >= 1000000000) {
      due.tv_nsec -= 1000000000;
      ++due.tv_sec;
    }
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, NULL);
    clock_gettime(CLOCK_MONOTONIC, &now);
    late[i] = (now.tv_sec - due.tv_sec) * 1000000000 + now.tv_nsec - due.tv_nsec;
  }
  // Sorting takes milliseconds: not above the servo.
  const struct sched_param none = {.sched_priority = 0};
  if (sched_setscheduler(0, SCHED_OTHER, &none) != 0) return 5;
  qsort(late, (size_t)count, sizeof *late, compare);
  printf("{\"count\": %ld, \"p50_ns\": %ld, \"p999_ns\": %ld, \"max_ns\": %ld}\n", count, late[count / 2],
         late[count * 999 / 1000], late[count - 1]);
  return 0;
}
