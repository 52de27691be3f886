#include "tools/haptic-bench/collide/timing.h"

#include <time.h>

#include <algorithm>
#include <cstdint>
#include <numeric>

#include "tools/haptic-bench/metric/quantile.h"

namespace haptic_bench {
namespace {

constexpr std::size_t kColdBytes = 96u << 20;

double read(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return 1e9 * static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec);
}

/** Leaves nothing of the query in the caches. */
void walk(std::vector<std::uint64_t>& memory) {
  for (std::size_t i = 0; i < memory.size(); i += 8) memory[i] += i;
}

}  // namespace

Times summarise(std::vector<double> ms, std::size_t passes) {
  Times times;
  times.count = ms.size();
  if (ms.empty()) return times;
  const std::size_t poses = std::max<std::size_t>(1, ms.size() / std::max<std::size_t>(1, passes));
  std::vector<double> medians, one;
  for (std::size_t i = 0; i < poses; ++i) {
    one.clear();
    for (std::size_t j = i; j < ms.size(); j += poses) one.push_back(ms[j]);
    medians.push_back(middleOf(one));
  }
  std::sort(medians.begin(), medians.end());
  times.steady999 = nearestRank(medians, 0.999);
  std::sort(ms.begin(), ms.end());
  times.mean = std::accumulate(ms.begin(), ms.end(), 0.0) / static_cast<double>(ms.size());
  times.p50 = nearestRank(ms, 0.5);
  times.p99 = nearestRank(ms, 0.99);
  times.p999 = nearestRank(ms, 0.999);
  times.max = ms.back();
  return times;
}

double threadNs() { return read(CLOCK_THREAD_CPUTIME_ID); }
double processNs() { return read(CLOCK_PROCESS_CPUTIME_ID); }

double readingNs() {
  double least = 1e9;
  for (int i = 0; i < 1000; ++i) {
    const double start = threadNs();
    least = std::min(least, threadNs() - start);
  }
  return least;
}

std::vector<double> timeQueries(const std::vector<hapticd::Pose>& poses, const TimingOptions& options,
                                const std::function<void(std::size_t)>& query) {
  std::vector<double> ms;
  std::vector<std::uint64_t> memory(options.cold ? kColdBytes / sizeof(std::uint64_t) : 0);
  const double reading = readingNs();
  const double end = threadNs() + options.seconds * 1e9;
  for (int pass = 0; pass < options.passes && (pass == 0 || threadNs() < end); ++pass) {
    for (std::size_t i = 0; i < poses.size(); i += static_cast<std::size_t>(options.stride)) {
      if (options.cold) walk(memory);
      const double start = threadNs();
      query(i);
      ms.push_back(std::max(0.0, threadNs() - start - reading) * 1e-6);
    }
  }
  return ms;
}

}  // namespace haptic_bench
