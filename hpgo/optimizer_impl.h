// The inside of Optimizer; see optimizer.h for what the calls mean.
#pragma once

#include <chrono>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "hpgo/chains/condensed_graph.h"
#include "hpgo/graph/id_map.h"
#include "hpgo/hierarchy/chunked_vector.h"
#include "hpgo/hierarchy/hierarchy.h"
#include "hpgo/optimizer.h"
#include "hpgo/schedule/stress.h"
#include "hpgo/schedule/sweep.h"
#include "hpgo/solve/over_correction.h"
#include "hpgo/solve/window.h"

namespace hpgo {

// Adds the counts and times of one step; status, levels and means are the latest.
void Accumulate(const UpdateReport& step, UpdateReport* sum);

// CPU time of the calling thread, in seconds.
double ThreadCpuSeconds();

// What is left of limits after some wall and CPU time, both in seconds.
UpdateLimits Remaining(const UpdateLimits& limits, double seconds, double cpu_seconds);

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

  // optimizer_update.cc
  UpdateReport Update(Mode mode, const UpdateLimits& limits);
  UpdateReport Refine(const UpdateLimits& limits);

  // optimizer_converge.cc
  UpdateReport Converge(const UpdateLimits& limits);

  // optimizer_query.cc
  Result<G> GetPose(NodeId id) const;
  Result<Group> GetGroup(NodeId id, int level) const;
  void ForEachPose(const std::function<void(NodeId, const G&)>& visit) const;
  void ForEachMoved(double distance, double angle,
                    const std::function<void(NodeId, const G&)>& visit);
  std::vector<EdgeError> EdgeErrors() const;
  Result<EdgeError> GetEdgeError(EdgeId edge) const;
  double Cost() const;
  Result<std::shared_ptr<CeresLevel<G>>> LevelProblem(int level);

  // optimizer_covariance.cc
  Result<Matrix> MarginalCovariance(NodeId id) const;
  Result<Matrix> RelativeCovariance(NodeId i, NodeId j) const;
  PoseGraph<G> ToGraph() const;
  std::size_t MemoryBytes() const;

  const OptimizerOptions& options() const { return options_; }
  const Hierarchy<G>& hierarchy() const { return hierarchy_; }
  const IdMap& ids() const { return index_of_; }
  std::size_t num_nodes() const { return graph_.num_nodes(); }
  std::size_t num_edges() const { return graph_.num_edges(); }
  // Empty if all is well; for tests.
  std::string FindInconsistency();

 private:
  using Clock = std::chrono::steady_clock;
  static double Seconds(Clock::duration duration) {
    return std::chrono::duration<double>(duration).count();
  }
  // Adds the time it lives to a field of the report.
  class Stopwatch {
   public:
    explicit Stopwatch(double* total) : total_(total), start_(Clock::now()) {}
    Stopwatch(const Stopwatch&) = delete;
    Stopwatch& operator=(const Stopwatch&) = delete;
    ~Stopwatch() { *total_ += Elapsed(); }
    double Elapsed() const { return Seconds(Clock::now() - start_); }

   private:
    double* total_;
    Clock::time_point start_;
  };

  // Edges as EdgeIds: the index in graph_ and its generation. Nodes by their index there, too.
  EdgeId IdOf(Index edge) const;
  Result<Index> FindEdge(EdgeId id) const;
  Result<Index> FindNode(NodeId id) const;
  std::string NameOf(Index edge) const;
  std::string NameOfLevelEdge(Index level_edge) const;
  Index Link(Index i, Index j, const EdgeData<G>& data);
  void Disturb(Index node);
  EdgeError ErrorOf(Index edge, const G& T_i_j) const;

  // optimizer_corrections.cc
  void NoteGivenPose(Index node, const G& pose);
  void ForgetNode(Index node);

  // optimizer_covariance.cc
  Subproblem<G> ComponentsOf(const std::vector<Index>& nodes,
                             std::unordered_map<Index, int>* position) const;

  // optimizer_anchors.cc: what holds the gauge of each component.
  struct TopComponents {
    std::vector<int> of_node;  // by index on the top level
    int count = 0;
  };
  TopComponents FindTopComponents() const;
  void AlignJoinedComponents();
  std::vector<std::int64_t> FindHolders(const TopComponents& components) const;
  void HoldComponents();
  Index TopAncestor(Index node) const;
  bool HasPrior(Index node) const;

  // The steps of an update.
  UpdateReport Step(Mode mode, const UpdateLimits& limits);
  void QueueAll();
  void InsertNewNodes();
  void NoteNewEdges();
  void SampleChi2();
  void MeasureChi2();
  void SetThresholds();
  void MergeDirtyEdges();
  void NoteRefreshed();
  void SolveLevel(int l, int iterations);
  int ServeStressed(int l, int max_solves);
  void RunStressSchedule();
  void RunFixedSchedule();
  void SolveFull();
  int SolveWindowToRest(int max_solves);
  bool SolveWindow(int max_iterations,
                   double max_seconds = std::numeric_limits<double>::infinity());
  // Whether time or the caller, not the options, say when to stop.
  bool IsUncapped() const { return HasTimeLimit() || refining_; }
  bool HasTimeLimit() const { return limits_.max_seconds > 0 || limits_.max_cpu_seconds > 0; }
  double TimeLimit() const;  // the shorter one; infinity without
  bool IsStrained() const;
  bool Struggles() const;
  double SecondsLeft() const;
  double SecondsForWindow() const;
  bool IsStopped() const;
  bool GraphGains() const;
  bool ShortenToGain(SubproblemSummary* summary);
  void NoteMotions();
  G NewestPose() const { return newest_ == kNone ? G() : graph_.WorldPose(newest_); }
  // The motion from one pose to another.
  static Motion MotionBetween(const G& before, const G& after);
  Status NotFinite(Index level_edge) const;
  Status WhyUnusable(const Status& status);
  void RecordChanges(const SubproblemSummary& summary, double stretch);
  std::vector<Index> SeedsOnLevel(int l) const;
  bool TopIsSmall() const;
  double Worth();
  void LearnWindowSeconds(double elapsed);
  double UsualWindowSeconds(int l) const;
  WindowLimits NextWindow(int l) const;

  OptimizerOptions options_;
  // Mutable: asking for a pose brings up to date what it is computed from.
  mutable CondensedGraph<G> graph_;
  Hierarchy<G>& hierarchy_;  // of graph_
  IdMap index_of_;
  ChunkedVector<NodeId> ids_;  // by index in graph_
  std::unique_ptr<SubproblemSolver<G>> solver_;
  Window<G> window_;
  OverCorrection<G> over_correction_;  // of a far-off closure
  Sweep sweep_;
  StressThresholds thresholds_;
  double depth_ = 1;  // Refine divides the stress threshold by it
  // The running mean of chi2 over samples of the edges, and how many it is of.
  double mean_chi2_ = 0;
  int num_samples_ = 0;
  std::uint32_t next_sample_ = 0;
  // chi2 of recent new edges over the mean, fading from update to update; kFarOff and above: a
  // far-off closure is being taken in.
  static constexpr double kFarOff = 3e3;
  double strain_ = 0;
  bool damped_ = false, damped_last_ = false;  // whether a solve of this, of the last update was

  // Held for want of a fixed node or prior, one a component; the value orders them by age.
  std::map<Index, std::int64_t> anchors_;
  std::int64_t next_anchor_ = 0;
  std::set<Index> fixed_;  // by the caller
  int num_priors_ = 0;
  bool check_anchors_ = false;

  // Corrections are taken: poses that the caller has given since it last did, and the node that was
  // the newest then, at its pose then.
  bool takes_corrections_ = false;
  std::unordered_map<Index, G> given_;
  Index reference_ = kNone;
  G reference_pose_;

  // Since the last update.
  std::vector<Index> new_nodes_;
  std::vector<EdgeId> new_edges_;
  Index newest_ = kNone;
  // Of the update that is running.
  UpdateReport report_;
  std::vector<std::vector<Index>> seeds_;  // by level: the ancestors of the new edges' ends
  std::vector<bool> had_window_;           // by level
  UpdateLimits limits_;
  Clock::time_point started_;
  double cpu_started_ = 0;
  bool refining_ = false;
  bool rested_ = false;       // the last update
  bool converged_ = false;    // the last solve
  bool at_optimum_ = false;   // since the last Converge, but for changes
  double largest_scale_ = 1;  // of windows, over the options' size
  // By level, what recent windows would have taken at the options' size; 0: none yet.
  std::vector<double> window_seconds_;
};

}  // namespace hpgo
