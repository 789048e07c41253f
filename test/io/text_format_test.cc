// What is said of files that are no graph, by their content, and files that gzip compressed.
#include "hpgo/io/text_format.h"

#include <unistd.h>
#include <zlib.h>

#include <filesystem>
#include <fstream>

#include "hpgo/io/g2o_writer.h"
#include "hpgo/io/input_text.h"
#include "hpgo/io/trajectory.h"
#include "test/io/graph_text.h"

namespace hpgo {
namespace {

using namespace std::string_literals;

std::string TrajectoryError(const std::string& text) {
  return ParseTrajectory(text, "f", TrajectoryFormat::kAuto, ReadOptions(), nullptr)
      .status()
      .message();
}

TEST(TextFormatTest, NamesWhatIsCompressedOrBinary) {
  EXPECT_EQ(ErrorOf("BZh91AY"), "f: looks like data compressed with bzip2, unpack it first");
  EXPECT_EQ(ErrorOf("\xfd\x37zXZ\0\0"s), "f: looks like data compressed with xz, unpack it first");
  EXPECT_EQ(ErrorOf("\x28\xb5\x2f\xfd"),
            "f: looks like data compressed with zstd, unpack it first");
  EXPECT_EQ(ErrorOf("PK\x03\x04"), "f: looks like a ZIP archive, unpack it first");
  EXPECT_EQ(ErrorOf("SQLite format 3\0"s),
            "f: looks like an SQLite database (RTAB-Map's, say): export its graph as g2o");
  EXPECT_EQ(ErrorOf("#ROSBAG V2.0\n"), "f: looks like a ROS bag");
  EXPECT_EQ(ErrorOf("\x01\x02 \0\x03 \x04"s), "f: looks like binary data");
}

TEST(TextFormatTest, NamesOtherEncodings) {
  EXPECT_EQ(ErrorOf("\xff\xfeV\0E\0R\0"s), "f: looks like UTF-16 text, convert it to UTF-8");
  EXPECT_EQ(ErrorOf("\xfe\xff\0V\0E\0R"s), "f: looks like UTF-16 text, convert it to UTF-8");
  EXPECT_EQ(ErrorOf("V\0E\0R\0T\0E\0X\0"s), "f: looks like UTF-16 text, convert it to UTF-8");
  EXPECT_EQ(ErrorOf("\xff\xfe\0\0V\0\0\0"s), "f: looks like UTF-32 text, convert it to UTF-8");
  EXPECT_EQ(TrajectoryError("\xff\xfe"
                            "1\0 \0"s),
            "f: looks like UTF-16 text, convert it to UTF-8");
}

TEST(TextFormatTest, NamesOtherTexts) {
  EXPECT_EQ(ErrorOf("#time,px,py,pz,qw,qx,qy,qz\n1500000000000000000,1,2,3,1,0,0,0\n"),
            "f: looks like a table with 8 numbers a line parted by commas (a trajectory as "
            "EuRoC's?); trajectories are read as TUM: stamp x y z qx qy qz qw, parted by spaces");
  EXPECT_EQ(ErrorOf("a;b\n1;2\n"),
            "f: looks like a table with 2 numbers a line parted by semicolons; trajectories are "
            "read as TUM: stamp x y z qx qy qz qw, parted by spaces");
  EXPECT_EQ(ErrorOf("{\"nodes\": []}"), "f: looks like JSON");
  EXPECT_EQ(ErrorOf("\n<html>"), "f: looks like XML or HTML");
  EXPECT_EQ(ErrorOf("ADD VERTEX_XYT 0;\n"),
            "f: looks like commands of g2o's incremental interface (ADD ...)");
  EXPECT_EQ(ErrorOf("version https://git-lfs.github.com/spec/v1\n"),
            "f: looks like a Git LFS pointer, not the file itself");
  EXPECT_EQ(ErrorOf("1 2 3\n"),
            "f: looks like a table of 3 numbers a line, no graph and no trajectory");
}

TEST(TextFormatTest, NamesTrajectories) {
  const std::string pose = "1 0 0 0 0 0 0 1\n";
  EXPECT_EQ(ErrorOf("# stamps\n" + pose),
            "f: looks like a trajectory (TUM): poses alone, no edges");
  EXPECT_EQ(ErrorOf("1 0 0 0 0 1 0 0 0 0 1 0\n"),
            "f: looks like a trajectory (KITTI): poses alone, no edges");
  const std::string titles = "time x y z qx qy qz qw\n" + pose;
  EXPECT_EQ(ErrorOf(titles),
            "f: looks like a trajectory (TUM) with a line of titles; put a # before it");
  EXPECT_EQ(TrajectoryError(titles),
            "f: looks like a trajectory (TUM) with a line of titles; put a # before it");
  EXPECT_EQ(TrajectoryError("# " + titles), "");
}

TEST(TextFormatTest, AGraphIsAGraphWhateverStandsAroundIt) {
  EXPECT_EQ(ErrorOf("{\nVERTEX_SE2 0 0 0 0\n"), "");
  EXPECT_EQ(ErrorOf("a,b\n1,2\nVERTEX_SE2 0 0 0 0\n"), "");
  EXPECT_EQ(ErrorOf("\x28\xb5\x2f\xfd 0\nVERTEX_SE2 0 0 0 0\n"), "");
  EXPECT_EQ(ErrorOf("VERTEX_SE2 0 \0 0 0\n"s), "f:1: VERTEX_SE2: not a number: '?'");
}

// Blank lines are not kept: what stood behind them may come first.
TEST(TextFormatTest, AKeptLineIsNotTakenForTheFilesMark) {
  for (const std::string line : {"\xEF\xBB\xBF# x", "\x1f\x8b\x08", "\x28\xb5\x2f\xfd"}) {
    const std::string text = "\n" + line + "\nVERTEX_SE2 0 0 0 0\n";
    const GraphFile<SE2> file = FileOf<SE2>(text);
    ASSERT_EQ(file.verbatim, std::vector<std::string>{line});
    std::string written;
    ASSERT_TRUE(FormatG2o(file, WriteOptions(), &written).ok());
    EXPECT_FALSE(HasFileMark(written));
    EXPECT_EQ(FileOf<SE2>(written).verbatim, file.verbatim);
  }
}

class GzipTest : public ::testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(path_); }
  // Compressed as gzip does it.
  static std::string Packed(const std::string& text) {
    z_stream stream = {};
    constexpr int kGzip = 16;
    EXPECT_EQ(deflateInit2(&stream, 9, Z_DEFLATED, MAX_WBITS + kGzip, 8, Z_DEFAULT_STRATEGY), Z_OK);
    std::string packed(deflateBound(&stream, text.size()), '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
    stream.avail_in = static_cast<uInt>(text.size());
    stream.next_out = reinterpret_cast<Bytef*>(packed.data());
    stream.avail_out = static_cast<uInt>(packed.size());
    EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
    packed.resize(packed.size() - stream.avail_out);
    deflateEnd(&stream);
    return packed;
  }
  // The text of a file with this content, or the error without the path.
  std::string Read(const std::string& content) const {
    std::ofstream(path_, std::ios::binary) << content;
    const Result<InputText> input = InputText::Read(path_);
    if (input.ok()) return std::string(input->text());
    EXPECT_EQ(input.status().code(), StatusCode::kMalformed);
    return input.status().message().substr(path_.size());
  }
  const std::string path_ = ::testing::TempDir() + "/hpgo_gzip_" + std::to_string(getpid());
};

TEST_F(GzipTest, IsUnpacked) {
  std::string text;
  for (int k = 0; k < 20000; ++k) text += "VERTEX_SE2 " + std::to_string(k) + " 0 0 0\n";
  EXPECT_EQ(Read(Packed(text)), text);
  EXPECT_EQ(Read(Packed("\xEF\xBB\xBFVERTEX")), "VERTEX");
  EXPECT_EQ(Read(Packed("")), "");
  EXPECT_EQ(Read(Packed("one\n") + Packed("two\n") + std::string(512, '\0')), "one\ntwo\n");
}

TEST_F(GzipTest, DamageIsAnError) {
  const std::string packed = Packed("VERTEX_SE2 0 0 0 0\n");
  for (std::size_t size = 3; size < packed.size(); ++size) {
    EXPECT_EQ(Read(packed.substr(0, size)), ": compressed with gzip, but the data ends early");
  }
  EXPECT_EQ(Read(packed + "x"), ": compressed with gzip, but something else follows");
  std::string damaged = packed;
  damaged[packed.size() - 6] ^= 1;  // of the checksum
  EXPECT_EQ(Read(damaged), ": compressed with gzip, but damaged");
}

}  // namespace
}  // namespace hpgo
