#include "daemon/scene/texture/texture_store.h"

#include <set>

namespace hapticd {

/** What was uploaded, and what each servo reads. */
struct TextureStore::Entry : ShelfEntry<TextureInfo, std::shared_ptr<const TextureMemory>> {
  std::shared_ptr<const Texture> texture;
  LaidOut made;                           ///< For servos that are being told of it, or will be.
  std::map<std::int64_t, bool> answered;  ///< By period, whether what was asked for aside has come, or failed.

  /** Null: none is laid out as a servo of that period wants it. A relief is the same at any rate. */
  [[nodiscard]] std::shared_ptr<const TextureMemory> copyFor(std::int64_t period_ns) const {
    for (const auto& [sink, copy] : copies) {
      if (info.is_relief || sink->periodNs() == period_ns) return copy;
    }
    return nullptr;
  }
  [[nodiscard]] std::uint64_t lockedBytes() const {
    std::set<const TextureMemory*> memories;
    for (const auto& [sink, copy] : copies) memories.insert(copy.get());
    return info.bytes * memories.size();
  }
};

TextureStore::TextureStore()
    : shelf_(std::make_unique<Shelf<Entry, kMaxTextures>>(
          ShelfWords{"texture", "textures", "surfaces", "give them another surface first"})) {}
TextureStore::~TextureStore() = default;

Result<LaidOut> layOutAll(const Texture& texture, const std::set<std::int64_t>& periods, bool lock) {
  LaidOut made;
  for (const std::int64_t period_ns : periods) {
    auto memory = layOut(texture, period_ns, lock);
    if (!memory) return memory.error();
    made.emplace(period_ns, std::make_shared<const TextureMemory>(std::move(*memory)));
  }
  return made;
}

std::set<std::int64_t> TextureStore::periodsFor(const Texture& texture) const {
  std::set<std::int64_t> periods;
  for (const CommandSink* sink : shelf_->sinks()) periods.insert(texture.isRelief() ? 0 : sink->periodNs());
  return periods;
}

Result<std::uint64_t> TextureStore::add(Texture texture, const Client& by, LaidOut made) {
  if (auto room = shelf_->room(by); !room) return room.error();
  auto entry = std::make_unique<Entry>();
  TextureInfo& info = entry->info;
  info.owner = by;
  info.is_relief = texture.isRelief();
  info.width = texture.relief.width;
  info.height = texture.relief.height;
  info.across = texture.relief.across;
  info.down = texture.relief.down;
  info.slopes = texture.relief.slopes;
  info.models = static_cast<std::uint32_t>(texture.vibration.models.size());
  info.rate_hz = texture.vibration.rate_hz;
  info.bytes = layOutBytes(texture);
  entry->texture = std::make_shared<const Texture>(std::move(texture));
  entry->made = std::move(made);
  auto id = shelf_->put(
      std::move(entry), [&](std::uint32_t index, CommandSink& sink) { return publish(index, sink); },
      [&](std::uint32_t index) { unpublish(index); });
  if (id) shelf_->find(*id)->made.clear();
  return id;
}

Result<void> TextureStore::publish(std::uint32_t index, CommandSink& sink) {
  Entry& entry = *shelf_->entries()[index];
  // A servo that comes late is told of all textures at once: laid out anew, many models would keep the control thread
  // for seconds.
  auto copy = entry.copyFor(sink.periodNs());
  const auto made = entry.made.find(entry.info.is_relief ? 0 : sink.periodNs());
  if (copy == nullptr && made != entry.made.end()) copy = made->second;
  if (copy == nullptr) {
    auto memory = layOut(*entry.texture, sink.periodNs(), lock_);
    if (!memory) return memory.error();
    copy = std::make_shared<const TextureMemory>(std::move(*memory));
  }
  entry.copies.insert_or_assign(&sink, copy);
  sink.meshes().publishTexture(index, copy->view());
  if (published_) published_(sink, {index, copy});
  return {};
}

std::vector<PublishedTexture> TextureStore::published(CommandSink& sink) const {
  std::vector<PublishedTexture> out;
  for (std::uint32_t i = 0; i < kMaxTextures; ++i) {
    const auto& entry = shelf_->entries()[i];
    if (entry == nullptr) continue;
    if (const auto copy = entry->copies.find(&sink); copy != entry->copies.end()) out.push_back({i, copy->second});
  }
  return out;
}

void TextureStore::unpublish(std::uint32_t index) {
  for (CommandSink* sink : shelf_->sinks()) sink->meshes().publishTexture(index, nullptr);
}

Result<void> TextureStore::room(const Client& by) const { return shelf_->room(by); }

Result<void> TextureStore::drop(std::uint64_t id, const Client& by) { return shelf_->drop(id, by); }

void TextureStore::dropUnusedOf(std::uint64_t connection) { shelf_->dropUnusedOf(connection); }

const TextureInfo* TextureStore::find(std::uint64_t id) const {
  const Entry* entry = shelf_->find(id);
  return entry == nullptr ? nullptr : &entry->info;
}

std::vector<const TextureInfo*> TextureStore::list() const { return shelf_->list(); }

std::uint64_t TextureStore::lockedBytes() const {
  std::uint64_t sum = 0;
  for (const auto& entry : shelf_->entries()) {
    if (entry != nullptr) sum += entry->lockedBytes();
  }
  return sum;
}

std::uint64_t TextureStore::bytesOf(std::uint32_t uid) const {
  std::uint64_t sum = 0;
  for (const auto& entry : shelf_->entries()) {
    if (entry != nullptr && entry->info.owner.uid == uid) sum += entry->info.bytes + entry->lockedBytes();
  }
  return sum;
}

std::uint64_t TextureStore::bytesFor(const Texture& texture) const {
  return layOutBytes(texture) * (1 + periodsFor(texture).size());
}

std::uint32_t TextureStore::referenceTo(std::uint64_t id) const {
  const std::uint32_t index = shelf_->indexOf(id);
  return index == kMaxTextures ? 0 : index + 1;
}

void TextureStore::use(std::uint64_t id) { shelf_->use(id); }

void TextureStore::release(std::uint64_t id) { shelf_->release(id); }

bool TextureStore::readyForServo(std::int64_t period_ns) {
  bool ready = true;
  for (const auto& entry : shelf_->entries()) {
    if (entry == nullptr || entry->dropped || entry->info.is_relief || entry->copyFor(period_ns) != nullptr) continue;
    if (entry->answered.try_emplace(period_ns, false).second) layOutAside(*entry, period_ns);
    ready = ready && entry->answered.at(period_ns);
  }
  return ready;
}

/** What fails then fails once more in attach(), which tells. */
void TextureStore::layOutAside(Entry& entry, std::int64_t period_ns) {
  aside_.start([texture = entry.texture, period_ns, lock = lock_] { return layOutAll(*texture, {period_ns}, lock); },
               [this, period_ns, id = entry.info.id](Result<LaidOut> laid_out) {
                 Entry* const asked = shelf_->find(id);
                 if (asked == nullptr) return;  // dropped
                 asked->answered[period_ns] = true;
                 if (laid_out) asked->made.merge(*laid_out);
               });
}

Result<void> TextureStore::attach(CommandSink& sink) {
  auto attached = shelf_->attach(sink, [&](std::uint32_t index, CommandSink& s) { return publish(index, s); });
  noServoComes();  // Beyond this one.
  return attached;
}

void TextureStore::noServoComes() {
  for (const auto& entry : shelf_->entries()) {
    if (entry == nullptr) continue;
    entry->made.clear();
    entry->answered.clear();
  }
}

void TextureStore::detach(CommandSink& sink) { shelf_->detach(sink); }

void TextureStore::reclaim() {
  aside_.poll();
  shelf_->reclaim([&](std::uint32_t index) { unpublish(index); },
                  [&](std::unique_ptr<Entry> entry) {
                    if (entry->info.bytes >= kLargeBytes) (void)aside_.letGo(std::move(entry), [] {});
                  });
}

}  // namespace hapticd
