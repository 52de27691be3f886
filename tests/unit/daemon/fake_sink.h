/** @file
 * A servo that only remembers its orders.
 */
#pragma once

#include <memory>
#include <vector>

#include "daemon/scene/command_sink.h"

namespace hapticd::test {

class FakeSink final : public CommandSink {
 public:
  std::uint64_t post(const Command& command) override {
    orders.push_back(command);
    return orders.size();
  }
  [[nodiscard]] std::uint64_t posted() const override { return orders.size(); }
  [[nodiscard]] bool passed(std::uint64_t ticket) override { return ticket <= taken; }
  [[nodiscard]] bool accepting() const override { return accepts; }
  [[nodiscard]] std::uint64_t nextTick() const override { return next_tick; }
  [[nodiscard]] std::int64_t periodNs() const override { return period_ns; }
  [[nodiscard]] MeshTable& meshes() override { return *table_; }
  [[nodiscard]] bool posed(std::uint32_t slot, std::uint64_t ticket, PosedObject& out) override {
    if (ticket > taken || slot != board.object % 65536) return false;
    out = board;
    return true;
  }

  std::vector<Command> orders;
  std::uint64_t taken = 0;
  bool accepts = true;
  std::uint64_t next_tick = 0;
  std::int64_t period_ns = 1'000'000;
  PosedObject board;  ///< The one entry of the board.

 private:
  std::unique_ptr<MeshTable> table_ = std::make_unique<MeshTable>();
};

}  // namespace hapticd::test
