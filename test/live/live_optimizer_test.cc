#include "hpgo/live/live_optimizer.h"

#include <unistd.h>
#include <algorithm>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <functional>
#include <future>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "hpgo/generate/synthetic_graph.h"
#include "hpgo/io/state_file.h"
#include "hpgo/replay.h"
#include "test/optimizer/oracle.h"

namespace hpgo {
namespace {

using Matrix = SE2::Matrix;

PoseGraph<SE2> MakeWorld(World world, int nodes) {
  GenerateOptions options;
  options.world = world;
  options.nodes = nodes;
  return GenerateGraph<SE2>(options)->graph;
}

// A client that poses each node from the newest snapshot, as fast as it can.
void Feed(const PoseGraph<SE2>& graph, LiveOptimizer<SE2>* live) {
  for (const ReplayStep& step : ReplaySteps(graph)) {
    const Result<SE2> pose = StartPose<SE2>(
        graph, step, [&](int node) -> Result<SE2> { return *live->Latest()->poses.Find(node); });
    ASSERT_TRUE(live->AddNode(step.node, *pose).ok());
    for (const int e : step.edges) {
      const auto& edge = graph.edges()[e];
      ASSERT_TRUE(live->AddEdge(edge.i, edge.j, edge.measurement, edge.information).ok());
    }
  }
}

TEST(LiveOptimizerTest, ReadersSeeAConsistentMapWhileItIsSolved) {
  const PoseGraph<SE2> graph = MakeWorld(World::kManhattan, 1500);
  LiveOptimizer<SE2> live;
  std::atomic<bool> done{false};
  std::atomic<int> snapshots{0};
  std::vector<std::thread> readers;
  std::vector<std::vector<double>> seconds(4);
  for (int r = 0; r < 4; ++r) {
    readers.emplace_back([&, r] {
      std::uint64_t version = 0;
      std::size_t size = 0;
      while (!done) {
        const auto start = std::chrono::steady_clock::now();
        const auto latest = live.Latest();
        const std::size_t count = latest->poses.size();
        const SE2* newest =
            count == 0 ? nullptr : latest->poses.Find(static_cast<NodeId>(count) - 1);
        seconds[r].push_back(
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
        if (latest->version == version) {
          std::this_thread::yield();
          continue;
        }
        ++snapshots;
        EXPECT_GT(latest->version, version);
        EXPECT_GE(count, size);
        // Nodes are added in the order of their ids: all up to the newest are there.
        if (count > 0) {
          EXPECT_NE(newest, nullptr);
        }
        version = latest->version;
        size = count;
      }
    });
  }
  Feed(graph, &live);
  int nodes_seen = 0;
  live.Run([&](Optimizer<SE2>* optimizer) {
        nodes_seen = static_cast<int>(optimizer->ToGraph().nodes().size());
      })
      .get();
  EXPECT_EQ(nodes_seen, 1500);
  const UpdateReport report = live.Converge();
  done = true;
  for (std::thread& reader : readers) reader.join();
  EXPECT_TRUE(report.at_rest) << report.status.ToString();
  EXPECT_GT(snapshots, 0);
  std::vector<double> all;
  for (const auto& some : seconds) all.insert(all.end(), some.begin(), some.end());
  std::sort(all.begin(), all.end());
  std::printf("%zu reads: p50 %.2f us, p99 %.2f us, max %.1f us\n", all.size(),
              1e6 * all[all.size() / 2], 1e6 * all[all.size() * 99 / 100], 1e6 * all.back());
  // What is published is what the optimizer has.
  live.Run([&](Optimizer<SE2>* optimizer) {
        EXPECT_LT(Gap(*optimizer), 1e-8);
        const auto latest = live.Latest();
        EXPECT_EQ(latest->waiting, 0u);
        optimizer->ForEachPose([&](NodeId id, const SE2& pose) {
          EXPECT_LT(pose.LocalCoordinates(*latest->poses.Find(id)).norm(), 1e-9) << id;
        });
      })
      .get();
}

TEST(LiveOptimizerTest, IdleTimeGoesIntoRefine) {
  const PoseGraph<SE2> graph = MakeWorld(World::kManhattan, 800);
  for (const double slice : {LiveOptions().refine_seconds, 1e-9}) {  // any length will do
    LiveOptions options;
    options.refine_seconds = slice;
    LiveOptimizer<SE2> live(options);
    Feed(graph, &live);
    live.WaitUntilIdle();
    EXPECT_TRUE(live.Latest()->report.at_rest);
    live.Run([](Optimizer<SE2>* optimizer) { EXPECT_LT(Gap(*optimizer), 1e-4); }).get();
  }
}

// Runs something, and stops the worker then, until Release.
class Pause {
 public:
  explicit Pause(LiveOptimizer<SE2>* live, std::function<void(Optimizer<SE2>*)> run = nullptr)
      : done_(live->Run([this, run](Optimizer<SE2>* optimizer) {
          if (run) run(optimizer);
          reached_.set_value();
          go_on_.get_future().wait();
        })) {}
  void Await() { reached_.get_future().wait(); }
  void Release() {
    go_on_.set_value();
    done_.get();
  }

 private:
  std::promise<void> reached_, go_on_;
  std::future<void> done_;
};

// Nodes that come while a solve runs move with the map that they were posed in.
TEST(LiveOptimizerTest, NewerNodesAreCarriedAlong) {
  LiveOptions options;
  options.refine_when_idle = false;
  LiveOptimizer<SE2> live(options);
  const Matrix I = Matrix::Identity();
  ASSERT_TRUE(live.AddNode(0, SE2()).ok());
  for (int k = 1; k < 20; ++k) {
    ASSERT_TRUE(live.AddNode(k, SE2(k, 0, 0)).ok());
    ASSERT_TRUE(live.AddEdge(k - 1, k, SE2(1, 0, 0), I).ok());
  }
  live.Update();
  // A closure that turns the map; before it is solved the next node comes, posed in the old one.
  Pause closure(&live, [&](Optimizer<SE2>* optimizer) {
    const SE2 turned = SE2(0, 0, 0.3) * SE2(19, 0, 0);
    ASSERT_TRUE(optimizer->AddEdge(0, 19, turned, 1e4 * I).ok());
  });
  closure.Await();
  ASSERT_TRUE(live.AddNode(20, SE2(20, 0, 0)).ok());
  Pause after(&live);
  closure.Release();
  after.Await();
  const auto latest = live.Latest();
  EXPECT_GT(latest->poses.Find(19)->data()[1], 1);
  const SE2 relative = latest->poses.Find(19)->Between(*latest->poses.Find(20));
  EXPECT_LT(relative.LocalCoordinates(SE2(1, 0, 0)).norm(), 1e-9);
  after.Release();
}

// What the client does during a solve counts for more than its result.
TEST(LiveOptimizerTest, ChangesDuringASolveStay) {
  LiveOptions options;
  options.refine_when_idle = false;
  LiveOptimizer<SE2> live(options);
  const Matrix I = Matrix::Identity();
  for (int k = 0; k < 4; ++k) ASSERT_TRUE(live.AddNode(k, SE2(k, 0, 0)).ok());
  for (int k = 1; k < 4; ++k) ASSERT_TRUE(live.AddEdge(k - 1, k, SE2(1, 0, 0), I).ok());
  live.Update();
  // All but the first move two metres to the side in the update that the worker is before.
  Pause solve(&live, [&](Optimizer<SE2>* optimizer) {
    for (int k = 1; k < 4; ++k) ASSERT_TRUE(optimizer->AddPrior(k, SE2(k, 2, 0), 1e6 * I).ok());
  });
  solve.Await();
  ASSERT_TRUE(live.RemoveNode(1).ok());
  ASSERT_TRUE(live.SetPose(3, SE2(3, 7, 0)).ok());
  EXPECT_EQ(live.Latest()->waiting, 1u);
  SE2 given;
  Pause next(&live, [&](Optimizer<SE2>* optimizer) {
    EXPECT_FALSE(optimizer->HasNode(1));
    given = *optimizer->GetPose(3);
  });
  solve.Release();
  next.Await();
  const auto latest = live.Latest();
  EXPECT_EQ(latest->poses.Find(1), nullptr);
  EXPECT_NEAR(latest->poses.Find(2)->data()[1], 2, 0.1);
  EXPECT_NEAR(latest->poses.Find(3)->data()[1], 9, 0.1);
  EXPECT_LT(given.LocalCoordinates(*latest->poses.Find(3)).norm(), 1e-12);
  next.Release();
}

// The last reader of a snapshot does not free it: the next one that is published does.
TEST(LiveOptimizerTest, SnapshotsAreFreedByTheirWriter) {
  LiveOptimizer<SE2> live;
  Pause pause(&live);
  pause.Await();
  ASSERT_TRUE(live.AddNode(0, SE2()).ok());
  auto reader = live.Latest();
  const std::weak_ptr<const Snapshot<SE2>> snapshot = reader;
  ASSERT_TRUE(live.AddNode(1, SE2()).ok());
  reader.reset();
  EXPECT_FALSE(snapshot.expired());
  ASSERT_TRUE(live.AddNode(2, SE2()).ok());
  EXPECT_TRUE(snapshot.expired());
  pause.Release();
}

// Every state that is saved while nodes keep arriving is one to go on from.
TEST(LiveOptimizerTest, SavesMeanwhileAndGoesOnFromIt) {
  const PoseGraph<SE2> graph = MakeWorld(World::kManhattan, 600);
  const std::string path = testing::TempDir() + "hpgo_live_state_" + std::to_string(getpid());
  std::atomic<bool> done{false};
  std::vector<std::size_t> sizes;
  {
    LiveOptimizer<SE2> live;
    std::thread saver([&] {
      while (!done) {
        live.Run([&](Optimizer<SE2>* optimizer) {
              const Status status = SaveState(*optimizer, path);
              EXPECT_TRUE(status.ok()) << status.ToString();
            })
            .get();
        Optimizer<SE2> loaded;
        const Status status = LoadState(path, &loaded);
        EXPECT_TRUE(status.ok()) << status.ToString();
        loaded.Update();
        EXPECT_EQ(loaded.FindInconsistency(), "");
        sizes.push_back(loaded.num_nodes());
      }
    });
    Feed(graph, &live);
    done = true;
    saver.join();
    live.Run([&](Optimizer<SE2>* optimizer) { EXPECT_TRUE(SaveState(*optimizer, path).ok()); })
        .get();
  }
  EXPECT_TRUE(std::is_sorted(sizes.begin(), sizes.end()));
  Optimizer<SE2> loaded;
  ASSERT_TRUE(LoadState(path, &loaded).ok());
  LiveOptimizer<SE2> resumed(LiveOptions(), std::move(loaded));
  EXPECT_EQ(resumed.Latest()->poses.size(), 600u);
  EXPECT_EQ(resumed.AddNode(599, SE2()).message(), "node 599 exists");
  EXPECT_TRUE(resumed.Converge().at_rest);
  resumed.Run([](Optimizer<SE2>* optimizer) { EXPECT_LT(Gap(*optimizer), 1e-8); }).get();
}

TEST(LiveOptimizerTest, ErrorsAreNamed) {
  std::vector<std::string> errors;
  LiveOptions options;
  options.on_error = [&](const Status& status) { errors.push_back(status.message()); };
  LiveOptimizer<SE2> live(options);
  const Matrix I = Matrix::Identity();
  ASSERT_TRUE(live.AddNode(1, SE2()).ok());
  EXPECT_EQ(live.AddNode(1, SE2()).message(), "node 1 exists");
  EXPECT_EQ(live.AddEdge(1, 2, SE2(), I).message(), "no node 2");
  EXPECT_EQ(live.RemoveEdges(1, 2).message(), "no node 2");
  EXPECT_EQ(live.RemoveNode(2).message(), "no node 2");
  EXPECT_EQ(live.SetFixed(2, true).message(), "no node 2");
  EXPECT_EQ(live.SetPose(2, SE2()).message(), "no node 2");
  EXPECT_EQ(live.AddPrior(2, SE2(), I).message(), "no node 2");
  ASSERT_TRUE(live.AddNode(2, SE2()).ok());
  EXPECT_THAT(live.AddEdge(1, 2, SE2(), -I).message(), testing::HasSubstr("edge 1 -> 2"));
  ASSERT_TRUE(live.AddEdge(1, 1, SE2(), I).ok());
  live.Update();
  live.Run([](Optimizer<SE2>*) {}).get();
  EXPECT_THAT(errors, testing::ElementsAre("edge 1 -> 1: a self edge"));
  ASSERT_TRUE(live.RemoveNode(2).ok());
  EXPECT_EQ(live.Latest()->poses.Find(2), nullptr);
  ASSERT_TRUE(live.AddNode(2, SE2(5, 0, 0)).ok());
  live.WaitUntilIdle();
  EXPECT_EQ(live.Latest()->poses.Find(2)->data()[0], 5);
  std::future<void> failing =
      live.Run([](Optimizer<SE2>*) { throw std::runtime_error("the client's own"); });
  EXPECT_THROW(failing.get(), std::runtime_error);
}

}  // namespace
}  // namespace hpgo
