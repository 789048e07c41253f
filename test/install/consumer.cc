// What a user of the installed library writes: a square of four poses, odometry that closes, and a
// start that is wrong; a full optimization finds the square.
#include <cmath>
#include <cstdio>

#include "hpgo/graph/pose_graph.h"
#include "hpgo/solve/full_solve.h"

int main() {
  constexpr double kQuarterTurn = 1.5707963267948966;
  hpgo::PoseGraph2d graph;
  for (int k = 0; k < 4; ++k) {
    hpgo::GraphNode<hpgo::SE2> node;
    node.id = k;
    node.pose = hpgo::SE2(0.9 * k, 0.2 * k, 0.1 * k);
    if (!graph.AddNode(node).ok()) return 1;
  }
  for (int k = 0; k < 4; ++k) {
    hpgo::GraphEdge<hpgo::SE2> edge;
    edge.i = k;
    edge.j = (k + 1) % 4;
    edge.measurement = hpgo::SE2(1, 0, kQuarterTurn);
    if (!graph.AddEdge(edge).ok()) return 1;
  }
  const hpgo::FullSolveReport report = hpgo::SolveFull(hpgo::FullSolveOptions(), &graph);
  if (!report.status.ok()) {
    std::printf("%s\n", report.status.ToString().c_str());
    return 1;
  }
  std::printf("chi2 before: %.4f\nchi2 after: %.4f\n", report.chi2_before, report.chi2_after);
  const hpgo::SE2& corner = graph.nodes()[2].pose;
  return std::hypot(corner.data()[0] - 1, corner.data()[1] - 1) < 1e-6 ? 0 : 1;
}
