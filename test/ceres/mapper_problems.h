// ceres::Problems as mappers build them: their blocks, manifolds, shapes of costs, losses and what
// they hold, over any pose graph.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "ceres/loss_function.h"
#include "ceres/manifold.h"
#include "ceres/problem.h"
#include "ceres_costs/se2.h"
#include "ceres_costs/se3.h"
#include "hpgo/graph/pose_graph.h"

namespace hpgo {

enum class Mapper2d {
  kCeresExample,  // scalars x, y, yaw; whitened by L; first pose held
  kSlamToolbox,   // the same, contiguous; Cauchy on all; persistent
  kRtabMap,       // the same, root held
  kCartographer,  // one block x y theta without manifold; Huber on loops; first held
};
enum class Mapper3d {
  kCeresExample,  // p, q x y z w
  kRtabMap,       // the same, root held
  kCartographer,  // q w x y z, t; t of the first held and its yaw; Huber on loops
  kVins6,         // q w x y z, t; Huber on loops
  kVinsGlobal,    // the same, Huber on positions, nothing held
  kFuse,          // p, q w x y z, own right manifold with the full angle; a loss a constraint
  kOkvis,         // one block t, q x y z w; own manifold; analytic
  kOv2slam,       // the same, left SE(3) manifold, lifted Jacobians
  kCovins,        // one block q x y z w, t; extrinsics held; Cauchy on loops
  kOpenLidarMap,  // one block t, q, product manifold; Cauchy; Tukey on absolute poses
  kVins4,         // yaw in degrees, t; roll and pitch inside the cost; Huber on loops
  kVoxgraph,      // one block x y z yaw
};
constexpr Mapper2d kMappers2d[] = {Mapper2d::kCeresExample, Mapper2d::kSlamToolbox,
                                   Mapper2d::kRtabMap, Mapper2d::kCartographer};
constexpr Mapper3d kMappers3d[] = {
    Mapper3d::kCeresExample, Mapper3d::kRtabMap,      Mapper3d::kCartographer, Mapper3d::kVins6,
    Mapper3d::kVinsGlobal,   Mapper3d::kFuse,         Mapper3d::kOkvis,        Mapper3d::kOv2slam,
    Mapper3d::kCovins,       Mapper3d::kOpenLidarMap, Mapper3d::kVins4,        Mapper3d::kVoxgraph};
const char* MapperName(Mapper2d mapper);
const char* MapperName(Mapper3d mapper);

// A problem with the memory of its blocks.
struct MapperProblem {
  std::vector<std::vector<double>> storage;  // by pose: all its blocks, one behind the other
  std::vector<std::vector<int>> sizes;       // of these blocks
  std::vector<std::vector<double>> extra;    // extrinsics and the like
  // The manifolds and losses that the problem does not own.
  std::vector<std::unique_ptr<ceres::Manifold>> manifolds;
  std::vector<std::unique_ptr<ceres::LossFunction>> losses;
  std::unique_ptr<ceres::Problem> problem;

  double* Block(int pose, int k) {
    double* values = storage[pose].data();
    for (int b = 0; b < k; ++b) values += sizes[pose][b];
    return values;
  }
};

// `graph`: poses are the start. Scaled noise and units are the graph's own.
std::unique_ptr<MapperProblem> MakeMapperProblem(Mapper2d mapper,
                                                 const PoseGraph<ceres_costs::SE2>& graph);
std::unique_ptr<MapperProblem> MakeMapperProblem(Mapper3d mapper,
                                                 const PoseGraph<ceres_costs::SE3>& graph);

}  // namespace hpgo
