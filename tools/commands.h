// Every subcommand of `hpgo`; each is defined in its cmd_NAME.cc.
#pragma once

#include <vector>

#include "tools/command.h"

namespace hpgo_cli {

const Command& OptimizeCommand();
const Command& ReplayCommand();
const Command& EvaluateCommand();
const Command& GenerateCommand();
const Command& PlotCommand();
const Command& ConvertCommand();
const Command& CheckCommand();
const Command& HierarchyCommand();
const Command& ChartCommand();

// In the order of the help text.
const std::vector<const Command*>& AllCommands();

}  // namespace hpgo_cli
