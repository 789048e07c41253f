#include "ceres_costs/losses.h"

#include <cmath>
#include <sstream>

namespace ceres_costs {
namespace {

class GemanMcClureLoss final : public ceres::LossFunction {
 public:
  explicit GemanMcClureLoss(double scale) : inverse_(1 / (scale * scale)) {}
  void Evaluate(double s, double rho[3]) const override {
    const double q = 1 / (1 + s * inverse_);
    rho[0] = s * q;
    rho[1] = q * q;
    rho[2] = -2 * inverse_ * q * q * q;
  }

 private:
  const double inverse_;  // 1 / k^2
};

class DynamicCovarianceScalingLoss final : public ceres::LossFunction {
 public:
  explicit DynamicCovarianceScalingLoss(double phi) : phi_(phi) {}
  void Evaluate(double s, double rho[3]) const override {
    if (s <= phi_) {
      rho[0] = s;
      rho[1] = 1;
      rho[2] = 0;
      return;
    }
    const double scale = 2 * phi_ / (phi_ + s);
    rho[0] = 2 * scale * s - phi_;
    rho[1] = scale * scale;
    rho[2] = -2 * scale * scale / (phi_ + s);
  }

 private:
  const double phi_;
};

}  // namespace

const char* LossNames() { return "none, huber, cauchy, tukey, geman_mcclure (gm), dcs"; }

bool MakeLoss(const std::string& name, double scale, std::unique_ptr<ceres::LossFunction>* loss,
              std::string* error) {
  if (name == "none") {
    loss->reset();
    return true;
  }
  const bool known = name == "huber" || name == "cauchy" || name == "tukey" ||
                     name == "geman_mcclure" || name == "gm" || name == "dcs";
  if (!known) {
    *error = "unknown loss \"" + name + "\"; known: " + LossNames();
    return false;
  }
  if (!(scale > 0) || !std::isfinite(scale)) {
    std::ostringstream message;
    message << "the scale of loss \"" << name << "\" is " << scale
            << "; it must be positive and finite";
    *error = message.str();
    return false;
  }
  if (name == "huber") {
    *loss = std::make_unique<ceres::HuberLoss>(scale);
  } else if (name == "cauchy") {
    *loss = std::make_unique<ceres::CauchyLoss>(scale);
  } else if (name == "tukey") {
    *loss = std::make_unique<ceres::TukeyLoss>(scale);
  } else if (name == "dcs") {
    *loss = std::make_unique<DynamicCovarianceScalingLoss>(scale);
  } else {
    *loss = std::make_unique<GemanMcClureLoss>(scale);
  }
  return true;
}

}  // namespace ceres_costs
