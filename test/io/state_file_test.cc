// Saved states: what is loaded goes on with the same bits, and a file that is not what was written
// is refused.
//
// HPGO_SEQUENCES=20000 runs more of the random sequences, HPGO_SEED=17 one again.

#include "hpgo/io/state_file.h"

#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "ceres_costs/relative_pose_cost.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "hpgo/io/output_file.h"
#include "hpgo/state/state_traits.h"
#include "hpgo/state/state_writer.h"
#include "test/io/robot.h"
#include "test/solve/small_graphs.h"
#include "test/update/ladder.h"

namespace hpgo {
namespace {

using testing::HasSubstr;

// A file of this process: CTest runs the cases beside each other.
std::string TempPath(const std::string& name) {
  return testing::TempDir() + "hpgo_state_" + name + "_" + std::to_string(getpid());
}

std::string ReadBytes(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

void WriteBytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

// All poses and errors, bit for bit.
template <typename G>
std::string BitsOf(const Optimizer<G>& optimizer) {
  std::string bits;
  const auto add = [&bits](const double* values, int count) {
    bits.append(reinterpret_cast<const char*>(values), count * sizeof(double));
  };
  optimizer.ForEachPose([&](NodeId id, const G& pose) {
    bits += std::to_string(id);
    add(pose.data(), G::kParams);
  });
  for (const EdgeError& error : optimizer.EdgeErrors()) {
    bits += std::to_string(error.id.value);
    add(&error.chi2, 1);
  }
  const double cost = optimizer.Cost();
  add(&cost, 1);
  return bits;
}

// The first section of the states that differs; the last one has times in it.
template <typename G>
std::string FirstDifference(const Optimizer<G>& a, const Optimizer<G>& b) {
  std::vector<std::pair<std::string, std::string>> sections[2];
  for (const Optimizer<G>* optimizer : {&a, &b}) {
    auto& mine = sections[optimizer == &b];
    StateWriter writer(
        [&](const char* section, std::string_view bytes) { mine.emplace_back(section, bytes); });
    EXPECT_TRUE(optimizer->Save(&writer).ok());
  }
  EXPECT_EQ(sections[0].size(), sections[1].size());
  for (std::size_t k = 0; k + 1 < sections[0].size(); ++k) {
    if (sections[0][k] == sections[1][k]) continue;
    const std::string& x = sections[0][k].second;
    const std::string& y = sections[1][k].second;
    const auto at = std::mismatch(x.begin(), x.end(), y.begin(), y.end()).first - x.begin();
    return "section " + sections[0][k].first + " at byte " + std::to_string(at);
  }
  return "";
}

template <typename G>
class StateFileTest : public testing::Test {
 protected:
  // A state of a few kilobytes.
  Optimizer<G> SmallOptimizer() {
    Robot<G> robot(3);
    OptimizerOptions options;
    options.max_top_nodes = 3;
    Optimizer<G> optimizer(options);
    for (int k = 0; k < 25; ++k) robot.Next(optimizer)(&optimizer);
    optimizer.Update();
    return optimizer;
  }
  const std::string path_ = TempPath(std::to_string(G::kDim) + "d");
};
using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(StateFileTest, Groups);

TYPED_TEST(StateFileTest, GoesOnWithTheSameBits) {
  using G = TypeParam;
  const char* one = std::getenv("HPGO_SEED");
  const char* many = std::getenv("HPGO_SEQUENCES");
  const std::uint64_t first = one != nullptr ? std::strtoull(one, nullptr, 10) : 0;
  const std::uint64_t count = one != nullptr    ? 1
                              : many != nullptr ? std::strtoull(many, nullptr, 10)
                                                : 200;
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    SCOPED_TRACE("HPGO_SEED=" + std::to_string(seed));
    std::mt19937_64 rng(seed);
    Robot<G> robot(seed);
    Optimizer<G> through(robot.Options());  // is never interrupted
    const int saved_at = std::uniform_int_distribution<int>(0, 120)(rng);
    for (int k = 0; k < saved_at; ++k) robot.Next(through)(&through);
    Status status = SaveState(through, this->path_);
    ASSERT_TRUE(status.ok()) << status.ToString();
    Optimizer<G> resumed;
    status = LoadState(this->path_, &resumed);
    ASSERT_TRUE(status.ok()) << status.ToString();
    ASSERT_TRUE(BitsOf(resumed) == BitsOf(through));
    for (int k = 0; k < 40; ++k) {
      const typename Robot<G>::Call call = robot.Next(through);
      ASSERT_TRUE(call(&resumed) == call(&through))
          << "call " << k << " after " << saved_at << ": " << robot.dice();
      ASSERT_EQ(FirstDifference(resumed, through), "")
          << "call " << k << " after " << saved_at << ": " << robot.dice();
      ASSERT_TRUE(BitsOf(resumed) == BitsOf(through))
          << "call " << k << " after " << saved_at << ": " << robot.dice();
    }
    through.Update();
    resumed.Update();
    ASSERT_TRUE(BitsOf(resumed) == BitsOf(through));
    ASSERT_EQ(resumed.FindInconsistency(), "");
  }
}

TYPED_TEST(StateFileTest, AClosureUnderWayGoesOnWithTheSameBits) {
  using G = TypeParam;
  OptimizerOptions options;
  options.max_top_nodes = 20;
  Optimizer<G> through(options), resumed;
  const PoseGraph<G> ladder = Ladder<G>(201);
  for (const GraphNode<G>& node : ladder.nodes())
    ASSERT_TRUE(through.AddNode(node.id, node.pose).ok());
  for (const GraphEdge<G>& edge : ladder.edges()) {
    (void)through.AddEdge(edge.i, edge.j, edge.measurement, edge.information);
  }
  through.Update();
  const auto last = static_cast<NodeId>(ladder.nodes().size()) - 1;
  ASSERT_TRUE(through.AddEdge(100, last, Ahead<G>(0, 3), ladder.edges()[0].information).ok());
  ASSERT_FALSE(through.Update().at_rest);
  ASSERT_TRUE(SaveState(through, this->path_).ok());
  ASSERT_TRUE(LoadState(this->path_, &resumed).ok());
  for (int k = 0; k < 10; ++k) {
    EXPECT_EQ(through.Update().at_rest, resumed.Update().at_rest);
    ASSERT_EQ(FirstDifference(resumed, through), "");
  }
}

TYPED_TEST(StateFileTest, SavingWhatWasLoadedGivesTheSameFile) {
  const Optimizer<TypeParam> saved = this->SmallOptimizer();
  ASSERT_TRUE(SaveState(saved, this->path_).ok());
  const std::string bytes = ReadBytes(this->path_);
  Optimizer<TypeParam> loaded;
  ASSERT_TRUE(LoadState(this->path_, &loaded).ok());
  EXPECT_EQ(loaded.options().max_top_nodes, 3);
  ASSERT_TRUE(SaveState(loaded, this->path_).ok());
  EXPECT_TRUE(ReadBytes(this->path_) == bytes);
}

TYPED_TEST(StateFileTest, EveryChangedByteIsFound) {
  ASSERT_TRUE(SaveState(this->SmallOptimizer(), this->path_).ok());
  const std::string bytes = ReadBytes(this->path_);
  Optimizer<TypeParam> optimizer;
  ASSERT_TRUE(optimizer.AddNode(7, TypeParam()).ok());
  for (std::size_t k = 0; k < bytes.size(); ++k) {
    for (const int change : {0x01, 0x80, 0xff}) {
      std::string changed = bytes;
      changed[k] = static_cast<char>(changed[k] ^ change);
      ASSERT_EQ(ParseState(changed, &optimizer).code(), StatusCode::kMalformed)
          << "byte " << k << " ^ " << change;
    }
  }
  EXPECT_EQ(optimizer.num_nodes(), 1u);
  EXPECT_TRUE(optimizer.HasNode(7));
}

TYPED_TEST(StateFileTest, EveryShorterFileIsFound) {
  ASSERT_TRUE(SaveState(this->SmallOptimizer(), this->path_).ok());
  const std::string bytes = ReadBytes(this->path_);
  Optimizer<TypeParam> optimizer;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const Status status = ParseState(std::string_view(bytes).substr(0, size), &optimizer);
    ASSERT_EQ(status.code(), StatusCode::kMalformed) << size;
    ASSERT_THAT(status.message(), HasSubstr("cut off")) << size;
  }
  EXPECT_THAT(ParseState(bytes + "x", &optimizer).message(), HasSubstr("goes on behind its end"));
}

// Each block goes on from the checksum of the one before: one from another file is found.
TYPED_TEST(StateFileTest, ABlockOfAnotherStateIsFound) {
  const auto save = [this](int max_windows) {
    OptimizerOptions options;
    options.max_windows = max_windows;
    EXPECT_TRUE(SaveState(Optimizer<TypeParam>(options), this->path_).ok());
    return ReadBytes(this->path_);
  };
  const std::string one = save(1), two = save(2);
  const std::size_t options_end = one.find("levels");
  ASSERT_NE(options_end, std::string::npos);
  ASSERT_NE(one.substr(0, options_end), two.substr(0, options_end));
  ASSERT_EQ(two.find("levels"), options_end);
  Optimizer<TypeParam> optimizer;
  EXPECT_TRUE(ParseState(one, &optimizer).ok());
  EXPECT_THAT(
      ParseState(one.substr(0, options_end) + two.substr(options_end), &optimizer).message(),
      HasSubstr("is damaged: the checksum of a block of section 'levels'"));
}

TYPED_TEST(StateFileTest, CloneGoesItsOwnWay) {
  using G = TypeParam;
  Optimizer<G> optimizer = this->SmallOptimizer();
  const auto cost = std::make_shared<ceres_costs::RelativePoseCost<G>>();
  ASSERT_TRUE(optimizer.AddNode(1000000, G()).ok());
  ASSERT_TRUE(optimizer.AddNode(1000001, G()).ok());
  ASSERT_TRUE(optimizer.AddCustomEdge(1000000, 1000001, cost, G(), G::Matrix::Identity()).ok());
  // A loss without a name.
  std::mt19937_64 rng;
  ASSERT_TRUE(optimizer
                  .AddEdge(1000000, 1000001, RandomPose<G>(&rng, 9, 1), G::Matrix::Identity(),
                           std::make_shared<ceres::HuberLoss>(1.0))
                  .ok());
  const std::string bits = BitsOf(optimizer);
  Optimizer<G> clone = optimizer.Clone();
  EXPECT_TRUE(BitsOf(clone) == bits);
  ASSERT_TRUE(
      clone.SetPose(1000001, RandomPose<G>(std::make_unique<std::mt19937_64>().get(), 1, 1)).ok());
  clone.Converge();
  EXPECT_FALSE(BitsOf(clone) == bits);
  EXPECT_TRUE(BitsOf(optimizer) == bits);
  EXPECT_EQ(clone.FindInconsistency(), "");
}

TEST(StateFileErrorsTest, NameWhatIsWrong) {
  const std::string path = TempPath("errors");
  Optimizer2d optimizer;
  EXPECT_THAT(LoadState(TempPath("none"), &optimizer).message(), HasSubstr("cannot be opened"));
  WriteBytes(path, "VERTEX_SE2 0 0 0 0\n");
  EXPECT_EQ(LoadState(path, &optimizer).message(), path + ": is no saved state");
  ASSERT_TRUE(SaveState(Optimizer3d(), path).ok());
  EXPECT_EQ(LoadState(path, &optimizer).message(),
            path + ": is the state of a 3D graph, not of a 2D graph");
  // Of another version, undamaged.
  std::string bytes = ReadBytes(path);
  bytes[8] = static_cast<char>(kStateVersion + 1);
  const auto checksum =
      static_cast<std::uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), 16));
  StoreNumber(checksum, &bytes[16]);
  EXPECT_EQ(ParseState(bytes, &optimizer).message(),
            "is a state of version " + std::to_string(kStateVersion + 1) +
                ", and only those of version " + std::to_string(kStateVersion) + " can be read");
  EXPECT_THAT(SaveState(optimizer, "/nowhere/at/all").message(), HasSubstr("cannot be created"));
}

TEST(StateFileErrorsTest, CostsAndLossesWithoutNamesAreRefused) {
  const std::string path = TempPath("names");
  WriteBytes(path, "what was there");
  Optimizer2d optimizer;
  for (const NodeId id : {3, 4, 5}) ASSERT_TRUE(optimizer.AddNode(id, SE2()).ok());
  const Result<EdgeId> edge = optimizer.AddEdge(3, 4, SE2(), SE2::Matrix::Identity(),
                                                std::make_shared<ceres::HuberLoss>(1.0));
  ASSERT_TRUE(edge.ok());
  Status status = SaveState(optimizer, path);
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(status.message(), path +
                                  ": edge 3 -> 4: its loss has no name, and cannot be saved; "
                                  "ceres_costs::MakeLoss makes losses with one");
  ASSERT_TRUE(optimizer.RemoveEdge(*edge).ok());
  ASSERT_TRUE(optimizer
                  .AddCustomEdge(4, 5, std::make_shared<ceres_costs::RelativePoseCost<SE2>>(),
                                 SE2(), SE2::Matrix::Identity())
                  .ok());
  EXPECT_EQ(SaveState(optimizer, path).message(),
            path + ": edge 4 -> 5: its cost is the caller's own, which cannot be saved");
  EXPECT_EQ(ReadBytes(path), "what was there");
}

}  // namespace
}  // namespace hpgo
