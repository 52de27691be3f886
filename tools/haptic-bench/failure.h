/** @file
 * The one exception of haptic-bench: bad input or a machine that refuses. main() prints it and ends with 1.
 */
#pragma once

#include <stdexcept>
#include <string>

#include "rt/base/error.h"

namespace haptic_bench {

/** Where, what and the remedy, as "where: what (remedy)". */
class Failure : public std::runtime_error {
 public:
  Failure(const std::string& where, const std::string& what, const std::string& remedy);
  explicit Failure(const std::string& sentence) : std::runtime_error(sentence) {}  ///< Which says it all.
  explicit Failure(const hapticd::Error& error) : std::runtime_error(hapticd::toString(error)) {}
};

/** The value, or a Failure with the error. */
template <class T>
[[nodiscard]] T orFail(hapticd::Result<T> result) {
  if (!result.ok()) throw Failure(result.error());
  return std::move(*result);
}

/** The same for an error of a recording: some name the block alone, and the file is ours to name. */
template <class T>
[[nodiscard]] T orFailIn(const std::string& file, hapticd::Result<T> result) {
  if (result.ok()) return std::move(*result);
  const std::string words = hapticd::toString(result.error());
  if (words.compare(0, file.size(), file) == 0) throw Failure(words);
  throw Failure(file, words, {});
}

/** A Failure with the error, if there is one. */
inline void orFail(const hapticd::Result<void>& result) {
  if (!result.ok()) throw Failure(result.error());
}

}  // namespace haptic_bench
