// A table of comma-separated values with a line of names first.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hpgo/graph/status.h"

namespace hpgo_cli {

struct Table {
  std::string name;  // of the file, for messages
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;  // as many cells each as there are columns

  std::optional<std::size_t> Find(const std::string& column) const;
  // "FILE:LINE", counted from one, of a row.
  std::string Place(std::size_t row) const;
};

// Cells are taken as they stand: no quotes. Blank lines are skipped at the end only. kMalformed
// with the line for one with too few or too many cells, and for a text without any line.
hpgo::Result<Table> ParseTable(std::string_view text, const std::string& name);

// The number in a cell; nothing where it is empty. kMalformed where it holds something else.
hpgo::Result<std::optional<double>> NumberAt(const Table& table, std::size_t row,
                                             std::size_t column);

}  // namespace hpgo_cli
