// Writes pose graphs in the g2o format.
#pragma once

#include <string>

#include "hpgo/graph/status.h"
#include "hpgo/io/graph_file.h"

namespace hpgo {

struct WriteOptions {
  // Writes FIX lines for fixed nodes that no FIX line of the file names. Off: nobody gets a gauge
  // that was not asked for.
  bool write_fixed = false;
};

// Writes to `path`, completely or not at all (output_file.h); "-" is the standard output. Lines
// keep their order, and every number reads back bit for bit. A node without a vertex line gets one
// ahead of the other records if it has a pose; edges and priors that the file did not hold come
// last. Records that were read in TORO's format are written in g2o's.
//
// kUnreadable if the file cannot be written; kInvalidArgument, with nothing written, for what
// cannot be read again: a number that is not finite, poses for some nodes only, a prior in 2D with
// an offset.
template <typename G>
Status WriteG2o(const GraphFile<G>& file, const std::string& path,
                const WriteOptions& options = WriteOptions());
Status WriteG2o(const AnyGraphFile& file, const std::string& path,
                const WriteOptions& options = WriteOptions());

// The same text in memory, appended to `text`; unchanged on an error.
template <typename G>
Status FormatG2o(const GraphFile<G>& file, const WriteOptions& options, std::string* text);
Status FormatG2o(const AnyGraphFile& file, const WriteOptions& options, std::string* text);

// A graph alone: parameters, vertices, edges and priors.
template <typename G>
Status WriteG2o(const PoseGraph<G>& graph, const std::string& path,
                const WriteOptions& options = WriteOptions());

}  // namespace hpgo
