// Random numbers whose values a seed fixes on every compiler: the conversions of the standard
// library's distributions are left to each implementation, so they are done here.
#pragma once

#include <cstdint>
#include <random>

namespace hpgo {

// Not synchronized. Streams of one seed are independent, so that what is drawn for one purpose does
// not move when another draws more.
class Random {
 public:
  Random(std::uint64_t seed, std::uint64_t stream);

  // In [0, 1), 53 bits.
  double Uniform();
  // In [low, high).
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  // In 0 .. n - 1, n > 0.
  int Below(int n) { return static_cast<int>(Uniform() * n); }
  // Mean 0, standard deviation 1 (Box and Muller).
  double Normal();

 private:
  std::mt19937_64 engine_;
  double spare_ = 0;
  bool has_spare_ = false;
};

// A well-mixed 64-bit number of `x` (the finalizer of SplitMix64).
std::uint64_t MixBits(std::uint64_t x);

}  // namespace hpgo
