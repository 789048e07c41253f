// What a reader is told, and what it says about a file.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "hpgo/graph/status.h"

namespace hpgo {

// The order of the six information numbers of the tags EDGE2 and EDGE.
enum class Edge2Order {
  kToro,      // xx xy yy tt xt yt: TORO
  kRowMajor,  // xx xy xt yy yt tt: RTAB-Map, GTSAM
};

struct ReadOptions {
  // What would be a warning about the content of a line is an error: unknown tags, landmarks,
  // quaternions off unit length, priors without their parameter, vertices given twice.
  bool strict = false;
  // Replaces an information matrix that is not positive semi-definite by the nearest one with
  // eigenvalues of at least 1e-9 times the largest.
  bool project_information = false;
  // A line whose information is missing altogether is read as if the identity stood there.
  bool identity_information = false;
  // Composes, from the edges, the poses of nodes that no vertex line gives. A file without any
  // vertex needs no such leave.
  bool create_missing = false;
  // Goes on after an error, to list every one in ReadReport::problems; the result is an error
  // still. Lists every warning too.
  bool collect_all_problems = false;
  Edge2Order edge2_order = Edge2Order::kToro;
};

// Counts are of lines. Messages read "FILE:LINE: what is wrong: 'offending text'" and stand in the
// order of the lines.
struct ReadReport {
  std::int64_t bytes = 0;
  std::int64_t lines = 0;
  std::map<std::string, std::int64_t, std::less<>> tags;  // lines with each tag, unknown ones too
  std::int64_t comments = 0;
  std::int64_t unknown = 0;
  std::int64_t landmarks = 0;
  std::int64_t duplicate_vertices = 0;      // with identical poses; the later ones are left out
  std::int64_t normalized_quaternions = 0;  // off unit length by more than 1e-3
  std::int64_t semidefinite_informations = 0;
  std::int64_t projected_informations = 0;
  std::int64_t identity_informations = 0;  // missing, under identity_information
  std::int64_t merged_nodes = 0;           // further names of a node, by EQUIV
  std::int64_t created_nodes = 0;          // composed from edges, under create_missing
  std::int64_t priors_without_offset = 0;
  bool edges_only = false;            // no vertex line: no node has a pose
  std::vector<std::string> warnings;  // at most a few of each kind, with a count of the others
  std::vector<std::string> problems;  // under collect_all_problems only
};

}  // namespace hpgo
