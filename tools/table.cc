#include "tools/table.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace hpgo_cli {
namespace {

std::vector<std::string> SplitCells(std::string_view line) {
  std::vector<std::string> cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t comma = std::min(line.find(',', begin), line.size());
    cells.emplace_back(line.substr(begin, comma - begin));
    begin = comma + 1;
  }
  return cells;
}

}  // namespace

std::optional<std::size_t> Table::Find(const std::string& column) const {
  const auto found = std::find(columns.begin(), columns.end(), column);
  if (found == columns.end()) return std::nullopt;
  return static_cast<std::size_t>(found - columns.begin());
}

std::string Table::Place(std::size_t row) const { return name + ":" + std::to_string(row + 2); }

hpgo::Result<Table> ParseTable(std::string_view text, const std::string& name) {
  Table table;
  table.name = name;
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.remove_suffix(1);
  if (text.empty()) return hpgo::Status(hpgo::StatusCode::kMalformed, name + ": is empty");
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    std::vector<std::string> cells = SplitCells(line);
    if (table.columns.empty()) {
      table.columns = std::move(cells);
      continue;
    }
    table.rows.push_back(std::move(cells));
    if (table.rows.back().size() != table.columns.size()) {
      return hpgo::Status(hpgo::StatusCode::kMalformed,
                          table.Place(table.rows.size() - 1) + ": has " +
                              std::to_string(table.rows.back().size()) + " cells, the first line " +
                              std::to_string(table.columns.size()));
    }
  }
  return table;
}

hpgo::Result<std::optional<double>> NumberAt(const Table& table, std::size_t row,
                                             std::size_t column) {
  const std::string& cell = table.rows[row][column];
  if (cell.empty()) return std::optional<double>();
  char* end = nullptr;
  const double value = std::strtod(cell.c_str(), &end);
  if (*end == '\0' && std::isfinite(value)) return std::optional<double>(value);
  return hpgo::Status(
      hpgo::StatusCode::kMalformed,
      table.Place(row) + ": '" + cell + "' in column " + table.columns[column] + " is no number");
}

}  // namespace hpgo_cli
