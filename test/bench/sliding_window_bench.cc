// A robot that forgets: a window of so many live nodes over so many steps, in 3D. Each step adds a
// node, its odometry and a closure to a node one lap ago, removes the oldest node and updates.
//   sliding_window_bench [NODES] [STEPS] [ROWS]
// Prints a CSV line for every STEPS / ROWS steps: CPU time of a step and memory.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "hpgo/optimizer.h"
#include "test/bench/measure.h"

namespace {

using hpgo::CpuSeconds;
using hpgo::Quantile;
using hpgo::SE3;

std::int64_t ResidentBytes() {
  std::int64_t pages = 0, resident = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(file, "%ld %ld", &pages, &resident) != 2) resident = 0;
    std::fclose(file);
  }
  return resident * sysconf(_SC_PAGESIZE);
}

class Robot {
 public:
  explicit Robot(int live) : live_(live), lap_(std::max(8, live / 5)) {}

  hpgo::Status Step(hpgo::Optimizer3d* optimizer) {
    const std::int64_t k = next_++;
    const SE3 truth = Truth(k);
    hpgo::Status status;
    if (k == 0) return optimizer->AddNode(k, truth);
    const SE3 odometry = Truth(k - 1).Between(truth) * Noise();
    status = optimizer->AddNode(k, *optimizer->GetPose(k - 1) * odometry);
    if (status.ok()) status = optimizer->AddEdge(k - 1, k, odometry, information_).status();
    const std::int64_t before = k - lap_;
    if (status.ok() && before >= 0 && k % 5 == 0 && optimizer->HasNode(before)) {
      status = optimizer->AddEdge(before, k, Truth(before).Between(truth) * Noise(), information_)
                   .status();
    }
    if (status.ok() && k >= live_) status = optimizer->RemoveNode(k - live_).status();
    if (status.ok()) status = optimizer->Update().status;
    return status;
  }

 private:
  // Laps that rise slowly.
  SE3 Truth(std::int64_t k) const {
    const double angle = 2 * M_PI * static_cast<double>(k % lap_) / lap_;
    const double radius = lap_ / (2 * M_PI);
    const Eigen::Quaterniond rotation(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
    return SE3(Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle),
                               1e-4 * static_cast<double>(k)),
               rotation);
  }
  SE3 Noise() {
    SE3::Tangent d;
    for (int c = 0; c < 6; ++c) d(c) = (c < 3 ? 0.05 : 0.01) * normal_(rng_);
    return SE3().Retract(d);
  }

  const int live_, lap_;
  std::int64_t next_ = 0;
  std::mt19937_64 rng_{1};
  std::normal_distribution<double> normal_;
  const SE3::Matrix information_ =
      (SE3::Tangent() << 400, 400, 400, 1e4, 1e4, 1e4).finished().asDiagonal();
};

}  // namespace

int main(int argc, char** argv) {
  const int live = argc > 1 ? std::atoi(argv[1]) : 50;
  const std::int64_t steps = argc > 2 ? std::atoll(argv[2]) : 100'000;
  const std::int64_t rows = argc > 3 ? std::atoll(argv[3]) : 50;
  hpgo::Optimizer3d optimizer;
  Robot robot(live);
  std::vector<double> times;
  std::printf("live,step,p50_us,p99_us,max_us,optimizer_kb,resident_kb,edges\n");
  for (std::int64_t k = 1; k <= steps; ++k) {
    const double start = CpuSeconds();
    const hpgo::Status status = robot.Step(&optimizer);
    times.push_back(CpuSeconds() - start);
    if (!status.ok()) {
      std::fprintf(stderr, "step %ld: %s\n", static_cast<long>(k), status.ToString().c_str());
      return 1;
    }
    if (k % std::max<std::int64_t>(steps / rows, 1) != 0) continue;
    std::printf("%d,%ld,%.1f,%.1f,%.1f,%zu,%ld,%zu\n", live, static_cast<long>(k),
                1e6 * Quantile(times, 0.5), 1e6 * Quantile(times, 0.99), 1e6 * Quantile(times, 1),
                optimizer.MemoryBytes() / 1024, static_cast<long>(ResidentBytes() / 1024),
                optimizer.num_edges());
    std::fflush(stdout);
    times.clear();
  }
}
