#include <utility>

#include "Eigen/Cholesky"
#include "ceres/autodiff_cost_function.h"
#include "ceres/autodiff_manifold.h"
#include "ceres/product_manifold.h"
#include "ceres_costs/manifolds.h"
#include "hpgo/graph/edge_classes.h"
#include "test/ceres/mapper_costs_3d.h"
#include "test/ceres/mapper_problems.h"

namespace hpgo {
namespace {

using namespace mappers;

class Builder {
 public:
  Builder(Mapper3d mapper, const PoseGraph<SE3>& graph)
      : mapper_(mapper), graph_(graph), result_(std::make_unique<MapperProblem>()) {}

  std::unique_ptr<MapperProblem> Run() {
    ceres::Problem::Options options;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    result_->problem = std::make_unique<ceres::Problem>(options);
    const std::vector<bool> loops = LoopClosures(graph_);
    switch (mapper_) {
      case Mapper3d::kCeresExample:
      case Mapper3d::kRtabMap:
        Build<Layout::kTQ>({3, 4}, loops);
        break;
      case Mapper3d::kCartographer:
      case Mapper3d::kVins6:
      case Mapper3d::kVinsGlobal:
        Build<Layout::kQwT>({4, 3}, loops);
        break;
      case Mapper3d::kFuse:
        Build<Layout::kTQw>({3, 4}, loops);
        break;
      case Mapper3d::kOkvis:
      case Mapper3d::kOv2slam:
      case Mapper3d::kOpenLidarMap:
        Build<Layout::k7TQ>({7}, loops);
        break;
      case Mapper3d::kCovins:
        Build<Layout::k7QT>({7}, loops);
        break;
      case Mapper3d::kVins4:
      case Mapper3d::kVoxgraph:
        BuildYaw(loops);
        break;
    }
    return std::move(result_);
  }

 private:
  ceres::Problem& problem() { return *result_->problem; }
  ceres::LossFunction* Own(ceres::LossFunction* loss) {
    result_->losses.emplace_back(loss);
    return loss;
  }
  ceres::Manifold* Own(ceres::Manifold* manifold) {
    result_->manifolds.emplace_back(manifold);
    return manifold;
  }

  ceres::Manifold* MakeManifold() {
    switch (mapper_) {
      case Mapper3d::kCeresExample:
      case Mapper3d::kRtabMap:
        return Own(new ceres::EigenQuaternionManifold);
      case Mapper3d::kCartographer:
      case Mapper3d::kVins6:
      case Mapper3d::kVinsGlobal:
        return Own(new ceres::QuaternionManifold);
      case Mapper3d::kFuse:
        return Own(new ceres::AutoDiffManifold<RightFullAngle, 4, 3>);
      case Mapper3d::kOkvis:
        return Own(new ceres_costs::PoseManifold<SE3>);
      case Mapper3d::kOv2slam:
        return Own(new LeftLiftedManifold);
      case Mapper3d::kCovins:
        return Own(new ceres::ProductManifold<ceres::EigenQuaternionManifold,
                                              ceres::EuclideanManifold<3>>);
      default:
        return Own(new ceres::ProductManifold<ceres::EuclideanManifold<3>,
                                              ceres::EigenQuaternionManifold>);
    }
  }

  template <Layout kLayout>
  void Build(const std::vector<int>& sizes, const std::vector<bool>& loops) {
    using Error = RelativeError<kLayout>;
    for (const GraphNode<SE3>& node : graph_.nodes()) {
      result_->storage.emplace_back(7);
      result_->sizes.push_back(sizes);
      WritePose(kLayout, node.pose, result_->storage.back().data());
    }
    ceres::LossFunction* loss = nullptr;
    if (mapper_ == Mapper3d::kCartographer || mapper_ == Mapper3d::kVins6) {
      loss = Own(new ceres::HuberLoss(1));
    }
    if (mapper_ == Mapper3d::kCovins || mapper_ == Mapper3d::kOpenLidarMap) {
      loss = Own(new ceres::CauchyLoss(50));
    }
    if (mapper_ == Mapper3d::kCovins) {
      // The camera in the body, the same for all; a pose as the others are.
      result_->extra = {{0.1, -0.2, 0.05, 0.9, 0.3, 0.1, -0.2}};
      Eigen::Map<Eigen::Vector4d>(result_->extra[0].data()).normalize();
    }
    for (std::size_t e = 0; e < graph_.edges().size(); ++e) {
      const GraphEdge<SE3>& edge = graph_.edges()[e];
      double* a = result_->Block(edge.i, 0);
      double* b = result_->Block(edge.j, 0);
      ceres::LossFunction* its_loss = loops[e] ? loss : nullptr;
      if (mapper_ == Mapper3d::kFuse) its_loss = Own(new ceres::HuberLoss(loops[e] ? 1 : 5));
      const Error error{edge.measurement, Whitening(edge)};
      if (mapper_ == Mapper3d::kOv2slam) {
        problem().AddResidualBlock(
            new LiftedCost(edge.measurement, edge.information.llt().matrixU()), its_loss, a, b);
      } else if (mapper_ == Mapper3d::kCovins) {
        double* extrinsic = result_->extra[0].data();
        Error moved = error;
        const SE3 E = ReadPose<kLayout>(extrinsic, extrinsic + 4);
        moved.z = E.Inverse() * error.z * E;
        // Ceres takes a block once a residual: the second extrinsic has a copy.
        if (result_->extra.size() == 1) result_->extra.push_back(result_->extra[0]);
        extrinsic = result_->extra[0].data();
        problem().AddResidualBlock(
            new ceres::AutoDiffCostFunction<Error, 6, 7, 7, 7, 7>(new Error(moved)), its_loss, a, b,
            extrinsic, result_->extra[1].data());
        for (const auto& extra : result_->extra) {
          problem().SetParameterBlockConstant(const_cast<double*>(extra.data()));
        }
      } else if (sizes.size() == 1) {
        problem().AddResidualBlock(
            new ceres::AutoDiffCostFunction<Error, 6, 7, 7>(new Error(error)), its_loss, a, b);
      } else if (sizes[0] == 3) {
        problem().AddResidualBlock(
            new ceres::AutoDiffCostFunction<Error, 6, 3, 4, 3, 4>(new Error(error)), its_loss, a,
            a + 3, b, b + 3);
      } else {
        problem().AddResidualBlock(
            new ceres::AutoDiffCostFunction<Error, 6, 4, 3, 4, 3>(new Error(error)), its_loss, a,
            a + 4, b, b + 4);
      }
    }
    ceres::Manifold* manifold = MakeManifold();
    for (std::size_t p = 0; p < graph_.nodes().size(); ++p) {
      const int k = sizes.size() == 2 && sizes[0] == 3 ? 1 : 0;
      double* block = result_->Block(static_cast<int>(p), k);
      if (problem().HasParameterBlock(block)) problem().SetManifold(block, manifold);
    }
    Hold();
  }

  void Hold() {
    if (mapper_ == Mapper3d::kVinsGlobal) {
      ceres::LossFunction* loss = Own(new ceres::HuberLoss(1));
      for (std::size_t p = 0; p < graph_.nodes().size(); p += 10) {
        problem().AddResidualBlock(new ceres::AutoDiffCostFunction<PositionError, 3, 3>(
                                       new PositionError{graph_.nodes()[p].pose.translation(), 1}),
                                   loss, result_->Block(static_cast<int>(p), 1));
      }
    } else if (mapper_ == Mapper3d::kOpenLidarMap) {
      ceres::LossFunction* loss = Own(new ceres::TukeyLoss(500));
      for (std::size_t p = 0; p < graph_.nodes().size(); p += 50) {
        problem().AddResidualBlock(
            new ceres::AutoDiffCostFunction<AbsoluteError, 6, 7>(
                new AbsoluteError{graph_.nodes()[p].pose, Matrix6d::Identity()}),
            p == 0 ? nullptr : loss, result_->Block(static_cast<int>(p), 0));
      }
    } else if (mapper_ == Mapper3d::kCartographer) {
      problem().SetManifold(result_->Block(0, 0),
                            Own(new ceres::AutoDiffManifold<ConstantYaw, 4, 2>));
      problem().SetParameterBlockConstant(result_->Block(0, 1));
    } else {
      for (std::size_t k = 0; k < result_->sizes[0].size(); ++k) {
        problem().SetParameterBlockConstant(result_->Block(0, static_cast<int>(k)));
      }
    }
  }

  void BuildYaw(const std::vector<bool>& loops) {
    const bool vins = mapper_ == Mapper3d::kVins4;
    for (const GraphNode<SE3>& node : graph_.nodes()) {
      const double* t = node.pose.data();
      const double yaw = YawOf(node.pose);
      result_->sizes.push_back(vins ? std::vector<int>{1, 3} : std::vector<int>{4});
      result_->storage.push_back(vins ? std::vector<double>{yaw * 180 / M_PI, t[0], t[1], t[2]}
                                      : std::vector<double>{t[0], t[1], t[2], yaw});
    }
    ceres::LossFunction* loss = vins ? Own(new ceres::HuberLoss(1)) : nullptr;
    for (std::size_t e = 0; e < graph_.edges().size(); ++e) {
      const GraphEdge<SE3>& edge = graph_.edges()[e];
      const SE3& X_i = graph_.nodes()[edge.i].pose;
      const Eigen::Matrix3d K =
          Eigen::AngleAxisd(-YawOf(X_i), Eigen::Vector3d::UnitZ()).toRotationMatrix() *
          X_i.matrix();
      const double yaw = NormalizeAngle(YawOf(X_i * edge.measurement) - YawOf(X_i));
      double* a = result_->Block(edge.i, 0);
      double* b = result_->Block(edge.j, 0);
      if (vins) {
        problem().AddResidualBlock(
            new ceres::AutoDiffCostFunction<YawError<true>, 4, 1, 3, 1, 3>(
                new YawError<true>{K, edge.measurement.translation(), yaw, 0.1, 0.02}),
            loops[e] ? loss : nullptr, a, a + 1, b, b + 1);
      } else {
        problem().AddResidualBlock(
            new ceres::AutoDiffCostFunction<YawError<false>, 4, 4, 4>(
                new YawError<false>{K, edge.measurement.translation(), yaw, 0.1, 0.02}),
            nullptr, a, b);
      }
    }
    ceres::Manifold* manifold =
        vins ? Own(new ceres::AutoDiffManifold<AngleFunctor<true>, 1, 1>)
             : Own(new ceres::ProductManifold<ceres::EuclideanManifold<3>,
                                              ceres::AutoDiffManifold<AngleFunctor<false>, 1, 1>>);
    for (std::size_t p = 0; p < graph_.nodes().size(); ++p) {
      double* block = result_->Block(static_cast<int>(p), 0);
      if (problem().HasParameterBlock(block)) problem().SetManifold(block, manifold);
    }
    Hold();
  }

  const Mapper3d mapper_;
  const PoseGraph<SE3>& graph_;
  std::unique_ptr<MapperProblem> result_;
};

}  // namespace

const char* MapperName(Mapper3d mapper) {
  switch (mapper) {
    case Mapper3d::kCeresExample:
      return "CeresExample3d";
    case Mapper3d::kRtabMap:
      return "RtabMap3d";
    case Mapper3d::kCartographer:
      return "Cartographer3d";
    case Mapper3d::kVins6:
      return "Vins6Dof";
    case Mapper3d::kVinsGlobal:
      return "VinsGlobalFusion";
    case Mapper3d::kFuse:
      return "Fuse";
    case Mapper3d::kOkvis:
      return "Okvis2";
    case Mapper3d::kOv2slam:
      return "Ov2slam";
    case Mapper3d::kCovins:
      return "Covins";
    case Mapper3d::kOpenLidarMap:
      return "OpenLidarMap";
    case Mapper3d::kVins4:
      return "Vins4Dof";
    case Mapper3d::kVoxgraph:
      return "Voxgraph";
  }
  return "?";
}

std::unique_ptr<MapperProblem> MakeMapperProblem(Mapper3d mapper, const PoseGraph<SE3>& graph) {
  return Builder(mapper, graph).Run();
}

}  // namespace hpgo
