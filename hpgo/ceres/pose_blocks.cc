#include "hpgo/ceres/pose_blocks.h"

#include <algorithm>
#include <set>

namespace hpgo {
namespace {

struct KnownLayout {
  std::vector<int> sizes;
  const char* name;
  int max_dof;  // in total: what keeps a pose apart from a point, or a quaternion without manifold
};

const std::vector<KnownLayout>& KnownLayouts() {
  static const auto* const layouts = new std::vector<KnownLayout>{
      {{7}, "a block of 7", 6},
      {{3, 4}, "translation and quaternion", 6},
      {{4, 3}, "quaternion and translation", 6},
      {{1, 1, 1}, "scalars x, y, yaw", 3},
      {{2, 1}, "position and yaw", 3},
      {{1, 2}, "yaw and position", 3},
      {{1, 3}, "yaw and translation", 4},
      {{3, 1}, "translation and yaw", 4},
      {{4}, "a block x, y, z, yaw", 4},
      {{3}, "a block x, y, theta", 3},
      {{6}, "a block of 6", 6},
  };
  return *layouts;
}

class Finder {
 public:
  Finder(const ProblemView& problem, const KnownLayout& layout, PoseBlocks* poses)
      : problem_(problem), layout_(layout), length_(layout.sizes.size()), poses_(*poses) {}

  bool Run() {
    poses_ = PoseBlocks();
    poses_.sizes = layout_.sizes;
    poses_.pose_of.assign(problem_.blocks().size(), -1);
    poses_.column_of.assign(problem_.blocks().size(), 0);
    // Two poses at a time first: what a shorter residual is over shows only then.
    const int num_residuals = static_cast<int>(problem_.residuals().size());
    for (int r = 0; r < num_residuals; ++r) {
      if (Count(r) < 2 * length_) continue;
      if (!Split(r)) return false;
      ++passed_;
    }
    for (int r = 0; r < num_residuals; ++r) {
      if (Count(r) < 2 * length_) TrySplit(r);
    }
    for (int r = 0; r < num_residuals; ++r) {
      if (!Check(r)) return false;
      ++passed_;
    }
    return CheckPoses();
  }
  // How far it got, and why no further.
  int passed() const { return passed_; }
  const std::string& reason() const { return reason_; }

 private:
  std::size_t Count(int r) const { return problem_.residuals()[r].count; }
  const BlockView& Block(int r, std::size_t k) const { return problem_.blocks()[Index(r, k)]; }
  int Index(int r, std::size_t k) const {
    return problem_.BlockOf(problem_.residuals()[r], static_cast<int>(k));
  }
  bool Refuse(const std::string& reason) {
    reason_ = reason;
    return false;
  }

  // Whether blocks k and the following have the sizes of a pose.
  bool Matches(int r, std::size_t k) const {
    if (k + length_ > Count(r)) return false;
    for (std::size_t p = 0; p < length_; ++p) {
      if (Block(r, k + p).size != layout_.sizes[p]) return false;
    }
    return true;
  }

  // Makes them one, unless they are already, or parts of others.
  bool Join(int r, std::size_t k) {
    const int first = poses_.pose_of[Index(r, k)];
    for (std::size_t p = 0; p < length_; ++p) {
      const int pose = poses_.pose_of[Index(r, k + p)];
      if (pose != first || (pose >= 0 && poses_.BlockOf(pose, p) != Index(r, k + p))) return false;
    }
    if (first >= 0) return true;
    const int pose = poses_.num_poses();
    int column = 0;
    for (std::size_t p = 0; p < length_; ++p) {
      const int b = Index(r, k + p);
      poses_.blocks.push_back(b);
      poses_.pose_of[b] = pose;
      poses_.column_of[b] = column;
      if (!problem_.blocks()[b].constant) column += problem_.blocks()[b].tangent;
    }
    poses_.max_dof = std::max(poses_.max_dof, column);
    return true;
  }

  bool Split(int r) {
    for (std::size_t k = 0; k < Count(r);) {
      if (Matches(r, k) && Join(r, k)) {
        k += length_;
      } else if (Block(r, k).constant) {
        ++k;
      } else {
        return Refuse(problem_.NameOf(Index(r, k)) + " belongs to no pose of " + layout_.name);
      }
    }
    return true;
  }

  void TrySplit(int r) {
    for (std::size_t k = 0; k < Count(r);) k += Matches(r, k) && Join(r, k) ? length_ : 1;
  }

  bool Check(int r) {
    over_.clear();
    for (std::size_t k = 0; k < Count(r); ++k) {
      if (Block(r, k).constant) continue;
      const int pose = poses_.pose_of[Index(r, k)];
      if (pose < 0) {
        return Refuse(problem_.NameOf(Index(r, k)) + " belongs to no pose");
      }
      if (std::find(over_.begin(), over_.end(), pose) == over_.end()) over_.push_back(pose);
    }
    if (over_.size() > 2) {
      return Refuse("residual " + std::to_string(r) + " spans " + std::to_string(over_.size()) +
                    " poses");
    }
    return true;
  }

  bool CheckPoses() {
    for (const int b : poses_.blocks) {
      if (problem_.blocks()[b].bounded) {
        return Refuse("bounds on a pose: " + problem_.NameOf(b));
      }
    }
    if (poses_.max_dof > layout_.max_dof) {
      return Refuse("a pose has " + std::to_string(poses_.max_dof) +
                    " degrees of freedom: its quaternion has no manifold");
    }
    if (layout_.sizes == std::vector<int>{4}) {
      for (const int b : poses_.blocks) {
        if (problem_.blocks()[b].tangent == 3) {
          return Refuse(problem_.NameOf(b) + " is a rotation alone");
        }
      }
    }
    return true;
  }

  const ProblemView& problem_;
  const KnownLayout& layout_;
  const std::size_t length_;
  PoseBlocks& poses_;
  std::string reason_;
  int passed_ = 0;
  std::vector<int> over_;  // workspace
};

}  // namespace

std::string LayoutName(const std::vector<int>& sizes) {
  for (const KnownLayout& layout : KnownLayouts()) {
    if (layout.sizes == sizes) return layout.name;
  }
  return "unknown blocks";
}

bool FindPoseBlocks(const ProblemView& problem, const std::vector<int>& sizes, PoseBlocks* poses,
                    std::string* reason) {
  std::set<int> free_sizes;
  for (const BlockView& block : problem.blocks()) {
    if (block.used && !block.constant) free_sizes.insert(block.size);
  }
  if (free_sizes.empty()) {
    *reason = "no residual is over a block that may move";
    return false;
  }
  *reason = "the declared sizes are those of no known pose";
  int furthest = -1;
  // First the layouts of which every size occurs, then those whose other blocks would all be held.
  for (const bool all_occur : {true, false}) {
    for (const KnownLayout& layout : KnownLayouts()) {
      if (!sizes.empty() && layout.sizes != sizes) continue;
      const bool occur = std::all_of(layout.sizes.begin(), layout.sizes.end(),
                                     [&](int size) { return free_sizes.count(size) > 0; });
      if (occur != all_occur) continue;
      Finder finder(problem, layout, poses);
      if (finder.Run()) return true;
      if (finder.passed() <= furthest) continue;
      furthest = finder.passed();
      *reason = finder.reason();
    }
  }
  return false;
}

}  // namespace hpgo
