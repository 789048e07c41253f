// What hpgo optimize has read and found: for people, and as JSON.
#pragma once

#include <cstddef>
#include <string>

#include "hpgo/io/g2o_reader.h"
#include "hpgo/solve/full_solve.h"
#include "nlohmann/json.hpp"

namespace hpgo_cli {

// What a file holds.
struct InputFigures {
  std::string name;
  int dimension = 0;
  std::size_t nodes = 0, edges = 0, priors = 0;
  double seconds = 0;  // it took to read
};

void DescribeInput(const InputFigures& input, const hpgo::ReadReport& report);
nlohmann::ordered_json InputJson(const InputFigures& input, const hpgo::ReadReport& report);

// With what the flags of the solve say.
void DescribeResult(const hpgo::FullSolveReport& report);
nlohmann::ordered_json ResultJson(const hpgo::FullSolveReport& report);

}  // namespace hpgo_cli
