#include "hpgo/solve/graduated_loss.h"

#include <cmath>

#include "ceres_costs/losses.h"
#include "glog/logging.h"

namespace hpgo {

std::vector<std::unique_ptr<ceres::LossFunction>> GraduatedLosses(const std::string& name,
                                                                  double scale) {
  std::vector<std::unique_ptr<ceres::LossFunction>> losses;
  const auto add = [&](const std::string& loss, double at) {
    std::string error;
    CHECK(ceres_costs::MakeLoss(loss, at, &losses.emplace_back(), &error)) << error;
  };
  const bool of_square = name == "dcs";  // its scale bounds s = e' Omega e, not the error
  if (of_square || name == "tukey" || name == "geman_mcclure" || name == "gm") {
    add("huber", of_square ? std::sqrt(scale) : scale);
    for (const double factor : {4., 2.}) add(name, scale * (of_square ? factor * factor : factor));
  }
  add(name, scale);
  return losses;
}

}  // namespace hpgo
