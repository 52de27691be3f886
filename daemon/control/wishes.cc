// What waits a little rather than be refused: for room that one who ends still takes, and for a force to be lowered.
#include <algorithm>
#include <new>
#include <utility>

#include "daemon/control/core.h"

namespace hapticd {
namespace {

Error left() { return {ErrorCode::kTimeout, "connection", "the client has left", {}}; }

}  // namespace

/** A session that has ended counts until its force has faded: who opens one after the other waits for that. */
void Core::fulfil(Wish wish) {
  const std::string uri = wish.uri;
  const std::uint64_t connection = wish.connection;
  openDevice(uri, connection, [this, wish = std::move(wish)](const Result<OpenDevice*>& device) mutable {
    if (!device) return wish.done(device.error());
    if (!clients_.has(wish.connection)) return wish.done(left());  // While the device was opened.
    auto session = sessionOn(*device.value(), wish.connection, wish.name);
    const bool waits = !session && session.error().code == ErrorCode::kQuotaExceeded && wishes_.size() < kWishes &&
                       clock_.now() < wish.until_ns &&
                       sessions_.anyEnds(client(wish.connection).uid, *device.value()->link);
    if (waits) return wishes_.push_back(std::move(wish));
    wish.done(session);
  });
}

Result<Recordings::Started> Core::record(std::string_view uri, std::uint64_t connection) {
  auto device = devices_.find(uri);
  if (!device) return device.error();
  const Client& by = client(connection);
  if (auto r = checkQuota(by.uid, sizeof(CycleLog), 0); !r) return r.error();
  return recordings_.start(**device, by, devices_);
}

void Core::record(std::string_view uri, std::uint64_t connection, RecordDone done) {
  fulfil(RecordWish{std::string(uri), connection, clock_.now(), clock_.now(), std::move(done)});
}

/** One that ends is there until all is in its stream: who records again at once waits for that. So does who has just
 * disarmed. */
void Core::fulfil(RecordWish wish) {
  if (!clients_.has(wish.connection)) return wish.done(left());
  const auto device = devices_.find(wish.uri);
  const std::int64_t now_ns = clock_.now();
  const bool has_place = device && record_wishes_.size() < kWishes;
  const bool may_wait = has_place && now_ns - wish.free_ns < kRoomNs;
  if (may_wait && !recordings_.ready(**device, client(wish.connection)))
    return record_wishes_.push_back(std::move(wish));
  auto started = record(wish.uri, wish.connection);
  const auto is = [&](ErrorCode code) { return !started && started.error().code == code; };
  const auto lowers = [&] {  // Nobody wants one of the group armed any more.
    return std::ranges::all_of(devices_.devices(), [&](const auto& other) {
      return other->link != (*device)->link || powerless(*other) || isLowered(*other);
    });
  };
  if ((may_wait && is(ErrorCode::kWouldBlock)) ||
      (may_wait && is(ErrorCode::kAlreadyExists) && recordings_.ends(*(*device)->link)))
    return record_wishes_.push_back(std::move(wish));
  if (has_place && now_ns - wish.since_ns < kLowered_ns && is(ErrorCode::kInvalidArgument) && lowers()) {
    wish.free_ns = now_ns;
    return record_wishes_.push_back(std::move(wish));
  }
  wish.done(std::move(started));
}

bool Core::isLowered(const OpenDevice& device) const {
  return device.link->isSwitchedOff(device.index) && (!powerless(device) || mayBeArmed(device));
}

void Core::onceLowered(std::uint64_t connection, std::function<Result<void>()> attempt,
                       std::function<void(const Result<void>&)> done) {
  fulfil(LoweredWish{connection, clock_.now(), std::move(attempt), std::move(done)});
}

void Core::fulfil(LoweredWish wish) {
  if (!clients_.has(wish.connection)) return wish.done(left());
  const bool may_wait = lowered_wishes_.size() < kWishes && clock_.now() - wish.since_ns < kLowered_ns;
  if (may_wait &&
      std::ranges::find(lowered_wishes_, wish.connection, &LoweredWish::connection) != lowered_wishes_.end())
    return lowered_wishes_.push_back(std::move(wish));  // Behind what it has asked for before.
  // First: what the attempt still sees may be over after it.
  const bool lowers =
      std::ranges::any_of(devices_.devices(), [this](const auto& device) { return isLowered(*device); });
  const Result<void> result = wish.attempt();
  if (may_wait && lowers && !result && result.error().code == ErrorCode::kWouldBlock)
    return lowered_wishes_.push_back(std::move(wish));
  wish.done(result);
}

/** For want of memory a wish is over, and with it whoever waits for it; the others are not. */
void Core::pollWishes() {
  bool no_memory = false;
  const auto look = [&](auto waiting, auto&& at) {
    for (auto& wish : waiting) {
      try {
        at(wish);
      } catch (const std::bad_alloc&) {
        no_memory = true;
      }
    }
  };
  look(std::exchange(wishes_, {}), [this](Wish& wish) {
    if (!clients_.has(wish.connection)) {
      wish.done(left());
    } else {
      fulfil(std::move(wish));
    }
  });
  look(std::exchange(record_wishes_, {}), [this](RecordWish& wish) { fulfil(std::move(wish)); });
  look(std::exchange(lowered_wishes_, {}), [this](LoweredWish& wish) { fulfil(std::move(wish)); });
  if (no_memory) throw std::bad_alloc();
}

}  // namespace hapticd
