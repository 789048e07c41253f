#include "hpgo_solver.hpp"

#include <memory>
#include <pluginlib/class_list_macros.hpp>
#include <string>
#include <type_traits>

#include "ceres/loss_function.h"

PLUGINLIB_EXPORT_CLASS(solver_plugins::HpgoSolver, karto::ScanSolver)

namespace solver_plugins {
namespace {

template <typename Node, typename T>
T Parameter(Node& node, const std::string& name, const T& value) {
  if (!node.has_parameter(name)) return node.template declare_parameter<T>(name, value);
  if constexpr (std::is_same_v<T, double>) {
    return node.get_parameter(name).as_double();
  } else {
    return node.get_parameter(name).as_string();
  }
}

}  // namespace

void HpgoSolver::Configure(NodePointer node) {
  node_ = node;
  const std::string loss_name = Parameter(*node, "hpgo_loss", std::string("None"));
  const double loss_scale = Parameter(*node, "hpgo_loss_scale", 0.7);
  const std::string preset = Parameter(*node, "hpgo_preset", std::string("accurate"));
  const double distance = Parameter(*node, "hpgo_min_correction_distance", 1e-4);
  const double angle = Parameter(*node, "hpgo_min_correction_angle", 1e-4);
  hpgo::Optimizer2d::Loss loss;
  if (loss_name == "HuberLoss") {
    loss = std::make_shared<ceres::HuberLoss>(loss_scale);
  } else if (loss_name == "CauchyLoss") {
    loss = std::make_shared<ceres::CauchyLoss>(loss_scale);
  } else if (loss_name != "None") {
    RCLCPP_ERROR(node->get_logger(), "hpgo_loss is '%s', must be None, HuberLoss or CauchyLoss",
                 loss_name.c_str());
  }
  const auto options = hpgo::OptimizerOptions::FromName(preset);
  if (!options.ok()) {
    RCLCPP_ERROR(node->get_logger(), "hpgo_preset: %s", options.status().message().c_str());
  }
  const hpgo::Status status =
      SetOptions(options.ok() ? *options : hpgo::OptimizerOptions(), loss, distance, angle);
  if (!status.ok()) {
    RCLCPP_ERROR(node->get_logger(), "hpgo: %s", status.message().c_str());
  }
}

void HpgoSolver::Compute() {
  KartoScanSolver::Compute();
  const hpgo::Status status = last_status();
  if (!status.ok() && node_ != nullptr) {
    RCLCPP_WARN(node_->get_logger(), "hpgo: %s", status.message().c_str());
  }
}

}  // namespace solver_plugins
