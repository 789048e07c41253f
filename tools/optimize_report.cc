#include "tools/optimize_report.h"

#include "hpgo/solve/initial_guess.h"
#include "tools/common_flags.h"
#include "tools/console.h"

namespace hpgo_cli {

using nlohmann::ordered_json;

namespace {

std::string ConventionText() { return "sum of e' Omega e, " + FLAGS_error + " error"; }

}  // namespace

void DescribeInput(const InputFigures& input, const hpgo::ReadReport& report) {
  Message("read " + Bold(input.name) + ": " + std::to_string(input.dimension) + "D, " +
          Plural(input.nodes, "node") + ", " + Plural(input.edges, "edge") + ", " +
          Plural(input.priors, "prior") + " in " + FormatDuration(input.seconds));
  if (report.edges_only) Message("no vertices: poses are composed from the edges");
}

ordered_json InputJson(const InputFigures& input, const hpgo::ReadReport& report) {
  ordered_json tags = ordered_json::object();
  for (const auto& [tag, count] : report.tags) tags[tag] = count;
  return {{"file", input.name},
          {"dimension", input.dimension},
          {"nodes", input.nodes},
          {"edges", input.edges},
          {"priors", input.priors},
          {"bytes", report.bytes},
          {"lines", report.lines},
          {"tags", tags},
          {"unknown_lines", report.unknown},
          {"landmark_lines", report.landmarks},
          {"duplicate_vertices", report.duplicate_vertices},
          {"normalized_quaternions", report.normalized_quaternions},
          {"semidefinite_informations", report.semidefinite_informations},
          {"projected_informations", report.projected_informations},
          {"created_nodes", report.created_nodes},
          {"edges_only", report.edges_only},
          {"warnings", report.warnings}};
}

void DescribeResult(const hpgo::FullSolveReport& report) {
  Message(Plural(report.components, "component") + ", " +
          Plural(report.loop_closures, "loop closure") + ", " + Plural(report.held_nodes, "node") +
          " held");
  std::string init = std::string("start: ") + hpgo::InitMethodName(report.init);
  if (report.candidates.size() > 1) {
    init += report.runs > 1 ? ", the lowest end of" : ", the lowest cost of";
    for (const hpgo::InitCandidate& candidate : report.candidates) {
      init += std::string(" ") + hpgo::InitMethodName(candidate.method) + " " +
              (candidate.status.ok() ? FormatNumber(candidate.cost) : "(failed)");
      if (report.runs > 1 && candidate.solved) init += " to " + FormatNumber(candidate.end_cost);
    }
  }
  Message(init);
  if (!report.undetermined.empty()) {
    const std::string first = std::to_string(report.undetermined.front());
    Warn((report.undetermined.size() == 1 ? "node " + first + " is not determined"
                                          : Plural(report.undetermined.size(), "node") +
                                                " are not determined, the first of them " + first) +
         ": what is measured leaves a direction open");
  }
  Message("chi2 " + FormatNumber(report.chi2_before) + " -> " +
          Bold(FormatNumber(report.chi2_after)) + " (" + ConventionText() + ")");
  if (FLAGS_loss != "none") {
    Message("cost with " + FLAGS_loss + " " + FormatNumber(report.cost_before) + " -> " +
            FormatNumber(report.cost_after));
  }
  Message(Plural(report.iterations, "iteration") + " in " + FormatDuration(report.seconds) +
          (report.converged ? ", converged" : ", not converged"));
}

ordered_json ResultJson(const hpgo::FullSolveReport& report) {
  ordered_json candidates = ordered_json::array();
  for (const hpgo::InitCandidate& candidate : report.candidates) {
    ordered_json entry = {{"method", hpgo::InitMethodName(candidate.method)},
                          {"seconds", candidate.seconds}};
    if (candidate.status.ok()) {
      entry["cost"] = candidate.cost;
      if (candidate.solved) {
        entry["end_cost"] = candidate.end_cost;
        entry["iterations"] = candidate.iterations;
      }
    } else {
      entry["error"] = candidate.status.message();
    }
    candidates.push_back(entry);
  }
  return {{"status", report.status.ToString()},
          {"converged", report.converged},
          {"engine", FLAGS_engine},
          {"error", FLAGS_error},
          {"loss", FLAGS_loss},
          {"loss_scale", FLAGS_loss_scale},
          {"loss_on", FLAGS_loss_on},
          {"components", report.components},
          {"loop_closures", report.loop_closures},
          {"held_nodes", report.held_nodes},
          {"anchored_nodes", report.anchored},
          {"undetermined_nodes", report.undetermined.size()},
          {"first_undetermined_node", report.undetermined.empty()
                                          ? ordered_json(nullptr)
                                          : ordered_json(report.undetermined.front())},
          {"init", hpgo::InitMethodName(report.init)},
          {"init_candidates", candidates},
          {"runs", report.runs},
          {"chi2_before", report.chi2_before},
          {"chi2_start", report.chi2_start},
          {"chi2_after", report.chi2_after},
          {"cost_before", report.cost_before},
          {"cost_start", report.cost_start},
          {"cost_after", report.cost_after},
          {"iterations", report.iterations},
          {"seconds",
           {{"init", report.init_seconds},
            {"solve", report.solve_seconds},
            {"total", report.seconds}}}};
}

}  // namespace hpgo_cli
