// Whether a replay went well.
#pragma once

#include "tools/replay_report.h"

namespace hpgo_cli {

// Warns of what went wrong; the exit code of a replay that came to a result.
int JudgeReplay(const ReplayFigures& figures);

}  // namespace hpgo_cli
