#include "ceres_costs/losses.h"

#include <cmath>
#include <sstream>
#include <utility>

namespace ceres_costs {
namespace {

// A loss that knows its name.
class NamedLoss : public ceres::LossFunction {
 public:
  explicit NamedLoss(LossName name) : name_(std::move(name)) {}
  const LossName& name() const { return name_; }

 private:
  const LossName name_;
};

template <typename Loss>
class Named final : public NamedLoss {
 public:
  Named(const char* name, double scale) : NamedLoss({name, scale}), loss_(scale) {}
  void Evaluate(double s, double rho[3]) const override { loss_.Evaluate(s, rho); }

 private:
  const Loss loss_;
};

class GemanMcClureLoss final {
 public:
  explicit GemanMcClureLoss(double scale) : inverse_(1 / (scale * scale)) {}
  void Evaluate(double s, double rho[3]) const {
    const double q = 1 / (1 + s * inverse_);
    rho[0] = s * q;
    rho[1] = q * q;
    rho[2] = -2 * inverse_ * q * q * q;
  }

 private:
  const double inverse_;  // 1 / k^2
};

class DynamicCovarianceScalingLoss final {
 public:
  explicit DynamicCovarianceScalingLoss(double phi) : phi_(phi) {}
  void Evaluate(double s, double rho[3]) const {
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
    *loss = std::make_unique<Named<ceres::HuberLoss>>("huber", scale);
  } else if (name == "cauchy") {
    *loss = std::make_unique<Named<ceres::CauchyLoss>>("cauchy", scale);
  } else if (name == "tukey") {
    *loss = std::make_unique<Named<ceres::TukeyLoss>>("tukey", scale);
  } else if (name == "dcs") {
    *loss = std::make_unique<Named<DynamicCovarianceScalingLoss>>("dcs", scale);
  } else {
    *loss = std::make_unique<Named<GemanMcClureLoss>>("geman_mcclure", scale);
  }
  return true;
}

std::optional<LossName> NameOfLoss(const ceres::LossFunction& loss) {
  const NamedLoss* const named = dynamic_cast<const NamedLoss*>(&loss);
  if (named == nullptr) return std::nullopt;
  return named->name();
}

}  // namespace ceres_costs
