// RTAB-Map's optimize, with stand-ins of its types.

#include "hpgo/adapters/rtabmap_optimizer.h"

#include <map>
#include <string>

#include "test/adapters/real_graphs.h"

namespace hpgo {
namespace {

class Transform {
 public:
  Transform() = default;
  Transform(float x, float y, float z, float qx, float qy, float qz, float qw)
      : t_(x, y, z), q_(qw, qx, qy, qz) {}
  float x() const { return t_(0); }
  float y() const { return t_(1); }
  float z() const { return t_(2); }
  Eigen::Quaterniond getQuaterniond() const { return q_.cast<double>(); }

 private:
  Eigen::Vector3f t_ = Eigen::Vector3f::Zero();
  Eigen::Quaternionf q_ = Eigen::Quaternionf::Identity();
};

struct Mat {
  Eigen::Matrix<double, 6, 6> entries;
  template <typename T>
  T at(int row, int column) const {
    return entries(row, column);
  }
};

class Link {
 public:
  enum Type { kNeighbor, kGlobalClosure, kPosePrior = 7, kGravity = 9 };
  Link(int from, int to, Type type, const Transform& transform, const Mat& information)
      : from_(from), to_(to), type_(type), transform_(transform), information_(information) {}
  int from() const { return from_; }
  int to() const { return to_; }
  Type type() const { return type_; }
  const Transform& transform() const { return transform_; }
  const Mat& infMatrix() const { return information_; }

 private:
  int from_, to_;
  Type type_;
  Transform transform_;
  Mat information_;
};

Transform ToTransform(const SE3& X) {
  const Eigen::Vector3f t = X.translation().cast<float>();
  const Eigen::Quaternionf q = Eigen::Quaterniond(X.rotation()).cast<float>();
  return Transform(t(0), t(1), t(2), q.x(), q.y(), q.z(), q.w());
}
Transform ToTransform(const SE2& X) {
  const Eigen::Quaterniond q(Eigen::AngleAxisd(X.angle(), Eigen::Vector3d::UnitZ()));
  return ToTransform(SE3(Eigen::Vector3d(X.data()[0], X.data()[1], 0.5), q));
}
SE2 FromTransform(const Transform& T, SE2*) {
  const Eigen::Matrix3d R = T.getQuaterniond().toRotationMatrix();
  return SE2(T.x(), T.y(), std::atan2(R(1, 0), R(0, 0)));
}
SE3 FromTransform(const Transform& T, SE3*) {
  return SE3(Eigen::Vector3d(T.x(), T.y(), T.z()), T.getQuaterniond().normalized());
}
Mat ToMat(const Eigen::Matrix3d& information) {
  Mat mat{Eigen::Matrix<double, 6, 6>::Identity()};
  const int rows[] = {0, 1, 5};
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) mat.entries(rows[r], rows[c]) = information(r, c);
  }
  return mat;
}
Mat ToMat(const Eigen::Matrix<double, 6, 6>& information) { return {information}; }

template <typename G>
Link MakeLink(int from, int to, const G& Z, const typename G::Matrix& information) {
  return Link(from, to, to - from == 1 ? Link::kNeighbor : Link::kGlobalClosure, ToTransform(Z),
              ToMat(information));
}

template <typename G>
void ExpectOptimum(const std::string& name) {
  const PoseGraph<G> graph = RealGraph<G>(name);
  if (graph.nodes().empty()) GTEST_SKIP() << "no " << name;
  RtabmapOptimizer<G, Transform, Link> optimizer;
  std::map<int, Transform> poses, optimized;
  std::multimap<int, Link> links;
  const int n = static_cast<int>(graph.nodes().size());
  double ms = 0;
  PoseGraph<G> before = graph;
  for (const ReplayStep& step : ReplaySteps(graph)) {
    // Ids from 1; new poses from odometry behind the optimized map of the last call.
    const int k = step.node;
    poses[k + 1] = ToTransform(*StartPose<G>(graph, step, [&](int node) -> Result<G> {
      return FromTransform(poses.at(node + 1), static_cast<G*>(nullptr));
    }));
    for (const int e : step.edges) {
      const auto& edge = graph.edges()[e];
      links.emplace(edge.i + 1,
                    MakeLink(edge.i + 1, edge.j + 1, edge.measurement, edge.information));
    }
    if ((k + 1) % (n / 10) != 0 && k + 1 != n) continue;
    for (int m = 0; m <= k; ++m)
      before.node(m).pose = FromTransform(poses.at(m + 1), static_cast<G*>(nullptr));
    double error = 0;
    int iterations = 0;
    const double start = CpuMilliseconds();
    optimized = optimizer.optimize(1, poses, links, nullptr, &error, &iterations);
    ms = CpuMilliseconds() - start;
    ASSERT_TRUE(optimizer.last_status().ok()) << optimizer.last_status().ToString();
    ASSERT_EQ(optimized.size(), poses.size());
    EXPECT_NEAR(error, optimizer.optimizer().Cost(), 1e-9 * error);
    poses = optimized;
  }
  EXPECT_LT(Gap(optimizer.optimizer()), 1e-6);
  std::printf("%s: the last optimize %.1f ms of CPU time, ceres::Solve of the same %.1f ms\n",
              name.c_str(), ms, CeresMilliseconds(before));
  for (const auto& [id, pose] : optimized) {
    const G X = *optimizer.optimizer().GetPose(id);
    EXPECT_LT(X.LocalCoordinates(FromTransform(pose, static_cast<G*>(nullptr))).norm(),
              1e-5 * (1 + X.translation().norm()));
  }
  int iterations = -1;
  optimizer.optimize(1, poses, links, nullptr, nullptr, &iterations);
  EXPECT_EQ(iterations, 0);  // the same graph
}

TEST(RtabmapTest, M3500) { ExpectOptimum<SE2>("g2o/M3500.g2o"); }
TEST(RtabmapTest, Intel) { ExpectOptimum<SE2>("g2o/intel.g2o"); }
TEST(RtabmapTest, Kitti00) { ExpectOptimum<SE2>("kitti/graphs/kitti_00.g2o"); }
TEST(RtabmapTest, City2d) { ExpectOptimum<SE2>("city 10000"); }
TEST(RtabmapTest, City3d) { ExpectOptimum<SE3>("city 3000"); }

// In the plane, what it does not say of a pose stays.
TEST(RtabmapTest, PlanarPosesKeepTheirHeight) {
  RtabmapOptimizer<SE2, Transform, Link> optimizer;
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  std::map<int, Transform> poses{{1, ToTransform(SE2())}, {2, ToTransform(SE2(5, 0, 0))}};
  std::multimap<int, Link> links;
  links.emplace(1, MakeLink(1, 2, SE2(1, 0, 0.5), I));
  const auto optimized = optimizer.optimize(1, poses, links);
  EXPECT_NEAR(optimized.at(2).x(), 1, 1e-6);
  EXPECT_EQ(optimized.at(2).z(), 0.5f);
  EXPECT_NEAR(FromTransform(optimized.at(2), static_cast<SE2*>(nullptr)).angle(), 0.5, 1e-6);
}

// Two nodes a metre apart.
class RtabmapPairTest : public testing::Test {
 protected:
  RtabmapPairTest() { links.emplace(1, MakeLink(1, 2, SE2(1, 0, 0), I)); }

  RtabmapOptimizer<SE2, Transform, Link> optimizer;
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  std::map<int, Transform> poses{{1, ToTransform(SE2())}, {2, ToTransform(SE2(1, 0, 0))}};
  std::multimap<int, Link> links;
};

TEST_F(RtabmapPairTest, PriorsAreSelfLinks) {
  links.emplace(2, Link(2, 2, Link::kPosePrior, ToTransform(SE2(3, 0, 0)), ToMat(I)));
  const auto optimized = optimizer.optimize(1, poses, links);
  EXPECT_NEAR(optimized.at(2).x(), 2, 1e-6);  // half-way
  links.erase(2);
  EXPECT_NEAR(optimizer.optimize(1, poses, links).at(2).x(), 1, 1e-6);
}

// Links between the same nodes all count, and weigh the same on demand.
TEST_F(RtabmapPairTest, ParallelLinksCount) {
  links.emplace(1, MakeLink(1, 2, SE2(4, 0, 0), 2 * I));
  EXPECT_NEAR(optimizer.optimize(1, poses, links).at(2).x(), 3, 1e-6);
  optimizer.SetInformationIgnored(true);
  EXPECT_NEAR(optimizer.optimize(1, poses, links).at(2).x(), 2.5, 1e-6);
}

TEST_F(RtabmapPairTest, TheRootIsHeldWhereItIsGiven) {
  EXPECT_NEAR(optimizer.optimize(1, poses, links).at(2).x(), 1, 1e-6);
  poses[2] = ToTransform(SE2(8, 0, 0));
  const auto optimized = optimizer.optimize(2, poses, links);
  EXPECT_EQ(optimized.at(2).x(), 8);
  EXPECT_NEAR(optimized.at(1).x(), 7, 1e-5);
}

TEST_F(RtabmapPairTest, FailuresGiveAnEmptyMapAndSayWhy) {
  EXPECT_EQ(optimizer.optimize(1, poses, links).size(), 2u);
  EXPECT_TRUE(optimizer.optimize(7, poses, links).empty());
  EXPECT_EQ(optimizer.last_status().message(), "the root 7 has no pose");
  auto more = links;
  more.emplace(2, Link(2, 2, Link::kGravity, ToTransform(SE2()), ToMat(I)));
  EXPECT_TRUE(optimizer.optimize(1, poses, more).empty());
  EXPECT_EQ(optimizer.last_status().message(), "link 2 -> 2: gravity is not taken");
  more = links;
  more.emplace(2, Link(2, 2, Link::kNeighbor, ToTransform(SE2()), ToMat(I)));
  EXPECT_TRUE(optimizer.optimize(1, poses, more).empty());
  EXPECT_EQ(optimizer.last_status().message(), "link 2 -> 2: a self link that is no prior");
  more = links;
  more.emplace(2, MakeLink(2, 3, SE2(), I));
  EXPECT_TRUE(optimizer.optimize(1, poses, more).empty());
  EXPECT_EQ(optimizer.last_status().message(), "edge 2 -> 3: no node 3");
  more = links;
  more.emplace(1, MakeLink(1, 2, SE2(), -I));
  EXPECT_TRUE(optimizer.optimize(1, poses, more).empty());
  EXPECT_EQ(optimizer.optimize(1, poses, links).size(), 2u);
  EXPECT_TRUE(optimizer.last_status().ok());
}

}  // namespace
}  // namespace hpgo
