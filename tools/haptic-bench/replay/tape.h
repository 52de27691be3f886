/** @file
 * One device of a recording, row by row: what exports write.
 */
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "daemon/recording/replayer.h"

namespace haptic_bench {

/** A cycle of one device: as recorded, and what the replay tells besides. */
struct Row {
  std::uint64_t tick = 0;
  double t_s = 0;  ///< Since the first cycle.
  const hapticd::DeviceSample* sample = nullptr;
  const hapticd::DeviceCommand* sent = nullptr;
  const hapticd::DeviceOutput* replayed = nullptr;
  const hapticd::Mount* mount = nullptr;  ///< Where the device stood.
};

/** One quantity of a row: a name and `width` numbers. */
struct Column {
  const char* name;
  const char* unit;
  int width;
  void (*get)(const Row& row, double* out);
};

/** All of them, in the order of export. Names of CSV columns: the name alone, or with x, y, z (w, x, y, z) behind. */
[[nodiscard]] const std::vector<Column>& columns();

/** "px", "py", "pz" for p; "qw" ... for q; "proxy_x" ... for names of more than two letters. */
[[nodiscard]] std::string columnName(const Column& column, int i);

/** Replays to the end and calls `take` for each device of each cycle. Throws Failure that names `recording`. */
void forEachRow(hapticd::Replayer& replayer, const std::string& recording,
                const std::function<void(std::uint32_t device, const Row& row)>& take);

/** Writes the rows of all devices; `device` says whose, from 0. Throws Failure. */
void exportCsv(hapticd::Replayer& replayer, const std::string& recording, const std::string& path);
/** A group per device with a data set per quantity; attributes say what the header says. Throws Failure. */
void exportHdf5(hapticd::Replayer& replayer, const std::string& recording, const std::string& path);

}  // namespace haptic_bench
