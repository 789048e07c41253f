// Which tags a file has, how often, and what is to be said about them.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "hpgo/io/message_log.h"
#include "hpgo/io/record_tags.h"

namespace hpgo {

class TagCensus {
 public:
  // Counts a line with the tag called `name`, and returns what is known about that tag.
  const RecordTag& Count(std::string_view name, std::int64_t line);
  // Whether the last line counted was the first with its tag.
  bool was_first() const { return last_->second.count == 1; }

  // The last line counted became an edge.
  void TookEdge() { ++last_->second.edges; }

  // Fills ReadReport::tags, and warns once for each tag whose lines were not taken as they stand.
  // Under `strict`, what is not optimized was an error at its first line.
  void Report(bool strict, MessageLog* log, ReadReport* report) const;

 private:
  struct Lines {
    const RecordTag* tag;
    std::int64_t first;
    std::int64_t count;
    std::int64_t edges;
  };
  using Map = std::map<std::string, Lines, std::less<>>;

  Map lines_;
  Map::iterator last_ = lines_.end();  // most lines have the tag of the one before
};

}  // namespace hpgo
