#include "hpgo/io/state_file.h"

#include <zlib.h>

#include <cstdint>
#include <string_view>

#include "hpgo/io/input_text.h"
#include "hpgo/io/output_file.h"
#include "hpgo/state/state_reader.h"
#include "hpgo/state/state_traits.h"
#include "hpgo/state/state_writer.h"

namespace hpgo {
namespace {

constexpr std::string_view kMagic = "hpgostat";
constexpr std::size_t kNumberBytes = sizeof(std::uint32_t), kSectionBytes = 8;
constexpr std::size_t kHeaderBytes = kMagic.size() + 3 * kNumberBytes;
constexpr std::string_view kEnd = "end";

// What a header says of the poses: the dimension of the graph, or their four numbers.
template <typename G>
constexpr std::uint32_t kPoses = G::kDof == 4 ? 4 : G::kDim;

std::string NameOfPoses(std::uint32_t poses) {
  return poses == 4 ? "a graph over x, y, z and yaw" : "a " + std::to_string(poses) + "D graph";
}

std::string Number(std::uint32_t value) {
  std::string bytes(kNumberBytes, '\0');
  StoreNumber(value, bytes.data());
  return bytes;
}

std::uint32_t NumberAt(std::string_view bytes) { return LoadNumber<std::uint32_t>(bytes.data()); }

// Goes on from the one of what comes before.
std::uint32_t Checksum(std::uint32_t before, std::string_view bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

class BlockWriter {
 public:
  BlockWriter(OutputFile* out, std::uint32_t poses) : out_(*out) {
    std::string header(kMagic);
    header += Number(kStateVersion) + Number(poses);
    Append(header);
    AppendChecksum();
  }

  void Append(std::string_view section, std::string_view bytes) {
    std::string head(section);
    head.resize(kSectionBytes, '\0');
    head += Number(static_cast<std::uint32_t>(bytes.size()));
    Append(head);
    Append(bytes);
    AppendChecksum();
  }

 private:
  void Append(std::string_view bytes) {
    checksum_ = Checksum(checksum_, bytes);
    out_.Append(bytes);
  }
  void AppendChecksum() { out_.Append(Number(checksum_)); }

  OutputFile& out_;
  std::uint32_t checksum_ = 0;
};

// Errors are without the name of the file.
class BlockReader {
 public:
  explicit BlockReader(std::string_view text) : text_(text) {}

  Status ReadHeader(std::uint32_t poses) {
    if (text_.substr(0, kMagic.size()) != kMagic.substr(0, text_.size())) {
      return Malformed("is no saved state");
    }
    if (text_.size() < kHeaderBytes) return CutOff();
    const std::size_t checked = kHeaderBytes - kNumberBytes;
    checksum_ = Checksum(0, text_.substr(0, checked));
    if (NumberAt(text_.substr(checked)) != checksum_) return Damaged(0, "the header");
    const std::uint32_t version = NumberAt(text_.substr(kMagic.size()));
    if (version != kStateVersion) {
      return Malformed("is a state of version " + std::to_string(version) +
                       ", and only those of version " + std::to_string(kStateVersion) +
                       " can be read");
    }
    const std::uint32_t saved = NumberAt(text_.substr(kMagic.size() + kNumberBytes));
    if (saved != poses) {
      return Malformed("is the state of " + NameOfPoses(saved) + ", not of " + NameOfPoses(poses));
    }
    at_ = kHeaderBytes;
    return Status::Ok();
  }

  Result<StateReader::Block> Next() {
    constexpr std::size_t kHeadBytes = kSectionBytes + kNumberBytes;
    const std::string_view rest = text_.substr(at_);
    if (rest.size() < kHeadBytes + kNumberBytes) return CutOff();
    const std::string_view padded = rest.substr(0, kSectionBytes);
    const std::string_view section = padded.substr(0, padded.find('\0'));
    const std::size_t size = NumberAt(rest.substr(kSectionBytes));
    if (size > rest.size() - kHeadBytes - kNumberBytes) {
      // Either the file is too short or the number is wrong.
      return Malformed("cut off or damaged: there are " + std::to_string(text_.size()) +
                       " bytes, and the block at byte " + std::to_string(at_) +
                       " would end behind them");
    }
    checksum_ = Checksum(checksum_, rest.substr(0, kHeadBytes + size));
    if (NumberAt(rest.substr(kHeadBytes + size)) != checksum_) {
      return Damaged(at_, "a block of section '" + Printable(section) + "'");
    }
    at_ += kHeadBytes + size + kNumberBytes;
    if (section != kEnd) return StateReader::Block{section, rest.substr(kHeadBytes, size)};
    if (at_ < text_.size())
      return Malformed("goes on behind its end, at byte " + std::to_string(at_));
    return StateReader::Block();
  }

 private:
  static std::string Printable(std::string_view section) {
    std::string text(section);
    for (char& c : text) {
      if (c < ' ' || c > '~') c = '?';
    }
    return text;
  }
  static Status Malformed(const std::string& what) { return Status(StatusCode::kMalformed, what); }
  Status CutOff() const {
    return Malformed("is cut off after " + std::to_string(text_.size()) + " bytes");
  }
  static Status Damaged(std::size_t at, const std::string& what) {
    return Malformed("is damaged: the checksum of " + what + ", at byte " + std::to_string(at) +
                     ", is another");
  }

  const std::string_view text_;
  std::size_t at_ = 0;
  std::uint32_t checksum_ = 0;
};

}  // namespace

template <typename G>
Status SaveState(const Optimizer<G>& optimizer, const std::string& path) {
  OutputFile out(path);
  if (!out.status().ok()) return out.status();
  BlockWriter blocks(&out, kPoses<G>);
  StateWriter writer(
      [&](const char* section, std::string_view bytes) { blocks.Append(section, bytes); });
  const Status status = optimizer.Save(&writer);
  if (!status.ok()) return Status(status.code(), path + ": " + status.message());
  blocks.Append(kEnd, "");
  return out.Commit();
}

template <typename G>
Status ParseState(std::string_view bytes, Optimizer<G>* optimizer) {
  BlockReader blocks(bytes);
  const Status status = blocks.ReadHeader(kPoses<G>);
  if (!status.ok()) return status;
  StateReader reader([&] { return blocks.Next(); });
  return optimizer->Load(&reader);
}

template <typename G>
Status LoadState(const std::string& path, Optimizer<G>* optimizer) {
  const Result<InputText> input = InputText::Read(path);
  if (!input.ok()) return input.status();
  const Status status = ParseState(input->text(), optimizer);
  if (status.ok()) return status;
  return Status(status.code(), input->name() + ": " + status.message());
}

template Status SaveState(const Optimizer<SE2>&, const std::string&);
template Status SaveState(const Optimizer<SE3>&, const std::string&);
template Status SaveState(const Optimizer<YawPose>&, const std::string&);
template Status ParseState(std::string_view, Optimizer<SE2>*);
template Status ParseState(std::string_view, Optimizer<SE3>*);
template Status ParseState(std::string_view, Optimizer<YawPose>*);
template Status LoadState(const std::string&, Optimizer<SE2>*);
template Status LoadState(const std::string&, Optimizer<SE3>*);
template Status LoadState(const std::string&, Optimizer<YawPose>*);

}  // namespace hpgo
