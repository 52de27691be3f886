/** @file
 * hapticctl: look at, feed and stop a running hapticd. A client like any other: it uses libhapticclient alone.
 */
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstring>
#include <deque>
#include <nlohmann/json.hpp>

#include "rt/base/standard_streams.h"
#include "tools/hapticctl/command/command.h"
#include "tools/hapticctl/daemon.h"
#include "tools/hapticctl/external.h"
#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/option.h"
#include "tools/hapticctl/output/output.h"
#include "tools/options/help.h"

namespace hapticctl {
namespace {

constexpr AddCommand kCommands[] = {addStatus,      addList,    addInfo,   addTop,  addMonitor, addRecord,
                                    addEvents,      addArm,     addDisarm, addStop, addLimits,  addLoad,
                                    addLoadTexture, addVolumes, addExport, addAdd,  addRemove,  addObjects,
                                    addHand,        addGet,     addSet,    addTool, addDoctor,  addDump};

constexpr const char* kCommandFooter =
    "Also --json, --socket PATH, --admin, --timeout SECONDS: hapticctl --help tells of them and of exit codes.";
constexpr const char* kFooter =
    "Exit: 0 done; 1 refused, or a check is red; 2 wrong command line; 3 no daemon answers; 4 the daemon went away;\n"
    "5 a file cannot be read or written, or holds nothing usable. A program hapticctl-NAME becomes the subcommand "
    "NAME.\n"
    "Sockets: --socket, else $HAPTICD_SOCKET, else $XDG_RUNTIME_DIR/hapticd, else /run/hapticd. Manual: hapticctl(1).";

/** The index of the first word that is no option (nor an option's value); argc if there is none. */
int firstWord(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--socket") == 0 || std::strcmp(argv[i], "--timeout") == 0) {
      ++i;
    } else if (argv[i][0] != '-') {
      return i;
    }
  }
  return argc;
}

/** Programs of a package of their own. */
constexpr const char* kImport = "import";  // Hands on to load what it does not know.
constexpr const char* kOwnPrograms[] = {kImport, "cut"};

std::string footer() {
  const bool there = !findExternal(kOwnPrograms[0]).empty();
  return std::string(there ? "Further: import, a scan as an object; cut, a mesh into two parts. Each has --help.\n"
                           : "Further, by the package hapticctl-import: import, a scan as an object; cut, a mesh.\n") +
         kFooter;
}

/**
 * Of the words before `end` each "--name=", as a variable that is not set leaves it, is two, the second one empty: CLI
 * would take the word behind it for the value, and that may be the command. Null stands at the end.
 */
std::vector<char*> apart(int argc, char** argv, int end) {
  static std::deque<std::string> names;
  static char none[] = "";
  std::vector<char*> words;
  for (int i = 0; i < argc; ++i) {
    const std::string_view word = argv[i];
    if (word == "--") end = i;
    if (i < end && word.size() > 3 && word.starts_with("--") && word.find('=') == word.size() - 1) {
      words.push_back(names.emplace_back(word.substr(0, word.size() - 1)).data());
      words.push_back(none);
    } else {
      words.push_back(argv[i]);
    }
  }
  words.push_back(nullptr);
  return words;
}

/** `word`: of the command, if there is one. */
void failIfEmpty(char** argv, int i, std::string_view word = {}) {
  if (argv[i][0] != '\0') return;
  const bool value = word == "set" && argv[i - 1][0] == '/';
  failUsage(argv[i - 1], "what follows it is empty",
            value ? fmt::format("give it a value, or write '{}?value=' to set nothing", argv[i - 1])
                  : "leave it out, or give it a value");
}

[[noreturn]] void failUnknown(std::string_view word, const std::vector<std::string>& names) {
  for (const char* const own : kOwnPrograms)
    if (word == own) failUsage(std::string(word), "is not installed", "apt install hapticctl-import");
  std::string near;
  for (const std::string& name : suggestions(word, names)) near += (near.empty() ? "did you mean " : " or ") + name;
  failUsage(std::string(word), "no such subcommand", near.empty() ? "hapticctl --help lists them" : near + "?");
}

/** The options, of the program or of the command that was named, that the first word which is none may mean. */
std::string meantOption(const CLI::App& app, int argc, char** argv) {
  std::vector<std::string> known;
  for (const CLI::App* at = &app; at != nullptr;
       at = at->get_subcommands().empty() ? nullptr : at->get_subcommands().front()) {
    for (const CLI::Option* option : at->get_options())
      for (const std::string& name : option->get_lnames())
        if (std::find(known.begin(), known.end(), "--" + name) == known.end()) known.push_back("--" + name);
  }
  for (int i = 1; i < argc && std::strcmp(argv[i], "--") != 0; ++i) {
    const std::string word = std::string(argv[i]).substr(0, std::string_view(argv[i]).find('='));
    if (!word.starts_with("--") || std::find(known.begin(), known.end(), word) != known.end()) continue;
    std::string near;
    for (const std::string& name : suggestions(word, known)) near += (near.empty() ? "did you mean " : " or ") + name;
    return near.empty() ? near : near + "? ";
  }
  return {};
}

/** Of those before the first word, which then is the value of one that nobody knows. */
void failIfNoOption(const CLI::App& app, int argc, char** argv, int word) {
  for (int i = 1; i < word; ++i) {
    const std::string name = std::string(argv[i]).substr(0, std::string_view(argv[i]).find('='));
    if (name == "--socket" || name == "--timeout") i += name == argv[i] ? 1 : 0;  // Over its value.
    if (name.starts_with('-') && app.get_option_no_throw(name) == nullptr && name != "-" && name != "--")
      failUsage(name, "no such option", meantOption(app, argc, argv) + "hapticctl --help lists them");
  }
}

int run(int argc, char** argv, Globals& globals) {
  for (int i = 1; i < argc && std::strcmp(argv[i], "--") != 0; ++i)
    if (std::strcmp(argv[i], "--json") == 0) globals.json = true;  // Also for what is found before all is read.
  CLI::App app{"Look at, feed and stop a running hapticd, the haptic device server.", "hapticctl"};
  app.footer(kCommandFooter);  // Commands begin with that of the program.
  app.set_version_flag("--version", std::string("hapticctl ") + haptic_version());
  app.add_flag("--json", globals.json, "Answer in JSON (streams: one value a line)");
  app.add_option("--socket", globals.socket, "Socket of the daemon")->type_name("PATH");
  app.add_flag("--admin", globals.admin, "Use the administration socket (raising limits, resetting statistics)");
  app.add_option("--timeout", globals.timeout_s, "Wait at most so long for an answer")
      ->type_name("SECONDS")
      ->capture_default_str()
      ->check(number(0.01, 3600.0));
  app.require_subcommand(1);

  Action chosen;
  std::vector<std::string> names;
  for (const AddCommand add : kCommands) add(app, chosen);
  app.footer(footer());
  for (CLI::App* command : app.get_subcommands({})) {
    command->fallthrough();
    names.push_back(command->get_name());
  }

  const auto isOwn = [&](int i) { return i == argc || std::find(names.begin(), names.end(), argv[i]) != names.end(); };
  int word = firstWord(argc, argv);
  std::vector<char*> words = apart(argc, argv, isOwn(word) ? argc : word);  // What is another program's stays.
  argc = static_cast<int>(words.size()) - 1;
  argv = words.data();
  word = firstWord(argc, argv);
  if (!isOwn(word)) {
    const std::string program = findExternal(argv[word]);
    if (program.empty()) {
      failIfNoOption(app, argc, argv, word);
      failUnknown(argv[word], names);
    }
    for (int i = 1; i < word; ++i) failIfEmpty(argv, i);
    runExternal(program, argc, argv, word, std::strcmp(argv[word], kImport) == 0);
    throw Failure{kExitRefused, program, std::strerror(errno), {}};
  }
  // Most likely a variable that is not set. "stop" takes it for every device: to stop is never wrong.
  const std::string_view command = word < argc ? argv[word] : "";
  for (int i = 1; i < argc && command != "stop"; ++i) failIfEmpty(argv, i, command);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // --help, --version
      put(hapticd_options::helpOf(app, error));
      flush();
      return kExitOk;
    }
    std::string command = "hapticctl";
    for (const CLI::App* at = &app; !at->get_subcommands().empty();)
      command += " " + (at = at->get_subcommands()[0])->get_name();
    const bool extras = error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError);
    failUsage({}, error.what(), (extras ? meantOption(app, argc, argv) : "") + command + " --help tells how");
  }
  const int code = chosen(globals);
  flush();
  return code;
}

}  // namespace
}  // namespace hapticctl

int main(int argc, char** argv) {
  using namespace hapticctl;       // NOLINT(google-build-using-namespace)
  hapticd::holdStandardStreams();  // What is said must not get into the file that is recorded, or to the daemon.
  std::signal(SIGPIPE, SIG_IGN);   // A reader that leaves is seen as EPIPE: what is armed must still be disarmed.
  std::signal(SIGXFSZ, SIG_IGN);   // A file that may not grow as EFBIG: it is told.
  Globals globals;
  try {
    return run(argc, argv, globals);
  } catch (const Failure& failure) {
    try {
      flush();
    } catch (...) {  // The failure is what matters.
    }
    report(failure, globals.json);
    return failure.exit;
  } catch (const OutputClosed&) {
    return kExitOk;
  } catch (const std::exception& error) {
    report({kExitRefused, {}, error.what(), "this is a defect in hapticctl; please report it", "INTERNAL"},
           globals.json);
    return kExitRefused;
  }
}
