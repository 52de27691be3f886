/** @file
 * Textures that clients uploaded: checked, laid out for each rate of a servo, locked, published; given back once every
 * servo has passed. What MeshStore is for meshes.
 */
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "daemon/scene/command_sink.h"
#include "daemon/scene/object.h"
#include "daemon/scene/texture/texture.h"
#include "daemon/scene/texture/texture_memory.h"
#include "daemon/scene/upload/aside.h"
#include "daemon/scene/upload/shelf.h"

namespace hapticd {

struct TextureInfo {
  std::uint64_t id = 0;
  bool is_relief = false;
  std::uint32_t width = 0, height = 0;  ///< Of a relief, pixels.
  SteepestStep across, down;            ///< Of a relief.
  std::vector<ReliefSlope> slopes;      ///< Of a relief.
  std::uint32_t models = 0;             ///< Of a vibration.
  double rate_hz = 0;                   ///< It was recorded at.
  std::uint64_t bytes = 0;              ///< Of each copy; see lockedBytes().
  std::uint32_t uses = 0;               ///< Surfaces that show it.
  Client owner;
};

/** A texture as the servos of a period [ns] read it; a relief is the same for all, and stands at 0. */
using LaidOut = std::map<std::int64_t, std::shared_ptr<const TextureMemory>>;
/** For these periods; many models take a second each. Any thread. */
[[nodiscard]] Result<LaidOut> layOutAll(const Texture& texture, const std::set<std::int64_t>& periods, bool lock);

/** A texture as one servo reads it. */
struct PublishedTexture {
  std::uint32_t entry = 0;                      ///< Of the servo's texture table.
  std::shared_ptr<const TextureMemory> memory;  ///< Stays as it is for as long as somebody holds it.
};

/** Control thread only. */
class TextureStore {
 public:
  TextureStore();
  ~TextureStore();

  /** Whether what the servos read must be locked (it may not be under --allow-no-rt). */
  void setLock(bool lock) { lock_ = lock; }
  [[nodiscard]] bool locks() const { return lock_; }
  /** Of the servos that there are, as LaidOut knows them. */
  [[nodiscard]] std::set<std::int64_t> periodsFor(const Texture& texture) const;

  /** kQuotaExceeded where that user may have no more. */
  [[nodiscard]] Result<void> room(const Client& by) const;
  /** `made` is what layOutAll() made of it; what is missing there is laid out now. */
  [[nodiscard]] Result<std::uint64_t> add(Texture texture, const Client& by, LaidOut made = {});
  /** Refused while a surface shows it. Its maker's user or administration. */
  [[nodiscard]] Result<void> drop(std::uint64_t id, const Client& by);
  /** The textures of a connection go once no surface shows them. */
  void dropUnusedOf(std::uint64_t connection);

  [[nodiscard]] const TextureInfo* find(std::uint64_t id) const;
  [[nodiscard]] std::vector<const TextureInfo*> list() const;
  /** Of all copies: of a vibration one for the servos of each rate, of a relief one. */
  [[nodiscard]] std::uint64_t lockedBytes() const;
  [[nodiscard]] std::uint64_t bytesOf(std::uint32_t uid) const;
  /** What it will count for [bytes]. */
  [[nodiscard]] std::uint64_t bytesFor(const Texture& texture) const;

  // By the scene model.
  /** Entry of the texture tables plus 1; 0 for the id 0. */
  [[nodiscard]] std::uint32_t referenceTo(std::uint64_t id) const;
  void use(std::uint64_t id);
  void release(std::uint64_t id);
  /**
   * Whether attach() would be quick for a servo of that period: vibrations that no servo reads so are laid out on a
   * thread aside. Where it is false, ask again after reclaim().
   */
  [[nodiscard]] bool readyForServo(std::int64_t period_ns);
  /** The servo does not come, and no other is on its way: what was made aside for it goes. */
  void noServoComes();
  /** Publishes every texture to a new sink, before the scene is replayed to it. */
  [[nodiscard]] Result<void> attach(CommandSink& sink);
  void detach(CommandSink& sink);

  /** What stands in that servo's table. */
  [[nodiscard]] std::vector<PublishedTexture> published(CommandSink& sink) const;
  /** Told of each texture when it is published, before any order can name it. */
  void onPublish(std::function<void(CommandSink&, const PublishedTexture&)> f) { published_ = std::move(f); }

  /** Unmaps what every servo has passed. Call every few milliseconds. */
  void reclaim();
  /** Whether something is laid out aside. */
  [[nodiscard]] bool busy() const { return aside_.size() != 0; }

 private:
  struct Entry;
  void layOutAside(Entry& entry, std::int64_t period_ns);
  Result<void> publish(std::uint32_t index, CommandSink& sink);
  void unpublish(std::uint32_t index);

  bool lock_ = true;
  std::unique_ptr<Shelf<Entry, kMaxTextures>> shelf_;
  std::function<void(CommandSink&, const PublishedTexture&)> published_;
  Aside aside_;  // last: its thread ends first
};

}  // namespace hapticd
