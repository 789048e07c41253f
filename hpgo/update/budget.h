// What a call may spend.
#pragma once

#include <functional>

#include "hpgo/update/report.h"

namespace hpgo {

// Readings in seconds, from any origin; tests give their own.
struct Clocks {
  std::function<double()> wall;
  std::function<double()> cpu;  // of the calling thread
  static Clocks Real();
};

// Adds the wall time it lives to a number.
class Stopwatch {
 public:
  explicit Stopwatch(double* total);
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;
  ~Stopwatch() { *total_ += Elapsed(); }
  double Elapsed() const;

 private:
  double* total_;
  double start_;
};

// The limits of one call, from the moment it is made. Its fields never change.
class Budget {
 public:
  // `to_rest`: without a limit, work goes on until nothing is stressed.
  explicit Budget(const UpdateLimits& limits, bool to_rest = false,
                  const Clocks& clocks = Clocks::Real());

  bool HasTimeLimit() const { return limits_.max_seconds > 0 || limits_.max_cpu_seconds > 0; }
  // Whether time or the caller, not the options, say when to stop.
  bool IsUncapped() const { return HasTimeLimit() || to_rest_; }
  bool IsToRest() const { return to_rest_; }
  double SecondsSpent() const { return clocks_.wall() - wall_start_; }
  // Infinity without a limit, below zero past it.
  double SecondsLeft() const;
  // The share of one window, of the whole limit or of what is left.
  double SecondsForWindow() const;
  bool IsCancelled() const { return limits_.cancel != nullptr && *limits_.cancel; }
  bool IsStopped() const { return IsCancelled() || SecondsLeft() < 0; }
  const std::atomic<bool>* cancel() const { return limits_.cancel; }
  // The limits of a part of the call that begins now.
  UpdateLimits Rest() const;

 private:
  UpdateLimits limits_;
  bool to_rest_;
  Clocks clocks_;
  double wall_start_, cpu_start_;
};

}  // namespace hpgo
