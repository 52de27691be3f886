#include "daemon/log/log.h"

#include <spdlog/details/os.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <charconv>
#include <cstdlib>
#include <memory>
#include <mutex>

#include "daemon/log/line_stream.h"

namespace hapticd::log {
namespace {

constexpr std::array<std::string_view, 6> kNames = {"trace", "debug", "info", "warn", "error", "off"};

std::atomic<Level> g_level{Level::kInfo};

spdlog::level::level_enum spdlogLevel(Level level) {
  switch (level) {
    case Level::kTrace:
      return spdlog::level::trace;
    case Level::kDebug:
      return spdlog::level::debug;
    case Level::kInfo:
      return spdlog::level::info;
    case Level::kWarn:
      return spdlog::level::warn;
    case Level::kError:
      return spdlog::level::err;
    case Level::kOff:
      return spdlog::level::off;
  }
  return spdlog::level::info;
}

enum class Dress { kNone, kColours, kJournal };

/** To standard error. Nobody waits for whoever reads it, nor for a journald that stands still: control logs, too. */
class StderrSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  StderrSink(LineStream stream, Dress dress) : stream_(std::move(stream)), dress_(dress) {}

 private:
  void sink_it_(const spdlog::details::log_msg& message) override {
    constexpr std::array<const char*, spdlog::level::n_levels> kColours = {
        "\033[37m", "\033[36m", "\033[32m", "\033[33m\033[1m", "\033[31m\033[1m", "\033[1m\033[41m", ""};
    constexpr std::array<char, spdlog::level::n_levels> kPriorities = {'7', '7', '6', '4', '3', '2', '7'};
    spdlog::memory_buf_t formatted;
    formatter_->format(message, formatted);
    const std::string_view line(formatted.data(), formatted.size());
    const std::size_t begin = message.color_range_start, end = message.color_range_end;
    if (dress_ == Dress::kJournal) {
      stream_.write(fmt::format("<{}>{}", kPriorities[message.level], line));  // sd-daemon(3)
    } else if (dress_ == Dress::kColours && end > begin) {
      stream_.write(fmt::format("{}{}{}\033[m{}", line.substr(0, begin), kColours[message.level],
                                line.substr(begin, end - begin), line.substr(end)));
    } else {
      stream_.write(line);
    }
  }
  void flush_() override {}

  LineStream stream_;
  Dress dress_;
};

std::shared_ptr<spdlog::logger> loggerTo(LineStream stream, Dress dress, const char* pattern) {
  auto made = std::make_shared<spdlog::logger>("hapticd", std::make_shared<StderrSink>(std::move(stream), dress));
  made->set_pattern(pattern);
  return made;
}

std::shared_ptr<spdlog::logger>& logger() {
  static auto instance = loggerTo(LineStream(STDERR_FILENO), Dress::kNone, "%+");
  return instance;
}

}  // namespace

Result<Level> parseLevel(std::string_view text) {
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (text == kNames[i]) return static_cast<Level>(i);
  return Error{ErrorCode::kInvalidArgument, "log level", '"' + printable(text) + "\" is not a level",
               "one of trace, debug, info, warn, error, off"};
}

std::string_view toString(Level level) { return kNames[static_cast<std::size_t>(level)]; }

bool isJournalStream(std::string_view journal_stream, int fd) {
  const std::size_t colon = journal_stream.find(':');
  if (colon == std::string_view::npos) return false;
  const char* const end = journal_stream.data() + journal_stream.size();
  const char* const middle = journal_stream.data() + colon;
  unsigned long long device = 0, inode = 0;
  if (std::from_chars(journal_stream.data(), middle, device).ptr != middle) return false;
  if (std::from_chars(middle + 1, end, inode).ptr != end) return false;
  struct stat status {};
  return ::fstat(fd, &status) == 0 && status.st_dev == device && status.st_ino == inode;
}

void start(Level level) {
  const char* const stream = std::getenv("JOURNAL_STREAM");
  if (stream != nullptr && isJournalStream(stream, STDERR_FILENO)) {
    logger() = loggerTo(LineStream(STDERR_FILENO), Dress::kJournal, "%v");
  } else {
    const bool coloured = ::isatty(STDERR_FILENO) != 0 && spdlog::details::os::is_color_terminal();
    logger() = loggerTo(LineStream::unblocked(STDERR_FILENO), coloured ? Dress::kColours : Dress::kNone,
                        "%H:%M:%S.%e %^%l%$ %v");
  }
  logger()->set_level(spdlog::level::trace);  // enabled() decides
  setLevel(level);
}

void setLevel(Level level) { g_level.store(level, std::memory_order_relaxed); }

bool enabled(Level level) noexcept {
  const Level least = g_level.load(std::memory_order_relaxed);
  return least != Level::kOff && level >= least;
}

std::string printable(std::string_view text) noexcept try {
  static constexpr char kHex[] = "0123456789abcdef";
  std::string out;
  out.reserve(text.size());
  unsigned char before = 0;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool c1 = before == 0xc2 && byte >= 0x80 && byte < 0xa0;  // U+0080 to U+009F steer terminals, too.
    if (c1) out.pop_back();
    if (c1 || (byte < 0x20 && c != '\t') || byte == 0x7f) {
      out += "\\x";
      out += kHex[byte >> 4];
      out += kHex[byte & 15];
    } else {
      out += c;
    }
    before = byte;
  }
  return out;
} catch (const std::bad_alloc&) {
  return {};
}

void write(Level level, std::string_view message) {
  if (!enabled(level)) return;
  const std::string text = printable(message);
  logger()->log(spdlogLevel(level), spdlog::string_view_t(text.data(), text.size()));
}

bool RateLimit::allow(std::int64_t now_ns, std::uint64_t& suppressed) noexcept {
  if (!started_ || now_ns - begin_ns_ >= interval_ns_) {
    started_ = true;
    begin_ns_ = now_ns;
    passed_ = 0;
  }
  if (passed_ >= burst_) {
    ++suppressed_;
    return false;
  }
  ++passed_;
  suppressed = suppressed_;
  suppressed_ = 0;
  return true;
}

std::string suppressedNote(std::uint64_t suppressed) noexcept try {
  return suppressed == 0 ? std::string() : fmt::format(" ({} suppressed)", suppressed);
} catch (const std::bad_alloc&) {
  return {};
}

}  // namespace hapticd::log
