// Bounded covariances against exact ones, in a 3D city: by how much the standard deviations are
// above, and what both take.
//   covariance_bench [NODES]
// A table of CSV: medians and 90th percentiles over pairs of the newest node and one before it.
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "hpgo/optimizer.h"
#include "hpgo/replay.h"
#include "test/bench/measure.h"

namespace {

using hpgo::CpuSeconds;
using hpgo::Quantile;
using hpgo::SE3;

// By how many percent a standard deviation of the translation is above the exact one.
double Above(const SE3::Matrix& bounded, const SE3::Matrix& exact) {
  const double ratio = bounded.topLeftCorner<3, 3>().trace() / exact.topLeftCorner<3, 3>().trace();
  return 100 * (std::sqrt(ratio) - 1);
}

}  // namespace

int main(int argc, char** argv) {
  constexpr int kPairs = 20;
  const auto city = hpgo::CityOfArguments(argc, argv);
  if (!city.has_value()) return 1;
  const int nodes = static_cast<int>(city->nodes().size());
  hpgo::Optimizer3d optimizer;
  for (const hpgo::ReplayStep& step : hpgo::ReplaySteps(*city)) {
    const hpgo::Status status = hpgo::ApplyStep<SE3>(*city, step, nullptr, &optimizer);
    if (!status.ok()) {
      std::fprintf(stderr, "%s\n", status.ToString().c_str());
      return 1;
    }
    optimizer.Update();
  }
  std::mt19937 random(1);
  std::vector<hpgo::NodeId> others;
  std::vector<SE3::Matrix> marginals, relatives;
  std::vector<double> exact_ms;
  for (int k = 0; k < kPairs; ++k) {
    const hpgo::NodeId other = 1 + static_cast<int>(random() % (nodes - 2));
    const double begin = CpuSeconds();
    const auto marginal = optimizer.MarginalCovariance(other);
    exact_ms.push_back(1e3 * (CpuSeconds() - begin));
    const auto relative = optimizer.RelativeCovariance(nodes - 1, other);
    if (!marginal.ok() || !relative.ok()) continue;
    others.push_back(other);
    marginals.push_back(*marginal);
    relatives.push_back(*relative);
  }
  std::printf(
      "nodes,max_nodes,solved,exact,ms_p50,ms_p90,marginal_above_percent_p50,"
      "marginal_above_percent_p90,relative_above_percent_p50,relative_above_percent_p90\n");
  std::printf("%d,all,%d,1,%.3g,%.3g,0,0,0,0\n", nodes, nodes - 1, Quantile(exact_ms, 0.5),
              Quantile(exact_ms, 0.9));
  for (const int max_nodes : {0, 50, 100, 200, 400, 800, 1600, 3200}) {
    std::vector<double> ms, marginal_above, relative_above, solved;
    bool exact = true;
    for (std::size_t k = 0; k < others.size(); ++k) {
      const double begin = CpuSeconds();
      const auto marginal = optimizer.BoundedMarginalCovariance(others[k], max_nodes);
      ms.push_back(1e3 * (CpuSeconds() - begin));
      const auto relative = optimizer.BoundedRelativeCovariance(nodes - 1, others[k], max_nodes);
      if (!marginal.ok() || !relative.ok()) {
        std::fprintf(stderr, "node %ld: %s\n", static_cast<long>(others[k]),
                     (marginal.ok() ? relative.status() : marginal.status()).ToString().c_str());
        return 1;
      }
      exact &= marginal->exact;
      solved.push_back(marginal->nodes);
      marginal_above.push_back(Above(marginal->covariance, marginals[k]));
      relative_above.push_back(Above(relative->covariance, relatives[k]));
    }
    std::printf("%d,%d,%.0f,%d,%.3g,%.3g,%.3g,%.3g,%.3g,%.3g\n", nodes, max_nodes,
                Quantile(solved, 0.5), exact, Quantile(ms, 0.5), Quantile(ms, 0.9),
                Quantile(marginal_above, 0.5), Quantile(marginal_above, 0.9),
                Quantile(relative_above, 0.5), Quantile(relative_above, 0.9));
    std::fflush(stdout);
  }
}
