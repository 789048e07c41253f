// Round numbers for axes and scale bars.
#pragma once

#include <string>
#include <vector>

namespace hpgo {

// The largest of 1, 2 or 5 times a power of ten that is at most `value`. value > 0.
double RoundDown125(double value);

struct AxisTick {
  double value = 0;
  std::string label;  // empty: a grid line of a logarithmic axis between two powers of ten
};

// Multiples of a round step inside [low, high], at most count + 1 of them. low < high.
std::vector<AxisTick> LinearTicks(double low, double high, int count);

// The powers of ten inside [low, high], labelled, with 2 to 9 times them between; 2 and 5 times are
// labelled too where the range holds fewer than two powers. 0 < low < high.
std::vector<AxisTick> LogTicks(double low, double high);

// "0.05", "12", "10k", "2.5M", "1e-06".
std::string TickLabel(double value);

}  // namespace hpgo
