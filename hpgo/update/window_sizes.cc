#include "hpgo/update/window_sizes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "hpgo/update/constants.h"

namespace hpgo {

double WindowSizes::Worth(int num_nodes, std::size_t num_edges) const {
  return std::max(static_cast<double>(num_edges) / options_.window_edges,
                  static_cast<double>(num_nodes) / options_.window_nodes);
}

double WindowSizes::SecondsOf(double worth, int l) const {
  double usual = l < static_cast<int>(seconds_.size()) ? seconds_[l] : 0;
  if (usual == 0 && !seconds_.empty()) usual = *std::max_element(seconds_.begin(), seconds_.end());
  return usual * std::pow(worth, kFillGrowth);
}

WindowLimits WindowSizes::Next(int l, const Budget& budget) const {
  double scale = 1;
  if (budget.HasTimeLimit()) {
    const double seconds = budget.SecondsForWindow(), usual = SecondsOf(1, l);
    if (usual > 0 && seconds > usual) {
      scale = std::min(std::pow(seconds / usual, 1 / kFillGrowth), largest_);
    }
  } else if (budget.IsToRest()) {
    scale = largest_;
  }
  const auto scaled = [&](int count) {
    return static_cast<int>(std::min<double>(scale * count, std::numeric_limits<int>::max()));
  };
  return {scaled(options_.window_nodes), scaled(options_.window_edges)};
}

void WindowSizes::Learn(int l, double worth, double seconds, bool damped) {
  largest_ = damped ? 1 : std::min(kLargestWindow, kWindowGrowth * largest_);
  if (l >= static_cast<int>(seconds_.size())) seconds_.resize(l + 1, 0);
  if (worth < kSmallestTimedWindow) return;
  const double usual = seconds / std::pow(worth, kFillGrowth);
  double& mean = seconds_[l];
  const double share = mean == 0 ? 1 : usual > mean ? kShareOfSlower : kShareOfFaster;
  mean += share * (usual - mean);
}

}  // namespace hpgo
