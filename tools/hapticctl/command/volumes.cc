// hapticctl volumes: the cache on disk; export: the volume of an object as an OpenVDB file.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <chrono>
#include <vector>

#include "tools/hapticctl/command/command.h"
#include "tools/hapticctl/daemon.h"
#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/file/new_file.h"
#include "tools/hapticctl/file/whole_file.h"
#include "tools/hapticctl/numbers.h"
#include "tools/hapticctl/option.h"
#include "tools/hapticctl/output/output.h"
#include "tools/hapticctl/output/terminal.h"
#include "tools/hapticctl/output/to_json.h"
#include "tools/options/ending.h"

namespace hapticctl {
namespace {

int listVolumes(const Globals& globals) {
  const Daemon daemon(globals);
  const auto text = daemon.ask<haptic_text>(haptic_get, "/volumes");
  const Json volumes = Json::parse(std::string_view(text->text, text->length));
  if (globals.json) {
    putJson(volumes);
    return kExitOk;
  }
  Table table({{"OBJECTS"}, {"USER", true}, {"SIZE", true}, {"OPENVDB", true}, {"UNUSED", true}, {"KEY"}});
  for (const Json& v : volumes) {
    std::string objects;
    for (const Json& name : v["objects"]) objects += (objects.empty() ? "" : " ") + name.get<std::string>();
    const auto key = v["key"].get<std::string>();
    const auto vdb = v["vdb_bytes"].get<std::uint64_t>();
    table.row({objects.empty() ? "-" : objects, key.substr(0, key.find('-')), bytes(v["bytes"].get<std::uint64_t>()),
               vdb == 0 ? "-" : bytes(vdb), duration(v["unused_s"].get<double>() * 1e9), key},
              objects.empty() ? Style::kDim : Style::kPlain);
  }
  put(table.text());
  if (table.empty()) {
    note(
        "hapticctl: no volume is kept on disk; hapticctl load --voxel builds one, builder.cache says where it is kept");
  }
  return kExitOk;
}

struct VolumesOptions {
  std::string object, file;
  bool replace = false;
  double wait_s = 60;
};

/** A descriptor of the daemon's file; waits while it is being made. */
int openVolume(const Daemon& daemon, const VolumesOptions& options, const Interrupt& interrupt) {
  LiveLine live;
  const std::int64_t begin_ns = haptic_now_ns();
  for (;;) {
    int fd = -1;
    haptic_error error = HAPTIC_ERROR_INIT;
    const int code = haptic_object_volume_file(daemon.client(), options.object.c_str(), &fd, &error);
    const bool late = static_cast<double>(haptic_now_ns() - begin_ns) * 1e-9 >= options.wait_s;
    if (code != HAPTIC_WOULD_BLOCK || late || Interrupt::asked()) {
      live.clear();
      try {
        check(code, error);
      } catch (Failure& failure) {
        if (failure.where == "mesh") failure.where = options.object;  // Its.
        throw;
      }
      return fd;
    }
    live.show("waiting for the file to be made");
    interrupt.wait(std::chrono::milliseconds(100));
  }
}

int exportVolume(const VolumesOptions& options, const Globals& globals) {
  if (hapticd_options::promisesAnother(options.file, ".vdb"))
    failUsage(options.file, "is no name for a .vdb file", "end it in .vdb");
  const Interrupt interrupt;
  const Daemon daemon(globals);
  const int from = openVolume(daemon, options, interrupt);
  const struct Close {
    int fd;
    ~Close() { ::close(fd); }
  } close{from};
  WholeFile file(options.file, options.replace);
  std::vector<char> piece(1u << 20);
  int problem = 0;
  for (ssize_t n = 1; problem == 0 && n != 0 && !Interrupt::asked();) {
    n = ::read(from, piece.data(), piece.size());
    if (n < 0 && errno == EINTR) continue;
    problem = n < 0 ? errno : file.write(piece.data(), static_cast<std::size_t>(n));
  }
  if (Interrupt::asked()) throw Failure{kExitRefused, options.file, "cancelled; it is not written", {}, "CANCELLED"};
  if (problem == 0) problem = file.keep();
  if (problem == EEXIST) failMaking(options.file, problem);
  if (problem != 0) failWriting(options.file, problem);
  if (globals.json) {
    putJson({{"file", options.file}, {"bytes", file.bytes()}});
  } else {
    print("{}: {}\n", printable(options.file), bytes(file.bytes()));
  }
  return kExitOk;
}

}  // namespace

void addVolumes(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("volumes", "List the built volumes that the daemon keeps on disk");
  whenNamed(command, chosen, listVolumes);
}

void addExport(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("export", "Write the volume of an object as an OpenVDB file");
  auto o = std::make_shared<VolumesOptions>();
  command->add_option("OBJECT", o->object, "Name of an object whose mesh was loaded with --voxel")->required();
  command->add_option("FILE", o->file, "The file to write, .vdb")->required();
  command->add_flag("--replace", o->replace, "Overwrite the file if it is there");
  command->add_option("--wait", o->wait_s, "Wait at most so long while it is being made")
      ->type_name("SECONDS")
      ->capture_default_str()
      ->check(number(0, 86400));
  whenNamed(command, chosen, [o](const Globals& globals) { return exportVolume(*o, globals); });
}

}  // namespace hapticctl
