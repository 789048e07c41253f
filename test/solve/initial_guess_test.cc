#include "hpgo/solve/initial_guess.h"

#include <algorithm>
#include <cmath>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "hpgo/solve/initial_guess_tree.h"
#include "independent_solver.h"
#include "small_graphs.h"

namespace hpgo {
namespace {

template <typename G>
std::function<double(const std::vector<G>&)> NoCost() {
  return [](const std::vector<G>&) { return 0.0; };
}

template <typename G>
std::vector<G> Guess(InitMethod method, const PoseGraph<G>& graph) {
  const Result<InitialGuess<G>> guess = MakeInitialGuess<G>(method, graph, NoCost<G>(), nullptr);
  EXPECT_TRUE(guess.ok()) << guess.status().ToString();
  return guess.ok() ? guess->poses : std::vector<G>();
}

template <typename G>
double Distance(const std::vector<G>& a, const std::vector<G>& b) {
  double largest = a.size() == b.size() ? 0 : NAN;
  for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k) {
    const double d = a[k].LocalCoordinates(b[k]).norm();
    if (!(d <= largest)) largest = d;
  }
  return largest;
}

TEST(InitMethodTest, NamesGoBothWays) {
  for (const InitMethod method :
       {InitMethod::kFile, InitMethod::kOdometry, InitMethod::kSpanningTree, InitMethod::kChordal,
        InitMethod::kJointChordal, InitMethod::kAuto}) {
    EXPECT_EQ(ParseInitMethod(InitMethodName(method)), method);
  }
  EXPECT_STREQ(InitMethodName(InitMethod::kSpanningTree), "spanning_tree");
  EXPECT_EQ(ParseInitMethod("Chordal"), std::nullopt);
}

template <typename G>
class InitialGuessTest : public ::testing::Test {};
using Groups = ::testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(InitialGuessTest, Groups);

TYPED_TEST(InitialGuessTest, EveryMethodIsExactWithoutNoise) {
  using G = TypeParam;
  KnownGraph<G> known = MakeKnownGraph<G>(50, 0, 1);
  std::mt19937_64 rng(1);
  for (int k = 1; k < 50; ++k) known.graph.node(k).pose = RandomPose<G>(&rng, 5, 3);
  for (const InitMethod method : {InitMethod::kOdometry, InitMethod::kSpanningTree,
                                  InitMethod::kChordal, InitMethod::kJointChordal}) {
    EXPECT_LT(Distance(Guess(method, known.graph), known.truth), 1e-9) << InitMethodName(method);
  }
}

TYPED_TEST(InitialGuessTest, ChordalIsExactWithSeveralFixedNodesAndPriors) {
  using G = TypeParam;
  KnownGraph<G> known = MakeKnownGraph<G>(30, 0, 2);
  std::mt19937_64 rng(2);
  for (int k = 0; k < 30; ++k) known.graph.node(k).pose = RandomPose<G>(&rng, 5, 3);
  for (const int k : {3, 20}) {
    known.graph.node(k).pose = known.truth[k];
    known.graph.node(k).fixed = true;
  }
  for (const int k : {3, 9}) {
    GraphPrior<G> prior;
    prior.node = k;
    prior.offset = RandomPose<G>(&rng, 1, 1);
    prior.measurement = known.truth[k] * prior.offset;
    prior.information = RandomInformation<G>(&rng);
    ASSERT_TRUE(known.graph.AddPrior(prior).ok());
  }
  EXPECT_LT(Distance(Guess(InitMethod::kChordal, known.graph), known.truth), 1e-6);
  EXPECT_LT(Distance(Guess(InitMethod::kJointChordal, known.graph), known.truth), 1e-6);
}

TYPED_TEST(InitialGuessTest, ChordalComesNearTheOptimumWhereDeadReckoningDoesNot) {
  using G = TypeParam;
  const KnownGraph<G> known = MakeKnownGraph<G>(300, 0.1, 3);
  const auto chi2_at = [&](InitMethod method) {
    PoseGraph<G> graph = known.graph;
    const std::vector<G> poses = Guess(method, graph);
    for (int k = 0; k < 300; ++k) graph.node(k).pose = poses[k];
    return IndependentSolver<G>(graph, 0).Chi2();
  };
  PoseGraph<G> graph = known.graph;
  for (int k = 0; k < 300; ++k) graph.node(k).pose = known.truth[k];
  const double optimum = IndependentSolver<G>(graph, 0).Solve();
  EXPECT_GT(chi2_at(InitMethod::kOdometry), 10 * optimum);
  EXPECT_LT(chi2_at(InitMethod::kChordal), 5 * optimum);
}

TYPED_TEST(InitialGuessTest, ChordalCopesWithDirectionsThatNoEdgeMeasures) {
  using G = TypeParam;
  KnownGraph<G> known = MakeKnownGraph<G>(20, 0, 4);
  for (std::size_t k = 0; k < known.graph.edges().size(); ++k) {
    known.graph.edge(k).information.template bottomRightCorner<1, G::kDof>().setZero();
    known.graph.edge(k).information.template rightCols<1>().setZero();
  }
  EXPECT_LT(Distance(Guess(InitMethod::kChordal, known.graph), known.truth), 1e-5);
}

TYPED_TEST(InitialGuessTest, AnotherGuessHoldsAnotherNodeAndWeighsTheEdges) {
  using G = TypeParam;
  KnownGraph<G> known = MakeKnownGraph<G>(40, 0, 12);
  for (const int turn : {1, 2, 3}) {
    const Result<std::vector<G>> guess = AnotherGuess(known.graph, {}, turn);
    ASSERT_TRUE(guess.ok()) << guess.status().ToString();
    EXPECT_LT(Distance(*guess, known.truth), 1e-8) << turn;
  }
  // A wrong edge turns others, unless it counts for nothing.
  known.graph.edge(45).measurement.translation()(0) += 10;
  const auto turned = [&](double weight) {
    std::vector<double> weights(known.graph.edges().size(), 1);
    weights[45] = weight;
    const Result<std::vector<G>> guess = AnotherGuess(known.graph, weights, 1);
    double most = 0;
    for (int k = 0; k < 40; ++k) {
      most = std::max(most, ((*guess)[k].matrix() - known.truth[k].matrix()).norm());
    }
    return most;
  };
  EXPECT_GT(turned(1), 0.01);
  EXPECT_LT(turned(0), 1e-6);
}

TYPED_TEST(InitialGuessTest, OdometryTrustsNoClosureWhereItNeedNot) {
  using G = TypeParam;
  KnownGraph<G> known = MakeKnownGraph<G>(20, 0, 5);
  for (std::size_t k = 19; k < known.graph.edges().size(); ++k) {
    known.graph.edge(k).measurement.translation()(0) += 100;
    known.graph.edge(k).information *= 1e6;
  }
  EXPECT_LT(Distance(Guess(InitMethod::kOdometry, known.graph), known.truth), 1e-9);
  EXPECT_GT(Distance(Guess(InitMethod::kSpanningTree, known.graph), known.truth), 10);
}

TYPED_TEST(InitialGuessTest, TheSpanningTreeTakesThePathOfLeastUncertainty) {
  using G = TypeParam;
  PoseGraph<G> graph;
  for (NodeId id = 0; id < 3; ++id) {
    GraphNode<G> node;
    node.id = id;
    ASSERT_TRUE(graph.AddNode(node).ok());
  }
  const auto add = [&](int i, int j, double x, double information) {
    GraphEdge<G> edge;
    edge.i = i;
    edge.j = j;
    edge.measurement.translation()(0) = x;
    edge.information *= information;
    ASSERT_TRUE(graph.AddEdge(edge).ok());
  };
  add(0, 1, 1, 4);   // variance 1/4
  add(1, 2, 1, 4);   // 1/2 in all
  add(2, 0, -7, 1);  // 1 directly
  EXPECT_NEAR(Guess(InitMethod::kSpanningTree, graph)[2].translation()(0), 2, 1e-12);
  graph.edge(2).information *= 3;  // 1/3 directly
  EXPECT_NEAR(Guess(InitMethod::kSpanningTree, graph)[2].translation()(0), 7, 1e-12);
}

TYPED_TEST(InitialGuessTest, FileKeepsThePosesAndComposesTheMissingOnes) {
  using G = TypeParam;
  KnownGraph<G> known = MakeKnownGraph<G>(10, 0, 6);
  std::vector<G> expected;
  for (int k = 0; k < 10; ++k) {
    known.graph.node(k).pose.translation()(1) += 5;
    if (k == 8) known.graph.node(k).has_pose = false;
    expected.push_back(known.graph.nodes()[k].pose);
  }
  expected[8] = expected[7] * known.graph.edges()[7].measurement;
  known.graph.node(8).pose = G();
  EXPECT_LT(Distance(Guess(InitMethod::kFile, known.graph), expected), 1e-12);
}

TYPED_TEST(InitialGuessTest, AutoTakesTheCheapestAndTheFileOnTies) {
  using G = TypeParam;
  const KnownGraph<G> known = MakeKnownGraph<G>(10, 0.1, 7);
  int calls = 0;
  const auto result = MakeInitialGuess<G>(
      InitMethod::kAuto, known.graph,
      [&](const std::vector<G>&) { return ++calls == 3 ? 1.0 : 2.0; }, nullptr);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->method, InitMethod::kSpanningTree);
  ASSERT_EQ(result->candidates.size(), 5);
  EXPECT_EQ(result->candidates[2].cost, 1);
  EXPECT_EQ(result->candidates[3].cost, 2);
  const auto tie = MakeInitialGuess<G>(InitMethod::kAuto, known.graph, NoCost<G>(), nullptr);
  ASSERT_TRUE(tie.ok());
  EXPECT_EQ(tie->method, InitMethod::kFile);
}

TYPED_TEST(InitialGuessTest, AGuessWithoutAFiniteCostIsNoCandidate) {
  using G = TypeParam;
  const KnownGraph<G> known = MakeKnownGraph<G>(10, 0.1, 8);
  int calls = 0;
  const auto result = MakeInitialGuess<G>(
      InitMethod::kAuto, known.graph,
      [&](const std::vector<G>&) { return ++calls == 2 ? 3.0 : NAN; }, nullptr);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->method, InitMethod::kOdometry);
  EXPECT_EQ(result->candidates[0].status.message(), "init file: the cost is not finite");
  const auto none = MakeInitialGuess<G>(
      InitMethod::kAuto, known.graph, [](const std::vector<G>&) { return NAN; }, nullptr);
  EXPECT_EQ(none.status().code(), StatusCode::kNoSolution);
}

TYPED_TEST(InitialGuessTest, CancelEndsTheSearchWithWhatThereIs) {
  using G = TypeParam;
  const KnownGraph<G> known = MakeKnownGraph<G>(10, 0.1, 9);
  std::atomic<bool> cancel(false);
  const auto result = MakeInitialGuess<G>(
      InitMethod::kAuto, known.graph,
      [&](const std::vector<G>&) {
        cancel = true;
        return 1.0;
      },
      &cancel);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->candidates.size(), 1);
  const auto none = MakeInitialGuess<G>(InitMethod::kAuto, known.graph, NoCost<G>(), &cancel);
  EXPECT_EQ(none.status().code(), StatusCode::kInterrupted);
}

TYPED_TEST(InitialGuessTest, AnchorsAreFixedNodesThenPriorsThenTheFirstNode) {
  using G = TypeParam;
  PoseGraph<G> graph;
  for (const NodeId id : {9, 8, 7, 6, 5, 4, 3, 2}) {
    GraphNode<G> node;
    node.id = id;
    node.pose.translation()(0) = static_cast<double>(id);
    ASSERT_TRUE(graph.AddNode(node).ok());
  }
  for (int i = 0; i < 8; i += 2) {  // four components of two
    GraphEdge<G> edge;
    edge.i = i;
    edge.j = i + 1;
    ASSERT_TRUE(graph.AddEdge(edge).ok());
  }
  graph.node(0).fixed = true;
  graph.node(3).fixed = true;
  graph.node(3).has_pose = false;
  GraphPrior<G> prior;
  prior.node = 4;
  prior.measurement.translation()(0) = 50;
  prior.offset.translation()(0) = 1;
  ASSERT_TRUE(graph.AddPrior(prior).ok());

  const std::vector<Anchor<G>> anchors = FindAnchors(graph, FindComponents(graph));
  ASSERT_EQ(anchors.size(), 4);
  const int nodes[] = {0, 3, 4, 7};
  const double x[] = {9, 0, 49, 2};
  const bool firm[] = {true, true, true, false};
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ(anchors[k].node, nodes[k]);
    EXPECT_NEAR(anchors[k].pose.translation()(0), x[k], 1e-12);
    EXPECT_EQ(anchors[k].firm, firm[k]);
  }
}

}  // namespace
}  // namespace hpgo
