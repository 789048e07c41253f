// What may stand on a line of a g2o or TORO file.
#pragma once

#include <string>
#include <string_view>

namespace hpgo {

enum class RecordType {
  kVertex,
  kEdge,
  kPrior,
  kOffset,       // PARAMS_SE3OFFSET, PARAMS_SE2OFFSET: the pose of a sensor on the robot
  kFix,          // one or more ids of nodes that never move
  kLandmark,     // counted and kept, not optimized
  kEquivalence,  // TORO's EQUIV: two names of one node
  kUnknown,      // counted and kept
};

// How the numbers of an information matrix stand.
enum class InformationForm {
  kRowMajor,  // the upper triangle, row by row
  kToro,      // xx xy yy tt xt yt, unless the reader is told otherwise
  kRoot,      // iSAM: R, upper triangular and row by row, with R' R the information
};

// One tag and the numbers that follow it, in this order.
struct RecordTag {
  std::string_view name;
  RecordType type = RecordType::kUnknown;
  int dimension = 0;    // 2 or 3; 0 where both may have it
  int ids = 0;          // of nodes, then of a parameter
  int pose = 0;         // 2: x y; 3: x y theta, or x y z; 6: x y z roll pitch yaw; 7: quaternion
  int information = 0;  // of the upper triangle
  InformationForm form = InformationForm::kRowMajor;
  int parameter = -1;  // which of the ids is a parameter's
  int fields() const { return ids + pose + information; }
};

// The tag called `name`; one of type kUnknown, without a name, for any other.
const RecordTag& FindRecordTag(std::string_view name);

// The tags of which something is read, and those that are kept as text, for people: indented lines.
std::string RecordTagList();

}  // namespace hpgo
