#include "hpgo_solver.hpp"

#include <memory>
#include <pluginlib/class_list_macros.hpp>
#include <string>
#include <type_traits>
#include <utility>

#include "ceres_costs/losses.h"

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
  std::unique_ptr<ceres::LossFunction> loss;
  std::string error;
  if (loss_name == "HuberLoss" || loss_name == "CauchyLoss") {
    const char* name = loss_name == "HuberLoss" ? "huber" : "cauchy";
    if (!ceres_costs::MakeLoss(name, loss_scale, &loss, &error)) {
      RCLCPP_ERROR(node->get_logger(), "hpgo_loss_scale: %s", error.c_str());
    }
  } else if (loss_name != "None") {
    RCLCPP_ERROR(node->get_logger(), "hpgo_loss is '%s', must be None, HuberLoss or CauchyLoss",
                 loss_name.c_str());
  }
  const auto options = hpgo::OptimizerOptions::FromName(preset);
  if (!options.ok()) {
    RCLCPP_ERROR(node->get_logger(), "hpgo_preset: %s", options.status().message().c_str());
  }
  const hpgo::Status status = SetOptions(options.ok() ? *options : hpgo::OptimizerOptions(),
                                         std::move(loss), distance, angle);
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
