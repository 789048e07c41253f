// Names what a file is that holds no pose graph and no trajectory, for the error message.
#pragma once

#include <string>
#include <string_view>

namespace hpgo {

// "looks like a ZIP archive, unpack it first", for bytes that no reader of text can use: other
// compressed files, UTF-16 and UTF-32, databases, pictures. Empty for text.
std::string DescribeBinary(std::string_view content);

// The same for text of which no line has a tag that is read: CSV tables, trajectories with a line
// of titles, JSON, XML and so on. Empty if it looks like nothing known.
std::string DescribeText(std::string_view text);

}  // namespace hpgo
