#include "hpgo/generate/revisits.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;

// Poses by the cell they lie in, as lists through an array. Never iterated over as a whole, so that
// the order of the hash table does not matter.
template <typename G>
class PlaceIndex {
 public:
  PlaceIndex(const std::vector<G>& poses, double cell) : poses_(poses), cell_(cell) {
    places_.reserve(poses.size());
    next_.assign(poses.size(), -1);
  }

  void Insert(int pose) {
    Place& place = places_[Key(CellOf(pose))];
    if (place.count == kMaxPoses) return;
    ++place.count;
    next_[pose] = place.head;
    place.head = pose;
  }

  // Calls visit(pose) for every pose in the cells around that of `pose`.
  template <typename Visit>
  void ForEachNear(int pose, Visit visit) const {
    const Cell center = CellOf(pose);
    const int reach_z = G::kDim == 3 ? 1 : 0;
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dz = -reach_z; dz <= reach_z; ++dz) {
          const auto found = places_.find(Key({center.x + dx, center.y + dy, center.z + dz}));
          if (found == places_.end()) continue;
          for (int k = found->second.head; k >= 0; k = next_[k]) visit(k);
        }
      }
    }
  }

 private:
  static constexpr int kMaxPoses = 64;
  struct Cell {
    std::int64_t x, y, z;
  };
  struct Place {
    int head = -1;
    int count = 0;
  };
  Cell CellOf(int pose) const {
    const auto t = poses_[pose].translation();
    return {Coordinate(t(0)), Coordinate(t(1)), G::kDim == 3 ? Coordinate(t(G::kDim - 1)) : 0};
  }
  std::int64_t Coordinate(double x) const {
    return static_cast<std::int64_t>(std::floor(x / cell_));
  }
  // 21 bits each: cells that share a key lie 2 million cells apart and are told apart by distance.
  static std::uint64_t Key(const Cell& c) {
    constexpr std::uint64_t kMask = (std::uint64_t{1} << 21) - 1;
    return (static_cast<std::uint64_t>(c.x) & kMask) << 42 |
           (static_cast<std::uint64_t>(c.y) & kMask) << 21 |
           (static_cast<std::uint64_t>(c.z) & kMask);
  }

  const std::vector<G>& poses_;
  double cell_;
  std::unordered_map<std::uint64_t, Place> places_;
  std::vector<int> next_;
};

struct Candidate {
  double distance_sq;
  int pose;
};

}  // namespace

template <typename G>
std::vector<Revisit> FindRevisits(const std::vector<G>& poses, const RevisitOptions& options) {
  std::vector<double> travelled(poses.size(), 0.0);
  for (std::size_t k = 1; k < poses.size(); ++k) {
    travelled[k] = travelled[k - 1] + (poses[k].translation() - poses[k - 1].translation()).norm();
  }
  PlaceIndex<G> index(poses, options.radius);
  std::vector<Revisit> revisits;
  std::vector<Candidate> candidates;
  int inserted = 0;  // only poses far enough back along the way are in the index
  for (int newer = 0; newer < static_cast<int>(poses.size()); ++newer) {
    while (inserted < newer && travelled[newer] - travelled[inserted] >= options.min_travel) {
      index.Insert(inserted++);
    }
    candidates.clear();
    index.ForEachNear(newer, [&](int older) {
      const double distance_sq =
          (poses[older].translation() - poses[newer].translation()).squaredNorm();
      if (distance_sq <= options.radius * options.radius)
        candidates.push_back({distance_sq, older});
    });
    std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
      return a.distance_sq != b.distance_sq ? a.distance_sq < b.distance_sq : a.pose < b.pose;
    });
    const std::size_t first = revisits.size();
    for (const Candidate& candidate : candidates) {
      if (revisits.size() - first >= static_cast<std::size_t>(options.max_per_node)) break;
      const bool same_pass =
          std::any_of(revisits.begin() + first, revisits.end(), [&](const Revisit& taken) {
            return std::abs(travelled[taken.older] - travelled[candidate.pose]) <=
                   3 * options.radius;
          });
      if (!same_pass) revisits.push_back({newer, candidate.pose});
    }
  }
  return revisits;
}

template std::vector<Revisit> FindRevisits(const std::vector<SE2>&, const RevisitOptions&);
template std::vector<Revisit> FindRevisits(const std::vector<SE3>&, const RevisitOptions&);

}  // namespace hpgo
