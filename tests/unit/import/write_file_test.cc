// What is written: whole or not at all, and nothing else is left behind.
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <functional>
#include <iterator>

#include "tests/unit/import/ball.h"
#include "tools/hapticctl-import/hand_over.h"

namespace hapticctl_import::test {
namespace {

using ::testing::HasSubstr;

void expectLeftIfItDoesNotFit(const Folder& folder, const std::string& name) {
  const std::string path = folder.put(name, "what was there"), link = folder.path() + "/link";
  std::filesystem::permissions(path, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit little{4096, before.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &little), 0);
  const std::string words = refusal([&] { return writeFile(path, std::string(5000, 'x')), 0; });
  const std::string fresh = refusal([&] { return writeFile(folder.path() + "/new", std::string(5000, 'x')), 0; });
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_THAT(words, HasSubstr("cannot be written: File too large"));
  EXPECT_THAT(fresh, HasSubstr("cannot be written: File too large"));
  const auto contents = [&] {
    std::ifstream file(path);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const auto files = [&] {
    return std::distance(std::filesystem::directory_iterator(folder.path()), std::filesystem::directory_iterator());
  };
  EXPECT_EQ(contents(), "what was there");
  EXPECT_EQ(files(), 1) << "a part was left";

  writeFile(path, "new");
  EXPECT_EQ(contents(), "new");
  EXPECT_EQ(std::filesystem::status(path).permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  std::filesystem::create_symlink(path, link);
  writeFile(link, "through it");
  EXPECT_EQ(contents(), "through it");
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &little), 0);
  std::signal(SIGXFSZ, SIG_IGN);
  EXPECT_THAT(refusal([&] { return writeFile(link, std::string(5000, 'x')), 0; }), HasSubstr("File too large"));
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(contents(), "through it");
  EXPECT_EQ(files(), 2);
}

TEST(WriteFile, leavesWhatWasThereIfItDoesNotFit) { expectLeftIfItDoesNotFit(Folder(), "old.ply"); }

// Beside a name as long as names may be no longer one could stand, and it was written in its place.
TEST(WriteFile, leavesWhatWasThereIfItDoesNotFitUnderALongName) {
  expectLeftIfItDoesNotFit(Folder(), std::string(251, 'a') + ".ply");
}

/** How a process ends that does that. */
int endOf(const std::function<void()>& work) {
  const pid_t child = ::fork();
  if (child == 0) {
    work();
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return status;
}

// As of /dev/stdout where a program has a nameless file for it, or a named one that it reads by its descriptor.
TEST(WriteFile, goesToAnOpenDescriptorsFileNotToItsName) {
  const Folder folder;
  const std::string path = folder.put("named", "old, and longer");
  for (const bool named : {true, false}) {
    const int fd = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
    ASSERT_GE(fd, 0);
    if (!named) {
      ASSERT_EQ(::unlink(path.c_str()), 0);
    }
    writeFile("/dev/fd/" + std::to_string(fd), "new");
    char read[16] = {};
    EXPECT_EQ(::pread(fd, read, sizeof read, 0), 3) << (named ? "named" : "nameless");
    EXPECT_STREQ(read, "new");
    ::close(fd);
  }
}

// The body of a cut was written, its fragment not: the old one lay beside it, and fitted nothing.
TEST(WriteFile, ofSeveralAllOrNoneAreWritten) {
  const Folder folder;
  const std::string body = folder.put("body.ply", "old body"), fragment = folder.put("fragment.ply", "old fragment");
  const auto contents = [](const std::string& path) {
    std::ifstream file(path);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const auto write = [&](std::size_t size) {
    PreparedFile first(body, "new body"), second(fragment, std::string(size, 'x'));
    first.keep();
    second.keep();
    return 0;
  };
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit little{4096, before.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &little), 0);
  const std::string words = refusal([&] { return write(5000); });
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_THAT(words, HasSubstr("File too large"));
  EXPECT_EQ(contents(body), "old body");
  EXPECT_EQ(contents(fragment), "old fragment");
  write(2);
  EXPECT_EQ(contents(body), "new body");
  EXPECT_EQ(contents(fragment), "xx");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 2);
  const int status = endOf([&] {
    const PreparedFile first(body, "newer body"), second(fragment, "newer fragment");
    ::raise(SIGTERM);
  });
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGTERM) << status;
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 2) << "a part was left";
}

// Of a file that replaced another one the part was left.
TEST(WriteFile, aSignalThatEndsTheProgramTakesWhatWasWritten) {
  for (const int end : {SIGINT, SIGTERM, SIGHUP}) {
    const Folder folder;
    const std::string path = folder.put("old.ply", "what was there");
    static int raised = 0;
    raised = end;
    const int status = endOf([&] {
      const rlimit little{4096, 4096};
      ::setrlimit(RLIMIT_FSIZE, &little);
      std::signal(SIGXFSZ, [](int) { ::raise(raised); });  // In the midst of it.
      writeFile(path, std::string(5000, 'x'));
    });
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == end) << status;
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
    std::ifstream file(path);
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), "what was there");
  }
}

// It took SIGHUP from nohup, and ended with the terminal.
TEST(WriteFile, aSignalThatIsIgnoredStaysSo) {
  EXPECT_EQ(endOf([] {
              std::signal(SIGHUP, SIG_IGN);
              const TemporaryFile file;
              ::raise(SIGHUP);
              ::_exit(std::filesystem::exists(file.path()) ? ::unlink(file.path().c_str()) : 1);
            }),
            0);
}

}  // namespace
}  // namespace hapticctl_import::test
