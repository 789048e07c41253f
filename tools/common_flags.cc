#include "tools/common_flags.h"

#include "hpgo/solve/full_solve.h"

namespace {
// A default of the solver stands in its options alone.
const hpgo::FullSolveOptions kSolve;
}  // namespace

DEFINE_bool(quiet, false, "print no messages and no progress; warnings and errors remain");
DEFINE_string(output, "", "the file to write; - is the standard output");
DEFINE_string(stats_json, "",
              "write counts, costs and times to this file as JSON; - is the standard output");
DEFINE_string(json, "", "write the figures to this file as JSON; - is the standard output");
DEFINE_string(title, "", "the line above the picture");
DEFINE_uint64(seed, 1, "the seed of all random numbers; equal seeds give equal results");

DEFINE_bool(strict, false, "unknown tags and other oddities in the input are errors");
DEFINE_bool(project_information, false,
            "replace information matrices that are not positive semi-definite by the nearest that "
            "are, instead of rejecting the file");
DEFINE_bool(identity_information, false,
            "take the identity for the information of edges and priors that give none, instead of "
            "rejecting the file");
DEFINE_bool(create_missing, false,
            "compose the pose of a node that only edges name, instead of rejecting the file");
DEFINE_bool(row_major_edge2, false,
            "the information of EDGE2 lines is in row-major order, as RTAB-Map and GTSAM write it, "
            "not in TORO's");

DEFINE_string(error, "g2o",
              "the error of an edge: g2o (translation and quaternion vector part; x, y, theta in "
              "2D) or log (the logarithm of the pose)");
DEFINE_string(loss, kSolve.loss,
              "the robust loss: none, huber, cauchy, tukey, geman_mcclure or dcs");
DEFINE_double(loss_scale, kSolve.loss_scale,
              "the whitened error (standard deviations) at which the robust loss begins to bend");
DEFINE_string(loss_on, "closures", "the edges with the robust loss: closures or all");

DEFINE_string(
    init, "auto",
    "where the poses start: file, odometry, spanning_tree, chordal, joint_chordal, or auto (the "
    "one with the lowest cost and, where the graph is small or the result fits badly, others too: "
    "the lowest end counts)");
DEFINE_string(engine, "block",
              "the solver: block (the fast one) or ceres; both end at the same optimum");
DEFINE_int32(
    max_iterations, kSolve.max_iterations,
    "the largest number of iterations; work ends it too, 3e8 evaluations of an edge, though "
    "never before 200");
DEFINE_double(max_seconds, kSolve.max_seconds,
              "the time limit in seconds; the best result so far is written");

DEFINE_int32(dof, 0,
             "what of the poses of a 3D file is estimated: 6, all, or 4, x, y, z and yaw, where z "
             "is up and the roll and pitch of its vertices are right; 0: all, in 2D too");

DEFINE_int32(max_top_nodes, 0,
             "a top level with more nodes gets another one above it; 0: the default");
DEFINE_int32(max_top_edges, 0, "so does one with more edges; 0: the default");

DEFINE_string(reference, "", "true poses to compare with: a g2o, TORO, KITTI or TUM file");
DEFINE_bool(by_order, false,
            "match poses one by one where no time or id agrees, instead of refusing");
DEFINE_string(plane, "",
              "the ground plane on which 3D poses are seen in 2D: xy (z up) or xz (a camera's "
              "frame, as KITTI's: planar x = z, planar y = -x)");

ceres_costs::ErrorConvention ConventionOfFlag() {
  return FLAGS_error == "log" ? ceres_costs::ErrorConvention::kTwist
                              : ceres_costs::ErrorConvention::kG2o;
}

bool IsOutputFlag(const std::string& name) {
  for (const char* output : {"output", "stats_json", "json", "stats_csv", "summary_csv",
                             "ground_truth", "chart", "save"}) {
    if (name == output) return true;
  }
  return false;
}
