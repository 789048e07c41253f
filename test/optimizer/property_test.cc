// Random sequences of every call on small graphs with many levels: the
// structure is checked after every call, the estimate against a full
// optimization whenever the optimizer comes to rest.
//
// HPGO_SEQUENCES=20000 runs more of them, HPGO_SEED=17 one again.

#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <string>

#include "gtest/gtest.h"
#include "test/optimizer/property_sequence.h"

namespace hpgo {
namespace {

template <typename G>
class PropertyTest : public testing::Test {};
using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(PropertyTest, Groups);

// In 3D, the levels of this one undid each other's work: Refine did not come to rest.
TYPED_TEST(PropertyTest, RefineEndsWhereItGetsNowhere) { Sequence<TypeParam>(4242).Run(); }

// In 3D, an edge came to stand at the half turn and no step was taken across it: 722 where 374 is
// near.
TYPED_TEST(PropertyTest, TheHalfTurnIsCrossed) { Sequence<TypeParam>(20487).Run(); }

TYPED_TEST(PropertyTest, RandomSequences) {
  const char* one = std::getenv("HPGO_SEED");
  const char* many = std::getenv("HPGO_SEQUENCES");
  const std::uint64_t first = one != nullptr ? std::strtoull(one, nullptr, 10) : 0;
  const std::uint64_t count = one != nullptr && many == nullptr ? 1
                              : many != nullptr                 ? std::strtoull(many, nullptr, 10)
                                                                : 4000;
  int rests = 0, off = 0, half_turns = 0;
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    SCOPED_TRACE("HPGO_SEED=" + std::to_string(seed));
    Sequence<TypeParam> sequence(seed);
    sequence.Run();
    ASSERT_FALSE(this->HasFailure());
    rests += sequence.rests();
    off += sequence.off();
    half_turns += sequence.half_turns();
  }
  // No single node is under stress at rest; long chains may sum up what is
  // left.
  std::cout << "from seed " << first << ": " << off << " of " << rests
            << " times at rest above 0.01 %; " << half_turns
            << " not compared, an edge at the half turn\n";
  EXPECT_LE(off, 1 + rests / 1000);
}

}  // namespace
}  // namespace hpgo
