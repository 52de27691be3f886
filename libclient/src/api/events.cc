// events.h
#include <hapticclient/events.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <deque>

#include "libclient/src/connection/loop.h"
#include "libclient/src/connection/patience.h"
#include "libclient/src/reply/convert.h"

using hapticd::client::Connection;
using hapticd::client::Failure;
using hapticd::client::Link;
namespace client = hapticd::client;
namespace proto = hapticd::proto;

namespace {

constexpr std::uint32_t kDefaultCapacity = 1024;
constexpr std::uint32_t kMaxCapacity = 1u << 20;

/** Between the library's thread and those that take events. The descriptor is readable while the queue holds any. */
class Queue {
 public:
  explicit Queue(const haptic_events_options& options)
      : capacity_(options.capacity == 0 ? kDefaultCapacity : options.capacity),
        callback_(options.callback),
        user_(options.user),
        fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}
  ~Queue() {
    if (fd_ >= 0) ::close(fd_);
  }

  [[nodiscard]] int fd() const { return fd_; }

  /** Library's thread. */
  void put(haptic_event event, std::uint64_t lost_by_daemon) {
    if (closed_) return;
    std::unique_lock lock(mutex_);
    lost_ += lost_by_daemon;
    event.lost = lost_;
    if (callback_ != nullptr) {
      lock.unlock();
      try {
        callback_(&event, user_);
      } catch (...) {  // The daemon would take it for ours, and send no more.
      }
      return;
    }
    if (events_.size() == capacity_) {
      events_.pop_front();
      ++lost_;
    }
    events_.push_back(event);
    if (events_.size() == 1) eventfd_write(fd_, 1);
    changed_.notify_one();
  }
  /** The handle goes; the daemon may still send until it has heard. Library's thread. */
  void close() { closed_ = true; }
  void setConnected(bool connected) {
    const std::lock_guard lock(mutex_);
    connected_ = connected;
    if (!connected) changed_.notify_all();
  }

  int take(haptic_event& event, std::int64_t timeout_ns) {
    std::unique_lock lock(mutex_);
    const auto ready = [&] { return !events_.empty() || !connected_; };
    if (timeout_ns < 0) {
      changed_.wait(lock, ready);
    } else {
      changed_.wait_for(lock, std::chrono::nanoseconds(std::min(timeout_ns, client::kLongestWait_ns)), ready);
    }
    if (events_.empty()) return connected_ ? HAPTIC_TIMEOUT : HAPTIC_DISCONNECTED;
    event = events_.front();
    event.lost = lost_;
    events_.pop_front();
    if (events_.empty()) {
      eventfd_t drained;
      eventfd_read(fd_, &drained);
    }
    return HAPTIC_OK;
  }

 private:
  const std::size_t capacity_;
  const haptic_event_callback callback_;
  void* const user_;
  const int fd_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<haptic_event> events_;
  std::uint64_t lost_ = 0;
  bool connected_ = true;
  bool closed_ = false;  // library's thread
};

template <std::size_t N>
void cut(char (&to)[N], capnp::Text::Reader from) {
  std::size_t length = std::min<std::size_t>(from.size(), N - 1);
  while (length < from.size() && length > 0 && (from[length] & 0xc0) == 0x80) --length;
  std::memcpy(to, from.cStr(), length);
  to[length] = 0;
}

haptic_event convert(proto::Event::Reader from) {
  haptic_event to{};
  to.size = sizeof to;
  to.kind = static_cast<std::uint32_t>(from.getKind());
  to.t_ns = from.getTNs();
  to.tick = from.getTick();
  to.session = from.getSession();
  to.value = from.getValue();
  client::convert(from.getPoint(), to.point);
  to.force = from.getForce();
  cut(to.device, from.getDevice());
  cut(to.object, from.getObject());
  cut(to.text, from.getText());
  return to;
}

class Listener final : public proto::EventListener::Server {
 public:
  explicit Listener(std::shared_ptr<Queue> queue) : queue_(std::move(queue)) {}
  kj::Promise<void> events(EventsContext context) override {
    const auto params = context.getParams();
    std::uint64_t lost = params.getLost();
    for (const auto event : params.getEvents()) {
      queue_->put(convert(event), lost);
      lost = 0;
    }
    return kj::READY_NOW;
  }

 private:
  std::shared_ptr<Queue> queue_;
};

}  // namespace

namespace {

/** A subscription on the library's thread. The handle may go while an answer is on its way, hence shared. */
struct Subscribed {
  explicit Subscribed(const haptic_events_options& options)
      : kinds(options.kinds), queue(std::make_shared<Queue>(options)) {}

  static kj::Promise<void> ask(const std::shared_ptr<Subscribed>& self, Link& link) {
    auto request = link.daemon.subscribeRequest();
    request.setListener(kj::heap<Listener>(self->queue));
    request.setKinds(self->kinds);
    return request.send().then([self](auto&& results) {
      self->failure = client::toFailure(results.getStatus());
      if (self->failure || self->closed) return;
      self->subscription = results.getSubscription();
    });
  }
  void close() {
    closed = true;
    queue->close();
    subscription = nullptr;
  }

  const std::uint32_t kinds;
  const std::shared_ptr<Queue> queue;
  bool closed = false;
  Failure failure;
  proto::Subscription::Client subscription = nullptr;
};

}  // namespace

/** The handle of events.h. */
struct haptic_events final : client::Dependent {
  haptic_events(std::shared_ptr<Connection> c, const haptic_events_options& options)
      : connection(std::move(c)), subscribed(std::make_shared<Subscribed>(options)), queue(subscribed->queue) {}
  ~haptic_events() noexcept override = default;

  void lost() noexcept override { queue->setConnected(false); }
  kj::Promise<void> renew(Link& link, Failure& refusal) override {
    return Subscribed::ask(subscribed, link).then([&refusal, self = subscribed] {
      if (self->closed) return;
      if (!self->failure) self->queue->setConnected(true);
      if (self->failure && !refusal) refusal = self->failure;
    });
  }

  std::shared_ptr<Connection> connection;
  std::shared_ptr<Subscribed> subscribed;
  std::shared_ptr<Queue> queue;
};

extern "C" {

const char* haptic_event_name(uint32_t kind) {
  static constexpr const char* kNames[HAPTIC_EVENT_KINDS] = {
      "touch",       "untouch",       "button",         "fault",          "armed",   "disarmed",
      "lease-lost",  "lease-taken",   "device-added",   "device-removed", "overrun", "client-joined",
      "client-left", "model-expired", "object-changed", "refused"};
  return kind < HAPTIC_EVENT_KINDS ? kNames[kind] : "unknown";
}

int haptic_events_open(haptic_client* c, const haptic_events_options* options, haptic_events** events,
                       haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    if (c == nullptr) return client::badArgument("client", "is null");
    if (events == nullptr) return client::badArgument("events", "is null");
    haptic_events_options full = HAPTIC_EVENTS_OPTIONS_INIT;
    if (options != nullptr) {
      if (Failure bad = client::readSized(options, full, 8, "haptic_events_options")) return bad;
    }
    if (Failure bad = client::checkReserved(full.reserved, "haptic_events_options.reserved")) return bad;
    if (full.capacity > kMaxCapacity) {
      return client::badArgument("haptic_events_options.capacity", "is " + std::to_string(full.capacity),
                                 "give at most " + std::to_string(kMaxCapacity));
    }
    auto made = std::make_unique<haptic_events>(c->connection, full);
    if (made->queue->fd() < 0) return {HAPTIC_SYSTEM, "events", strerror(errno), client::kFewerDescriptors};
    // Served from the question on: a link that is lost and renewed before the answer is heard of must renew this, too.
    Failure refusal;
    const Failure broken = c->connection->call([&](Link& link) {
      c->connection->run([&](Connection::Loop& loop) { Connection::add(loop, *made); });
      return Subscribed::ask(made->subscribed, link).then([&] { refusal = made->subscribed->failure; });
    });
    if (broken || refusal) {
      c->connection->run([&](Connection::Loop& loop) {
        Connection::remove(loop, *made);
        made->subscribed->close();
      });
      return broken ? broken : refusal;
    }
    *events = made.release();
    return {};
  });
}

int haptic_events_next(haptic_events* events, haptic_event* event, int64_t timeout_ns) {
  if (events == nullptr || event == nullptr) return HAPTIC_INVALID_ARGUMENT;
  if (!events->connection->ownProcess()) return HAPTIC_DISCONNECTED;
  // The queue is filled by the library's thread: a callback would wait for itself.
  if (timeout_ns != 0 && events->connection->onOwnThread()) return HAPTIC_INVALID_ARGUMENT;
  return client::edge(nullptr, [&]() -> Failure {
    haptic_event full{};
    if (event->size < 8 || event->size % 8 != 0) return {HAPTIC_INVALID_ARGUMENT, {}, {}, {}};
    if (const int code = events->queue->take(full, timeout_ns); code != HAPTIC_OK) return {code, {}, {}, {}};
    return client::writeSized(full, event, "haptic_event");
  });
}

int haptic_events_fd(const haptic_events* events) { return events == nullptr ? -1 : events->queue->fd(); }

void haptic_events_close(haptic_events* events) {
  if (events == nullptr || !events->connection->ownProcess()) return;
  events->connection->run([&](Connection::Loop& loop) {
    Connection::remove(loop, *events);
    events->subscribed->close();
  });
  delete events;
}

}  // extern "C"
