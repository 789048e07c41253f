// A writer at full speed, four readers, updates on the worker: what a reader waits.
//   live_bench [NODES]
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

#include "hpgo/live/live_optimizer.h"
#include "hpgo/replay.h"
#include "test/bench/measure.h"

namespace {

using Clock = std::chrono::steady_clock;
using hpgo::SE3;

double Seconds(Clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

}  // namespace

int main(int argc, char** argv) {
  const auto city = hpgo::CityOfArguments(argc, argv);
  if (!city.has_value()) return 1;
  const hpgo::PoseGraph<SE3>& graph = *city;
  const std::vector<hpgo::ReplayStep> steps = hpgo::ReplaySteps(graph);
  hpgo::LiveOptimizer<SE3> live;
  std::atomic<bool> done{false};
  constexpr int kReaders = 4;
  std::vector<std::vector<double>> waits(kReaders);
  std::vector<std::thread> readers;
  for (int r = 0; r < kReaders; ++r) {
    readers.emplace_back([&, r] {
      while (!done) {
        const Clock::time_point start = Clock::now();
        const auto latest = live.Latest();
        const SE3* newest = latest->poses.Find(static_cast<hpgo::NodeId>(latest->poses.size()) - 1);
        waits[r].push_back(Seconds(Clock::now() - start));
        if (newest == nullptr && latest->poses.size() > 0) std::abort();
        std::this_thread::sleep_for(std::chrono::microseconds(500));
      }
    });
  }
  const Clock::time_point start = Clock::now();
  for (int k = 0; k < static_cast<int>(graph.nodes().size()); ++k) {
    const auto pose = hpgo::StartPose<SE3>(graph, steps[k], [&](int node) -> hpgo::Result<SE3> {
      return *live.Latest()->poses.Find(node);
    });
    hpgo::Status status = live.AddNode(k, *pose);
    for (const int e : steps[k].edges) {
      const auto& edge = graph.edges()[e];
      if (status.ok()) {
        status = live.AddEdge(edge.i, edge.j, edge.measurement, edge.information);
      }
    }
    if (!status.ok()) std::fprintf(stderr, "%s\n", status.ToString().c_str());
  }
  const double written = Seconds(Clock::now() - start);
  live.WaitUntilIdle();
  const double idle = Seconds(Clock::now() - start);
  done = true;
  for (std::thread& reader : readers) reader.join();
  std::vector<double> all;
  for (const auto& some : waits) all.insert(all.end(), some.begin(), some.end());
  std::printf("%d nodes written in %.2f s, at rest after %.2f s, %llu snapshots\n",
              static_cast<int>(graph.nodes().size()), written, idle,
              static_cast<unsigned long long>(live.Latest()->version));
  std::printf("%zu reads: p50 %.2f us, p99 %.2f us, p99.9 %.2f us, max %.1f us\n", all.size(),
              1e6 * hpgo::Quantile(all, 0.5), 1e6 * hpgo::Quantile(all, 0.99),
              1e6 * hpgo::Quantile(all, 0.999), 1e6 * hpgo::Quantile(all, 1));
}
