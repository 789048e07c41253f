// Incremental pose graph optimization with a bounded cost per update.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hpgo/graph/pose_graph.h"
#include "hpgo/graph/status.h"
#include "hpgo/optimizer_options.h"

namespace ceres {
class CostFunction;
class LossFunction;
}  // namespace ceres

namespace hpgo {

template <typename G>
class CeresLevel;  // hpgo/ceres/level_problem.h

template <typename G>
class Hierarchy;  // hpgo/hierarchy/hierarchy.h

class StateReader;  // hpgo/state/state_reader.h
class StateWriter;  // hpgo/state/state_writer.h

// Names an edge or a prior for as long as it exists; never given twice.
struct EdgeId {
  std::int64_t value = -1;
  friend bool operator==(EdgeId a, EdgeId b) { return a.value == b.value; }
  friend bool operator!=(EdgeId a, EdgeId b) { return a.value != b.value; }

  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.value);
  }
};

// What an edge or a prior ties together.
struct EdgeEnds {
  EdgeId id;
  NodeId i = 0, j = 0;  // of a prior, i == j
};

// The frame in which an information matrix weighs the translation's error; the rotation's is the
// same in both.
enum class InfoFrame {
  kMeasurement,  // of node j as measured, R_z' (t_i_j - t_z): g2o's, and what is stored
  kFirstNode,    // of node i, t_i_j - t_z: karto's
};

// How one edge fits the current estimate.
struct EdgeError {
  EdgeId id;
  NodeId i = 0, j = 0;  // of a prior, i == j
  double chi2 = 0;      // e' Omega e, without the loss
};

// A pose graph that is optimized while it grows and changes.
//
//   hpgo::Optimizer3d optimizer;
//   optimizer.AddNode(0, SE3());
//   optimizer.AddNode(1, T_0_1);
//   optimizer.AddEdge(0, 1, T_0_1, information);
//   optimizer.Update();
//   SE3 T_world_1 = *optimizer.GetPose(1);
//
// Poses are T_world_node. Each connected component with neither a fixed node nor a prior is held at
// its first node. A component that is joined to an older one by an edge moves as a whole to fit
// that edge. A call that returns an error has changed nothing. Deterministic unless a time limit is
// given. Not synchronized: one thread at a time, or a lock around it.
template <typename G>
class Optimizer {
 public:
  using Matrix = typename G::Matrix;
  using Loss = std::shared_ptr<const ceres::LossFunction>;

  explicit Optimizer(const OptimizerOptions& options = {});
  Optimizer(Optimizer&&) noexcept;
  Optimizer& operator=(Optimizer&&) noexcept;
  ~Optimizer();
  const OptimizerOptions& options() const;

  // --- Building and changing the graph; nothing is solved until Update. O(levels x degree) each.
  // kAlreadyExists; kInvalidArgument for a pose that is not finite.
  Status AddNode(NodeId id, const G& pose);
  // A measurement T_i_j with the information of its error, translation first; loss null: squared.
  // kNotFound; kInvalidArgument for a self edge and for values that cannot be used (see
  // hpgo/graph/validate.h). Several edges between the same nodes are allowed.
  Result<EdgeId> AddEdge(NodeId i, NodeId j, const G& measurement, const Matrix& information,
                         Loss loss = nullptr, InfoFrame frame = InfoFrame::kMeasurement);
  // Any Ceres cost over {X_i, X_j} in the storage order of G that depends on T_i_j only, with
  // whitened residuals. `measurement` and `information` approximate it where groups are formed.
  // kInvalidArgument where it cannot be evaluated at the estimate, or changes when both poses are
  // moved together.
  Result<EdgeId> AddCustomEdge(NodeId i, NodeId j, std::shared_ptr<const ceres::CostFunction> cost,
                               const G& measurement, const Matrix& information,
                               Loss loss = nullptr);
  // A measurement of T_world_sensor with P = T_node_sensor; rows of zeros are not measured.
  Result<EdgeId> AddPrior(NodeId id, const G& measurement, const Matrix& information,
                          const G& offset = G(), Loss loss = nullptr);
  // Any Ceres cost over {X}, whitened; `measurement` and `information` approximate it.
  // kInvalidArgument where it cannot be evaluated at the estimate.
  Result<EdgeId> AddCustomPrior(NodeId id, std::shared_ptr<const ceres::CostFunction> cost,
                                const G& measurement, const Matrix& information,
                                Loss loss = nullptr);
  // Replaces the measurement of an edge or a prior, and the loss where one (or null) is given.
  // kInvalidArgument for an edge with a custom cost.
  Status UpdateEdge(EdgeId edge, const G& measurement, const Matrix& information,
                    InfoFrame frame = InfoFrame::kMeasurement);
  Status UpdateEdge(EdgeId edge, const G& measurement, const Matrix& information, Loss loss,
                    InfoFrame frame = InfoFrame::kMeasurement);
  // Removes an edge or a prior.
  Status RemoveEdge(EdgeId edge);
  // Removes all edges between two nodes, in either direction; the edges that went. kNotFound for a
  // node that is not there.
  Result<std::vector<EdgeEnds>> RemoveEdges(NodeId i, NodeId j);
  // Removes a node with its edges and priors; these.
  Result<std::vector<EdgeEnds>> RemoveNode(NodeId id);
  // A fixed node never moves.
  Status SetFixed(NodeId id, bool fixed);
  // Moves a node's estimate.
  Status SetPose(NodeId id, const G& pose);
  void Clear();

  // --- Solving.
  // One bounded step: inserts what is new and improves the estimate where it pays most. Where most
  // edges are in chains, a closure that is far off may take several updates; at_rest is false until
  // then, and the cost counts what it measures. Where nothing has changed, the cost does not end
  // above what it was, but for what chains' models miss, and where more edges are moved than can be
  // asked (hpgo/update/README.md).
  UpdateReport Update(const UpdateLimits& limits = {});
  // The same with another mode than that of the options.
  UpdateReport Optimize(Mode mode, const UpdateLimits& limits = {});
  // Idle work: updates until nothing is stressed, or the cost no longer falls, then again at a
  // tenth and a hundredth of the threshold, each time after one look at every edge; or until a
  // limit is hit, to be called again. Nothing is done where nothing has changed since it was at
  // rest. The schedules kNewEdges and kNewestNode know no rest: they make one update.
  UpdateReport Refine(const UpdateLimits& limits = {});
  // To the optimum now, by whatever is cheapest, for clients that ask once after many changes: the
  // whole graph is solved, or windows alone where the limits have no time for that, to be called
  // again. Nothing is done where nothing has changed. at_rest: it is the optimum, or as near to it
  // as Refine gets.
  UpdateReport Converge(const UpdateLimits& limits = {});

  // --- Asking. Poses cost O(levels) each.
  Result<G> GetPose(NodeId id) const;
  bool HasNode(NodeId id) const;
  std::size_t num_nodes() const;
  std::size_t num_edges() const;  // priors among them
  void ForEachPose(const std::function<void(NodeId, const G&)>& visit) const;
  // The poses that have moved since each was last reported here, by more than `distance` (m) or
  // `angle` (rad). Looks only at the parts of the hierarchy that moved. The first call reports all,
  // and so does one with a negative limit.
  void ForEachMoved(double distance, double angle,
                    const std::function<void(NodeId, const G&)>& visit);
  // What has changed of the map that a client holds, since it last took corrections.
  struct Corrections {
    std::vector<std::pair<NodeId, G>> moved;  // T_world_node
    // The motion of the node that was the newest when corrections were last taken. To be applied
    // from the left to all that was posed in the map since: T_world_sensor = motion * T_old_sensor.
    G motion;
  };
  // The poses that are off those that the client knows, having given them itself (AddNode, SetPose)
  // or taken them here, by more than `distance` (m) or `angle` (rad); twice that at most where it
  // gave them. They accumulate until taken. The first call takes all poses: made on the empty
  // optimizer, it has everything after it count. Shares its memory with ForEachMoved: use one of
  // them. O(what has moved).
  Corrections TakeCorrections(double distance = 0, double angle = 0);
  // The ancestor of a node on a level: the poses of all nodes with the same group move with it.
  // Keep T_world_group; when it has become T', the group's poses have been moved by T' T^-1.
  struct Group {
    std::int64_t id = 0;  // names the group until nodes or edges are removed
    G pose;               // T_world_group
  };
  Result<Group> GetGroup(NodeId id, int level) const;
  int num_levels() const;

  // The edges and priors of a node, oldest first. O(degree). kNotFound.
  Result<std::vector<EdgeEnds>> EdgesOf(NodeId id) const;
  // All edges and priors at the current estimate. O(edges).
  std::vector<EdgeError> EdgeErrors() const;
  Result<EdgeError> GetEdgeError(EdgeId edge) const;
  // The sum of the losses of e' Omega e: the objective. O(edges).
  double Cost() const;
  // The covariance of a node's pose, under a right perturbation, given all edges and the gauge as
  // it is held. Exact: factors its component. kNoSolution where this pose is not determined; others
  // may be.
  Result<Matrix> MarginalCovariance(NodeId id) const;
  // That of T_i_j = X_i^-1 X_j, under a right perturbation of it; likewise.
  Result<Matrix> RelativeCovariance(NodeId i, NodeId j) const;

  // The same in bounded time, from at most so many kept nodes (more only where the way to what
  // holds them is longer): those around the nodes, and around the way from what holds the first, or
  // from one to the other; chains are one edge, whatever their length. What lies beyond counts for
  // nothing, so that the covariance is never below the exact one but by what chains, linearized a
  // little off, make of it. As of the last update; nodes without an edge then are kNoSolution.
  struct CovarianceEstimate {
    Matrix covariance;
    bool exact = false;  // nothing was left out
    int nodes = 0;       // that were solved for
  };
  Result<CovarianceEstimate> BoundedMarginalCovariance(NodeId id, int max_nodes = 800) const;
  Result<CovarianceEstimate> BoundedRelativeCovariance(NodeId i, NodeId j,
                                                       int max_nodes = 800) const;

  // A level as a ceres::Problem at the current estimate, with its values and the way from nodes to
  // blocks: hpgo/ceres/level_problem.h. Levels are those of `hierarchy()` after the last update:
  // level 0 is the kept nodes. O(nodes of the level). kInvalidArgument where there is no such
  // level.
  Result<std::shared_ptr<CeresLevel<G>>> LevelProblem(int level);

  // The graph with the current estimate; custom costs and losses are not part of it.
  PoseGraph<G> ToGraph() const;
  // Adds a graph's nodes, edges and priors, without solving; nodes without a pose get one composed
  // along the edges. An error leaves the optimizer as it was.
  Status AddGraph(const PoseGraph<G>& graph);

  // All there is, as it is: what is loaded goes on with the same bits, and needs no solve first;
  // ids of edges stay. hpgo/io/state_file.h has files of it. kInvalidArgument, naming the edge, for
  // costs of the caller's own, and for losses that ceres_costs::MakeLoss has not made.
  Status Save(StateWriter* writer) const;
  // Replaces everything, the options too. An error leaves the optimizer as it was.
  Status Load(StateReader* reader);
  // A copy, for trying something out: shares losses and costs of the caller's own. O(edges).
  Optimizer Clone() const;

  // The hierarchy over the kept nodes (hpgo/chains): its level 0 is not the graph.
  const Hierarchy<G>& hierarchy() const;
  // Checks every invariant of the inside, for tests: empty, or the first thing wrong. O(edges).
  std::string FindInconsistency() const;
  // Of the nodes, edges and indices.
  std::size_t MemoryBytes() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

using Optimizer2d = Optimizer<SE2>;
using Optimizer3d = Optimizer<SE3>;

}  // namespace hpgo
