// The values that the bytes of an input stand for: numbers, poses, information matrices, losses and
// options, odd ones among them.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>

#include "ceres/loss_function.h"
#include "hpgo/optimizer.h"

namespace hpgo {

// What is left of the input; zeros after its end.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : next_(data), end_(data + size) {}
  bool empty() const { return next_ == end_; }
  std::uint8_t Byte() { return empty() ? 0 : *next_++; }
  int Below(int n) { return Byte() % n; }
  // Mostly tame.
  double Number() {
    constexpr double kOdd[] = {0,      std::numeric_limits<double>::quiet_NaN(),
                               1e300,  std::numeric_limits<double>::infinity(),
                               -1e300, -std::numeric_limits<double>::infinity(),
                               1e-310, 1e40,
                               1e-40,  -1e10,
                               1e-12,  M_PI,
                               -M_PI,  M_PI / 2,
                               1e6,    -1e-6};
    const std::uint8_t byte = Byte();
    if (byte < 240) return (byte - 120) / 30.;
    const double odd = kOdd[byte - 240];
    wild_ |= std::abs(odd) > 10 || (odd != 0 && std::abs(odd) < 1e-3);
    return odd;
  }
  // Whether a number was so large or small that rounding may be all there is.
  bool wild() const { return wild_; }

 private:
  const std::uint8_t* next_;
  const std::uint8_t* end_;
  bool wild_ = false;
};

template <typename G>
class Values {
 public:
  using Matrix = typename G::Matrix;

  explicit Values(Bytes* bytes) : bytes_(*bytes) {}

  OptimizerOptions Options() {
    OptimizerOptions options;
    options.max_group_size = 2 + bytes_.Below(3);
    options.max_top_nodes = 3 + bytes_.Below(8);
    options.condense_chains = bytes_.Below(5) > 0;
    options.window_nodes = 4 + bytes_.Below(40);
    options.window_edges = 8 + bytes_.Below(60);
    options.max_windows = 1 + bytes_.Below(6);
    const int kind = bytes_.Byte();
    options.engine = kind % 5 == 0 ? Engine::kCeres : Engine::kBlock;
    options.coarse_edges = kind % 7 == 0 ? CoarseEdges::kCondensed : CoarseEdges::kGalerkin;
    options.schedule = static_cast<Schedule>(kind % 11 == 0 ? 1 + kind % 2 : 0);
    options.convention = static_cast<ceres_costs::ErrorConvention>(kind % 3);
    return options;
  }
  G Pose() {
    double numbers[G::kParams];
    for (double& number : numbers) number = bytes_.Number();
    if (G::kDim == 3) numbers[G::kParams - 1] += 1;  // turns of less than half a turn mostly
    return G(numbers);
  }
  Matrix Information() {
    Matrix information = Matrix::Identity();
    const int kind = bytes_.Below(6);
    if (kind < 3) return information * std::abs(bytes_.Number());
    if (kind == 3) {
      for (int k = 0; k < G::kDof; ++k) information(k, k) = bytes_.Number();
    }
    if (kind >= 4) {  // of a rank that the bytes say
      information.setZero();
      for (int rank = bytes_.Below(4); rank >= 0; --rank) {
        typename G::Tangent v;
        for (int k = 0; k < G::kDof; ++k) v(k) = bytes_.Number();
        information += v * v.transpose();
      }
    }
    if (kind == 5) {
      information(0, 1) += bytes_.Number();
      information(1, 0) = information(0, 1);
    }
    return information;
  }
  typename Optimizer<G>::Loss Loss() {
    const double scale = 0.1 + bytes_.Below(40) / 10.;
    switch (bytes_.Below(8)) {
      case 0:
        return std::make_shared<ceres::HuberLoss>(scale);
      case 1:
        return std::make_shared<ceres::CauchyLoss>(scale);
      case 2:
        return std::make_shared<ceres::TukeyLoss>(scale);
      default:
        return nullptr;
    }
  }

 private:
  Bytes& bytes_;
};

}  // namespace hpgo
