// Ends the program with a message: what a fuzz target calls a finding.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>

namespace hpgo {

inline void Require(bool ok, const std::string& what) {
  if (ok) return;
  std::fprintf(stderr, "%s\n", what.c_str());
  std::abort();
}

}  // namespace hpgo
