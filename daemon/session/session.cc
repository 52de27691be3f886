#include "daemon/session/session.h"

#include <atomic>

#include "rt/ring/state.h"

namespace hapticd {

Result<SessionRegions> SessionRegions::create(const RegionIdentity& identity) {
  SessionRegions r;
  auto a = Memfd::create("hapticd-a", sizeof(hd_region_a));
  if (!a) return a.error();
  auto b = Memfd::create("hapticd-b", sizeof(hd_region_b));
  if (!b) return b.error();
  r.file_a_ = std::move(*a);
  r.file_b_ = std::move(*b);
  auto map_a = r.file_a_.map(Memfd::Access::kWrite);
  if (!map_a) return map_a.error();
  auto map_b = r.file_b_.map(Memfd::Access::kWrite);
  if (!map_b) return map_b.error();
  r.a_ = std::move(*map_a);
  r.b_ = std::move(*map_b);
  initialiseRegions(r.a(), r.b(), identity);
  if (auto sealed = r.file_a_.seal(Seals::kNoNewWriters); !sealed) return sealed.error();
  if (auto sealed = r.file_b_.seal(Seals::kFixedSize); !sealed) return sealed.error();
  return r;
}

Result<void> SessionRegions::sealAndLock(bool must_lock) {
  if (auto r = file_b_.seal(Seals::kNoNewWriters); !r) return r;
  if (auto r = file_a_.requireSeals(Seals::kNoNewWriters); !r) return r;
  if (auto r = file_b_.requireSeals(Seals::kNoNewWriters); !r) return r;
  for (Mapping* mapping : {&a_, &b_}) {
    if (auto r = mapping->lock(); !r && must_lock) return r;
  }
  return {};
}

void SessionRegions::markEnded() const {
  std::atomic_ref<std::uint32_t>(a()->acks.ended).store(1, std::memory_order_release);
}

}  // namespace hapticd
