/** @file
 * The connection to hapticd as the commands use it: libhapticclient's C interface, owned and with its errors thrown.
 */
#pragma once

#include <hapticclient/hapticclient.h>

#include <memory>
#include <string>

namespace hapticctl {

/** Options that every command has. */
struct Globals {
  bool json = false;
  bool admin = false;
  std::string socket;
  double timeout_s = 5;
};

struct FreeResult {
  void operator()(const void* result) const { haptic_free(result); }
};
/** A result of libhapticclient. */
template <class T>
using Owned = std::unique_ptr<T, FreeResult>;

/** Throws the refusal as a Failure, unless code is HAPTIC_OK. A lost connection ends with kExitDisconnected. */
void check(int code, const haptic_error& error);

/** A standing connection. Throws Failure with kExitNoDaemon when nobody answers. */
class Daemon {
 public:
  explicit Daemon(const Globals& globals);

  [[nodiscard]] haptic_client* client() const { return client_.get(); }

  /** Calls function(client, arguments..., &result, &error) and returns the result. */
  template <class T, class Function, class... Arguments>
  [[nodiscard]] Owned<T> ask(Function function, Arguments... arguments) const {
    T* result = nullptr;
    haptic_error error = HAPTIC_ERROR_INIT;
    check(function(client(), arguments..., &result, &error), error);
    return Owned<T>(result);
  }
  /** Calls function(client, arguments..., &error). */
  template <class Function, class... Arguments>
  void tell(Function function, Arguments... arguments) const {
    haptic_error error = HAPTIC_ERROR_INIT;
    check(function(client(), arguments..., &error), error);
  }

 private:
  struct Disconnect {
    void operator()(haptic_client* client) const { haptic_disconnect(client); }
  };
  std::unique_ptr<haptic_client, Disconnect> client_;
};

/** A session with a device; closing it disarms and releases. */
class Session {
 public:
  /** `device`: URI, name or serial; empty: the one that is open, else what the daemon chooses. */
  Session(const Daemon& daemon, const std::string& device);

  [[nodiscard]] haptic_session* get() const { return session_.get(); }
  [[nodiscard]] const haptic_session_info& info() const { return *info_; }

  template <class Function>
  void tell(Function function) const {
    haptic_error error = HAPTIC_ERROR_INIT;
    check(function(get(), &error), error);
  }

 private:
  struct Close {
    void operator()(haptic_session* session) const { haptic_session_close(session); }
  };
  std::unique_ptr<haptic_session, Close> session_;
  Owned<haptic_session_info> info_;
};

/** The device of that URI, name or serial in the daemon's list; empty: the first. Throws Failure naming what there is.
 */
[[nodiscard]] const haptic_device_info& findDevice(const haptic_device_list& devices, const std::string& wanted);
/** Its canonical URI; empty stays empty (the daemon's choice). */
[[nodiscard]] std::string deviceUri(const Daemon& daemon, const std::string& wanted);

/** "emergency stop", "velocity", ... for a haptic_fault. */
[[nodiscard]] const char* faultName(std::uint32_t fault);

}  // namespace hapticctl
