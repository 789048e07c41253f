// A hierarchy over the poses of a ceres::Problem.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "ceres/problem.h"
#include "hpgo/ceres/adapted_cost.h"
#include "hpgo/ceres/native_term.h"
#include "hpgo/ceres/pose_codec.h"
#include "hpgo/optimizer.h"

namespace hpgo {

// What ProblemSolver asks of it, whatever the group.
class KeptProblem {
 public:
  virtual ~KeptProblem() = default;
  // Each returns an error that says what cannot be kept; the object is then of no more use.
  // Takes over a new residual block, and one that is gone; nothing if it is not known. O(1).
  virtual Status Add(ceres::ResidualBlockId id) = 0;
  virtual Status Remove(ceres::ResidualBlockId id) = 0;
  // Looks again at a block: is it constant, was it moved. O(residuals) where it became constant or
  // variable, else O(1).
  virtual Status Look(const double* block) = 0;
  // All of that by looking at everything. O(N).
  virtual Status LookAtAll() = 0;
  virtual UpdateReport Update(const UpdateLimits& limits) = 0;
  virtual UpdateReport Refine(const UpdateLimits& limits) = 0;
  virtual const PoseLayout& layout() const = 0;
  // The one in which most of the first costs are terms that chains can hold, the options' own on
  // ties; and whether there were enough of them to tell.
  virtual ceres_costs::ErrorConvention BestConvention() const = 0;
  virtual bool HasSampled() const = 0;
  virtual double Cost() const = 0;
  virtual Result<std::int64_t> GroupOf(const double* block, int level) const = 0;
};

template <typename G>
class KeptProblemOf final : public KeptProblem {
 public:
  KeptProblemOf(ceres::Problem* problem, const OptimizerOptions& options, const PoseLayout& layout);

  Status Add(ceres::ResidualBlockId id) override;
  Status Remove(ceres::ResidualBlockId id) override;
  Status Look(const double* block) override;
  Status LookAtAll() override;
  UpdateReport Update(const UpdateLimits& limits) override;
  UpdateReport Refine(const UpdateLimits& limits) override;
  const PoseLayout& layout() const override { return codec_.layout(); }
  ceres_costs::ErrorConvention BestConvention() const override;
  bool HasSampled() const override { return sampled_ >= kEnoughSamples; }
  double Cost() const override { return optimizer_.Cost(); }

  Result<std::int64_t> GroupOf(const double* block, int level) const override;

  Optimizer<G>& optimizer() { return optimizer_; }

 private:
  struct Node {
    std::vector<double*> blocks;
    std::vector<double> numbers;  // as last seen or written
    std::vector<const ceres::Manifold*> manifolds;
    std::vector<bool> true_jacobians;
    bool fixed = false;
    int residuals = 0;
  };
  struct Residual {
    const ceres::CostFunction* cost = nullptr;
    const ceres::LossFunction* loss = nullptr;
    std::vector<double*> blocks;
    std::uint64_t fingerprint = 0;
    std::vector<NodeId> nodes;  // that it is over, held ones among them
    EdgeId edge;                // none where all are held
    std::uint64_t seen = 0;
  };
  struct Place {
    NodeId node = 0;
    int k = 0;
  };

  Residual Read(ceres::ResidualBlockId id) const;
  Status Link(ceres::ResidualBlockId id, Residual* residual);
  std::string NameOf(ceres::ResidualBlockId id) const;
  Status FindNodes(ceres::ResidualBlockId id, Residual* residual);
  Status AddNode(const std::vector<double*>& blocks, NodeId* id);
  Status LookAtNode(NodeId id);
  Status Relink(NodeId id);
  void Unlink(const Residual& residual);
  std::vector<BlockSource> Sources(const Residual& residual,
                                   const std::vector<NodeId>& poses) const;
  Status AddToOptimizer(const std::vector<NodeId>& poses, Residual* residual);
  Status Take(const Result<EdgeId>& edge, Residual* residual);
  void NoteConventions(const ceres::CostFunction& cost, const LeastCost<G>& least);
  int OffsetOf(int k) const;
  void WriteBack();

  ceres::Problem& problem_;
  PoseCodec<G> codec_;
  Optimizer<G> optimizer_;
  NodeId next_node_ = 0;
  std::unordered_map<NodeId, Node> nodes_;
  std::unordered_map<const double*, Place> places_;
  std::unordered_map<ceres::ResidualBlockId, Residual> residuals_;
  std::uint64_t looks_ = 0;
  static constexpr int kEnoughSamples = 8;
  // How many of the first costs are terms, by convention.
  int sampled_ = 0, matches_[3] = {};
};

}  // namespace hpgo
