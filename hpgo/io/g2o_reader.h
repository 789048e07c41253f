// Reads pose graphs in the g2o format and in TORO's, 2D and 3D.
#pragma once

#include <string>
#include <string_view>

#include "hpgo/graph/status.h"
#include "hpgo/io/graph_file.h"
#include "hpgo/io/read_report.h"

namespace hpgo {

// The file at `path`, or the standard input where it is "-". The first record that has a dimension
// decides whether the graph is 2D or 3D.
//
//   ReadReport report;
//   Result<AnyGraphFile> file = ReadG2o("map.g2o", ReadOptions(), &report);
//   if (!file.ok()) return file.status();
//   std::visit([](auto& f) { Optimize(&f.graph); }, *file);
//
// kUnreadable if the file cannot be read; kMalformed with "FILE:LINE: what is wrong: 'offending
// text'" if its content is wrong. Nothing is left out in silence: what the graph cannot hold is
// kept as text (see GraphFile) and reported. `report` may be null; it is filled on errors too.
Result<AnyGraphFile> ReadG2o(const std::string& path, const ReadOptions& options,
                             ReadReport* report);

// The same from memory. `name` stands for the file in messages.
Result<AnyGraphFile> ParseG2o(std::string_view text, const std::string& name,
                              const ReadOptions& options, ReadReport* report);

}  // namespace hpgo
