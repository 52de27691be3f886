#include "daemon/device/wanted_groups.h"

#include <fmt/format.h>

#include <algorithm>

#include "daemon/log/log.h"
#include "drivers/registry.h"

namespace hapticd {
namespace {

constexpr const char* kSimulator = "sim://default";

bool isUri(std::string_view text) { return text.find("://") != std::string_view::npos; }

std::string listed(const GroupConfig& group) {
  std::string all;
  for (const std::string& uri : group.devices) all += (all.empty() ? "" : ", ") + (uri.empty() ? "any device" : uri);
  return all;
}

}  // namespace

WantedGroups::WantedGroups(DeviceManager& devices, Clock& clock) : devices_(devices), clock_(clock) {
  devices_.onAsked([this](const std::string& canonical) { return advise(canonical); });
}

Result<void> WantedGroups::begin(const std::vector<GroupConfig>& groups) {
  began_ns_ = clock_.now();
  configured_ = groups;
  std::vector<std::string> all;
  for (const GroupConfig& group : groups) {
    Wanted& wanted = wanted_.emplace_back();
    wanted.group = group;
    for (const std::string& text : group.devices) {
      std::string& canonical = wanted.canonical.emplace_back();
      if (text.empty() && wanted.candidates.empty()) {
        for (const DeviceFound& found : devices_.attached()) {
          if (found.real) wanted.candidates.push_back(found.info.uri);
        }
        wanted.candidates.emplace_back(kSimulator);
      }
      if (text.empty()) continue;
      const auto made = devices_.make(text);
      if (made) canonical = (*made)->info().uri;
      // A serial number may be plugged in later; what a URI's driver refuses stays refused.
      if (!made && isUri(text)) {
        wanted_.clear();
        return made.error();
      }
      if (!canonical.empty() && std::find(all.begin(), all.end(), canonical) != all.end()) {
        const Error twice{ErrorCode::kDeviceBusy, fmt::format("group '{}'", group.name),
                          fmt::format("{} is there twice", canonical), "name each device once"};
        wanted_.clear();
        return twice;
      }
      all.push_back(canonical);
    }
  }
  for (Wanted& wanted : wanted_) {  // What another group names is not whatever there is.
    std::erase_if(wanted.candidates, [&](const auto& one) {
      return one != kSimulator &&
             std::any_of(all.begin(), all.end(), [&](const auto& named) { return isAskedFor(named, one); });
    });
  }
  return {};
}

bool WantedGroups::settled() const {
  return !patient() || std::all_of(wanted_.begin(), wanted_.end(), [](const Wanted& wanted) { return wanted.tried; });
}

bool WantedGroups::turnOf(const Wanted& wanted) const {
  if (wanted.tried || !patient()) return true;
  for (const Wanted& before : wanted_) {
    if (&before == &wanted) return true;
    if (!before.tried) return false;
  }
  return true;
}

void WantedGroups::poll() {
  for (auto it = wanted_.begin(); it != wanted_.end();) {
    Wanted& wanted = *it++;  // An attempt may erase it.
    if (wanted.trying || wanted.rests || clock_.now() < wanted.next_ns) continue;
    if (!wanted.candidates.empty() && !turnOf(wanted)) continue;
    attempt(wanted);
  }
}

void WantedGroups::closed(const std::string& name, std::vector<std::string> canonical) {
  const auto is = [&](const GroupConfig& group) { return group.name == name; };
  const auto group = std::find_if(configured_.begin(), configured_.end(), is);
  if (group == configured_.end()) return;
  const auto& devices = group->devices;
  Wanted& wanted = wanted_.emplace_back();
  wanted.group = *group;
  wanted.canonical = std::move(canonical);
  wanted.canonical.resize(devices.size());
  const auto any = std::find(devices.begin(), devices.end(), std::string());
  if (any != devices.end()) wanted.candidates = {wanted.canonical[static_cast<std::size_t>(any - devices.begin())]};
  wanted.tried = wanted.rests = true;
}

GroupConfig WantedGroups::next(const Wanted& wanted) {
  GroupConfig group = wanted.group;
  const auto any = std::find(group.devices.begin(), group.devices.end(), std::string());
  if (any != group.devices.end() && !wanted.candidates.empty()) *any = wanted.candidates.front();
  return group;
}

void WantedGroups::attempt(Wanted& wanted) {
  wanted.trying = true;
  try {
    const GroupConfig group = next(wanted);
    devices_.openGroup(
        group, [this, &wanted, group](const Result<void>& result) { answered(wanted, group, result); },
        [this, &wanted] { return turnOf(wanted); });
  } catch (const std::bad_alloc&) {  // poll() tries again.
    wanted.trying = false;
    throw;
  }
}

void WantedGroups::answered(Wanted& wanted, const GroupConfig& tried, const Result<void>& result) {
  wanted.trying = false;
  if (result) {
    if (wanted.told) log::info("group {} is there: {}", wanted.group.name, log::printable(listed(tried)));
    wanted_.remove_if([&](const Wanted& one) { return &one == &wanted; });
    return;
  }
  const Error& why = result.error();
  if (wanted.rests) return (void)(wanted.why = why);
  if (why.code == ErrorCode::kNoRealtime && fatal_) fatal_ = why;
  if (why.code == ErrorCode::kNoRealtime && patient() && !wanted.tried) return;  // The start ends with it.
  // Pass over a candidate only if it failed itself, not if another device of its group is missing.
  if (wanted.candidates.size() > 1 && devices_.culprit() == wanted.candidates.front()) {
    log::warn("{} does not open and is passed over: {}", log::printable(wanted.candidates.front()),
              log::printable(toString(why)));
    passed_over_.push_back({wanted.group.name, wanted.candidates.front(), why, true});
    wanted.candidates.erase(wanted.candidates.begin());
    return;  // poll() goes on with the next.
  }
  miss(wanted, why);
}

void WantedGroups::miss(Wanted& wanted, const Error& why) {
  wanted.tried = true;
  wanted.next_ns = clock_.now() + wanted.pause_ns;
  wanted.pause_ns = std::min(2 * wanted.pause_ns, kMostRetry_ns);
  const bool news = !wanted.told || toString(why) != toString(wanted.why);
  wanted.why = why;
  wanted.told = true;
  if (!news) return;
  log::warn("group {} is missing ({}): {}; hapticd goes on without it and keeps trying", wanted.group.name,
            log::printable(listed(wanted.group)), log::printable(toString(why)));
}

std::vector<WantedGroups::Absent> WantedGroups::absent() const {
  std::vector<Absent> all;
  for (const Wanted& wanted : wanted_) {
    if (wanted.rests) continue;
    const Error why =
        wanted.told ? wanted.why : Error{ErrorCode::kTimeout, wanted.group.name, "it is still being opened", {}};
    for (std::size_t i = 0; i < wanted.group.devices.size(); ++i) {
      const std::string& known = wanted.canonical[i];
      all.push_back({wanted.group.name, known.empty() ? next(wanted).devices[i] : known, why, false});
    }
  }
  for (const Absent& one : passed_over_) {
    const auto open = [&](const auto& device) { return device->info().uri == one.uri; };
    if (std::none_of(devices_.devices().begin(), devices_.devices().end(), open)) all.push_back(one);
  }
  return all;
}

bool WantedGroups::names(std::string_view uri) const {
  return !uri.empty() && std::any_of(wanted_.begin(), wanted_.end(), [&](const Wanted& wanted) {
    const auto is = [&](const std::string& one) { return one == uri; };
    return std::any_of(wanted.canonical.begin(), wanted.canonical.end(), is) ||
           std::any_of(wanted.group.devices.begin(), wanted.group.devices.end(), is);
  });
}

/** A serial number, or a URI like falcon://default, stands for a certain device only once that is plugged in. */
void WantedGroups::recognise(Wanted& wanted) const {
  for (std::size_t i = 0; i < wanted.group.devices.size(); ++i) {
    const std::string& text = wanted.group.devices[i];
    if (text.empty()) continue;
    if (auto known = devices_.recognise(text)) wanted.canonical[i] = std::move(*known);
  }
}

/** Whoever asks for a device of a missing group, or for any while none is open, has that group tried at once. */
Result<std::string> WantedGroups::advise(const std::string& canonical) {
  for (Wanted& wanted : wanted_) {
    if (!wanted.trying) recognise(wanted);
    if (wanted.rests && canonical.empty()) continue;
    const auto& has = wanted.canonical;
    const auto asked =
        std::find_if(has.begin(), has.end(), [&](const auto& one) { return isAskedFor(one, canonical); });
    if (!canonical.empty() && asked == has.end()) continue;
    const std::string first = canonical.empty() ? has.front() : *asked;
    if (first.empty()) {
      // A serial number: it is asked again when somebody has looked.
      if (wanted.told && !wanted.group.devices.front().empty() && devices_.hasNotLooked()) return canonical;
      if (wanted.told) return wanted.why;
      continue;  // It takes what there is, and so does who asks.
    }
    if (!wanted.trying) attempt(wanted);
    const auto still = std::find_if(wanted_.begin(), wanted_.end(), [&](const Wanted& one) { return &one == &wanted; });
    if (still != wanted_.end() && !still->trying) return still->why;  // Refused at once.
    return first;
  }
  return canonical;
}

}  // namespace hapticd
