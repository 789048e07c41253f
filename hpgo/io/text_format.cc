#include "hpgo/io/text_format.h"

#include <algorithm>

#include "hpgo/io/line_fields.h"

namespace hpgo {
namespace {

struct Signature {
  std::string_view bytes;  // at the beginning
  std::string_view what;
};

using namespace std::string_view_literals;

// The order matters where one begins like another.
constexpr Signature kBinary[] = {
    {"\x1f\x8b"sv, "data compressed with gzip, unpack it first"sv},
    {"BZh"sv, "data compressed with bzip2, unpack it first"sv},
    {"\xfd"
     "7zXZ\0"sv,
     "data compressed with xz, unpack it first"sv},
    {"\x28\xb5\x2f\xfd"sv, "data compressed with zstd, unpack it first"sv},
    {"\x04\x22\x4d\x18"sv, "data compressed with lz4, unpack it first"sv},
    {"PK\x03\x04"sv, "a ZIP archive, unpack it first"sv},
    {"7z\xbc\xaf\x27\x1c"sv, "a 7z archive, unpack it first"sv},
    {"SQLite format 3\0"sv, "an SQLite database (RTAB-Map's, say): export its graph as g2o"sv},
    {"#ROSBAG"sv, "a ROS bag"sv},
    {"\x89MCAP"sv, "an MCAP log"sv},
    {"\x89HDF"sv, "an HDF5 file"sv},
    {"\x89PNG"sv, "a PNG picture"sv},
    {"%PDF"sv, "a PDF document"sv},
    {"\x7f"
     "ELF"sv,
     "a program"sv},
    {"\xff\xfe\0\0"sv, "UTF-32 text, convert it to UTF-8"sv},
    {"\0\0\xfe\xff"sv, "UTF-32 text, convert it to UTF-8"sv},
    {"\xff\xfe"sv, "UTF-16 text, convert it to UTF-8"sv},
    {"\xfe\xff"sv, "UTF-16 text, convert it to UTF-8"sv},
};

constexpr Signature kText[] = {
    {"version https://git-lfs"sv, "a Git LFS pointer, not the file itself"sv},
    {"# .PCD"sv, "a point cloud (PCD)"sv},
    {"ply\n"sv, "a mesh or point cloud (PLY)"sv},
    {"ply\r"sv, "a mesh or point cloud (PLY)"sv},
    {"%YAML"sv, "YAML"sv},
    {"{"sv, "JSON"sv},
    {"["sv, "JSON"sv},
    {"<"sv, "XML or HTML"sv},
    {"ADD "sv, "commands of g2o's incremental interface (ADD ...)"sv},
};

constexpr std::size_t kLooked = 4096;  // bytes, to tell what the file is

template <std::size_t N>
std::string_view Find(const Signature (&signatures)[N], std::string_view content) {
  for (const Signature& signature : signatures) {
    if (content.substr(0, signature.bytes.size()) == signature.bytes) return signature.what;
  }
  return {};
}

std::string_view TakeLine(std::string_view* text) {
  const std::size_t end = text->find('\n');
  const std::string_view line = text->substr(0, end);
  text->remove_prefix(end == std::string_view::npos ? text->size() : end + 1);
  return line;
}

// How many numbers the line holds if these characters part them and there is nothing else; 0 if
// there is.
int CountNumbers(std::string_view line, char separator) {
  std::string spaced(line.substr(0, kLooked));
  std::replace(spaced.begin(), spaced.end(), separator, ' ');
  LineFields fields(spaced);
  int count = 0;
  for (double number = 0; !fields.AtEnd(); ++count) {
    if (!fields.Read(&number)) return 0;
  }
  return count;
}

std::string DescribeTable(int numbers, const char* separator) {
  const std::string text =
      "a table with " + std::to_string(numbers) + " numbers a line parted by " + separator + "s";
  // EuRoC's ground truth: time, position, quaternion, and often velocity and biases.
  const bool euroc = numbers == 8 || numbers == 17;
  return text + (euroc ? " (a trajectory as EuRoC's?)" : "") +
         "; trajectories are read as TUM: stamp x y z qx qy qz qw, parted by spaces";
}

}  // namespace

std::string DescribeBinary(std::string_view content) {
  const std::string_view known = Find(kBinary, content);
  if (!known.empty()) return "looks like " + std::string(known);
  const std::string_view head = content.substr(0, kLooked);
  const auto zeros = [&head](std::size_t first) {
    std::size_t count = 0;
    for (std::size_t k = first; k < head.size(); k += 2) count += head[k] == '\0';
    return count;
  };
  const std::size_t even = zeros(0), odd = zeros(1);
  if (even + odd == 0) return "";
  // Latin letters in UTF-16 without a mark: every second byte is zero, or nearly.
  const std::size_t half = head.size() / 2;
  const bool utf16 = half > 1 && std::max(even, odd) > half * 3 / 4 && std::min(even, odd) == 0;
  return utf16 ? "looks like UTF-16 text, convert it to UTF-8" : "looks like binary data";
}

std::string DescribeText(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin == std::string_view::npos) return text.empty() ? "is empty" : "";
  const std::string_view known = Find(kText, text.substr(begin));
  if (!known.empty()) return "looks like " + std::string(known);
  // The first line that is not blank may hold titles; the next tells what the lines hold.
  bool titles = false;
  while (!text.empty()) {
    const std::string_view line = TakeLine(&text);
    if (LineFields(line).AtEnd()) continue;
    for (const auto& [separator, name] : {std::make_pair(',', "comma"), {';', "semicolon"}}) {
      if (line.find(separator) == std::string_view::npos) continue;
      const int numbers = CountNumbers(line, separator);
      if (numbers > 1) return "looks like " + DescribeTable(numbers, name);
    }
    const int numbers = CountNumbers(line, ' ');
    if (numbers == 8 || numbers == 12) {
      const std::string name = numbers == 8 ? "TUM" : "KITTI";
      return "looks like a trajectory (" + name + ")" +
             (titles ? " with a line of titles; put a # before it" : ": poses alone, no edges");
    }
    if (numbers > 0) {
      return "looks like a table of " + std::to_string(numbers) +
             (numbers == 1 ? " number" : " numbers") + " a line, no graph and no trajectory";
    }
    if (titles) return "";
    titles = true;
  }
  return "";
}

}  // namespace hpgo
