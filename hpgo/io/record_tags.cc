#include "hpgo/io/record_tags.h"

namespace hpgo {
namespace {

constexpr InformationForm kRowMajor = InformationForm::kRowMajor;

// name, type, dimension, ids, pose, information, form, parameter
constexpr RecordTag kTags[] = {
    {"EDGE_SE2", RecordType::kEdge, 2, 2, 3, 6},
    {"EDGE_SE3:QUAT", RecordType::kEdge, 3, 2, 7, 21},
    {"VERTEX_SE2", RecordType::kVertex, 2, 1, 3, 0},
    {"VERTEX_SE3:QUAT", RecordType::kVertex, 3, 1, 7, 0},
    {"FIX", RecordType::kFix},
    {"PARAMS_SE2OFFSET", RecordType::kOffset, 2, 1, 3, 0, kRowMajor, 0},
    {"PARAMS_SE3OFFSET", RecordType::kOffset, 3, 1, 7, 0, kRowMajor, 0},
    {"EDGE_SE3_PRIOR", RecordType::kPrior, 3, 2, 7, 21, kRowMajor, 1},
    {"EDGE_SE3_XYZ_PRIOR", RecordType::kPrior, 3, 2, 3, 6, kRowMajor, 1},
    {"EDGE_PRIOR_SE2", RecordType::kPrior, 2, 1, 3, 6},
    {"EDGE_PRIOR_SE2_XY", RecordType::kPrior, 2, 1, 2, 3},
    {"VERTEX_XY", RecordType::kLandmark, 2},
    {"EDGE_SE2_XY", RecordType::kLandmark, 2},
    {"VERTEX_TRACKXYZ", RecordType::kLandmark, 3},
    {"EDGE_SE3_TRACKXYZ", RecordType::kLandmark, 3},
    {"VERTEX2", RecordType::kVertex, 2, 1, 3, 0},
    {"VERTEX", RecordType::kVertex, 2, 1, 3, 0},
    {"EDGE2", RecordType::kEdge, 2, 2, 3, 6, InformationForm::kToro},
    {"EDGE", RecordType::kEdge, 2, 2, 3, 6, InformationForm::kToro},
    {"VERTEX3", RecordType::kVertex, 3, 1, 6, 0},
    {"EDGE3", RecordType::kEdge, 3, 2, 6, 21},
    {"VERTEX_XYT", RecordType::kVertex, 2, 1, 3, 0},
    {"EDGE_XYT", RecordType::kEdge, 2, 2, 3, 6},
    {"ODOMETRY", RecordType::kEdge, 2, 2, 3, 6, InformationForm::kRoot},
    {"LANDMARK", RecordType::kLandmark, 2},
    {"EQUIV", RecordType::kEquivalence, 0, 2},
};
constexpr RecordTag kUnknownTag;

// The names of those for which `take` says so, in lines of this width.
template <typename Take>
std::string Names(const Take& take) {
  constexpr std::size_t kWidth = 80;
  std::string text, line = " ";
  for (const RecordTag& tag : kTags) {
    if (!take(tag)) continue;
    if (line.size() + 1 + tag.name.size() > kWidth) {
      text += line + "\n";
      line = " ";
    }
    line += " " + std::string(tag.name);
  }
  return text + line + "\n";
}

}  // namespace

const RecordTag& FindRecordTag(std::string_view name) {
  for (const RecordTag& tag : kTags) {
    if (tag.name == name) return tag;
  }
  return kUnknownTag;
}

std::string RecordTagList() {
  const auto kept = [](const RecordTag& tag) { return tag.type == RecordType::kLandmark; };
  const auto in = [&](int dimension) {
    return Names([&](const RecordTag& tag) { return tag.dimension == dimension && !kept(tag); });
  };
  return "Tags that are read, in 2D:\n" + in(2) + "in 3D:\n" + in(3) + "in both:\n" + in(0) +
         "Landmarks, kept as text:\n" + Names(kept) + "Any other tag is kept as text.\n";
}

}  // namespace hpgo
