#include "hpgo/evaluate/statistics.h"

#include <cmath>

namespace hpgo {

ErrorStatistics Summarize(const std::vector<double>& values) {
  ErrorStatistics s;
  s.count = static_cast<int>(values.size());
  if (values.empty()) return s;
  double sum = 0, sum_sq = 0;
  for (int k = 0; k < s.count; ++k) {
    sum += values[k];
    sum_sq += values[k] * values[k];
    // Written so that a NaN becomes the maximum, and stays it.
    if (s.max_index < 0 || !(values[k] <= s.max || std::isnan(s.max))) {
      s.max = values[k];
      s.max_index = k;
    }
  }
  s.mean = sum / s.count;
  s.rmse = std::sqrt(sum_sq / s.count);
  return s;
}

}  // namespace hpgo
