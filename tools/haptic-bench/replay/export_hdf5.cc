#include <fmt/format.h>
#include <hdf5.h>

#include <array>
#include <vector>

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/replay/tape.h"

namespace haptic_bench {
namespace {

constexpr hsize_t kChunk = 4096;  ///< Rows.
constexpr unsigned kDeflate = 4;

/** A handle of the library, closed by the function of its kind. */
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t), const std::string& what) : id_(id), close_(close) {
    if (id_ < 0) throw Failure(what, "the HDF5 library refuses", "see the path, its rights and the room on the disk");
  }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&&) = delete;
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  operator hid_t() const { return id_; }  // NOLINT(google-explicit-constructor)

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

void need(herr_t result, const std::string& what) {
  if (result < 0) throw Failure(what, "the HDF5 library refuses", "make room on the disk");
}

void setText(hid_t object, const char* name, const std::string& text) {
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose, name);
  need(H5Tset_size(type, text.size() + 1), name);
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose, name);
  const Handle attribute(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose, name);
  need(H5Awrite(attribute, type, text.c_str()), name);
}

void setNumber(hid_t object, const char* name, double value) {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose, name);
  const Handle attribute(H5Acreate2(object, name, H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose, name);
  need(H5Awrite(attribute, H5T_NATIVE_DOUBLE, &value), name);
}

/** Rows of one quantity, written a chunk at a time. */
class DataSet {
 public:
  DataSet(hid_t group, const Column& column)
      : column_(column), width_(static_cast<hsize_t>(column.width)), set_(make(group, column)) {
    setText(set_, "unit", column.unit);
  }

  void add(const Row& row) {
    const std::size_t at = buffer_.size();
    buffer_.resize(at + width_);
    column_.get(row, buffer_.data() + at);
    if (buffer_.size() == kChunk * width_) flush();
  }

  void flush() {
    const hsize_t count = buffer_.size() / width_;
    if (count == 0) return;
    const std::array<hsize_t, 2> size{rows_ + count, width_}, start{rows_, 0}, block{count, width_};
    need(H5Dset_extent(set_, size.data()), column_.name);
    const Handle file_space(H5Dget_space(set_), H5Sclose, column_.name);
    need(H5Sselect_hyperslab(file_space, H5S_SELECT_SET, start.data(), nullptr, block.data(), nullptr), column_.name);
    const Handle memory(H5Screate_simple(2, block.data(), nullptr), H5Sclose, column_.name);
    need(H5Dwrite(set_, H5T_NATIVE_DOUBLE, memory, file_space, H5P_DEFAULT, buffer_.data()), column_.name);
    rows_ += count;
    buffer_.clear();
  }

 private:
  static Handle make(hid_t group, const Column& column) {
    const auto width = static_cast<hsize_t>(column.width);
    const std::array<hsize_t, 2> size{0, width}, most{H5S_UNLIMITED, width}, chunk{kChunk, width};
    const Handle space(H5Screate_simple(2, size.data(), most.data()), H5Sclose, column.name);
    const Handle how(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, column.name);
    need(H5Pset_chunk(how, 2, chunk.data()), column.name);
    need(H5Pset_shuffle(how), column.name);
    need(H5Pset_deflate(how, kDeflate), column.name);
    // Two quantities are called t: time is a number, torque three.
    const std::string name = column.name == std::string("t") && width == 3 ? "torque" : column.name;
    return {H5Dcreate2(group, name.c_str(), H5T_IEEE_F64LE, space, H5P_DEFAULT, how, H5P_DEFAULT), H5Dclose, name};
  }

  const Column& column_;
  hsize_t width_;
  Handle set_;
  hsize_t rows_ = 0;
  std::vector<double> buffer_;
};

}  // namespace

void exportHdf5(hapticd::Replayer& replayer, const std::string& recording, const std::string& path) {
  H5dont_atexit();                              // What a full disk has refused it would write again at exit, and crash.
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // errors are ours to word
  const hapticd::RecordingHeader& header = replayer.recording().header();
  const Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose, path);
  setText(file, "program", "hapticd " + header.program);
  setText(file, "build", header.build);
  setText(file, "instructions", header.instructions);
  setNumber(file, "started_unix_s", static_cast<double>(header.started_ns) * 1e-9);
  setNumber(file, "period_s", static_cast<double>(header.start.config.period_ns) * 1e-9);
  std::vector<Handle> groups;
  std::vector<std::vector<DataSet>> sets(header.devices.size());
  for (std::size_t d = 0; d < header.devices.size(); ++d) {
    const std::string name = fmt::format("device{}", d);
    groups.emplace_back(H5Gcreate2(file, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose, name);
    setText(groups.back(), "name", header.devices[d].name);
    setText(groups.back(), "uri", header.devices[d].uri);
    setText(groups.back(), "model", header.devices[d].model);
    sets[d].reserve(columns().size());
    for (const Column& column : columns()) sets[d].emplace_back(groups.back(), column);
  }
  forEachRow(replayer, recording, [&](std::uint32_t device, const Row& row) {
    for (DataSet& set : sets[device]) set.add(row);
  });
  for (auto& device : sets) {
    for (DataSet& set : device) set.flush();
  }
  need(H5Fflush(file, H5F_SCOPE_GLOBAL), path);
}

}  // namespace haptic_bench
