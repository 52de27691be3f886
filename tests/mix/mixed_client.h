/** @file
 * A client that does whatever clients may do, in any order: by its own choice it leaves in good order, in the middle of
 * something, or stands still until it is killed.
 */
#pragma once

#include <array>
#include <cstdint>
#include <hapticclient/hapticclient.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/random.h"

namespace hapticd::test {

class MixedClient {
 public:
  MixedClient(std::string control, std::string admin, std::uint32_t seed)
      : control_(std::move(control)), admin_(std::move(admin)), random_(seed) {}

  /** Some calls and then its end. What the daemon calls a defect of its own; empty: nothing. */
  std::string run();

 private:
  template <class T>
  bool note(const haptic::Result<T>& result);
  template <std::size_t kCount>
  const char* any(const char* const (&words)[kCount]) {
    return words[random_.below(kCount)];
  }
  std::string name();
  std::string uri();
  haptic::Session* session();
  std::uint32_t objectId();
  haptic_shape shape();
  haptic_pose pose();
  haptic_material material();

  void step();
  void devices();
  void sessions();
  void arm();
  void push();
  void read();
  void create();
  void change();
  void look();
  void mesh();
  void texture();
  void record();
  void events();
  void properties();
  void limits();
  void recover();

  std::string control_, admin_;
  Random random_;
  haptic::Client client_{nullptr};
  std::vector<haptic::Session> sessions_;
  std::vector<haptic::Recording> recordings_;
  std::vector<haptic::Events> events_;
  std::vector<haptic::Upload> uploads_;
  std::vector<std::uint64_t> meshes_, textures_;
  std::vector<std::uint32_t> ids_;
  std::string defect_;
};

}  // namespace hapticd::test
