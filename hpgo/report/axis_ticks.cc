#include "hpgo/report/axis_ticks.h"

#include <cmath>
#include <cstdio>

namespace hpgo {

double RoundDown125(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  const double mantissa = value / power * (1 + 1e-12);
  return power * (mantissa >= 5 ? 5 : mantissa >= 2 ? 2 : 1);
}

std::vector<AxisTick> LinearTicks(double low, double high, int count) {
  double step = RoundDown125((high - low) / count);
  while ((high - low) / step > count) step = RoundDown125(2.5 * step);
  std::vector<AxisTick> ticks;
  for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) {
    const double value = k * step + 0.0;  // no negative zero
    ticks.push_back({value, TickLabel(value)});
  }
  return ticks;
}

std::vector<AxisTick> LogTicks(double low, double high) {
  constexpr double kSlack = 1e-9;
  const int first = static_cast<int>(std::floor(std::log10(low) + kSlack));
  const int last = static_cast<int>(std::floor(std::log10(high) + kSlack));
  const bool few_powers =
      std::floor(std::log10(high) + kSlack) - std::ceil(std::log10(low) - kSlack) < 1;
  std::vector<AxisTick> ticks;
  for (int power = first; power <= last; ++power) {
    for (int digit = 1; digit <= 9; ++digit) {
      const double value = digit * std::pow(10.0, power);
      if (value < low * (1 - kSlack) || value > high * (1 + kSlack)) continue;
      const bool labelled = digit == 1 || (few_powers && (digit == 2 || digit == 5));
      ticks.push_back({value, labelled ? TickLabel(value) : ""});
    }
  }
  return ticks;
}

std::string TickLabel(double value) {
  char text[32];
  const double size = std::abs(value);
  if (size >= 1e9 || (size > 0 && size < 1e-4)) {
    std::snprintf(text, sizeof(text), "%.3g", value);
  } else if (size >= 1e6) {
    std::snprintf(text, sizeof(text), "%.4gM", value / 1e6);
  } else if (size >= 1e3) {
    std::snprintf(text, sizeof(text), "%.4gk", value / 1e3);
  } else {
    std::snprintf(text, sizeof(text), "%.5g", value);
  }
  return text;
}

}  // namespace hpgo
