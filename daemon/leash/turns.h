/** @file
 * Work of many clients for one who does it: each has its turn, so that a client's flood delays itself.
 */
#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <list>
#include <utility>

namespace hapticd {

/**
 * The first of each client's waiting jobs, one client after the other: before a client's first job comes at most one of
 * every other that waits. In lists, which hand a job on without memory.
 */
template <class Job>
class Turns {
  struct Turn {
    std::uint64_t client;
    std::list<Job> jobs;  ///< Never empty.
  };

 public:
  void push(std::uint64_t client, Job job) {
    std::list<Job> one;
    one.push_back(std::move(job));
    // From the end: what pushFirst() has put before the others is a turn of its own.
    const auto own =
        std::find_if(turns_.rbegin(), turns_.rend(), [&](const Turn& turn) { return turn.client == client; });
    if (own != turns_.rend()) return own->jobs.splice(own->jobs.end(), one);
    turns_.push_back({client, std::move(one)});
  }
  /** Memory for a job that may come back. */
  class Place {
   public:
    Place() {
      turn_.emplace_back();
      turn_.front().jobs.emplace_back();
    }

   private:
    friend class Turns;
    std::list<Turn> turn_;
  };
  /** Before all others: it has had its turn already. */
  void pushFirst(std::uint64_t client, Job job, Place place) noexcept {
    Turn& turn = place.turn_.front();
    turn.client = client;
    turn.jobs.front() = std::move(job);
    turns_.splice(turns_.begin(), place.turn_);
  }

  [[nodiscard]] bool empty() const noexcept { return turns_.empty(); }
  [[nodiscard]] std::size_t size() const noexcept {
    std::size_t sum = 0;
    for (const Turn& turn : turns_) sum += turn.jobs.size();
    return sum;
  }

  /** The job whose turn it is, at the end of `to`. Not of none. */
  void next(std::list<Job>& to) noexcept {
    Turn& turn = turns_.front();
    to.splice(to.end(), turn.jobs, turn.jobs.begin());
    if (turn.jobs.empty()) {
      turns_.pop_front();
    } else {
      turns_.splice(turns_.end(), turns_, turns_.begin());
    }
  }
  /** The first job of which `is` is true, at the end of `to`; false: there is none. */
  template <class Is>
  bool take(Is&& is, std::list<Job>& to) {
    for (auto turn = turns_.begin(); turn != turns_.end(); ++turn) {
      const auto found = std::find_if(turn->jobs.begin(), turn->jobs.end(), is);
      if (found == turn->jobs.end()) continue;
      to.splice(to.end(), turn->jobs, found);
      if (turn->jobs.empty()) turns_.erase(turn);
      return true;
    }
    return false;
  }

 private:
  std::list<Turn> turns_;
};

}  // namespace hapticd
