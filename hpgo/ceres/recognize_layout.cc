#include "hpgo/ceres/recognize_layout.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "Eigen/Geometry"
#include "ceres/cost_function.h"
#include "ceres/manifold.h"
#include "ceres_costs/se2.h"
#include "ceres_costs/se3.h"
#include "ceres_costs/yaw_pose.h"
#include "hpgo/ceres/pose_codec.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;
using Kind = PoseLayout::Kind;
using Direction = PoseLayout::Direction;
using Order = PoseLayout::Quaternion;
using Unit = PoseLayout::AngleUnit;

constexpr int kSamples = 12;

Eigen::Quaterniond ReadQuaternion(Order order, const double* q) {
  return order == Order::kWFirst ? Eigen::Quaterniond(q[0], q[1], q[2], q[3])
                                 : Eigen::Quaterniond(q[3], q[0], q[1], q[2]);
}

bool SameRotation(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  constexpr double kTolerance = 1e-8;
  return std::min((a.coeffs() - b.coeffs()).norm(), (a.coeffs() + b.coeffs()).norm()) < kTolerance;
}

class Recognizer {
 public:
  Recognizer(const ProblemView& problem, const PoseBlocks& poses, const PoseLayout& declared)
      : problem_(problem), poses_(poses), declared_(declared) {}

  bool Run(PoseLayout* layout, std::string* reason) {
    int total = 0;
    for (const int size : poses_.sizes) total += size;
    std::vector<PoseLayout> candidates;
    if (total == 7) {
      candidates = QuaternionCandidates();
      if (candidates.empty()) {
        *reason = "no order of the quaternion fits its manifold";
        return false;
      }
      candidates = WithDirections(candidates);
      candidates = Invariant<SE3>(candidates, reason);
    } else if (total == 4) {
      candidates = Invariant<YawPose>(WithDirections(AngleCandidates(Kind::kXYZYaw, 3)), reason);
    } else if (total == 3) {
      candidates = Invariant<SE2>(WithDirections(AngleCandidates(Kind::kXYTheta, 2)), reason);
    } else {
      *reason = "poses of " + std::to_string(total) + " numbers (" + LayoutName(poses_.sizes) +
                ") are not kept in a hierarchy";
      return false;
    }
    if (candidates.empty()) return false;
    if (candidates.size() > 1) {
      *reason = "several conventions fit: declare one (PoseLayout)";
      return false;
    }
    *layout = candidates[0];
    return true;
  }

 private:
  PoseLayout Start(Kind kind, int translation_at, int rotation_at) const {
    PoseLayout layout = declared_;
    layout.sizes = poses_.sizes;
    layout.kind = kind;
    layout.translation_at = translation_at;
    layout.rotation_at = rotation_at;
    return layout;
  }
  bool Allows(int declared, int value) const { return declared < 0 || declared == value; }

  std::vector<PoseLayout> QuaternionCandidates() const {
    std::vector<PoseLayout> result;
    for (const auto& [t, q] : {std::pair(0, 3), std::pair(4, 0)}) {
      const bool first_is_t = poses_.sizes[0] == 3, first_is_q = poses_.sizes[0] == 4;
      if ((first_is_t && t != 0) || (first_is_q && q != 0)) continue;
      if (!Allows(declared_.translation_at, t) || !Allows(declared_.rotation_at, q)) continue;
      for (const Order order : {Order::kWFirst, Order::kWLast}) {
        if (declared_.quaternion != Order::kUnknown && declared_.quaternion != order) continue;
        PoseLayout layout = Start(Kind::kXYZQuaternion, t, q);
        layout.quaternion = order;
        if (declared_.quaternion == order || FitsManifolds(layout)) result.push_back(layout);
      }
    }
    return result;
  }

  // A translation of `dimension` numbers and an angle.
  std::vector<PoseLayout> AngleCandidates(Kind kind, int dimension) const {
    std::vector<PoseLayout> result;
    for (const auto& [t, r] : {std::pair(0, dimension), std::pair(1, 0)}) {
      const bool first = poses_.sizes.size() == 2 && poses_.sizes[0] == dimension;
      const bool last = poses_.sizes.size() == 2 && poses_.sizes[1] == dimension;
      if ((first && t != 0) || (last && t != 1)) continue;
      if (!Allows(declared_.translation_at, t) || !Allows(declared_.rotation_at, r)) continue;
      for (const Unit unit : {Unit::kRadians, Unit::kDegrees}) {
        if (declared_.angle != Unit::kUnknown && declared_.angle != unit) continue;
        PoseLayout layout = Start(kind, t, r);
        layout.angle = unit;
        result.push_back(layout);
      }
    }
    return result;
  }

  std::vector<PoseLayout> WithDirections(const std::vector<PoseLayout>& candidates) const {
    std::vector<PoseLayout> result;
    for (PoseLayout layout : candidates) {
      for (const Direction direction : {Direction::kWorldNode, Direction::kNodeWorld}) {
        if (declared_.direction != Direction::kUnknown && declared_.direction != direction)
          continue;
        layout.direction = direction;
        result.push_back(layout);
      }
    }
    return result;
  }

  // Plus(x, d) = Plus(1, d) x, or x Plus(1, d), for some of the manifolds.
  bool FitsManifolds(const PoseLayout& layout) const {
    int tried = 0;
    const std::size_t of_rotation = layout.sizes.size() == 1 ? 0 : (layout.sizes[0] == 4 ? 0 : 1);
    const int at = layout.sizes.size() == 1 ? layout.rotation_at : 0;
    for (int p = 0; p < poses_.num_poses() && tried < kSamples; ++p) {
      const BlockView& block = problem_.blocks()[poses_.BlockOf(p, static_cast<int>(of_rotation))];
      if (block.constant || block.manifold == nullptr || block.tangent < 3) continue;
      ++tried;
      if (!FitsManifold(layout.quaternion, at, block)) return false;
    }
    return tried > 0;
  }

  static bool FitsManifold(Order order, int at, const BlockView& block) {
    std::mt19937 random(static_cast<unsigned>(block.offset) + 1);
    std::uniform_real_distribution<double> number(-1, 1);
    std::vector<double> x(block.size), one(block.size, 0.), d(block.tangent), y(block.size),
        y_of_one(block.size);
    bool left = true, right = true;
    for (int trial = 0; trial < 3; ++trial) {
      for (double& v : x) v = number(random);
      Eigen::Map<Eigen::Vector4d>(&x[at]).normalize();
      one[at + (order == Order::kWFirst ? 0 : 3)] = 1;
      for (double& v : d) v = number(random);
      if (!block.manifold->Plus(x.data(), d.data(), y.data()) ||
          !block.manifold->Plus(one.data(), d.data(), y_of_one.data())) {
        return false;
      }
      const Eigen::Quaterniond q = ReadQuaternion(order, &x[at]);
      const Eigen::Quaterniond step = ReadQuaternion(order, &y_of_one[at]);
      const Eigen::Quaterniond moved = ReadQuaternion(order, &y[at]);
      left &= SameRotation(moved, step * q);
      right &= SameRotation(moved, q * step);
    }
    return left || right;
  }

  // Those for which the costs over two poses do not change with a common motion; the reason names
  // the first residual for which none is left.
  template <typename G>
  std::vector<PoseLayout> Invariant(std::vector<PoseLayout> candidates, std::string* reason) const {
    const std::vector<int> sample = PairResiduals();
    if (sample.empty()) candidates.resize(std::min<std::size_t>(candidates.size(), 1));
    for (const int r : sample) {
      std::vector<PoseLayout> fitting;
      for (const PoseLayout& layout : candidates) {
        if (IsInvariant<G>(layout, r)) fitting.push_back(layout);
      }
      if (fitting.empty()) {
        *reason = "residual " + std::to_string(r) +
                  " depends on both poses and changes under a common motion";
        return {};
      }
      candidates = fitting;
    }
    return candidates;
  }

  // Some of those over all the blocks of exactly two poses that are not both held.
  std::vector<int> PairResiduals() const {
    std::vector<int> result;
    const int count = static_cast<int>(problem_.residuals().size());
    const int stride = std::max(1, count / (4 * kSamples));
    for (int r = 0; r < count && static_cast<int>(result.size()) < kSamples; ++r) {
      if (r > 2 * kSamples && r % stride != 0) continue;
      if (PosesOf(r).size() == 2) result.push_back(r);
    }
    return result;
  }

  // The two poses that a residual relates: those that move, or one of them and one that is held.
  std::vector<int> PosesOf(int r) const {
    const ResidualView& residual = problem_.residuals()[r];
    std::vector<int> moving, all;
    const auto add = [](int pose, std::vector<int>* to) {
      if (std::find(to->begin(), to->end(), pose) == to->end()) to->push_back(pose);
    };
    for (int k = 0; k < residual.count; ++k) {
      const int b = problem_.BlockOf(residual, k);
      const int pose = poses_.pose_of[b];
      if (pose < 0) continue;
      add(pose, &all);
      if (!problem_.blocks()[b].constant) add(pose, &moving);
    }
    if (moving.size() == 2) return moving;
    return moving.empty() ? std::vector<int>() : all;
  }

  template <typename G>
  bool IsInvariant(const PoseLayout& layout, int r) const {
    const PoseCodec<G> codec(layout);
    const std::vector<int> over = PosesOf(r);
    std::mt19937 random(static_cast<unsigned>(r) + 1);
    std::uniform_real_distribution<double> number(-1, 1);
    const auto draw = [&](double size) {
      typename G::Tangent d;
      for (int k = 0; k < G::kDof; ++k) d(k) = size * number(random);
      return d;
    };
    for (int trial = 0; trial < 3; ++trial) {
      // Away from the minimum, where every cost looks the same.
      G poses[2];
      for (int k = 0; k < 2; ++k) {
        poses[k] = codec.Read(Numbers(over[k]).data()).Retract(draw(0.3));
      }
      const G motion = G().Retract(draw(2));
      const double before = Cost<G>(codec, r, over, poses[0], poses[1]);
      const double after = Cost<G>(codec, r, over, motion * poses[0], motion * poses[1]);
      if (!(std::abs(after - before) <= 1e-7 * (before + after) + 1e-20)) return false;
    }
    return true;
  }

  std::vector<double> Numbers(int pose) const {
    std::vector<double> numbers;
    for (std::size_t k = 0; k < poses_.sizes.size(); ++k) {
      const BlockView& block = problem_.blocks()[poses_.BlockOf(pose, static_cast<int>(k))];
      numbers.insert(numbers.end(), block.values, block.values + block.size);
    }
    return numbers;
  }

  template <typename G>
  double Cost(const PoseCodec<G>& codec, int r, const std::vector<int>& over, const G& a,
              const G& b) const {
    std::vector<double> numbers[2] = {Numbers(over[0]), Numbers(over[1])};
    codec.Write(a, numbers[0].data());
    codec.Write(b, numbers[1].data());
    const ResidualView& residual = problem_.residuals()[r];
    std::vector<const double*> parameters;
    for (int k = 0; k < residual.count; ++k) {
      const int index = problem_.BlockOf(residual, k);
      const int pose = poses_.pose_of[index];
      if (pose != over[0] && pose != over[1]) {
        parameters.push_back(problem_.blocks()[index].values);
        continue;
      }
      int offset = 0;
      for (int p = 0; poses_.BlockOf(pose, p) != index; ++p) offset += poses_.sizes[p];
      parameters.push_back(numbers[pose == over[1]].data() + offset);
    }
    Eigen::VectorXd residuals(residual.cost->num_residuals());
    if (!residual.cost->Evaluate(parameters.data(), residuals.data(), nullptr)) return std::nan("");
    return residuals.squaredNorm();
  }

  const ProblemView& problem_;
  const PoseBlocks& poses_;
  const PoseLayout& declared_;
};

}  // namespace

bool RecognizeLayout(const ProblemView& problem, const PoseBlocks& poses,
                     const PoseLayout& declared, PoseLayout* layout, std::string* reason) {
  return Recognizer(problem, poses, declared).Run(layout, reason);
}

}  // namespace hpgo
