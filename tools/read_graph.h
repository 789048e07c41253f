// Reads a graph as the flags of common_flags.h under "Reading" say.
#pragma once

#include <string>

#include "hpgo/graph/status.h"
#include "hpgo/io/graph_file.h"
#include "hpgo/io/read_report.h"

namespace hpgo_cli {

hpgo::ReadOptions ReadOptionsFromFlags();

// The graph in the file; "-" is the standard input. Prints the reader's warnings. `report` may be
// null.
hpgo::Result<hpgo::AnyGraphFile> ReadGraph(const std::string& path, hpgo::ReadReport* report);

}  // namespace hpgo_cli
