#include "tools/commands.h"

namespace hpgo_cli {

const std::vector<const Command*>& AllCommands() {
  static const std::vector<const Command*>* commands = new std::vector<const Command*>{
#ifdef HPGO_HAS_OPTIMIZE
      &OptimizeCommand(),
#endif
#ifdef HPGO_HAS_REPLAY
      &ReplayCommand(),
#endif
#ifdef HPGO_HAS_EVALUATE
      &EvaluateCommand(),
#endif
#ifdef HPGO_HAS_GENERATE
      &GenerateCommand(),
#endif
#ifdef HPGO_HAS_PLOT
      &PlotCommand(),
#endif
#ifdef HPGO_HAS_CONVERT
      &ConvertCommand(),
#endif
#ifdef HPGO_HAS_CHECK
      &CheckCommand(),
#endif
#ifdef HPGO_HAS_HIERARCHY
      &HierarchyCommand(),
#endif
#ifdef HPGO_HAS_CHART
      &ChartCommand(),
#endif
#ifdef HPGO_HAS_BENCH
      &BenchCommand(),
#endif
  };
  return *commands;
}

}  // namespace hpgo_cli
