#include "hpgo/io/record_tags.h"

namespace hpgo {
namespace {

// name, type, dimension, ids, pose, information, TORO order, parameter
constexpr RecordTag kTags[] = {
    {"EDGE_SE2", RecordType::kEdge, 2, 2, 3, 6},
    {"EDGE_SE3:QUAT", RecordType::kEdge, 3, 2, 7, 21},
    {"VERTEX_SE2", RecordType::kVertex, 2, 1, 3, 0},
    {"VERTEX_SE3:QUAT", RecordType::kVertex, 3, 1, 7, 0},
    {"FIX", RecordType::kFix},
    {"PARAMS_SE2OFFSET", RecordType::kOffset, 2, 1, 3, 0, false, 0},
    {"PARAMS_SE3OFFSET", RecordType::kOffset, 3, 1, 7, 0, false, 0},
    {"EDGE_SE3_PRIOR", RecordType::kPrior, 3, 2, 7, 21, false, 1},
    {"EDGE_SE3_XYZ_PRIOR", RecordType::kPrior, 3, 2, 3, 6, false, 1},
    {"EDGE_PRIOR_SE2", RecordType::kPrior, 2, 1, 3, 6},
    {"EDGE_PRIOR_SE2_XY", RecordType::kPrior, 2, 1, 2, 3},
    {"VERTEX_XY", RecordType::kLandmark, 2},
    {"EDGE_SE2_XY", RecordType::kLandmark, 2},
    {"VERTEX_TRACKXYZ", RecordType::kLandmark, 3},
    {"EDGE_SE3_TRACKXYZ", RecordType::kLandmark, 3},
    {"VERTEX2", RecordType::kVertex, 2, 1, 3, 0},
    {"VERTEX", RecordType::kVertex, 2, 1, 3, 0},
    {"EDGE2", RecordType::kEdge, 2, 2, 3, 6, true},
    {"EDGE", RecordType::kEdge, 2, 2, 3, 6, true},
    {"VERTEX3", RecordType::kVertex, 3, 1, 6, 0},
    {"EDGE3", RecordType::kEdge, 3, 2, 6, 21},
    {"EQUIV", RecordType::kEquivalence, 0, 2},
};
constexpr RecordTag kUnknownTag;

}  // namespace

const RecordTag& FindRecordTag(std::string_view name) {
  for (const RecordTag& tag : kTags) {
    if (tag.name == name) return tag;
  }
  return kUnknownTag;
}

}  // namespace hpgo
