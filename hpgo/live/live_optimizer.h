// The optimizer inside a running robot: solves on a thread of its own while nodes keep arriving,
// and publishes its poses to readers that never wait for it.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <future>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <thread>
#include <unordered_map>
#include <vector>

#include "hpgo/live/pose_map.h"
#include "hpgo/optimizer.h"

namespace hpgo {

// What readers get: all poses as of one moment. Never changes.
template <typename G>
struct Snapshot {
  std::uint64_t version = 0;  // counts the snapshots
  PoseMap<G> poses;           // T_world_node
  UpdateReport report;        // of the last update that was finished
  std::size_t waiting = 0;    // nodes among the poses that no update has taken in yet
};

struct LiveOptions {
  OptimizerOptions optimizer;
  UpdateLimits update;  // of each update; `cancel` is the live optimizer's own
  // Idle time goes into Refine until nothing is stressed (with Schedule::kStress), in slices of so
  // many seconds, each published when it ends. A change ends a slice.
  bool refine_when_idle = true;
  double refine_seconds = 0.1;
  // Called on the worker's thread for a change that the optimizer refuses though the call did not
  // (a self edge, an edge to a node that has been removed meanwhile), and for updates that fail.
  // May be empty.
  std::function<void(const Status&)> on_error;
};

// All calls may come from any thread at any time. Changes are queued and take effect in order; they
// wait for no solve, at most for a snapshot to be published. Each is in the readers' poses at once:
// a node appears where it was put, and goes when it is removed. When an update ends, the poses that
// it has moved are published, O(moved), and the nodes that came meanwhile are carried along by the
// motion of the newest node that it knew.
template <typename G>
class LiveOptimizer {
 public:
  using Matrix = typename G::Matrix;
  using Loss = typename Optimizer<G>::Loss;

  explicit LiveOptimizer(LiveOptions options = {});
  // Goes on with what `start` has (loaded from a file, perhaps), and with its options.
  LiveOptimizer(LiveOptions options, Optimizer<G> start);
  LiveOptimizer(const LiveOptimizer&) = delete;
  LiveOptimizer& operator=(const LiveOptimizer&) = delete;
  // Stops between two windows; changes that no update has taken in are lost.
  ~LiveOptimizer();

  // --- Readers.
  std::shared_ptr<const Snapshot<G>> Latest() const { return std::atomic_load(&latest_); }

  // --- Changes; see Optimizer for what is refused.
  Status AddNode(NodeId id, const G& pose);
  Status AddEdge(NodeId i, NodeId j, const G& measurement, const Matrix& information,
                 Loss loss = nullptr, InfoFrame frame = InfoFrame::kMeasurement);
  Status AddPrior(NodeId id, const G& measurement, const Matrix& information, Loss loss = nullptr);
  Status RemoveEdges(NodeId i, NodeId j);
  Status RemoveNode(NodeId id);
  Status SetFixed(NodeId id, bool fixed);
  Status SetPose(NodeId id, const G& pose);

  // Runs on the worker's thread, between two solves, after all changes before it; for what has no
  // call of its own here: SaveState, or Clone for the caller to save. Nodes are to be added and
  // removed, and poses to be set, by the calls above. The future holds what it threw, if it did.
  std::future<void> Run(std::function<void(Optimizer<G>*)> run);
  // Waits for an update that has all changes before it.
  UpdateReport Update();
  // The same, to the optimum.
  UpdateReport Converge(const UpdateLimits& limits = {});
  // Waits until nothing is left to be done.
  void WaitUntilIdle();

 private:
  struct Change {
    std::function<Status(Optimizer<G>*, const G&)> run;
    G pose;
  };
  struct Request {
    std::promise<UpdateReport> done;
    bool converge = false;
    UpdateLimits limits;
  };

  UpdateReport Wait(Request request);
  void Push(std::function<Status(Optimizer<G>*, const G&)> run);
  void PushPosed(NodeId id, const G& pose, std::function<Status(Optimizer<G>*, const G&)> run);
  // The mutex is held. Null if there is no such node.
  const G* Find(NodeId id) const { return next_.poses.Find(id); }
  Status CheckNodes(std::initializer_list<NodeId> ids) const;
  // The mutex is held.
  bool HasIdleWork() const {
    return options_.refine_when_idle && options_.optimizer.schedule == Schedule::kStress &&
           !at_rest_;
  }
  void Work();
  UpdateReport Solve(bool has_changes, const std::vector<Request>& requests);
  void Publish();
  void Report(const Status& status) const;

  const LiveOptions options_;
  std::shared_ptr<const Snapshot<G>> latest_;  // through atomic_load and atomic_store only

  mutable std::mutex mutex_;  // of what follows
  std::condition_variable wake_, idle_;
  std::vector<Change> changes_;
  std::vector<Request> requests_;
  // Nodes that changes_ pose -> which of them does.
  std::unordered_map<NodeId, std::size_t> posed_;
  PoseMapWriter<G> poses_;
  Snapshot<G> next_;  // what was published last, to be changed for the next time
  // Former snapshots that a reader may still hold: whoever drops the last one frees its pages,
  // which should not be the reader.
  std::vector<std::shared_ptr<const Snapshot<G>>> former_;
  bool busy_ = false, at_rest_;

  std::atomic<bool> stop_{false}, interrupt_{false};
  Optimizer<G> optimizer_;  // the worker's
  std::thread worker_;
};

using LiveOptimizer2d = LiveOptimizer<SE2>;
using LiveOptimizer3d = LiveOptimizer<SE3>;

extern template class LiveOptimizer<SE2>;
extern template class LiveOptimizer<SE3>;
extern template class LiveOptimizer<YawPose>;

}  // namespace hpgo
