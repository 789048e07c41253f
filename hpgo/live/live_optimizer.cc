#include "hpgo/live/live_optimizer.h"

#include <algorithm>
#include <string>
#include <utility>

#include "hpgo/graph/validate.h"

namespace hpgo {

template <typename G>
LiveOptimizer<G>::LiveOptimizer(LiveOptions options)
    : LiveOptimizer(options, Optimizer<G>(options.optimizer)) {}

template <typename G>
LiveOptimizer<G>::LiveOptimizer(LiveOptions options, Optimizer<G> start)
    : options_([&] {
        options.optimizer = start.options();
        return std::move(options);
      }()),
      latest_(std::make_shared<Snapshot<G>>()),
      at_rest_(start.num_nodes() == 0),
      optimizer_(std::move(start)) {
  optimizer_.ForEachPose([this](NodeId id, const G& pose) { poses_.Set(id, pose); });
  Publish();
  optimizer_.TakeCorrections();  // from here on everything counts
  worker_ = std::thread([this] { Work(); });
}

template <typename G>
LiveOptimizer<G>::~LiveOptimizer() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = interrupt_ = true;
  }
  wake_.notify_all();
  worker_.join();
}

template <typename G>
Status LiveOptimizer<G>::CheckNodes(std::initializer_list<NodeId> ids) const {
  for (const NodeId id : ids) {
    if (Find(id) == nullptr) {
      return Status(StatusCode::kNotFound, "no node " + std::to_string(id));
    }
  }
  return Status::Ok();
}

// The mutex is held.
template <typename G>
void LiveOptimizer<G>::Push(std::function<Status(Optimizer<G>*, const G&)> run) {
  changes_.push_back({std::move(run), G()});
  interrupt_ = true;
  wake_.notify_one();
}

template <typename G>
void LiveOptimizer<G>::PushPosed(NodeId id, const G& pose,
                                 std::function<Status(Optimizer<G>*, const G&)> run) {
  Push(std::move(run));
  changes_.back().pose = pose;
  posed_[id] = changes_.size() - 1;
  poses_.Set(id, pose);
  Publish();
}

template <typename G>
Status LiveOptimizer<G>::AddNode(NodeId id, const G& pose) {
  const Status status = CheckPose(pose, "node " + std::to_string(id) + ": the pose");
  if (!status.ok()) return status;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (Find(id) != nullptr) {
    return Status(StatusCode::kAlreadyExists, "node " + std::to_string(id) + " exists");
  }
  PushPosed(id, pose,
            [id](Optimizer<G>* optimizer, const G& at) { return optimizer->AddNode(id, at); });
  return Status::Ok();
}

template <typename G>
Status LiveOptimizer<G>::SetPose(NodeId id, const G& pose) {
  Status status = CheckPose(pose, "node " + std::to_string(id) + ": the pose");
  if (!status.ok()) return status;
  const std::lock_guard<std::mutex> lock(mutex_);
  status = CheckNodes({id});
  if (!status.ok()) return status;
  PushPosed(id, pose,
            [id](Optimizer<G>* optimizer, const G& at) { return optimizer->SetPose(id, at); });
  return Status::Ok();
}

template <typename G>
Status LiveOptimizer<G>::AddEdge(NodeId i, NodeId j, const G& measurement,
                                 const Matrix& information, Loss loss, InfoFrame frame) {
  Status status = CheckMeasurement(measurement, information, EdgeName(i, j));
  if (!status.ok()) return status;
  const std::lock_guard<std::mutex> lock(mutex_);
  status = CheckNodes({i, j});
  if (!status.ok()) return status;
  Push([=](Optimizer<G>* optimizer, const G&) {
    return optimizer->AddEdge(i, j, measurement, information, loss, frame).status();
  });
  return Status::Ok();
}

template <typename G>
Status LiveOptimizer<G>::AddPrior(NodeId id, const G& measurement, const Matrix& information,
                                  Loss loss) {
  Status status = CheckMeasurement(measurement, information, PriorName(id));
  if (!status.ok()) return status;
  const std::lock_guard<std::mutex> lock(mutex_);
  status = CheckNodes({id});
  if (!status.ok()) return status;
  Push([=](Optimizer<G>* optimizer, const G&) {
    return optimizer->AddPrior(id, measurement, information, G(), loss).status();
  });
  return Status::Ok();
}

template <typename G>
Status LiveOptimizer<G>::RemoveEdges(NodeId i, NodeId j) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const Status status = CheckNodes({i, j});
  if (!status.ok()) return status;
  Push([=](Optimizer<G>* optimizer, const G&) { return optimizer->RemoveEdges(i, j).status(); });
  return Status::Ok();
}

template <typename G>
Status LiveOptimizer<G>::RemoveNode(NodeId id) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const Status status = CheckNodes({id});
  if (!status.ok()) return status;
  Push([id](Optimizer<G>* optimizer, const G&) { return optimizer->RemoveNode(id).status(); });
  posed_.erase(id);
  poses_.Erase(id);
  Publish();
  return Status::Ok();
}

template <typename G>
Status LiveOptimizer<G>::SetFixed(NodeId id, bool fixed) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const Status status = CheckNodes({id});
  if (!status.ok()) return status;
  Push([=](Optimizer<G>* optimizer, const G&) { return optimizer->SetFixed(id, fixed); });
  return Status::Ok();
}

template <typename G>
std::future<void> LiveOptimizer<G>::Run(std::function<void(Optimizer<G>*)> run) {
  const auto task = std::make_shared<std::packaged_task<void(Optimizer<G>*)>>(std::move(run));
  std::future<void> done = task->get_future();
  const std::lock_guard<std::mutex> lock(mutex_);
  Push([task](Optimizer<G>* optimizer, const G&) {
    (*task)(optimizer);
    return Status::Ok();
  });
  return done;
}

template <typename G>
UpdateReport LiveOptimizer<G>::Wait(Request request) {
  std::future<UpdateReport> done = request.done.get_future();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    requests_.push_back(std::move(request));
    interrupt_ = true;
    wake_.notify_one();
  }
  return done.get();
}

template <typename G>
UpdateReport LiveOptimizer<G>::Update() {
  return Wait(Request());
}

template <typename G>
UpdateReport LiveOptimizer<G>::Converge(const UpdateLimits& limits) {
  Request request;
  request.converge = true;
  request.limits = limits;
  return Wait(std::move(request));
}

template <typename G>
void LiveOptimizer<G>::WaitUntilIdle() {
  std::unique_lock<std::mutex> lock(mutex_);
  idle_.wait(lock,
             [this] { return changes_.empty() && requests_.empty() && !busy_ && !HasIdleWork(); });
}

template <typename G>
void LiveOptimizer<G>::Report(const Status& status) const {
  if (!status.ok() && options_.on_error) options_.on_error(status);
}

// The mutex is held.
template <typename G>
void LiveOptimizer<G>::Publish() {
  ++next_.version;
  next_.poses = poses_.Publish();
  next_.waiting = posed_.size();
  former_.push_back(std::atomic_load(&latest_));
  std::atomic_store(&latest_,
                    std::shared_ptr<const Snapshot<G>>(std::make_shared<Snapshot<G>>(next_)));
  // Nobody can get hold of a former one any more: once it is ours alone it stays so.
  const auto is_dropped = [](const auto& former) { return former.use_count() == 1; };
  former_.erase(std::remove_if(former_.begin(), former_.end(), is_dropped), former_.end());
}

template <typename G>
UpdateReport LiveOptimizer<G>::Solve(bool has_changes, const std::vector<Request>& requests) {
  UpdateLimits limits = options_.update;
  for (const Request& request : requests) {
    if (!request.converge) continue;
    limits = request.limits;
    limits.cancel = &stop_;
    return optimizer_.Converge(limits);
  }
  if (has_changes || !requests.empty()) {
    limits.cancel = &stop_;
    return optimizer_.Update(limits);
  }
  limits = UpdateLimits();
  limits.max_seconds = options_.refine_seconds;
  limits.cancel = &interrupt_;
  return optimizer_.Refine(limits);
}

template <typename G>
void LiveOptimizer<G>::Work() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!stop_) {
    if (changes_.empty() && requests_.empty() && !HasIdleWork()) {
      idle_.notify_all();
      wake_.wait(lock);
      continue;
    }
    std::vector<Change> changes;
    std::vector<Request> requests;
    changes.swap(changes_);
    requests.swap(requests_);
    posed_.clear();
    interrupt_ = false;
    busy_ = true;
    lock.unlock();

    for (const Change& change : changes) Report(change.run(&optimizer_, change.pose));
    const UpdateReport report = Solve(!changes.empty(), requests);
    Report(report.status);
    const typename Optimizer<G>::Corrections corrections = optimizer_.TakeCorrections();

    lock.lock();
    busy_ = false;
    // An update makes progress, or nothing is stressed; a failure is not tried again without
    // change.
    at_rest_ = report.at_rest || !report.status.ok();
    for (const auto& [id, pose] : corrections.moved) {
      // Removed meanwhile, or posed anew.
      if (Find(id) != nullptr && posed_.count(id) == 0) poses_.Set(id, pose);
    }
    for (const auto& [id, change] : posed_) {
      G& pose = changes_[change].pose;
      pose = (corrections.motion * pose).Normalized();
      poses_.Set(id, pose);
    }
    next_.report = report;
    Publish();
    for (Request& request : requests) request.done.set_value(report);
  }
  // Whoever waits for an update that will not be made.
  UpdateReport stopped;
  stopped.status = Status(StatusCode::kInterrupted, "stopped");
  for (Request& request : requests_) request.done.set_value(stopped);
}

template class LiveOptimizer<SE2>;
template class LiveOptimizer<SE3>;
template class LiveOptimizer<YawPose>;

}  // namespace hpgo
