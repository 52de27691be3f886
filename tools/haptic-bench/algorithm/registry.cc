#include "tools/haptic-bench/algorithm/registry.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <set>

#include "tools/haptic-bench/algorithm/algorithms.h"
#include "tools/haptic-bench/failure.h"

namespace haptic_bench {
namespace {

constexpr const haptic_algorithm* kInTheBox[] = {&kOurs, &kGodObject, &kNearest, &kVoxel, &kLocal, &kDaemon, &kClient};

bool isPlugin(const std::string& name) { return name.find('/') != std::string::npos; }

const haptic_algorithm* load(const std::string& path) {
  const PluginWatch watch(path);  // Its constructors run too.
  void* object = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (object == nullptr) {
    // The loader's words begin with the path, but for some.
    const std::string words = dlerror(), begin = path + ": ";
    throw Failure(path, words.compare(0, begin.size(), begin) == 0 ? words.substr(begin.size()) : words,
                  "a shared object built for this machine");
  }
  void* symbol = dlsym(object, HAPTIC_ALGORITHM_SYMBOL);
  if (symbol == nullptr) {
    throw Failure(path, "it has no function " HAPTIC_ALGORITHM_SYMBOL, "see haptic_algorithm.h");
  }
  const haptic_algorithm* table = reinterpret_cast<const haptic_algorithm* (*)()>(symbol)();
  if (table == nullptr) throw Failure(path, "its " HAPTIC_ALGORITHM_SYMBOL "() answers null", "see haptic_algorithm.h");
  return table;
}

}  // namespace

void checkAlgorithm(const haptic_algorithm* table, const std::string& where) {
  if (table->version != HAPTIC_ALGORITHM_VERSION) {
    throw Failure(
        where,
        fmt::format("its interface is version {}, this haptic-bench has {}", table->version, HAPTIC_ALGORITHM_VERSION),
        "build it with the haptic_algorithm.h of this version");
  }
  if (table->bytes != sizeof(haptic_algorithm)) {
    throw Failure(where, fmt::format("its table has {} bytes instead of {}", table->bytes, sizeof(haptic_algorithm)),
                  "set bytes to sizeof(haptic_algorithm)");
  }
  if (table->name == nullptr || table->create == nullptr || table->destroy == nullptr || table->start == nullptr ||
      table->step == nullptr) {
    throw Failure(where, "its table lacks a name or a function", "only summary and memory_bytes may be null");
  }
}

const haptic_algorithm& findAlgorithm(const std::string& spec) {
  const std::string name = spec.substr(0, spec.find(':'));
  const haptic_algorithm* found = nullptr;
  for (const haptic_algorithm* one : kInTheBox) {
    if (name == one->name) found = one;
  }
  if (found == nullptr && isPlugin(name)) found = load(name);
  if (found == nullptr) {
    std::string names;
    for (const haptic_algorithm* one : kInTheBox) names += std::string(one->name) + ", ";
    throw Failure(spec, "there is no such algorithm", names + "or the path of a shared object, as ./mine.so");
  }
  checkAlgorithm(found, spec);
  return *found;
}

std::string algorithmHelp() {
  std::string help = "Algorithms:\n";
  for (const haptic_algorithm* one : kInTheBox) help += fmt::format("  {}: {}\n", one->name, one->summary);
  return help + "  ./FILE.so: a plug-in (haptic_algorithm.h)\n";
}

void requireNames(const std::vector<std::string>& algorithms) {
  std::set<std::string> seen;
  for (const std::string& one : algorithms) {
    if (!seen.insert(one).second) throw Failure("--algorithm", one + " is named twice", "more --rounds repeat it");
    (void)findAlgorithm(one);
  }
}

Algorithm::Algorithm(const std::string& spec, const haptic_algorithm_problem& problem)
    : table_(&findAlgorithm(spec)), instance_(nullptr, table_->destroy) {
  const std::size_t colon = spec.find(':');
  if (isPlugin(spec.substr(0, colon))) watch_.emplace(spec);
  haptic_algorithm_problem own = problem;
  own.options = colon == std::string::npos ? "" : spec.c_str() + colon + 1;
  char error[512] = "no reason given";
  try {
    instance_.reset(table_->create(&own, error, sizeof error));
  } catch (const std::exception& thrown) {
    throw Failure(spec, fmt::format("it has thrown \"{}\"", thrown.what()),
                  "mend the algorithm: no function of it may throw");
  }
  error[sizeof error - 1] = 0;
  if (instance_ != nullptr) return;
  // Those in the box begin with their own name.
  const std::string reason = error, name = spec.substr(0, colon);
  if (reason.compare(0, name.size(), name) == 0) throw Failure(reason);
  throw Failure(spec, reason, "");
}

void Algorithm::start(const Vec3& hip) { table_->start(instance_.get(), hip.data()); }

std::uint64_t Algorithm::bytes() const {
  return table_->memory_bytes == nullptr ? 0 : table_->memory_bytes(instance_.get());
}

}  // namespace haptic_bench
