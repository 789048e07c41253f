#include "tools/commands.h"

namespace hpgo_cli {

const std::vector<const Command*>& AllCommands() {
  static const std::vector<const Command*>* commands = new std::vector<const Command*>{
      &OptimizeCommand(), &ReplayCommand(), &EvaluateCommand(),  &GenerateCommand(), &PlotCommand(),
      &ConvertCommand(),  &CheckCommand(),  &HierarchyCommand(), &ChartCommand(),
  };
  return *commands;
}

}  // namespace hpgo_cli
