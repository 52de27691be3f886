#include "daemon/rpc/servers.h"

namespace hapticd {
namespace {

/** As answer(), for methods on the object that `name` names: runs `body(name, params, results)`. */
template <class Context, class Body>
kj::Promise<void> answerNamed(Context context, Body&& body) {
  return answer(context, [&](auto params, auto results) -> Result<void> {
    const auto name = readText(params.getName(), kMostName, "name");
    return name ? body(*name, params, results) : name.error();
  });
}

/** As answerNamed(), for those that change it: runs `body(name, params)`. */
template <class Context, class Body>
kj::Promise<void> answerEdit(Core& core, std::uint64_t connection, Context context, Body&& body) {
  return answerNamed(context, [&](auto& name, auto params, auto) {
    return core.editFor(connection, [&] { return body(name, params); });
  });
}

/** The last answer to a commit is out; the client may be slow, so only the newest report of progress waits. */
class ProgressSender : public kj::Refcounted {
 public:
  explicit ProgressSender(proto::Progress::Client client) : client_(kj::mv(client)) {}

  void report(float fraction, const std::string& stage) {
    if (busy_ || failed_) return;
    busy_ = true;
    auto request = client_.reportRequest();
    request.setFraction(fraction);
    request.setStage(capnp::Text::Reader(stage.data(), stage.size()));
    request.send()
        .then([self = kj::addRef(*this)]() mutable { self->busy_ = false; })
        .detach([self = kj::addRef(*this)](kj::Exception&&) mutable { self->failed_ = true; });
  }

 private:
  proto::Progress::Client client_;
  bool busy_ = false;
  bool failed_ = false;
};

}  // namespace

kj::Promise<void> SceneServer::create(CreateContext context) {
  return answer(context, [&](auto params, auto results) -> Result<void> {
    auto spec = read(params.getObject());
    if (!spec) return spec.error();
    auto id =
        core_.editFor(connection_, [&] { return core_.scene().create(std::move(*spec), core_.client(connection_)); });
    if (!id) return id.error();
    results.setId(*id);
    return {};
  });
}

kj::Promise<void> SceneServer::remove(RemoveContext context) {
  return answerEdit(core_, connection_, context,
                    [&](auto& name, auto) { return core_.scene().remove(name, core_.client(connection_)); });
}

kj::Promise<void> SceneServer::list(ListContext context) {
  return answer(context, [&](auto, auto results) -> Result<void> {
    const auto all = core_.scene().list();
    auto out = results.initObjects(static_cast<unsigned>(all.size()));
    for (unsigned i = 0; i < all.size(); ++i) write(out[i], all[i]);
    return {};
  });
}

kj::Promise<void> SceneServer::find(FindContext context) {
  return answerNamed(context, [&](auto& name, auto, auto results) -> Result<void> {
    auto object = core_.scene().find(name);
    if (!object) return object.error();
    write(results.initObject(), *object);
    return {};
  });
}

kj::Promise<void> SceneServer::setPose(SetPoseContext context) {
  return answerEdit(core_, connection_, context,
                    [&](auto& name, auto params) { return core_.setPose(name, read(params.getPose())); });
}

kj::Promise<void> SceneServer::setMaterial(SetMaterialContext context) {
  return answerEdit(core_, connection_, context, [&](auto& name, auto params) {
    return core_.scene().setMaterial(name, read(params.getMaterial()));
  });
}

kj::Promise<void> SceneServer::setFlags(SetFlagsContext context) {
  return answerEdit(core_, connection_, context, [&](auto& name, auto params) {
    return core_.scene().setFlags(name, {params.getEnabled(), params.getVisible(), params.getTwoSided()});
  });
}

kj::Promise<void> SceneServer::setShape(SetShapeContext context) {
  return answerEdit(core_, connection_, context,
                    [&](auto& name, auto params) { return core_.setShape(name, read(params.getShape())); });
}

kj::Promise<void> SceneServer::beginUpload(BeginUploadContext context) {
  return answer(context, [&](auto params, auto results) -> Result<void> {
    auto upload = kj::heap<UploadServer>(core_, core_.client(connection_).uid);  // First: without it nothing begins.
    auto id = core_.uploads().begin(params.getBytes(), core_.client(connection_));
    if (!id) return id.error();
    upload->hold(*id);
    results.setUpload(kj::mv(upload));
    return {};
  });
}

kj::Promise<void> SceneServer::dropMesh(DropMeshContext context) {
  return answer(context,
                [&](auto params, auto) { return core_.meshes().drop(params.getMesh(), core_.client(connection_)); });
}

kj::Promise<void> SceneServer::listMeshes(ListMeshesContext context) {
  return answer(context, [&](auto, auto results) -> Result<void> {
    const auto all = core_.meshes().list();
    auto out = results.initMeshes(static_cast<unsigned>(all.size()));
    for (unsigned i = 0; i < all.size(); ++i) write(out[i], *all[i]);
    return {};
  });
}

kj::Promise<void> SceneServer::setSurface(SetSurfaceContext context) {
  return answerEdit(core_, connection_, context,
                    [&](auto& name, auto params) { return core_.scene().setSurface(name, read(params.getSurface())); });
}

kj::Promise<void> SceneServer::dropTexture(DropTextureContext context) {
  return answer(context, [&](auto params, auto) {
    return core_.scene().textures().drop(params.getTexture(), core_.client(connection_));
  });
}

kj::Promise<void> SceneServer::listTextures(ListTexturesContext context) {
  return answer(context, [&](auto, auto results) -> Result<void> {
    const auto all = core_.scene().textures().list();
    auto out = results.initTextures(static_cast<unsigned>(all.size()));
    for (unsigned i = 0; i < all.size(); ++i) write(out[i], *all[i]);
    return {};
  });
}

kj::Promise<void> SceneServer::volumeFile(VolumeFileContext context) {
  return answerNamed(context, [&](auto& name, auto, auto results) -> Result<void> {
    auto object = core_.scene().find(name);
    if (!object) return object.error();
    const MeshInfo* mesh = core_.meshes().find(object->spec.shape.mesh);
    if (object->spec.shape.kind != ShapeKind::kMesh || mesh == nullptr) {
      return Error{ErrorCode::kNotFound, name, "it is no mesh: meshes alone have a volume to export",
                   "name an object that hapticctl load --voxel made; hapticctl volumes lists them"};
    }
    const Client& by = core_.client(connection_);
    auto file = RegionServer::handOut(core_, by.uid, core_.uploads().volumeFile(*mesh, by));
    if (!file) return file.error();
    results.setFile(std::move(*file));
    return {};
  });
}

kj::Promise<void> UploadServer::region(RegionContext context) {
  return answer(context, [&](auto, auto results) -> Result<void> {
    auto region = RegionServer::handOut(core_, uid_, core_.uploads().region(id_));
    if (!region) return region.error();
    results.setRegion(std::move(*region));
    return {};
  });
}

kj::Promise<void> UploadServer::commitTexture(CommitTextureContext context) {
  context.allowCancellation();
  return answerLater(context, [&](auto, auto later) -> Result<void> {
    return core_.uploads().commitTexture(id_, [later, &core = core_](const Result<std::uint64_t>& id) {
      later->answer([&](auto results) -> Result<void> {
        if (!id) return id.error();
        write(results.initTexture(), *core.scene().textures().find(*id));
        return {};
      });
    });
  });
}

kj::Promise<void> UploadServer::commit(CommitContext context) {
  context.allowCancellation();  // a client that goes away, or changes its mind, must not keep the builder busy
  return answerLater(context, [&](auto params, auto later) -> Result<void> {
    Uploads::Progress progress;
    if (params.hasProgress()) {
      auto sender = std::make_shared<kj::Own<ProgressSender>>(kj::refcounted<ProgressSender>(params.getProgress()));
      progress = [sender](float fraction, const std::string& stage) { (*sender)->report(fraction, stage); };
    }
    return core_.uploads().commit(id_, std::move(progress), [later](Result<MeshInfo> mesh) {
      later->answer([&](auto results) -> Result<void> {
        if (!mesh) return mesh.error();
        write(results.initMesh(), *mesh);
        return {};
      });
    });
  });
}

}  // namespace hapticd
