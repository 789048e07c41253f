// hpgo chart: curves from the columns of a table.
#include <algorithm>
#include <string>
#include <vector>

#include "hpgo/io/input_text.h"
#include "hpgo/io/output_file.h"
#include "hpgo/report/line_chart.h"
#include "tools/command.h"
#include "tools/commands.h"
#include "tools/common_flags.h"
#include "tools/console.h"
#include "tools/table.h"

DEFINE_string(x, "", "the column along the horizontal axis; the first one if not given");
DEFINE_string(
    y, "",
    "the columns to draw, separated by commas, each as COLUMN or COLUMN=NAME with the name "
    "for the legend; all others if not given");
DEFINE_string(by, "", "a curve for each value of this column, in order of appearance");
DEFINE_bool(log, false, "logarithmic axes; values that are not positive are left out");
DEFINE_string(x_label, "", "the text at the horizontal axis; the name of its column if not given");
DEFINE_string(y_label, "", "the text at the vertical axis");

namespace hpgo_cli {
namespace {

using hpgo::Status;
using hpgo::StatusCode;

std::vector<std::string> SplitNames(const std::string& text) {
  std::vector<std::string> names;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t comma = std::min(text.find(',', begin), text.size());
    names.push_back(text.substr(begin, comma - begin));
    begin = comma + 1;
  }
  return names;
}

Status FindColumn(const Table& table, const std::string& name, std::size_t* column) {
  const std::optional<std::size_t> found = table.Find(name);
  if (found.has_value()) {
    *column = *found;
    return Status::Ok();
  }
  std::string names;
  for (const std::string& known : table.columns) names += (names.empty() ? "" : ", ") + known;
  return Status(StatusCode::kInvalidArgument,
                table.name + " has no column '" + name + "'; it has " + names);
}

// One curve a column and value of the column `by`; points in the order of the lines.
Status AddSeries(const Table& table, std::size_t x, std::size_t y, const std::string& y_name,
                 const std::optional<std::size_t>& by, bool several_columns,
                 std::vector<hpgo::ChartSeries>* series) {
  const std::size_t first = series->size();
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const auto x_value = NumberAt(table, row, x), y_value = NumberAt(table, row, y);
    if (!x_value.ok()) return x_value.status();
    if (!y_value.ok()) return y_value.status();
    std::string name = y_name;
    if (by.has_value()) name = table.rows[row][*by] + (several_columns ? " " + y_name : "");
    auto one = std::find_if(series->begin() + static_cast<std::ptrdiff_t>(first), series->end(),
                            [&name](const hpgo::ChartSeries& s) { return s.name == name; });
    if (one == series->end()) {
      series->emplace_back();
      one = series->end() - 1;
      one->name = name;
    }
    if (!x_value->has_value() || !y_value->has_value()) continue;
    if (FLAGS_log && !(**x_value > 0 && **y_value > 0)) continue;
    one->x.push_back(**x_value);
    one->y.push_back(**y_value);
  }
  return Status::Ok();
}

Status MakeSeries(const Table& table, std::vector<hpgo::ChartSeries>* series, std::string* x_name) {
  std::size_t x = 0;
  if (!FLAGS_x.empty()) {
    const Status status = FindColumn(table, FLAGS_x, &x);
    if (!status.ok()) return status;
  }
  *x_name = table.columns[x];
  std::optional<std::size_t> by;
  if (!FLAGS_by.empty()) {
    std::size_t column = 0;
    const Status status = FindColumn(table, FLAGS_by, &column);
    if (!status.ok()) return status;
    by = column;
  }
  std::vector<std::string> names = SplitNames(FLAGS_y);
  if (names.empty()) {
    for (std::size_t k = 0; k < table.columns.size(); ++k) {
      if (k != x && (!by.has_value() || k != *by)) names.push_back(table.columns[k]);
    }
  }
  for (const std::string& item : names) {
    const std::size_t equals = item.find('=');
    const std::string name = equals == std::string::npos ? item : item.substr(equals + 1);
    std::size_t y = 0;
    Status status = FindColumn(table, item.substr(0, equals), &y);
    if (status.ok()) status = AddSeries(table, x, y, name, by, names.size() > 1, series);
    if (!status.ok()) return status;
  }
  constexpr std::size_t kMaxMarked = 60;
  for (hpgo::ChartSeries& one : *series) one.markers = one.x.size() <= kMaxMarked;
  return Status::Ok();
}

int Run(const std::vector<std::string>& arguments) {
  if (FLAGS_output.empty()) return FailUsage("--output=FILE.svg is required");
  const hpgo::Result<hpgo::InputText> input = hpgo::InputText::Read(arguments[0]);
  if (!input.ok()) return Fail(input.status());
  const hpgo::Result<Table> table = ParseTable(input->text(), input->name());
  if (!table.ok()) return Fail(table.status());
  std::vector<hpgo::ChartSeries> series;
  hpgo::LineChartOptions options;
  const Status status = MakeSeries(*table, &series, &options.x_label);
  if (!status.ok()) return Fail(status);
  options.title = FLAGS_title;
  if (!FLAGS_x_label.empty()) options.x_label = FLAGS_x_label;
  options.y_label = FLAGS_y_label;
  options.log_x = options.log_y = FLAGS_log;
  const hpgo::Result<std::string> svg = hpgo::LineChartSvg(series, options);
  if (!svg.ok()) return Fail(svg.status());
  const Status written = hpgo::WriteTextFile(FLAGS_output, *svg);
  if (!written.ok()) return Fail(written);
  if (FLAGS_output != "-") Message("wrote " + FLAGS_output);
  return kExitOk;
}

}  // namespace

const Command& ChartCommand() {
  static const Command* command =
      new Command{"chart",
                  "TABLE",
                  "Draws columns of a CSV file as curves, as SVG.",
                  1,
                  1,
                  {"x", "y", "by", "log", "title", "x_label", "y_label", "output"},
                  &Run,
                  "The first line names the columns. Cells may be empty.\n\n"
                  "Examples:\n"
                  "  hpgo chart updates.csv --x=nodes --y=latency_us --output=latency.svg\n"
                  "  hpgo chart summary.csv --x=nodes --y=all_cpu_p50_ms=p50,all_cpu_p99_ms=p99 "
                  "--by=engine \\\n"
                  "      --log --output=latency.svg\n"};
  return *command;
}

}  // namespace hpgo_cli
