#include "tests/model/weak_memory.h"

#include <ucontext.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <random>
#include <unordered_map>
#include <utility>
#include <vector>

namespace hapticd::model {
namespace {

constexpr int kMostThreads = 4, kNobody = -1;
constexpr std::size_t kStackBytes = 64 * 1024;

/** How many of each thread's stores are known. */
using Clock = std::array<std::uint32_t, kMostThreads>;

void join(Clock& into, const Clock& other) {
  for (std::size_t i = 0; i < into.size(); ++i) into[i] = std::max(into[i], other[i]);
}

struct Stored {
  std::uint64_t value = 0;
  int by = kNobody;  ///< Nobody: stood there from the start, and everybody knows it.
  std::uint32_t event = 0;
  bool released = false;
  Clock clock{};  ///< Of what was released: what an acquire load comes to know.
};

struct Location {
  std::vector<Stored> stored;  ///< In modification order.
  std::array<std::size_t, kMostThreads> seen{};
  std::size_t last_sc = 0;
};

bool acquires(int order) {
  return order == __ATOMIC_ACQUIRE || order == __ATOMIC_ACQ_REL || order == __ATOMIC_SEQ_CST ||
         order == __ATOMIC_CONSUME;
}
bool releases(int order) { return order == __ATOMIC_RELEASE || order == __ATOMIC_ACQ_REL || order == __ATOMIC_SEQ_CST; }

/** Draws, or goes through all sequences of choices, depth first. */
class Chooser {
 public:
  virtual ~Chooser() = default;
  virtual std::size_t choose(std::size_t of) = 0;
  /** Which goes on, of those that can: `now` among them, or none of them. */
  virtual std::size_t turn(std::size_t of, std::size_t now) = 0;
};

class All final : public Chooser {
 public:
  std::size_t choose(std::size_t of) override {
    if (of == 1) return 0;
    if (depth_ == path_.size()) path_.emplace_back(0, of);
    return path_[depth_++].first;
  }
  std::size_t turn(std::size_t of, std::size_t /*now*/) override { return choose(of); }
  /** False: that was the last. */
  bool next() {
    depth_ = 0;
    while (!path_.empty() && path_.back().first + 1 == path_.back().second) path_.pop_back();
    if (path_.empty()) return false;
    ++path_.back().first;
    return true;
  }

 private:
  std::vector<std::pair<std::size_t, std::size_t>> path_;  ///< What was taken, of how many.
  std::size_t depth_ = 0;
};

class Drawn final : public Chooser {
 public:
  explicit Drawn(std::uint64_t seed) : random_(seed) {}
  /** The newest in half the cases: who always saw old values would hardly come to an end. */
  std::size_t choose(std::size_t of) override { return random_() % 2 == 0 ? of - 1 : random_() % of; }
  /** Now and then, now rarely, and now at every operation. */
  std::size_t turn(std::size_t of, std::size_t now) override {
    return now < of && random_() % stay_ != 0 ? now : random_() % of;
  }
  void next() {
    static constexpr std::array<std::uint64_t, 5> kStay{1, 2, 6, 25, 100};
    stay_ = kStay[random_() % kStay.size()];
  }

 private:
  std::mt19937_64 random_;
  std::uint64_t stay_ = 1;
};

class Machine final : public Threads {
 public:
  explicit Machine(Chooser& chooser) : chooser_(chooser) {}

  void add(std::function<void()> body) override {
    auto fibre = std::make_unique<Fibre>();
    fibre->body = std::move(body);
    fibres_.push_back(std::move(fibre));
  }

  void go() override;

  Mark mark() override { return {now_, clock()[static_cast<std::size_t>(now_)]}; }
  bool knows(Mark mark) override { return clock()[static_cast<std::size_t>(mark.thread)] >= mark.event; }
  bool knowsMoreThan(Mark mark) override { return clock()[static_cast<std::size_t>(mark.thread)] > mark.event; }
  void plain(const void* begin, std::size_t bytes) override {
    plain_.emplace_back(reinterpret_cast<std::uintptr_t>(begin), reinterpret_cast<std::uintptr_t>(begin) + bytes);
  }
  void expect(bool ok, const char* what) override {
    if (!ok && failure_.empty()) failure_ = what;
  }

  [[nodiscard]] const std::string& failure() const { return failure_; }
  [[nodiscard]] bool inThread() const { return now_ != kNobody; }
  std::uint64_t load(const void* at, std::size_t bytes, int order);
  void store(void* at, std::size_t bytes, std::uint64_t value, int order);
  std::uint64_t change(void* at, std::size_t bytes, int order, std::uint64_t (*next)(std::uint64_t, std::uint64_t),
                       std::uint64_t with);

 private:
  struct Fibre {
    std::function<void()> body;
    std::unique_ptr<char[]> stack = std::make_unique_for_overwrite<char[]>(kStackBytes);
    ucontext_t context{};
    Clock clock{};
    bool done = false;
  };

  static void enter();
  Clock& clock() { return fibres_[static_cast<std::size_t>(now_)]->clock; }
  [[nodiscard]] std::size_t me() const { return static_cast<std::size_t>(now_); }
  /** Lets the chooser say who goes on. */
  void yield();
  Location& location(const void* at, std::size_t bytes);
  void append(Location& where, void* at, std::size_t bytes, const Stored& stored, int order);
  [[nodiscard]] bool isPlain(const void* at) const {
    const auto address = reinterpret_cast<std::uintptr_t>(at);
    return std::any_of(plain_.begin(), plain_.end(),
                       [&](const auto& range) { return address >= range.first && address < range.second; });
  }

  Chooser& chooser_;
  std::vector<std::unique_ptr<Fibre>> fibres_;
  std::vector<std::pair<std::uintptr_t, std::uintptr_t>> plain_;
  std::unordered_map<const void*, Location> locations_;
  ucontext_t outside_{};
  int now_ = kNobody;
  std::string failure_;
};

Machine* machine = nullptr;

void Machine::enter() {
  Fibre& self = *machine->fibres_[machine->me()];
  self.body();
  self.done = true;
  machine->yield();
}

void Machine::yield() {
  std::array<std::size_t, kMostThreads> able{};
  std::size_t count = 0, now = kMostThreads;
  for (std::size_t i = 0; i < fibres_.size(); ++i) {
    if (fibres_[i]->done) continue;
    if (i == me()) now = count;
    able[count++] = i;
  }
  ucontext_t& from = fibres_[me()]->context;
  if (count == 0) {
    now_ = kNobody;
    setcontext(&outside_);
  }
  const std::size_t next = able[chooser_.turn(count, now)];
  if (next == me()) return;
  now_ = static_cast<int>(next);
  swapcontext(&from, &fibres_[next]->context);
}

void Machine::go() {
  for (const auto& fibre : fibres_) {
    getcontext(&fibre->context);
    fibre->context.uc_stack.ss_sp = fibre->stack.get();
    fibre->context.uc_stack.ss_size = kStackBytes;
    makecontext(&fibre->context, &Machine::enter, 0);
  }
  now_ = static_cast<int>(chooser_.turn(fibres_.size(), fibres_.size()));
  swapcontext(&outside_, &fibres_[me()]->context);
}

Location& Machine::location(const void* at, std::size_t bytes) {
  Location& where = locations_[at];
  if (where.stored.empty()) {
    Stored first;
    std::memcpy(&first.value, at, bytes);
    where.stored.push_back(first);
  }
  return where;
}

std::uint64_t Machine::load(const void* at, std::size_t bytes, int order) {
  if (isPlain(at)) {
    std::uint64_t value = 0;
    std::memcpy(&value, at, bytes);
    return value;
  }
  yield();
  Location& where = location(at, bytes);
  std::size_t oldest = where.stored.size() - 1;
  const auto known = [&](const Stored& stored) {
    return stored.by == kNobody || stored.event <= clock()[static_cast<std::size_t>(stored.by)];
  };
  while (oldest > where.seen[me()] && !known(where.stored[oldest])) --oldest;
  if (order == __ATOMIC_SEQ_CST) oldest = std::max(oldest, where.last_sc);
  const std::size_t taken = oldest + chooser_.choose(where.stored.size() - oldest);
  where.seen[me()] = taken;
  const Stored& stored = where.stored[taken];
  if (acquires(order) && stored.released) join(clock(), stored.clock);
  return stored.value;
}

void Machine::append(Location& where, void* at, std::size_t bytes, const Stored& stored, int order) {
  where.stored.push_back(stored);
  where.seen[me()] = where.stored.size() - 1;
  if (order == __ATOMIC_SEQ_CST) where.last_sc = where.stored.size() - 1;
  std::memcpy(at, &stored.value, bytes);  // For what looks when the run is over.
}

void Machine::store(void* at, std::size_t bytes, std::uint64_t value, int order) {
  yield();
  Location& where = location(at, bytes);
  const std::uint32_t event = ++clock()[me()];
  append(where, at, bytes, {value, now_, event, releases(order), releases(order) ? clock() : Clock{}}, order);
}

std::uint64_t Machine::change(void* at, std::size_t bytes, int order,
                              std::uint64_t (*next)(std::uint64_t, std::uint64_t), std::uint64_t with) {
  yield();
  Location& where = location(at, bytes);
  const Stored old = where.stored.back();
  if (acquires(order) && old.released) join(clock(), old.clock);
  Stored changed{next(old.value, with), now_, ++clock()[me()], releases(order) || old.released, {}};
  if (old.released) changed.clock = old.clock;  // It continues the release sequence of what it replaces.
  if (releases(order)) join(changed.clock, clock());
  append(where, at, bytes, changed, order);
  return old.value;
}

/** One run; what failed. */
std::string runOnce(Chooser& chooser, const Body& body) {
  Machine run(chooser);
  machine = &run;
  body(run);
  machine = nullptr;
  return run.failure();
}

}  // namespace

// What intercept.h declares.
bool running() { return machine != nullptr && machine->inThread(); }
std::uint64_t modelLoad(const void* at, std::size_t bytes, int order) { return machine->load(at, bytes, order); }
void modelStore(void* at, std::size_t bytes, std::uint64_t value, int order) {
  machine->store(at, bytes, value, order);
}
std::uint64_t modelChange(void* at, std::size_t bytes, int order, std::uint64_t (*next)(std::uint64_t, std::uint64_t),
                          std::uint64_t with) {
  return machine->change(at, bytes, order, next, with);
}

Found exploreAll(const Body& body) {
  Found found;
  All all;
  do {
    ++found.runs;
    found.failure = runOnce(all, body);
    if (!found.failure.empty()) return found;
    found.all = !all.next();
  } while (!found.all && found.runs < kMostRuns);
  return found;
}

Found exploreSome(std::uint64_t runs, std::uint64_t seed, const Body& body) {
  Found found;
  Drawn drawn(seed);
  while (found.runs < runs && found.failure.empty()) {
    ++found.runs;
    drawn.next();
    found.failure = runOnce(drawn, body);
  }
  return found;
}

}  // namespace hapticd::model
