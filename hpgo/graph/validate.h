// What makes a value unusable: one judgement, in the same words, for files, graphs and calls.
#pragma once

#include <string>

#include "hpgo/graph/pose_graph.h"

namespace hpgo {

// Coordinates (m) and entries of an information matrix beyond this are refused: their products
// would leave the range of a double.
inline constexpr double kLargestValue = 1e50;
// A quaternion is zero if no coefficient reaches this. Any other is normalized, whatever its
// length.
inline constexpr double kZeroQuaternion = 1e-9;

// What follows "the pose" in a message: "is not finite", "is too large", "has a zero quaternion";
// empty if the value can be used.
std::string PoseProblem(const SE2& pose);
std::string PoseProblem(const SE3& pose);
std::string PoseProblem(const YawPose& pose);

// A message of its own: "information is not symmetric", "... is too large", or those of
// ceres_costs::InformationProblem; empty if the matrix can be used. For N = 2, 3, 4, 6.
template <int N>
std::string InformationProblem(const Eigen::Matrix<double, N, N>& information);

// For messages: "edge 3 -> 7", "prior of node 3".
std::string EdgeName(NodeId i, NodeId j);
std::string PriorName(NodeId id);

// kInvalidArgument, `what` first.
template <typename G>
Status CheckPose(const G& pose, const std::string& what);
template <typename G>
Status CheckMeasurement(const G& measurement, const typename G::Matrix& information,
                        const std::string& what);

// The first node, edge or prior whose values cannot be used. Poses that a node does not have are
// not looked at.
template <typename G>
Status CheckGraph(const PoseGraph<G>& graph);

}  // namespace hpgo
