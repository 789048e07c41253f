// slam_toolbox's solver plugin.
#pragma once

#include <karto_sdk/Mapper.h>

#include "hpgo/adapters/karto_scan_solver.h"

namespace solver_plugins {

// The parameters:
//   hpgo_loss (string, "None"): "None", "HuberLoss" or "CauchyLoss", of every link
//   hpgo_loss_scale (double, 0.7): in units of the whitened error
//   hpgo_preset (string, "accurate"): "accurate" or "fast"; see OptimizerOptions
//   hpgo_min_correction_distance, hpgo_min_correction_angle (double, 1e-4 m, 1e-4 rad): scans that
//     have moved by less are not returned as corrected
class HpgoSolver
    : public hpgo::KartoScanSolver<karto::ScanSolver, karto::Vertex<karto::LocalizedRangeScan>,
                                   karto::Edge<karto::LocalizedRangeScan>, karto::LinkInfo,
                                   karto::Pose2> {
  template <typename T>
  struct Argument;
  template <typename Class, typename T>
  struct Argument<void (Class::*)(T)> {
    using Type = T;
  };

 public:
  // A node, or a lifecycle node in later releases.
  using NodePointer = Argument<decltype(&karto::ScanSolver::Configure)>::Type;
  void Configure(NodePointer node) override;
  void Compute() override;

 private:
  NodePointer node_;
};

}  // namespace solver_plugins
