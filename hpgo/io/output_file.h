// Writes a file completely or not at all.
#pragma once

#include <string>
#include <string_view>

#include "hpgo/graph/status.h"

namespace hpgo {

// The text goes to a temporary file in the same directory, which Commit() gives its name; until
// then, and after any failure, what was at `path` is untouched and nothing else is left. The
// temporary file has no name where the file system knows such (O_TMPFILE), so that nothing is left
// of a killed process either. "-" is the standard output; it and what is no regular file (a pipe, a
// device) are written to directly.
//
//   OutputFile out(path);
//   out.Append("VERTEX_SE2 0 0 0 0\n");
//   const Status status = out.Commit();
//
// Not copyable; not synchronized.
class OutputFile {
 public:
  explicit OutputFile(const std::string& path);
  // Discards what was not committed.
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  // What is appended here is written by FlushIfLarge() and Commit().
  std::string* buffer() { return &buffer_; }
  void FlushIfLarge();
  void Append(std::string_view text);

  // The first failure so far.
  const Status& status() const { return status_; }
  // kUnreadable, with the path and the system's reason, for the first failure of any call.
  Status Commit();

 private:
  void OpenTemporary();
  void OpenNamedTemporary();
  void GiveName();
  void Flush();
  void Fail(const char* what);
  void Discard();

  const std::string path_;
  std::string target_;     // where a symbolic link at `path_` leads
  std::string temporary_;  // its name, if it has one
  bool direct_ = false;    // `fd_` is the target itself
  int fd_ = -1;
  std::string buffer_;
  Status status_;
};

// Whether a file could be written to `path` now, found out without a trace: for the beginning of
// long work. kUnreadable, in the words of OutputFile.
Status CheckOutputPath(const std::string& path);

// A whole file at once.
Status WriteTextFile(const std::string& path, std::string_view text);

}  // namespace hpgo
