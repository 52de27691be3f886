// Reading a session: every function here is servo-safe.
#include <span>

#include "libclient/src/session/session.h"
#include "rt/ring/shared.h"

using hapticd::loadAcquire;
using hapticd::loadRelaxed;

namespace {

/** layout.cc ties the two to one layout. */
hd_sample* asOurs(haptic_sample* sample) { return reinterpret_cast<hd_sample*>(sample); }

}  // namespace

extern "C" {

int haptic_session_check(const haptic_session* session) {
  return session == nullptr ? int{HAPTIC_INVALID_ARGUMENT} : session->check();
}

int haptic_session_latest(haptic_session* session, haptic_sample* sample) {
  if (session == nullptr) return HAPTIC_INVALID_ARGUMENT;
  if (session->opened == nullptr) return HAPTIC_DISCONNECTED;
  return haptic_session_latest_of(session, session->opened->device_index, sample);
}

int haptic_session_latest_of(haptic_session* session, uint32_t device, haptic_sample* sample) {
  if (session == nullptr || sample == nullptr) return HAPTIC_INVALID_ARGUMENT;
  if (const int dead = session->check(); dead != HAPTIC_OK) return dead;
  if (device >= session->opened->device_count || device >= HD_MAX_DEVICES) return HAPTIC_INVALID_ARGUMENT;
  return session->opened->reader->latest(device, *asOurs(sample)) ? HAPTIC_OK : HAPTIC_WOULD_BLOCK;
}

int haptic_session_drain(haptic_session* session, haptic_sample* samples, uint32_t capacity, uint32_t* count,
                         uint64_t* lost) {
  if (session == nullptr || count == nullptr || (samples == nullptr && capacity > 0)) return HAPTIC_INVALID_ARGUMENT;
  *count = 0;
  if (const int dead = session->check(); dead != HAPTIC_OK) return dead;
  uint64_t overwritten = 0;
  *count = session->opened->reader->drain(std::span(asOurs(samples), capacity), overwritten);
  if (lost != nullptr) *lost += overwritten;
  return HAPTIC_OK;
}

int haptic_session_acks(const haptic_session* session, haptic_acks* acks) {
  if (session == nullptr || acks == nullptr) return HAPTIC_INVALID_ARGUMENT;
  if (session->opened == nullptr || !session->connection->ownProcess()) return HAPTIC_DISCONNECTED;
  const hd_acks& from = session->opened->a()->acks;
  acks->ring_head = loadRelaxed(from.ring_head);
  acks->violations = loadRelaxed(from.violations);
  acks->received_seq = loadRelaxed(from.received_seq);
  acks->rejected = loadAcquire(from.rejected);  // Pairs with Ingest::reject(): before what was refused last.
  acks->last_rejected_seq = loadRelaxed(from.last_rejected_seq);
  acks->last_rejected_code = loadRelaxed(from.last_rejected_code);
  acks->stale_mailboxes = loadRelaxed(from.stale_mailboxes);
  acks->applied_seq = loadAcquire(from.applied_seq);  // A8, pairs with R8 in Servo::publishSession()
  acks->applied_tick = loadRelaxed(from.applied_tick);
  acks->heartbeat_age_ns = loadRelaxed(from.heartbeat_age_ns);
  acks->fade = loadRelaxed(from.fade);
  acks->ended = loadRelaxed(from.ended);
  return HAPTIC_OK;  // also of a dead session: this is where it says why
}

int haptic_session_counters(const haptic_session* session, haptic_counters* counters) {
  if (session == nullptr || counters == nullptr) return HAPTIC_INVALID_ARGUMENT;
  if (const int dead = session->check(); dead != HAPTIC_OK) return dead;
  const hd_counters& from = session->opened->a()->counters;
  counters->cycles = loadRelaxed(from.cycles);
  counters->missed = loadRelaxed(from.missed);
  counters->overruns = loadRelaxed(from.overruns);
  counters->stale_samples = loadRelaxed(from.stale_samples);
  counters->contacts = loadRelaxed(from.contacts);
  counters->faults = loadRelaxed(from.faults);
  counters->max_wake_ns = loadRelaxed(from.max_wake_ns);
  counters->max_cycle_ns = loadRelaxed(from.max_cycle_ns);
  return HAPTIC_OK;
}

int haptic_session_model_status(const haptic_session* session, uint32_t slot, haptic_model_status* status) {
  if (session == nullptr || status == nullptr || slot >= HAPTIC_MODEL_SLOTS) return HAPTIC_INVALID_ARGUMENT;
  if (const int dead = session->check(); dead != HAPTIC_OK) return dead;
  const hd_model_status& from = session->opened->a()->models[slot];
  status->seq = loadRelaxed(from.seq);
  status->age_ns = loadRelaxed(from.age_ns);
  status->weight = loadRelaxed(from.weight);
  status->state = loadRelaxed(from.state);
  return HAPTIC_OK;
}

}  // extern "C"
