#include "daemon/scene/texture_store.h"

#include <fmt/format.h>

#include <algorithm>

namespace hapticd {

/** One entry of the texture tables: what was uploaded, and a copy of it for each servo's rate. */
struct TextureStore::Entry {
  TextureInfo info;
  Texture texture;
  std::map<CommandSink*, std::shared_ptr<const TextureMemory>> copies;
  bool dropped = false;
  std::map<CommandSink*, std::uint64_t> waits_for;  ///< Ticket each servo has to pass before the memory goes.
};

TextureStore::TextureStore() = default;
TextureStore::~TextureStore() = default;

Result<std::uint64_t> TextureStore::add(Texture texture, const Client& by) {
  const auto free = std::find(entries_.begin(), entries_.end(), nullptr);
  if (free == entries_.end()) {
    return Error{ErrorCode::kQuotaExceeded, "texture",
                 fmt::format("the daemon holds {} textures, its most", kMaxTextures),
                 "drop textures that no surface shows"};
  }
  auto entry = std::make_unique<Entry>();
  TextureInfo& info = entry->info;
  info.id = next_id_;
  info.owner = by;
  info.is_relief = texture.isRelief();
  info.width = texture.relief.width;
  info.height = texture.relief.height;
  info.across = texture.relief.across;
  info.down = texture.relief.down;
  info.models = static_cast<std::uint32_t>(texture.vibration.models.size());
  info.rate_hz = texture.vibration.rate_hz;
  info.bytes = layOutBytes(texture);
  entry->texture = std::move(texture);
  const auto index = static_cast<std::uint32_t>(free - entries_.begin());
  *free = std::move(entry);
  for (CommandSink* sink : sinks_) {
    if (auto r = publish(index, *sink); !r) {
      unpublish(index);
      entries_[index].reset();  // no order names it yet
      return r.error();
    }
  }
  by_id_.emplace(next_id_, index);
  return next_id_++;
}

Result<void> TextureStore::publish(std::uint32_t index, CommandSink& sink) {
  Entry& entry = *entries_[index];
  auto memory = layOut(entry.texture, sink.periodNs(), lock_);
  if (!memory) return memory.error();
  const auto copy = std::make_shared<const TextureMemory>(std::move(*memory));
  entry.copies.insert_or_assign(&sink, copy);
  sink.meshes().publishTexture(index, copy->view());
  if (published_) published_(sink, {index, copy});
  return {};
}

std::vector<PublishedTexture> TextureStore::published(CommandSink& sink) const {
  std::vector<PublishedTexture> out;
  for (std::uint32_t i = 0; i < kMaxTextures; ++i) {
    if (entries_[i] == nullptr) continue;
    if (const auto copy = entries_[i]->copies.find(&sink); copy != entries_[i]->copies.end())
      out.push_back({i, copy->second});
  }
  return out;
}

void TextureStore::unpublish(std::uint32_t index) {
  for (CommandSink* sink : sinks_) sink->meshes().publishTexture(index, nullptr);
}

Result<void> TextureStore::drop(std::uint64_t id, const Client& by) {
  const auto it = by_id_.find(id);
  if (it == by_id_.end()) {
    return Error{ErrorCode::kNotFound, "texture", fmt::format("there is no texture {}", id),
                 "hapticctl get /textures lists them"};
  }
  Entry& entry = *entries_[it->second];
  if (entry.info.owner.uid != by.uid && !by.administration) {
    return Error{ErrorCode::kPermissionDenied, "texture",
                 fmt::format("texture {} belongs to user {}", id, entry.info.owner.uid),
                 "use the administration socket"};
  }
  if (entry.info.uses != 0) {
    return Error{ErrorCode::kInvalidArgument, "texture",
                 fmt::format("texture {} is shown by {} surfaces", id, entry.info.uses),
                 "give them another surface first"};
  }
  entry.dropped = true;
  for (CommandSink* sink : sinks_) entry.waits_for[sink] = sink->posted();
  by_id_.erase(it);
  return {};
}

void TextureStore::dropUnusedOf(std::uint64_t connection) {
  std::vector<std::uint64_t> ids;
  for (const auto& [id, index] : by_id_) {
    if (entries_[index]->info.owner.connection == connection) ids.push_back(id);
  }
  for (const std::uint64_t id : ids) {
    TextureInfo& info = entries_[by_id_.at(id)]->info;
    info.owner.connection = 0;  // its maker has left: it goes with its last surface
    if (info.uses == 0) (void)drop(id, info.owner);
  }
}

const TextureInfo* TextureStore::find(std::uint64_t id) const {
  const auto it = by_id_.find(id);
  return it == by_id_.end() ? nullptr : &entries_[it->second]->info;
}

std::vector<const TextureInfo*> TextureStore::list() const {
  std::vector<const TextureInfo*> all;
  for (const auto& [id, index] : by_id_) all.push_back(&entries_[index]->info);
  return all;
}

std::uint64_t TextureStore::lockedBytes() const {
  std::uint64_t sum = 0;
  for (const auto& entry : entries_) {
    if (entry != nullptr) sum += entry->info.bytes * entry->copies.size();
  }
  return sum;
}

std::uint64_t TextureStore::bytesOf(std::uint32_t uid) const {
  std::uint64_t sum = 0;
  for (const auto& entry : entries_) {
    if (entry != nullptr && entry->info.owner.uid == uid) sum += entry->info.bytes * (1 + entry->copies.size());
  }
  return sum;
}

std::uint32_t TextureStore::referenceTo(std::uint64_t id) const {
  const auto it = by_id_.find(id);
  return it == by_id_.end() ? 0 : it->second + 1;
}

void TextureStore::use(std::uint64_t id) {
  if (const auto it = by_id_.find(id); it != by_id_.end()) ++entries_[it->second]->info.uses;
}

void TextureStore::release(std::uint64_t id) {
  const auto it = by_id_.find(id);
  if (it == by_id_.end()) return;
  TextureInfo& info = entries_[it->second]->info;
  if (info.uses > 0) --info.uses;
  if (info.uses == 0 && info.owner.connection == 0) (void)drop(id, info.owner);
}

Result<void> TextureStore::attach(CommandSink& sink) {
  for (std::uint32_t i = 0; i < kMaxTextures; ++i) {
    if (entries_[i] == nullptr || entries_[i]->dropped) continue;
    if (auto r = publish(i, sink); !r) {
      detach(sink);
      return r;
    }
  }
  sinks_.push_back(&sink);
  return {};
}

void TextureStore::detach(CommandSink& sink) {
  sinks_.erase(std::remove(sinks_.begin(), sinks_.end(), &sink), sinks_.end());
  for (auto& entry : entries_) {
    if (entry == nullptr) continue;
    entry->copies.erase(&sink);
    entry->waits_for.erase(&sink);
  }
}

void TextureStore::reclaim() {
  for (std::uint32_t i = 0; i < kMaxTextures; ++i) {
    Entry* entry = entries_[i].get();
    if (entry == nullptr || !entry->dropped) continue;
    const bool all = std::all_of(entry->waits_for.begin(), entry->waits_for.end(),
                                 [](const auto& wait) { return wait.first->passed(wait.second); });
    if (!all) continue;
    unpublish(i);
    entries_[i].reset();
  }
}

}  // namespace hapticd
