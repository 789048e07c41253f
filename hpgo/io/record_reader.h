// Reads the numbers of one line and checks them: they are all there, finite, and make a pose and an
// information matrix.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "hpgo/graph/pose_graph.h"
#include "hpgo/io/line_fields.h"
#include "hpgo/io/message_log.h"
#include "hpgo/io/record_tags.h"

namespace hpgo {

template <typename G>
class RecordReader {
 public:
  // Problems go to `log`, what was normalized or projected is counted in `counts`; both must
  // outlive the reader.
  RecordReader(const ReadOptions& options, MessageLog* log, ReadReport* counts)
      : options_(options), log_(log), counts_(counts) {}

  // Starts with another line; `text` must live until the next one.
  void Begin(std::int64_t number, std::string_view text, const RecordTag* tag);
  // Reads all that follows the tag. Under ReadOptions::identity_information, the information may be
  // missing. As every bool below: false if it failed, which was logged.
  bool ReadNumbers(LineFields* fields);
  bool TakePose(G* pose);
  bool TakeInformation(typename G::Matrix* information);

  std::int64_t id(int k) const { return ids_[k]; }
  // How many ids were read: fewer than the tag has after a failure.
  int ids_read() const { return ids_read_; }
  const RecordTag& tag() const { return *tag_; }
  std::string_view text() const { return text_; }

  // Logs an error about this line.
  void Fail(const std::string& what, std::string_view offending);
  // Logs an oddity of this line.
  void Oddity(WarningKind kind, const std::string& what, std::string_view offending);

 private:
  static constexpr int kInformationNumbers = G::kDof * (G::kDof + 1) / 2;

  template <int N>
  bool CheckBlock(typename G::Matrix* information);
  // Whether the numbers of this line make a valid matrix if EDGE2 has them in that order.
  bool IsValidInOrder(Edge2Order order) const;
  // Which flag would read a line whose information is not positive semi-definite.
  std::string IndefiniteHint() const;
  void TakeIdentity();

  const ReadOptions options_;
  MessageLog* const log_;
  ReadReport* const counts_;

  std::int64_t number_ = 0;
  std::string_view text_;
  const RecordTag* tag_ = nullptr;
  int ids_read_ = 0;
  bool identity_ = false;  // the information of this line is missing, the identity stands for it
  std::array<std::int64_t, 2> ids_{};
  std::array<double, G::kParams + kInformationNumbers> numbers_{};

  // The last positive definite matrix: most files repeat a few.
  const RecordTag* last_tag_ = nullptr;
  std::array<double, kInformationNumbers> last_numbers_{};
  typename G::Matrix last_information_;
};

extern template class RecordReader<SE2>;
extern template class RecordReader<SE3>;

}  // namespace hpgo
