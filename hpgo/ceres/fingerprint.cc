#include "hpgo/ceres/fingerprint.h"

#include <cmath>
#include <cstring>
#include <vector>

namespace hpgo {
namespace {

void Mix(double value, std::uint64_t* hash) {
  std::uint64_t bits;
  std::memcpy(&bits, &value, sizeof(bits));
  *hash = (*hash ^ bits) * 0x9e3779b97f4a7c15u;
  *hash ^= *hash >> 29;
}

}  // namespace

std::uint64_t Fingerprint(const ceres::CostFunction& cost, const ceres::LossFunction* loss) {
  std::vector<double> values;
  std::vector<std::size_t> begins;
  for (const int size : cost.parameter_block_sizes()) {
    begins.push_back(values.size());
    double norm = 0;
    for (int k = 0; k < size; ++k) {
      values.push_back(std::cos(1.0 + static_cast<double>(values.size())));
      norm += values.back() * values.back();
    }
    if (size < 4) continue;  // may hold a quaternion
    for (int k = 0; k < size; ++k) values[begins.back() + k] /= std::sqrt(norm);
  }
  std::vector<const double*> parameters;
  for (const std::size_t begin : begins) parameters.push_back(&values[begin]);
  std::vector<double> residuals(cost.num_residuals());
  std::uint64_t hash = residuals.size();
  if (cost.Evaluate(parameters.data(), residuals.data(), nullptr)) {
    for (const double r : residuals) Mix(r, &hash);
  }
  for (const double s : {0.5, 5., 500.}) {
    double rho[3] = {s, 1, 0};
    if (loss != nullptr) loss->Evaluate(s, rho);
    Mix(rho[0], &hash);
  }
  return hash;
}

}  // namespace hpgo
