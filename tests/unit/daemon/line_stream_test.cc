#include "daemon/log/line_stream.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <termios.h>

#include <algorithm>
#include <string>

namespace hapticd {
namespace {

constexpr int kLines = 20'000;  ///< More than any pipe, socket or terminal holds of them.

std::string line(int number) { return "line " + std::to_string(number) + " " + std::string(40, '.') + "\n"; }

/** What is there to be read. */
std::string readAll(int fd) {
  (void)::fcntl(fd, F_SETFL, ::fcntl(fd, F_GETFL) | O_NONBLOCK);
  std::string text;
  char piece[4096];
  for (ssize_t n = 0; (n = ::read(fd, piece, sizeof piece)) > 0;) text.append(piece, static_cast<std::size_t>(n));
  return text;
}

/** Fills it, with nobody reading; then every line is either there, in order, or counted. */
void expectNobodyWaits(LineStream& stream, int reader) {
  for (int i = 0; i < kLines; ++i) stream.write(line(i));  // Comes back.
  const std::string before = readAll(reader);
  stream.write("last\n");
  const std::string after = readAll(reader);
  const auto kept = static_cast<int>(std::count(before.begin(), before.end(), '\n'));
  ASSERT_LT(kept, kLines);
  for (int i = 0; i < kept; ++i) ASSERT_NE(before.find(line(i)), std::string::npos) << i;
  EXPECT_NE(after.find(std::to_string(kLines - kept) + " lines are lost here: there was no room for them\nlast\n"),
            std::string::npos)
      << after;
  stream.write("one more\n");
  EXPECT_EQ(readAll(reader), "one more\n");
}

TEST(LineStream, AFullPipeHoldsNobodyUpAndTheLossIsTold) {
  for (const bool unblocked : {false, true}) {
    int ends[2];
    ASSERT_EQ(::pipe2(ends, O_CLOEXEC), 0);
    const UniqueFd reader(ends[0]), writer(ends[1]);
    LineStream stream = unblocked ? LineStream::unblocked(writer.get()) : LineStream(writer.get());
    expectNobodyWaits(stream, reader.get());
    EXPECT_EQ(::fcntl(writer.get(), F_GETFL) & O_NONBLOCK, 0) << "others share the description";
  }
}

TEST(LineStream, NorDoesAFullSocket) {
  int ends[2];
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends), 0);
  const UniqueFd reader(ends[0]), writer(ends[1]);
  LineStream stream = LineStream::unblocked(writer.get());
  expectNobodyWaits(stream, reader.get());
}

TEST(LineStream, NorATerminalWithCtrlS) {
  const UniqueFd emulator(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC));
  ASSERT_TRUE(emulator.valid() && ::grantpt(emulator.get()) == 0 && ::unlockpt(emulator.get()) == 0);
  const UniqueFd terminal(::open(::ptsname(emulator.get()), O_RDWR | O_NOCTTY | O_CLOEXEC));
  ASSERT_TRUE(terminal.valid());
  ASSERT_EQ(::tcflow(terminal.get(), TCOOFF), 0);
  LineStream stream = LineStream::unblocked(terminal.get());
  for (int i = 0; i < kLines; ++i) stream.write(line(i));  // Comes back.
  ASSERT_EQ(::tcflow(terminal.get(), TCOON), 0);
  stream.write("last\n");
  EXPECT_NE(readAll(emulator.get()).find("lines are lost here"), std::string::npos);
}

TEST(LineStream, ALineLongerThanAPipeTakesAtOnceIsWhole) {
  int ends[2];
  ASSERT_EQ(::pipe2(ends, O_CLOEXEC), 0);
  const UniqueFd reader(ends[0]), writer(ends[1]);
  LineStream stream(writer.get());
  std::string longest(10'001, 'x');
  longest.back() = '\n';
  stream.write(longest);
  EXPECT_EQ(readAll(reader.get()), longest);
}

}  // namespace
}  // namespace hapticd
