// The figures every error measure is summed up in.
#pragma once

#include <vector>

namespace hpgo {

// All in the unit of the values: metres or radians. A value that is not a number makes all of them
// not a number, so that no threshold passes.
struct ErrorStatistics {
  double rmse = 0;
  double mean = 0;
  double max = 0;
  int max_index = -1;  // of the largest value; -1 where there is none
  int count = 0;
};

// Of non-negative values. None: all zero.
ErrorStatistics Summarize(const std::vector<double>& values);

}  // namespace hpgo
