// Poses from any file that holds some, and which pose of one file belongs to which of another.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hpgo/graph/status.h"
#include "hpgo/io/graph_file.h"
#include "hpgo/io/trajectory.h"

namespace hpgo_cli {

struct PoseSource {
  std::string name;
  std::optional<hpgo::AnyGraphFile> graph;  // of a g2o or TORO file; every node has a pose
  hpgo::Trajectory trajectory;              // of any file: the graph's poses in space, by id
};

// A g2o, TORO, KITTI or TUM file, told apart by content; "-" is the standard input. Poses that a
// graph lacks are composed from its edges. Prints the reader's warnings.
hpgo::Result<PoseSource> ReadPoseSource(const std::string& path);

// The poses on the plane that --plane names. Poses that lie in the xy plane already (a 2D graph's)
// need no such flag. kInvalidArgument where there is no plane, or none of that name.
hpgo::Result<std::vector<hpgo::SE2>> PlanarPoses(const std::vector<hpgo::SE3>& poses,
                                                 const std::string& name);

struct PoseMatches {
  std::vector<std::pair<int, int>> pairs;  // (first, second), ascending in first's key
  std::string by;                          // "id", "time", "line" or "order", for people
};

// By id where both have ids; otherwise by the nearest id, stamp or line number within 0.01. Where
// nothing agrees so and the lengths are equal, in order: if one of them has no stamps, or under
// --by_order. kInvalidArgument where nothing matches.
hpgo::Result<PoseMatches> MatchPoses(const PoseSource& first, const PoseSource& second);

}  // namespace hpgo_cli
