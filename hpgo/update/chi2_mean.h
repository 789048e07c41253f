// The mean chi2 of an edge, which says what is worth looking at.
#pragma once

#include <cstdint>

#include "hpgo/hierarchy/hierarchy.h"

namespace hpgo {

// A running mean over samples. Not synchronized.
class Chi2Mean {
 public:
  double value() const { return mean_; }
  // A few edges of level 0, spread over it: the mean must follow the estimate, and no update may
  // look at all of them. To be called once an update.
  template <typename G>
  void Sample(const Hierarchy<G>& hierarchy, int new_edges);
  // Where all edges have been looked at.
  void Set(double mean) { mean_ = mean; }

  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.mean_, self.num_samples_, self.next_);
  }

 private:
  double mean_ = 0;
  int num_samples_ = 0;  // that it is the mean of, up to its memory
  std::uint32_t next_ = 0;
};

}  // namespace hpgo
