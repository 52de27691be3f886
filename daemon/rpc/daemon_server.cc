#include <fmt/format.h>

#include <algorithm>

#include "daemon/rpc/servers.h"
#include "daemon/rpc/status.h"

namespace hapticd {
namespace {

Result<std::string> readUri(capnp::Text::Reader in) { return readText(in, kMostUri, "uri"); }

/** Of what a client no longer waits for: it is not done behind its back. */
Error givenUp() { return {ErrorCode::kTimeout, "client", "it waits no more", {}}; }

template <class Results>
void writeSession(Results results, Core& core, const Session& session) {
  KJ_ON_SCOPE_FAILURE(core.sessions().end(session.id, "it could not be handed out"));
  results.setSession(kj::heap<SessionServer>(core, session.id));
  auto info = results.initInfo();
  info.setId(session.id);
  info.setEpoch(core.epoch());
  write(info.initDevice(), *session.device);
  info.setDeviceIndex(session.device->index);
  info.setDeviceCount(static_cast<std::uint32_t>(session.link->group().deviceCount()));
  info.setPeriodNs(session.link->group().options().cycle.period_ns);
  info.setRegionABytes(session.regions.fileA().size());
  info.setRegionBBytes(session.regions.fileB().size());
}

template <class Results>
void writeDevices(Results results, Core& core, std::vector<hapticd::DeviceInfo> found) {
  const auto& open = core.devices().devices();
  const auto absent = core.wanted().absent();
  for (const auto& one : absent) {
    const auto is = [&](const hapticd::DeviceInfo& info) { return info.uri == one.uri; };
    if (std::none_of(found.begin(), found.end(), is)) found.emplace_back().uri = one.uri;
  }
  auto list = results.initDevices(static_cast<unsigned>(open.size() + found.size()));
  for (unsigned i = 0; i < open.size(); ++i) write(list[i], *open[i]);
  for (unsigned i = 0; i < found.size(); ++i) {
    auto row = list[static_cast<unsigned>(open.size()) + i];
    write(row, found[i]);
    for (const auto& one : absent) {
      if (one.uri == found[i].uri) row.setProblem(log::printable(toString(one.why)));
    }
  }
}

}  // namespace

kj::Promise<void> DaemonServer::hello(HelloContext context) {
  return answer(context, [&](auto params, auto results) -> Result<void> {
    auto name = readText(params.getClientName(), kMostClient, "clientName");
    if (!name) return name.error();
    if (params.getProtocolMajor() != proto::PROTOCOL_MAJOR) {
      return Error{ErrorCode::kVersionMismatch, "protocolMajor",
                   fmt::format("the client speaks {}.{}, the daemon {}.{}", params.getProtocolMajor(),
                               params.getProtocolMinor(), proto::PROTOCOL_MAJOR, proto::PROTOCOL_MINOR),
                   params.getProtocolMajor() > proto::PROTOCOL_MAJOR ? "update hapticd" : "update the client"};
    }
    core_.introduce(connection_, name->empty() ? fmt::format("pid {}", client().pid) : std::move(*name));
    writeInfo(results.initInfo(), core_, client().administration);
    return {};
  });
}

kj::Promise<void> DaemonServer::listDevices(ListDevicesContext context) {
  return answerLater(context, [&](auto, auto later) -> Result<void> {
    core_.devices().found([later, &core = core_](const Result<std::vector<hapticd::DeviceInfo>>& found) {
      later->answer([&](auto results) -> Result<void> {
        if (!found) return found.error();
        writeDevices(results, core, *found);
        return {};
      });
    });
    return {};
  });
}

kj::Promise<void> DaemonServer::openDevice(OpenDeviceContext context) {
  return answerLater(context, [&](auto params, auto later) -> Result<void> {
    auto uri = readUri(params.getUri());
    if (!uri) return uri.error();
    core_.openDevice(*uri, connection_, [later](const Result<OpenDevice*>& device) {
      later->answer([&](auto results) -> Result<void> {
        if (!device) return device.error();
        write(results.initDevice(), *device.value());
        return {};
      });
    });
    return {};
  });
}

kj::Promise<void> DaemonServer::closeDevice(CloseDeviceContext context) {
  return answerLater(context, [&](auto params, auto later) -> Result<void> {
    auto uri = readUri(params.getUri());
    if (!uri) return uri.error();
    const auto close = [&core = core_, by = connection_, uri = std::string(*uri), later] {
      return caught([&] { return later->waiting() ? core.closeDevice(uri, by) : Result<void>(givenUp()); });
    };
    core_.onceLowered(connection_, close, [later](const Result<void>& closed) { later->done(closed); });
    return {};
  });
}

kj::Promise<void> DaemonServer::openSession(OpenSessionContext context) {
  return answerLater(context, [&](auto params, auto later) -> Result<void> {
    auto uri = readUri(params.getUri());
    if (!uri) return uri.error();
    auto name = readText(params.getClientName(), kMostClient, "clientName");
    if (!name) return name.error();
    core_.openSession(*uri, connection_, *name, params.getLayoutMajor(), params.getLayoutMinor(),
                      [later, &core = core_](const Result<Session*>& opened) {
                        if (!later->waiting()) {
                          if (opened) core.sessions().end((*opened.value()).id, "nobody waits for it any more");
                          return;
                        }
                        later->answer([&](auto results) -> Result<void> {
                          if (!opened) return opened.error();
                          writeSession(results, core, *opened.value());
                          return {};
                        });
                      });
    return {};
  });
}

kj::Promise<void> DaemonServer::scene(SceneContext context) {
  return answer(context, [&](auto, auto results) -> Result<void> {
    // One object for every request: else a client that never releases any would make the daemon keep them all.
    KJ_IF_MAYBE (scene, scene_) {
      results.setScene(*scene);
    } else {
      results.setScene(scene_.emplace(kj::heap<SceneServer>(core_, connection_)));
    }
    return {};
  });
}

kj::Promise<void> DaemonServer::get(GetContext context) {
  return answer(context, [&](auto params, auto results) -> Result<void> {
    const auto path = params.getPath();
    auto json = ResourceTree(core_).get({path.begin(), path.size()}, client());
    if (!json) return json.error();
    results.setJson(text(*json));
    return {};
  });
}

kj::Promise<void> DaemonServer::set(SetContext context) {
  return answerLater(context, [&](auto params, auto later) -> Result<void> {
    const std::string uri(params.getUri().begin(), params.getUri().size());
    const auto json = std::make_shared<std::string>();
    const auto set = [&core = core_, by = connection_, uri, json, later] {
      return caught([&]() -> Result<void> {
        if (!later->waiting()) return givenUp();
        auto now = core.editFor(by, [&] { return ResourceTree(core).set(uri, core.client(by)); });
        if (!now) return now.error();
        *json = std::move(*now);
        return {};
      });
    };
    const auto told = [later, json](const Result<void>& done) {
      later->answer([&](auto results) -> Result<void> {
        if (done) results.setJson(text(*json));
        return done;
      });
    };
    if (uri.starts_with("/devices/")) {
      core_.onceLowered(connection_, set, told);
    } else {
      told(set());
    }
    return {};
  });
}

kj::Promise<void> DaemonServer::state(StateContext context) {
  return answer(context, [&](auto, auto results) -> Result<void> {
    writeState(results.initState(), core_, client().administration);
    return {};
  });
}

kj::Promise<void> DaemonServer::statistics(StatisticsContext context) {
  return answer(context, [&](auto params, auto results) -> Result<void> {
    auto uri = readUri(params.getUri());
    if (!uri) return uri.error();
    auto device = core_.devices().find(*uri);
    if (!device) return device.error();
    if (params.getReset() && !client().administration) {
      const std::string& socket = core_.facts().admin_socket;
      return Error{ErrorCode::kPermissionDenied, "reset", "resetting statistics needs the administration socket",
                   socket.empty() ? "" : "connect to " + socket};
    }
    writeStatistics(results.initStatistics(), **device);
    if (params.getReset()) resetStatistics(**device);
    return {};
  });
}

kj::Promise<void> DaemonServer::subscribe(SubscribeContext context) {
  return answer(context, [&](auto params, auto results) -> Result<void> {
    constexpr std::uint32_t kAll = (1u << kEventKinds) - 1;
    if (!params.hasListener())
      return Error{ErrorCode::kInvalidArgument, "listener", "there is none", "pass a listener"};
    if ((params.getKinds() & ~kAll) != 0) {
      return Error{ErrorCode::kInvalidArgument, "kinds", fmt::format("bits beyond {} name no event", kEventKinds - 1),
                   "0 means all"};
    }
    const Clients::Subscriber by{client().uid, client().administration};
    if (auto r = core_.clients().subscriptionOpened(by); !r) return r;
    bool made = false;  // Then it counts for itself.
    KJ_DEFER(if (!made) core_.clients().subscriptionDropped(by));
    auto subscription = kj::heap<SubscriptionServer>(core_, by, params.getListener(), params.getKinds());
    made = true;
    results.setSubscription(kj::mv(subscription));
    return {};
  });
}

kj::Promise<void> DaemonServer::stop(StopContext context) {
  return answerAfter(context, [&](auto params) -> Result<void> {
    const capnp::Text::Reader uri = params.getUri();  // Not copied: what makes safe needs no memory.
    if (auto r = checkText(uri, kMostUri, "uri"); !r) return r.error();
    return core_.stop({uri.begin(), uri.size()}, connection_);
  });
}

kj::Promise<void> DaemonServer::setLimits(SetLimitsContext context) {
  return answer(context, [&](auto params, auto results) -> Result<void> {
    auto uri = readUri(params.getUri());
    if (!uri) return uri.error();
    if (!params.hasLimits()) return Error{ErrorCode::kInvalidArgument, "limits", "there are none", "give limits"};
    auto limits =
        core_.editFor(connection_, [&] { return core_.setLimits(*uri, read(params.getLimits()), connection_); });
    if (!limits) return limits.error();
    write(results.initLimits(), *limits);
    return {};
  });
}

kj::Promise<void> DaemonServer::configuration(ConfigurationContext context) {
  return answer(context, [&](auto, auto results) -> Result<void> {
    results.setToml(text(toToml(core_.config())));
    return {};
  });
}

kj::Promise<void> DaemonServer::doctor(DoctorContext context) {
  return answer(context, [&](auto, auto results) -> Result<void> {
    const auto checks = makeChecks(core_);
    auto list = results.initChecks(static_cast<unsigned>(checks.size()));
    for (unsigned i = 0; i < checks.size(); ++i) {
      list[i].setName(text(checks[i].name));
      list[i].setState(checks[i].state);
      list[i].setDetail(text(checks[i].detail));
      list[i].setRemedy(text(checks[i].remedy));
    }
    return {};
  });
}

kj::Promise<void> DaemonServer::dump(DumpContext context) {
  return answer(context, [&](auto, auto results) -> Result<void> {
    results.setJson(text(ResourceTree(core_).dump()));
    return {};
  });
}

kj::Promise<void> DaemonServer::record(RecordContext context) {
  return answerLater(context, [&](auto params, auto later) -> Result<void> {
    auto uri = readUri(params.getUri());
    if (!uri) return uri.error();
    // First: without memory for it nothing begins.
    auto recording = std::make_shared<kj::Own<RecordingServer>>(kj::heap<RecordingServer>(core_, client().uid));
    core_.record(*uri, connection_, [later, recording](Result<Recordings::Started> started) {
      if (started) (*recording)->hold(std::move(*started));  // If nobody waits for it any more it ends with this.
      later->answer([&](auto results) -> Result<void> {
        if (!started) return started.error();
        results.setRecording(kj::mv(*recording));
        return {};
      });
    });
    return {};
  });
}

}  // namespace hapticd
