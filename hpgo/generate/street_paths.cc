// Random drives through street grids.
#include <algorithm>
#include <array>
#include <cmath>

#include "hpgo/generate/true_path.h"

namespace hpgo {
namespace {

// A square of blocks on each floor, a street along every side of a block. Ramps climb along +x.
struct StreetGrid {
  int blocks = 1;  // a side
  int floors = 1;
  int block_nodes = 1;  // the length of a block, in steps of 1 m
  double floor_height = 0;
  int ramp_every = 1;        // about one in so many intersections has a ramp up
  double keep_straight = 1;  // the weight of going straight on; a turn weighs 1, turning back 0
  double unseen = 1;         // the factor for a street not driven yet
};

struct Intersection {
  int x = 0, y = 0, floor = 0;
};

class Drive {
 public:
  Drive(const StreetGrid& grid, Random* random)
      : grid_(grid),
        random_(random),
        ramp_salt_(static_cast<std::uint64_t>(random->Uniform() * 0x1.0p53)),
        seen_(2 * static_cast<std::size_t>(grid.blocks + 1) * (grid.blocks + 1) * grid.floors) {
    at_ = {grid.blocks / 2, grid.blocks / 2, 0};
  }

  // The next block: updates the intersection and returns the one it came from.
  Intersection Next() {
    std::array<Move, 6> moves;
    int count = 0;
    double total = 0;
    for (int heading = 0; heading < 4; ++heading) {
      const Intersection to = {at_.x + kDx[heading], at_.y + kDy[heading], at_.floor};
      Add({to, heading, Weight(to, heading)}, &moves, &count, &total);
    }
    const Intersection up = {at_.x + 1, at_.y, at_.floor + 1};
    const Intersection down = {at_.x - 1, at_.y, at_.floor - 1};
    Add({up, 0, HasRampUp(at_) ? 1.0 : 0.0}, &moves, &count, &total);
    Add({down, 2, Inside(down) && HasRampUp(down) ? 1.0 : 0.0}, &moves, &count, &total);

    double draw = random_->Uniform() * total;
    int chosen = 0;
    while (chosen + 1 < count && draw >= moves[chosen].weight) draw -= moves[chosen++].weight;
    const Intersection from = at_;
    at_ = moves[chosen].to;
    heading_ = moves[chosen].heading;
    if (at_.floor == from.floor) seen_[Street(from, at_)] = true;
    return from;
  }
  const Intersection& at() const { return at_; }

 private:
  struct Move {
    Intersection to;
    int heading = 0;
    double weight = 0;
  };
  static constexpr int kDx[4] = {1, 0, -1, 0};
  static constexpr int kDy[4] = {0, 1, 0, -1};

  static void Add(const Move& move, std::array<Move, 6>* moves, int* count, double* total) {
    if (move.weight <= 0) return;
    (*moves)[(*count)++] = move;
    *total += move.weight;
  }
  bool Inside(const Intersection& p) const {
    return p.x >= 0 && p.y >= 0 && p.x <= grid_.blocks && p.y <= grid_.blocks && p.floor >= 0 &&
           p.floor < grid_.floors;
  }
  double Weight(const Intersection& to, int heading) const {
    if (!Inside(to) || heading == (heading_ + 2) % 4) return 0;
    const double weight = heading == heading_ ? grid_.keep_straight : 1.0;
    return seen_[Street(at_, to)] ? weight : weight * grid_.unseen;
  }
  // The number of the street between two neighbours on a floor.
  std::size_t Street(const Intersection& a, const Intersection& b) const {
    const std::size_t side = grid_.blocks + 1;
    const std::size_t first = (a.floor * side + std::min(a.y, b.y)) * side + std::min(a.x, b.x);
    return 2 * first + (a.x == b.x ? 1 : 0);
  }
  bool HasRampUp(const Intersection& p) const {
    if (p.x >= grid_.blocks || p.floor + 1 >= grid_.floors) return false;
    const std::size_t side = grid_.blocks + 1;
    const std::uint64_t cell = (p.floor * side + p.y) * side + p.x;
    return MixBits(ramp_salt_ ^ cell) % static_cast<std::uint64_t>(grid_.ramp_every) == 0;
  }

  StreetGrid grid_;
  Random* random_;
  std::uint64_t ramp_salt_;
  std::vector<bool> seen_;  // by Street
  Intersection at_;
  int heading_ = 0;
};

// Nobody drives in the same track twice: an offset that wanders by `sigma` (m).
class Wander {
 public:
  Wander(double sigma, Random* random) : sigma_(sigma), random_(random) {}
  const Eigen::Vector3d& Next() {
    constexpr double kKept = 0.9;
    const double fresh = sigma_ * std::sqrt(1 - kKept * kKept);
    offset_.x() = kKept * offset_.x() + fresh * random_->Normal();
    offset_.y() = kKept * offset_.y() + fresh * random_->Normal();
    return offset_;
  }

 private:
  double sigma_;
  Random* random_;
  Eigen::Vector3d offset_ = Eigen::Vector3d::Zero();
};

std::vector<Waypoint> DriveStreets(const StreetGrid& grid, int nodes, Random* random) {
  const auto position = [&](const Intersection& p) {
    return Eigen::Vector3d(p.x * grid.block_nodes, p.y * grid.block_nodes,
                           p.floor * grid.floor_height);
  };
  Drive drive(grid, random);
  Wander wander(0.2, random);
  std::vector<Waypoint> path;
  path.reserve(nodes + grid.block_nodes);
  while (static_cast<int>(path.size()) < nodes) {
    const Eigen::Vector3d from = position(drive.Next());
    const Eigen::Vector3d to = position(drive.at());
    for (int k = 0; k < grid.block_nodes; ++k) {
      const double share = static_cast<double>(k) / grid.block_nodes;
      const Eigen::Vector3d on_street = from + share * (to - from);
      path.push_back({on_street + wander.Next(), Eigen::Vector3d::UnitZ()});
    }
  }
  path.resize(nodes);
  return path;
}

// The side of a square grid whose streets have `length` m on each of its floors.
int BlocksFor(double length, const StreetGrid& grid) {
  const double blocks = std::sqrt(length / (2.0 * grid.block_nodes * grid.floors));
  return std::max(2, static_cast<int>(std::lround(blocks)));
}

}  // namespace

std::vector<Waypoint> ManhattanPath(int nodes, int dim, Random* random) {
  constexpr double kVisits = 4;  // of a place, on average
  StreetGrid grid;
  grid.block_nodes = 5;
  grid.floors = dim == 3 ? std::clamp(nodes / 1000, 2, 5) : 1;
  grid.floor_height = 2.5;
  grid.ramp_every = 12;
  grid.keep_straight = 2;
  grid.blocks = BlocksFor(nodes / kVisits, grid);
  return DriveStreets(grid, nodes, random);
}

std::vector<Waypoint> CityPath(int nodes, int dim, Random* random) {
  StreetGrid grid;
  grid.block_nodes = std::clamp(nodes / 100, 10, 80);
  grid.keep_straight = 3;
  grid.unseen = 2;
  grid.blocks = BlocksFor(2.0 * nodes, grid);
  std::vector<Waypoint> path = DriveStreets(grid, nodes, random);
  if (dim == 3) {
    for (Waypoint& w : path) {  // hills, of slopes up to about 8 %
      w.position.z() = 6 * std::sin(w.position.x() / 120) + 3 * std::cos(w.position.y() / 90);
    }
  }
  return path;
}

}  // namespace hpgo
