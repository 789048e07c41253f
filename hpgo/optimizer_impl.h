// The inside of Optimizer; see optimizer.h for what the calls mean.
#pragma once

#include <functional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "hpgo/chains/condensed_graph.h"
#include "hpgo/graph/id_map.h"
#include "hpgo/hierarchy/chunked_vector.h"
#include "hpgo/hierarchy/hierarchy.h"
#include "hpgo/optimizer.h"
#include "hpgo/solve/subproblem.h"
#include "hpgo/update/gauge.h"
#include "hpgo/update/updater.h"

namespace hpgo {

// The information of an edge as it is stored, of one in another frame.
template <typename G>
typename G::Matrix StoredInformation(InfoFrame frame, const G& measurement,
                                     const typename G::Matrix& information);

template <typename G>
class Optimizer<G>::Impl {
 public:
  explicit Impl(const OptimizerOptions& options);

  // optimizer_edit.cc
  Status AddNode(NodeId id, const G& pose);
  Result<EdgeId> AddEdge(NodeId i, NodeId j, EdgeData<G> data);
  Result<EdgeId> AddPrior(NodeId id, EdgeData<G> data);
  // `loss` null: the edge keeps its own.
  Status UpdateEdge(EdgeId edge, const G& measurement, const Matrix& information, const Loss* loss);
  Status RemoveEdge(EdgeId edge);
  Status RemoveNode(NodeId id);
  Status SetFixed(NodeId id, bool fixed);
  Status SetPose(NodeId id, const G& pose);
  Status AddGraph(const PoseGraph<G>& graph);

  // optimizer_edges.cc
  Result<std::vector<EdgeEnds>> EdgesOf(NodeId id) const;

  // optimizer_corrections.cc
  Corrections TakeCorrections(double distance, double angle);

  // Solving: see hpgo/update.
  UpdateReport Update(Mode mode, const UpdateLimits& limits) {
    return updater_.Update(TakeChanges(), mode, limits, &gauge_);
  }
  UpdateReport Refine(const UpdateLimits& limits) {
    return updater_.Refine(TakeChanges(), limits, &gauge_);
  }
  UpdateReport Converge(const UpdateLimits& limits) {
    return updater_.Converge(TakeChanges(), limits, &gauge_);
  }

  // optimizer_query.cc
  Result<G> GetPose(NodeId id) const;
  Result<Group> GetGroup(NodeId id, int level) const;
  void ForEachPose(const std::function<void(NodeId, const G&)>& visit) const;
  void ForEachMoved(double distance, double angle,
                    const std::function<void(NodeId, const G&)>& visit);
  std::vector<EdgeError> EdgeErrors() const;
  Result<EdgeError> GetEdgeError(EdgeId edge) const;
  double Cost() const { return CostOf(&graph_); }
  Result<std::shared_ptr<CeresLevel<G>>> LevelProblem(int level);
  PoseGraph<G> ToGraph() const;
  std::size_t MemoryBytes() const;

  // optimizer_covariance.cc
  Result<Matrix> MarginalCovariance(NodeId id) const;
  Result<Matrix> RelativeCovariance(NodeId i, NodeId j) const;
  Result<CovarianceEstimate> BoundedMarginalCovariance(NodeId id, int max_nodes) const;
  Result<CovarianceEstimate> BoundedRelativeCovariance(NodeId i, NodeId j, int max_nodes) const;

  const OptimizerOptions& options() const { return options_; }
  const Hierarchy<G>& hierarchy() const { return hierarchy_; }
  const IdMap& ids() const { return index_of_; }
  std::size_t num_nodes() const { return graph_.num_nodes(); }
  std::size_t num_edges() const { return graph_.num_edges(); }
  // Empty if all is well; for tests.
  std::string FindInconsistency();

  // optimizer_state.cc: kInvalidArgument, naming the edge, for one that cannot be saved.
  Status CheckHasNames() const;

 private:
  // Edges as EdgeIds: the index in graph_ and its generation. Nodes by their index there, too.
  EdgeId IdOf(Index edge) const;
  Result<Index> FindEdge(EdgeId id) const;
  Result<Index> FindNode(NodeId id) const;
  std::string NameOf(Index edge) const;
  std::string NameOfLevelEdge(Index level_edge) const;
  Index Link(Index i, Index j, const EdgeData<G>& data);
  Changes TakeChanges();
  EdgeError ErrorOf(Index edge, const G& T_i_j) const;

  // optimizer_corrections.cc
  void NoteGivenPose(Index node, const G& pose);
  void ForgetNode(Index node);

  // optimizer_covariance.cc
  Subproblem<G> ComponentsOf(const std::vector<Index>& nodes,
                             std::unordered_map<Index, int>* position) const;

  OptimizerOptions options_;
  // Mutable: asking for a pose brings up to date what it is computed from.
  mutable CondensedGraph<G> graph_;
  Hierarchy<G>& hierarchy_;  // of graph_
  IdMap index_of_;
  ChunkedVector<NodeId> ids_;  // by index in graph_
  Gauge<G> gauge_;
  Updater<G> updater_;

  // Corrections are taken: poses that the caller has given since it last did, and the node that was
  // the newest then, at its pose then.
  bool takes_corrections_ = false;
  std::unordered_map<Index, G> given_;
  Index reference_ = kNone;
  G reference_pose_;

  // Since the last update; see Changes.
  std::vector<Index> new_nodes_, disturbed_;
  std::vector<EdgeId> new_edges_;
  Index newest_ = kNone;  // ever, unless it has been removed

 public:
  // What a saved state has of the fields above: all but the options, which come first there.
  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.graph_);
    archive.Section("nodes");
    archive(self.index_of_, self.ids_, self.gauge_, self.takes_corrections_, self.given_,
            self.reference_, self.reference_pose_, self.new_nodes_, self.disturbed_,
            self.new_edges_, self.newest_);
    archive.Section("updates");
    archive(self.updater_);
  }
};

}  // namespace hpgo
