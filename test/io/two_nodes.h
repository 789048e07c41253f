// The beginnings of graph files, for what the tests of the readers add to them.
#pragma once

#include <string>

#include "hpgo/io/g2o_reader.h"

namespace hpgo {

inline constexpr char kTwo[] = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\n";
inline constexpr char kEdge[] = "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n";
inline constexpr char kTwo3d[] =
    "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 1 0 0 0 0 0 1\n";
inline constexpr char kUnit3d[] = " 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n";

inline std::string Two(const std::string& rest) { return kTwo + rest; }
inline std::string Two3d(const std::string& rest) { return kTwo3d + rest; }

inline ReadOptions Strict() {
  ReadOptions options;
  options.strict = true;
  return options;
}

}  // namespace hpgo
