// The numbers of a line as poses and information matrices.
#pragma once

#include "ceres_costs/se2.h"
#include "ceres_costs/se3.h"
#include "hpgo/io/read_report.h"
#include "hpgo/io/record_tags.h"

namespace hpgo {

// Off unit length by more than this, a quaternion is reported.
inline constexpr double kQuaternionTolerance = 1e-3;

enum class QuaternionState { kUnit, kNormalized, kZero };

// Makes q = (x y z w) a unit quaternion. One that is so within 1e-12 stays as it is, bit for bit;
// kNormalized means off by more than kQuaternionTolerance, kZero that it holds no rotation.
// `norm` is that of the input.
QuaternionState NormalizeQuaternion(double* q, double* norm);

// A pose from `count` numbers, as RecordTag::pose describes them. What they do not give is zero.
QuaternionState ToPose(const double* numbers, int count, ceres_costs::SE2* pose, double* norm);
QuaternionState ToPose(const double* numbers, int count, ceres_costs::SE3* pose, double* norm);

// The information matrix of the g2o error from the numbers of a line with this tag; zero where they
// say nothing. `order` is that of InformationForm::kToro. Those of EDGE3 weigh Euler angles, for
// small errors twice the vector part of the quaternion, which is the g2o error.
void ToInformation(const double* numbers, const RecordTag& tag, Edge2Order order,
                   ceres_costs::SE2::Matrix* information);
void ToInformation(const double* numbers, const RecordTag& tag, Edge2Order order,
                   ceres_costs::SE3::Matrix* information);

}  // namespace hpgo
