/** @file
 * The subcommands, one file each. Each adds itself to the command line; what it does runs after all is parsed.
 */
#pragma once

#include <functional>

#include "tools/hapticctl/exit_code.h"

namespace CLI {
class App;
}

namespace hapticctl {

struct Globals;

/** What the chosen subcommand will do; throws Failure, returns an ExitCode. */
using Action = std::function<int(const Globals&)>;
/** Adds one subcommand, which sets `chosen` when it is named. */
using AddCommand = void (*)(CLI::App& app, Action& chosen);

void addList(CLI::App& app, Action& chosen);
void addInfo(CLI::App& app, Action& chosen);
void addStatus(CLI::App& app, Action& chosen);
void addTop(CLI::App& app, Action& chosen);
void addMonitor(CLI::App& app, Action& chosen);
void addRecord(CLI::App& app, Action& chosen);
void addEvents(CLI::App& app, Action& chosen);
void addLoad(CLI::App& app, Action& chosen);
void addVolumes(CLI::App& app, Action& chosen);
void addExport(CLI::App& app, Action& chosen);
void addLoadTexture(CLI::App& app, Action& chosen);
void addAdd(CLI::App& app, Action& chosen);
void addRemove(CLI::App& app, Action& chosen);
void addObjects(CLI::App& app, Action& chosen);
void addHand(CLI::App& app, Action& chosen);
void addGet(CLI::App& app, Action& chosen);
void addSet(CLI::App& app, Action& chosen);
void addArm(CLI::App& app, Action& chosen);
void addDisarm(CLI::App& app, Action& chosen);
void addStop(CLI::App& app, Action& chosen);
void addLimits(CLI::App& app, Action& chosen);
void addTool(CLI::App& app, Action& chosen);
void addDump(CLI::App& app, Action& chosen);
void addDoctor(CLI::App& app, Action& chosen);

}  // namespace hapticctl
