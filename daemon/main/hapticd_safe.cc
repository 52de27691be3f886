// hapticd-safe: brings to zero the devices that a dead hapticd had armed, and touches no other. systemd runs it
// whenever the service has ended, however that came about.
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <string>
#include <string_view>

#include "daemon/armed/armed_list.h"
#include "daemon/armed/make_safe.h"
#include "daemon/config/config.h"
#include "drivers/registry.h"
#include "rt/base/standard_streams.h"

namespace {

constexpr std::string_view kHelp =
    "hapticd-safe [FILE]\n"
    "Brings to zero each device listed in FILE and takes it off that list. Without\n"
    "FILE: armed in $RUNTIME_DIRECTORY, else /run/hapticd/armed. hapticd writes that\n"
    "list before it arms; while it lives nothing is done.\n"
    "Exit: 0 all is safe; 1 a device could not be brought to zero; 2 wrong usage;\n"
    "3 hapticd lives or the list cannot be read.\n";

std::string listIn(int argc, char** argv) {
  if (argc == 2) return argv[1];
  const std::string folder = hapticd::serviceFolder("RUNTIME_DIRECTORY");
  return (folder.empty() ? "/run/hapticd" : folder) + "/armed";
}

}  // namespace

int main(int argc, char** argv) {
  using namespace hapticd;  // NOLINT(google-build-using-namespace)
  hapticd::holdStandardStreams();
  if (argc > 2 || (argc == 2 && (argv[1][0] == '-' || argv[1][0] == '\0'))) {
    const bool help = argc == 2 && std::string_view(argv[1]) == "--help";
    std::fputs(kHelp.data(), help ? stdout : stderr);
    return help ? 0 : 2;
  }
  const std::string path = listIn(argc, argv);
  if (::access(path.c_str(), F_OK) != 0 && errno == ENOENT) return 0;  // nothing was ever armed
  Result<ArmedList> list = ArmedList::open(path);
  if (!list) {
    std::fprintf(stderr, "hapticd-safe: %s\n", toString(list.error()).c_str());
    return 3;
  }
  bool all = true;
  for (const MadeSafe& device : makeSafe(list->left(), zeroDevice)) {
    all = all && device.ok;
    if (device.ok) list->settle(device.uri);  // The others stay: whoever runs this again, or the next hapticd, tries.
    std::fprintf(stderr, "%s %s%s%s\n", device.ok ? "made safe:" : "NOT MADE SAFE:", device.uri.c_str(),
                 device.ok ? "" : ": ", device.text.c_str());
  }
  if (!all) {
    std::fprintf(stderr,
                 "(each start of hapticd tries again; of a device that is gone for good: delete its line from %s while "
                 "none runs)\n",
                 path.c_str());
  }
  return all ? 0 : 1;
}
