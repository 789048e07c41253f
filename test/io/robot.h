// Random calls of an optimizer, for the tests of saved states.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "ceres_costs/losses.h"
#include "gtest/gtest.h"
#include "hpgo/optimizer.h"
#include "test/solve/small_graphs.h"

namespace hpgo {

inline std::shared_ptr<const ceres::LossFunction> Loss(const std::string& name) {
  std::unique_ptr<ceres::LossFunction> loss;
  std::string error;
  EXPECT_TRUE(ceres_costs::MakeLoss(name, 3, &loss, &error)) << error;
  return loss;
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
    options.schedule = Chance(0.8)   ? Schedule::kStress
                       : Chance(0.5) ? Schedule::kNewEdges
                                     : Schedule::kNewestNode;
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

}  // namespace hpgo
