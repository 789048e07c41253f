// Lists of poses: what an estimate is compared with. KITTI and TUM files, and the vertices of g2o
// files.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "hpgo/graph/pose_graph.h"
#include "hpgo/io/graph_file.h"
#include "hpgo/io/read_report.h"

namespace hpgo {

struct Trajectory {
  std::vector<double> stamps;  // seconds; empty where the file gives none
  std::vector<SE3> poses;      // T_world_body
  std::vector<NodeId> ids;     // empty where the file gives none
};

enum class TrajectoryFormat {
  kAuto,   // by content
  kG2o,    // the vertices in the order of their ids; composed from the edges if there are none
  kKitti,  // 12 numbers a line: the upper 3 x 4 of the pose's matrix, row by row
  kTum,    // stamp x y z qx qy qz qw
};

// The format of `text`, by its first line that is neither blank nor a comment: 12 numbers, 8
// numbers, or a tag. kAuto if it is none of them.
TrajectoryFormat DetectFormat(std::string_view text);

// The file at `path`; "-" is the standard input. Poses of a planar file have z = 0. Errors as those
// of ReadG2o, and kMalformed for a matrix that is no rotation; one that is off by more than 1e-3 is
// made one with a warning. The report may be null.
Result<Trajectory> ReadTrajectory(const std::string& path, TrajectoryFormat format,
                                  const ReadOptions& options, ReadReport* report);
Result<Trajectory> ParseTrajectory(std::string_view text, const std::string& name,
                                   TrajectoryFormat format, const ReadOptions& options,
                                   ReadReport* report);

// The poses of a graph in the order of its ids, which also stand in for the time; poses that are
// missing are composed from the edges.
template <typename G>
Trajectory ToTrajectory(const PoseGraph<G>& graph);

// The pose in space of one in the plane: z = 0, rotated about the z axis.
SE3 ToSpace(const SE2& pose);
inline const SE3& ToSpace(const SE3& pose) { return pose; }

// As evo wants it: single spaces, no space at the end of a line, no blank line. `format` is kKitti
// or kTum. Where there are no stamps, TUM gets the ids, or else the numbers from zero. Completely
// or not at all; kInvalidArgument for poses that are not finite, arrays of different sizes and
// other formats.
Status WriteTrajectory(const Trajectory& trajectory, TrajectoryFormat format,
                       const std::string& path);

// The same text in memory, appended to `text`; unchanged on an error.
Status FormatTrajectory(const Trajectory& trajectory, TrajectoryFormat format, std::string* text);

}  // namespace hpgo
