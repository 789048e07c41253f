#include "tools/replay_run.h"

#include <sys/resource.h>
#include <time.h>

#include <algorithm>
#include <cstdio>

#include "hpgo/io/output_file.h"
#include "hpgo/io/state_file.h"
#include "hpgo/replay.h"
#include "tools/console.h"
#include "tools/replay_comparisons.h"
#include "tools/signals.h"

namespace hpgo_cli {
namespace {

using hpgo::SE2;
using hpgo::SE3;
using hpgo::Status;
using hpgo::StatusCode;
using hpgo::YawPose;

double ClockSeconds(clockid_t clock) {
  timespec now = {};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Wall time and CPU time of this thread.
struct Moment {
  double wall = ClockSeconds(CLOCK_MONOTONIC);
  double cpu = ClockSeconds(CLOCK_THREAD_CPUTIME_ID);
};

std::int64_t PeakMemoryBytes() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return std::int64_t{1024} * usage.ru_maxrss;
}

std::string ProgressText(std::size_t done, std::size_t total, double latency_ms) {
  constexpr int kWidth = 24;
  const int filled = static_cast<int>(kWidth * done / total);
  char text[128];
  std::snprintf(text, sizeof(text), "[%s%s] %s of %s nodes, %.3g ms an update",
                std::string(filled, '#').c_str(), std::string(kWidth - filled, '-').c_str(),
                FormatCount(static_cast<std::int64_t>(done)).c_str(),
                FormatCount(static_cast<std::int64_t>(total)).c_str(), latency_ms);
  return text;
}

template <typename G>
class Replay {
 public:
  Replay(const hpgo::PoseGraph<G>& graph, const ReplaySettings& settings,
         hpgo::Optimizer<G>* optimizer)
      : graph_(graph),
        settings_(settings),
        optimizer_(*optimizer),
        steps_(hpgo::ReplaySteps(graph)),
        loss_(MakeSharedLoss(settings.loss)),
        comparisons_(graph, settings, *optimizer, &result_) {
    limits_.max_seconds = settings.update_seconds;
    limits_.cancel = &CancelFlag();
    if (!settings.stats_csv.empty()) {
      csv_ = std::make_unique<hpgo::OutputFile>(settings.stats_csv);
      csv_->Append("update,nodes,edges,latency_us,windows,solved_nodes,levels,chi2\n");
    }
    const std::size_t count = steps_.size();
    const std::size_t measured = std::min<std::size_t>(settings.measure_updates, count);
    first_measured_ = settings.measure_mode.has_value() ? count - measured : count;
    first_counted_ = settings.measure_mode.has_value()
                         ? first_measured_
                         : static_cast<std::size_t>(settings.stats_from * count);
    comparisons_.SetClosures(ClosuresToCompare());
    if (settings.stale_poses > 0) client_poses_.resize(graph.nodes().size());
  }

  hpgo::Result<ReplayResult> Run() {
    Status status = SkipWhatIsThere();
    if (status.ok()) status = AddAllSteps();
    if (status.ok() && csv_ != nullptr) status = csv_->Commit();
    if (!status.ok()) return status;
    if (settings_.refine && !CancelFlag()) Refine();
    if (!settings_.save.empty()) status = hpgo::SaveState(optimizer_, settings_.save);
    if (!status.ok()) return status;
    result_.interrupted = CancelFlag();
    result_.optimizer_memory = optimizer_.MemoryBytes();
    result_.peak_memory = PeakMemoryBytes();
    return std::move(result_);
  }

 private:
  // Goes on behind the nodes that the optimizer has.
  Status SkipWhatIsThere() {
    std::size_t edges = 0;
    const auto is_there = [&](const hpgo::ReplayStep& step) {
      return optimizer_.HasNode(graph_.nodes()[step.node].id);
    };
    for (; first_step_ < steps_.size() && is_there(steps_[first_step_]); ++first_step_) {
      const hpgo::ReplayStep& step = steps_[first_step_];
      edges += step.edges.size() + step.priors.size();
    }
    if (first_step_ != optimizer_.num_nodes() || edges != optimizer_.num_edges()) {
      return Status(StatusCode::kInvalidArgument,
                    "the state, of " + Plural(optimizer_.num_nodes(), "node") + " and " +
                        Plural(optimizer_.num_edges(), "edge") +
                        ", is not of this graph's first nodes: " +
                        FormatCount(static_cast<std::int64_t>(first_step_)) + " of those, with " +
                        Plural(edges, "edge") + ", are in it");
    }
    result_.steps = static_cast<std::int64_t>(first_step_);
    comparisons_.SkipTo(first_step_);
    return Status::Ok();
  }

  bool IsSaveDue(std::size_t nodes) const {
    return settings_.save_every > 0 && nodes % static_cast<std::size_t>(settings_.save_every) == 0;
  }

  Status AddAllSteps() {
    Progress progress;
    UpdateSample sample;  // of the update to come, summed up over the nodes it waits for
    double shown_ms = 0;
    for (std::size_t k = first_step_; k < steps_.size() && !CancelFlag(); ++k) {
      const hpgo::ReplayStep& step = steps_[k];
      const Moment before;
      Status status = Insert(step);
      if (!status.ok()) return status;
      const double insert_seconds = ClockSeconds(CLOCK_MONOTONIC) - before.wall;
      hpgo::UpdateReport report;
      const bool due = IsDue(k);
      if (due) {
        report = optimizer_.Optimize(
            k >= first_measured_ ? *settings_.measure_mode : settings_.options.mode, limits_);
      }
      const Moment after;
      AddTimes(before, after, insert_seconds, report, &sample);
      sample.closes_loop |= step.closes_loop();
      status = comparisons_.Add(step);
      if (!status.ok()) return status;
      result_.steps = static_cast<std::int64_t>(k) + 1;
      if (due) {
        Record(k, report, &sample);
        shown_ms += 0.05 * (sample.wall_ms - shown_ms);
        comparisons_.AfterUpdate(k + 1, sample.closes_loop);
        sample = UpdateSample();
        if (settings_.stale_poses > 0 && result_.updates % settings_.stale_poses == 0) {
          status = TakePoses(k + 1);
          if (!status.ok()) return status;
        }
      }
      if (IsSaveDue(k + 1)) status = hpgo::SaveState(optimizer_, settings_.save);
      if (!status.ok()) return status;
      if (progress.enabled()) progress.Show(ProgressText(k + 1, steps_.size(), shown_ms));
    }
    return Status::Ok();
  }

  Status Insert(const hpgo::ReplayStep& step) {
    if (settings_.stale_poses == 0) {
      return hpgo::ApplyStep<G>(graph_, step, loss_, &optimizer_);
    }
    const hpgo::Result<G> pose = hpgo::StartPose<G>(
        graph_, step, [this](int node) -> hpgo::Result<G> { return client_poses_[node]; });
    if (!pose.ok()) return pose.status();
    client_poses_[step.node] = *pose;
    return hpgo::AddStep<G>(graph_, step, *pose, loss_, &optimizer_);
  }

  // The client reads the poses of the first nodes.
  Status TakePoses(std::size_t count) {
    for (std::size_t k = 0; k < count; ++k) {
      const int node = steps_[k].node;
      const hpgo::Result<G> pose = optimizer_.GetPose(graph_.nodes()[node].id);
      if (!pose.ok()) return pose.status();
      client_poses_[node] = *pose;
    }
    return Status::Ok();
  }

  // The numbers, among the updates that take in a closure, of those to compare after.
  std::vector<std::int64_t> ClosuresToCompare() const {
    std::int64_t total = 0;
    bool closes_loop = false;
    for (std::size_t k = 0; k < steps_.size(); ++k) {
      closes_loop |= steps_[k].closes_loop();
      if (!IsDue(k)) continue;
      total += closes_loop;
      closes_loop = false;
    }
    return SampleEvenly(total, settings_.compare_closures);
  }

  bool IsDue(std::size_t k) const {
    if (k + 1 == steps_.size() || k >= first_measured_) return true;
    if (settings_.solve_every == 0) return steps_[k].closes_loop();
    return (k + 1) % static_cast<std::size_t>(settings_.solve_every) == 0;
  }

  static void AddTimes(const Moment& before, const Moment& after, double insert_seconds,
                       const hpgo::UpdateReport& report, UpdateSample* sample) {
    const auto add = [](double seconds, float* milliseconds) {
      *milliseconds += static_cast<float>(1e3 * seconds);
    };
    add(after.wall - before.wall, &sample->wall_ms);
    add(after.cpu - before.cpu, &sample->cpu_ms);
    add(insert_seconds + report.insert_seconds, &sample->insert_ms);
    add(report.merge_seconds, &sample->merge_ms);
    add(report.examine_seconds, &sample->examine_ms);
    add(report.top_seconds, &sample->top_ms);
    add(report.window_seconds, &sample->windows_ms);
  }

  void Record(std::size_t k, const hpgo::UpdateReport& report, UpdateSample* sample) {
    sample->update = static_cast<std::int32_t>(++result_.updates);
    result_.seconds += 1e-3 * sample->wall_ms;
    result_.windows += report.windows;
    result_.top_solves += report.top_solves;
    result_.merged_edges += report.merged_edges;
    result_.examined_edges += report.examined_edges;
    result_.solved_nodes += report.solved_nodes;
    if (!report.status.ok() && result_.failed_updates++ == 0) result_.first_failure = report.status;
    if (k >= first_counted_) result_.samples.push_back(*sample);
    if (csv_ == nullptr) return;
    char line[160];
    std::snprintf(line, sizeof(line), "%d,%zu,%zu,%.1f,%d,%d,%d,", sample->update,
                  optimizer_.num_nodes(), optimizer_.num_edges(), 1e3 * sample->wall_ms,
                  report.windows, report.solved_nodes, report.num_levels);
    csv_->Append(line);
    if (settings_.chi2_every > 0 && result_.updates % settings_.chi2_every == 0) {
      std::snprintf(line, sizeof(line), "%.9g", Chi2(optimizer_));
      csv_->Append(line);
    }
    csv_->Append("\n");
    csv_->FlushIfLarge();
  }

  void Refine() {
    RefineResult refine;
    refine.cost_before = optimizer_.Cost();
    if (!result_.comparisons.empty() && result_.comparisons.back().percent == 100) {
      refine.before = result_.comparisons.back();
    }
    hpgo::UpdateLimits limits;
    limits.cancel = &CancelFlag();
    refine.report = optimizer_.Refine(limits);
    refine.cost_after = optimizer_.Cost();
    if (!CancelFlag()) refine.after = comparisons_.Compare(100);
    if (refine.before.has_value() && refine.after.has_value()) {
      ShareOptimum(&*refine.before, &*refine.after);
    }
    result_.refine = refine;
  }

  const hpgo::PoseGraph<G>& graph_;
  const ReplaySettings& settings_;
  hpgo::Optimizer<G>& optimizer_;
  const std::vector<hpgo::ReplayStep> steps_;
  typename hpgo::Optimizer<G>::Loss loss_;
  hpgo::UpdateLimits limits_;
  std::unique_ptr<hpgo::OutputFile> csv_;
  std::size_t first_step_ = 0;
  std::size_t first_measured_ = 0;  // steps in measure_mode
  std::size_t first_counted_ = 0;   // steps in the statistics
  std::vector<G> client_poses_;     // by index in graph_, with stale_poses
  ReplayResult result_;
  ReplayComparisons<G> comparisons_;
};

}  // namespace

template <typename G>
double Chi2(const hpgo::Optimizer<G>& optimizer) {
  double chi2 = 0;
  for (const hpgo::EdgeError& error : optimizer.EdgeErrors()) chi2 += error.chi2;
  return chi2;
}

template <typename G>
hpgo::Result<ReplayResult> RunReplay(const hpgo::PoseGraph<G>& graph,
                                     const ReplaySettings& settings,
                                     hpgo::Optimizer<G>* optimizer) {
  return Replay<G>(graph, settings, optimizer).Run();
}

template double Chi2(const hpgo::Optimizer<SE2>&);
template double Chi2(const hpgo::Optimizer<SE3>&);
template double Chi2(const hpgo::Optimizer<YawPose>&);
template hpgo::Result<ReplayResult> RunReplay(const hpgo::PoseGraph<SE2>&, const ReplaySettings&,
                                              hpgo::Optimizer<SE2>*);
template hpgo::Result<ReplayResult> RunReplay(const hpgo::PoseGraph<SE3>&, const ReplaySettings&,
                                              hpgo::Optimizer<SE3>*);
template hpgo::Result<ReplayResult> RunReplay(const hpgo::PoseGraph<YawPose>&,
                                              const ReplaySettings&, hpgo::Optimizer<YawPose>*);

}  // namespace hpgo_cli
