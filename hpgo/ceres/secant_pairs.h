// What the gradients along the last steps tell of the Hessian beyond Gauss-Newton's.
#pragma once

#include <deque>
#include <functional>
#include <vector>

namespace hpgo {

// The limited-memory BFGS correction of a matrix that can be solved with. Where residuals stay
// large, or a loss is past its bend, Gauss-Newton's matrix is up to many times too stiff, and its
// steps converge linearly: the pairs of the last steps and the changes of the gradient along them
// say what they were short of.
class SecantPairs {
 public:
  bool empty() const { return pairs_.empty(); }
  void Clear() { pairs_.clear(); }
  // `before` and `after`: the gradients at the ends of the step. Nothing if they do not tell of a
  // positive curvature along it.
  void Add(const std::vector<double>& step, const std::vector<double>& before,
           const std::vector<double>& after);
  // x becomes the inverse of the corrected matrix times x; `solve` solves with the matrix in place.
  void Solve(const std::function<void(double*)>& solve, std::vector<double>* x) const;

 private:
  struct Pair {
    std::vector<double> step, change;
    double curvature = 0;  // step' change
  };
  std::deque<Pair> pairs_;
};

}  // namespace hpgo
