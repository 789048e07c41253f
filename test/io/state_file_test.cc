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
#include <functional>
#include <memory>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "ceres_costs/losses.h"
#include "ceres_costs/relative_pose_cost.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "hpgo/io/output_file.h"
#include "hpgo/state/state_traits.h"
#include "hpgo/state/state_writer.h"
#include "test/solve/small_graphs.h"

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

std::shared_ptr<const ceres::LossFunction> Loss(const std::string& name) {
  std::unique_ptr<ceres::LossFunction> loss;
  std::string error;
  EXPECT_TRUE(ceres_costs::MakeLoss(name, 3, &loss, &error)) << error;
  return loss;
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

// Random calls on a small graph.
template <typename G>
class Robot {
 public:
  // Returns what it has seen, for comparison.
  using Call = std::function<std::string(Optimizer<G>*)>;

  explicit Robot(std::uint64_t seed) : rng_(seed), losses_{"none", "huber", "dcs"} {}

  OptimizerOptions Options() {
    OptimizerOptions options;
    options.max_group_size = 2 + Below(3);
    options.max_top_nodes = 3 + Below(8);
    options.condense_chains = Chance(0.8);
    options.coarse_edges = Chance(0.2) ? CoarseEdges::kCondensed : CoarseEdges::kGalerkin;
    options.schedule = Chance(0.8) ? Schedule::kStress : Schedule::kNewEdges;
    options.window_nodes = 8 + Below(30);
    options.max_windows = 1 + Below(4);
    options.max_examined = 1 + Below(50);
    options.max_merges = 1 + Below(50);
    return options;
  }

  int dice() const { return dice_; }

  // What to do next with an optimizer where the calls so far have been made.
  Call Next(const Optimizer<G>& optimizer) {
    if (nodes_.size() < 3) return AddNode(optimizer);
    const int dice = dice_ = Below(100);
    if (dice < 35) return AddNode(optimizer);
    if (dice < 45) return AddEdge(AnyNode(), AnyNode());
    if (dice < 48) return AddPrior(optimizer);
    if (dice < 52) return ChangeEdge();
    if (dice < 55) return ChangeNode(optimizer);
    if (dice < 58) return RemoveNode();
    if (dice < 60) {
      return [](Optimizer<G>* o) {
        o->Refine();
        return std::string();
      };
    }
    if (dice < 62) {
      return [](Optimizer<G>* o) {
        o->Converge();
        return std::string();
      };
    }
    if (dice < 70) return TakeCorrections();
    return [](Optimizer<G>* o) {
      const UpdateReport report = o->Update();
      return std::to_string(report.windows) + "/" + std::to_string(report.examined_edges);
    };
  }

 private:
  int Below(std::size_t n) {
    return static_cast<int>(std::uniform_int_distribution<std::size_t>(0, n - 1)(rng_));
  }
  bool Chance(double p) { return std::uniform_real_distribution<double>(0, 1)(rng_) < p; }
  NodeId AnyNode() { return *std::next(nodes_.begin(), Below(nodes_.size())); }
  typename G::Matrix Information() { return 100 * RandomInformation<G>(&rng_); }

  Call AddNode(const Optimizer<G>& optimizer) {
    const NodeId id = next_id_;
    next_id_ += 1 + 1000 * Chance(0.05);
    const G step = RandomPose<G>(&rng_, 1, 0.5), noise = RandomPose<G>(&rng_, 0.05, 0.02);
    const bool attached = !nodes_.empty() && Chance(0.95);
    const NodeId from = nodes_.empty() ? 0 : Chance(0.8) ? *nodes_.rbegin() : AnyNode();
    const G pose = attached ? *optimizer.GetPose(from) * step * noise : step;
    const typename G::Matrix information = Information();
    nodes_.insert(id);
    return [=](Optimizer<G>* o) {
      EXPECT_TRUE(o->AddNode(id, pose).ok());
      if (attached) {
        EXPECT_TRUE(o->AddEdge(from, id, step, information).ok());
      }
      return std::string();
    };
  }
  Call AddEdge(NodeId i, NodeId j) {
    const G measured = RandomPose<G>(&rng_, 2, 1);
    const typename G::Matrix information = Information();
    const std::string loss = losses_[Below(losses_.size())];
    return [=](Optimizer<G>* o) {
      const Result<EdgeId> edge = o->AddEdge(i, j, measured, information, Loss(loss));
      EXPECT_EQ(edge.ok(), i != j);
      return edge.ok() ? std::to_string(edge->value) : "";
    };
  }
  Call AddPrior(const Optimizer<G>& optimizer) {
    const NodeId node = AnyNode();
    const G measured = *optimizer.GetPose(node) * RandomPose<G>(&rng_, 0.1, 0.1);
    const G offset = Chance(0.5) ? G() : RandomPose<G>(&rng_, 0.1, 0.1);
    const typename G::Matrix information = Information();
    return [=](Optimizer<G>* o) {
      return std::to_string(o->AddPrior(node, measured, information, offset)->value);
    };
  }
  Call ChangeEdge() {
    const NodeId node = AnyNode();
    const bool removed = Chance(0.5);
    const G measured = RandomPose<G>(&rng_, 1, 0.5);
    const typename G::Matrix information = Information();
    const std::string loss = losses_[Below(losses_.size())];
    return [=](Optimizer<G>* o) {
      const std::vector<EdgeEnds> edges = *o->EdgesOf(node);
      if (edges.empty()) return std::string();
      const EdgeId edge = edges.back().id;
      const Status status =
          removed ? o->RemoveEdge(edge) : o->UpdateEdge(edge, measured, information, Loss(loss));
      EXPECT_TRUE(status.ok()) << status.ToString();
      return std::to_string(edge.value);
    };
  }
  Call ChangeNode(const Optimizer<G>& optimizer) {
    const NodeId node = AnyNode();
    const bool posed = Chance(0.5), fixed = Chance(0.5);
    const G pose = *optimizer.GetPose(node) * RandomPose<G>(&rng_, 0.5, 0.2);
    return [=](Optimizer<G>* o) {
      EXPECT_TRUE((posed ? o->SetPose(node, pose) : o->SetFixed(node, fixed)).ok());
      return std::string();
    };
  }
  Call RemoveNode() {
    const NodeId node = AnyNode();
    nodes_.erase(node);
    return [=](Optimizer<G>* o) { return std::to_string(o->RemoveNode(node)->size()); };
  }
  Call TakeCorrections() {
    const double distance = Chance(0.5) ? 0 : 0.05;
    return [=](Optimizer<G>* o) {
      const typename Optimizer<G>::Corrections corrections = o->TakeCorrections(distance, distance);
      std::string seen;
      for (const auto& [id, pose] : corrections.moved) {
        seen += std::to_string(id);
        seen.append(reinterpret_cast<const char*>(pose.data()), G::kParams * sizeof(double));
      }
      return seen;
    };
  }

  int dice_ = 0;
  std::mt19937_64 rng_;
  const std::vector<std::string> losses_;
  std::set<NodeId> nodes_;
  NodeId next_id_ = 0;
};

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
