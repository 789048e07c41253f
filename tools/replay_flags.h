// The flags of hpgo replay.
#pragma once

#include <string>

#include "gflags/gflags.h"
#include "tools/replay_run.h"

DECLARE_string(mode);
DECLARE_string(preset);
DECLARE_string(stats_csv);
DECLARE_string(chart);
DECLARE_string(summary_csv);
DECLARE_string(measure_mode);
DECLARE_string(save);
DECLARE_string(resume);
DECLARE_double(compare_threshold);

namespace hpgo_cli {

// What the flags ask for; `problem` says what is wrong with them, and is empty if nothing is.
ReplaySettings ReplaySettingsFromFlags(std::string* problem);

// Why the flags do not go with the options of a saved state: one of them asks for others. Empty if
// they do.
std::string ConflictWithSaved(const hpgo::OptimizerOptions& saved,
                              const hpgo::OptimizerOptions& wanted);

}  // namespace hpgo_cli
