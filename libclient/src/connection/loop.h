/** @file
 * What a connection's own thread works with.
 */
#pragma once

#include <memory>
#include <vector>

#include "libclient/src/connection/connection.h"

namespace hapticd::client {

struct Connection::Loop {
  explicit Loop(Connection& owner);

  /** The daemon hung up, or the client did. Safe within the link's own promises: the link stays until replaced. */
  void lose() noexcept;
  kj::Promise<void> beat();

  Connection& connection;
  kj::AsyncIoContext io;
  kj::PromiseFulfillerPair<void> stop;
  std::vector<Dependent*> dependents;
  std::unique_ptr<Link> link;
  kj::Promise<void> heart = nullptr;
};

}  // namespace hapticd::client
