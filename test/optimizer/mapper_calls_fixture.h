// What the tests of the calls of mappers share.
#pragma once

#include <random>
#include <vector>

#include "gtest/gtest.h"
#include "hpgo/optimizer.h"

namespace hpgo {

template <typename G>
class MapperCallsTest : public testing::Test {
 protected:
  using Matrix = typename G::Matrix;

  static std::vector<EdgeId> Ids(const Result<std::vector<EdgeEnds>>& edges) {
    std::vector<EdgeId> ids;
    for (const EdgeEnds& edge : *edges) ids.push_back(edge.id);
    return ids;
  }
  static double Distance(const G& a, const G& b) { return a.LocalCoordinates(b).norm(); }

  std::mt19937_64 rng_{3};
  Optimizer<G> optimizer_;
  const Matrix I_ = Matrix::Identity();
};
using MapperCallsGroups = testing::Types<SE2, SE3>;

}  // namespace hpgo
