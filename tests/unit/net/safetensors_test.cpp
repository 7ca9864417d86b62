#include "model/net/safetensors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <fstream>

#include "tests/support/temporary_folder.h"

namespace styled::net {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

std::vector<std::byte> File(const std::string& header, std::size_t data_bytes,
                            std::int64_t add_to_length = 0) {
  const std::uint64_t length = header.size() + static_cast<std::uint64_t>(add_to_length);
  std::vector<std::byte> file(8 + header.size() + data_bytes);
  std::memcpy(file.data(), &length, 8);
  std::memcpy(file.data() + 8, header.data(), header.size());
  return file;
}

struct Refused {
  const char* what;
  std::string header;
  std::size_t data_bytes;
  const char* message;
};

// One tensor "a" with these JSON values.
std::string A(const std::string& dtype, const std::string& shape, const std::string& offsets) {
  return R"({"a":{"dtype":)" + dtype + R"(,"shape":)" + shape + R"(,"data_offsets":)" + offsets +
         "}}";
}
const std::string kF32 = R"("F32")";

std::vector<Refused> RefusedHeaders() {
  const std::string a = R"("a":{"dtype":"F32","shape":[2],"data_offsets":[0,8]})";
  const auto b = [&a](const std::string& offsets) {
    return "{" + a + R"(,"b":{"dtype":"F32","shape":[2],"data_offsets":)" + offsets + "}}";
  };
  std::string deep = R"({"a":)";
  for (int i = 0; i < 100000; ++i) deep += '[';
  return {
      {"NotJson", "{", 0, "header: not JSON: line 1, column 2"},
      {"EmptyHeader", "", 0, "header: not JSON: line 1, column 1"},
      {"TrailingText", "{} x", 0, "header: not JSON: line 1, column 4"},
      {"BadUtf8", "{\"\xff\":1}", 0, "header: not JSON: line 1, column 3"},
      {"HugeNumber", A(kF32, "[1e999]", "[0,8]"), 8, "header: not JSON: a number out of range"},
      {"Array", "[]", 0, "header: expected an object"},
      {"Deep", deep, 0, "header: nested deeper than 16"},
      {"KeyTwice", "{" + a + "," + a + "}", 8, "key 'a' twice"},
      {"EntryNotObject", R"({"a":1})", 0, "tensor 'a': expected an object"},
      {"NoDtype", R"({"a":{"shape":[2],"data_offsets":[0,8]}})", 8, "expected the keys dtype"},
      {"NoShape", R"({"a":{"dtype":"F32","data_offsets":[0,8]}})", 8, "expected the keys dtype"},
      {"NoOffsets", R"({"a":{"dtype":"F32","shape":[2]}})", 8, "expected the keys dtype"},
      {"OddKey", R"({"a":{"dtype":"F32","shape":[2],"data_offsets":[0,8],"x":1}})", 8,
       "expected the keys dtype"},
      {"DtypeNumber", A("32", "[2]", "[0,8]"), 8, "dtype: expected a string"},
      {"DtypeUnknown", A(R"("F33")", "[2]", "[0,8]"), 8, "dtype: unknown 'F33'"},
      {"ShapeNotArray", A(kF32, "2", "[0,8]"), 8, "shape: expected an array"},
      {"ShapeNegative", A(kF32, "[-2]", "[0,8]"), 8, "shape: expected non-negative integers"},
      {"ShapeFraction", A(kF32, "[2.0]", "[0,8]"), 8, "shape: expected non-negative integers"},
      {"ShapeText", A(kF32, R"(["2"])", "[0,8]"), 8, "shape: expected non-negative integers"},
      {"ShapeBeyond63Bits", A(kF32, "[18446744073709551615]", "[0,8]"), 8,
       "shape: expected non-negative integers"},
      {"ShapeOverflows", A(kF32, "[4294967296,4294967296]", "[0,0]"), 0, "larger than the file"},
      {"ShapeOverflowsToFit", A(kF32, "[2,4611686018427387905]", "[0,8]"), 8,
       "larger than the file"},
      {"OffsetsOne", A(kF32, "[2]", "[8]"), 8, "data_offsets: expected two"},
      {"OffsetsThree", A(kF32, "[2]", "[0,4,8]"), 8, "data_offsets: expected two"},
      {"OffsetsNegative", A(kF32, "[2]", "[-8,0]"), 8, "data_offsets: expected two"},
      {"OffsetsReversed", A(kF32, "[2]", "[8,0]"), 8, "outside the file's 8 data bytes"},
      {"OffsetsOutside", A(kF32, "[2]", "[4,12]"), 8, "outside the file's 8 data bytes"},
      {"OffsetsFarOutside", A(kF32, "[2]", "[9223372036854775799,9223372036854775807]"), 8,
       "outside the file's 8 data bytes"},
      {"SizeNotOfShape", A(kF32, "[3]", "[0,8]"), 12, "expected 12 bytes for F32 [3], found 8"},
      {"SizeNotOfDtype", A(R"("F16")", "[2]", "[0,8]"), 8, "expected 4 bytes for F16 [2], found 8"},
      {"Overlap", b("[4,12]"), 12,
       "tensor 'b': data_offsets: expected to begin at 8, found 4 (over"},
      {"SamePlace", b("[0,8]"), 8, "(overlaps another tensor)"},
      {"Hole", b("[12,20]"), 20, "expected to begin at 8, found 12 (leaves a hole)"},
      {"DataBehind", "{" + a + "}", 9, "expected 8 data bytes, found 9"},
      {"Truncated", "{" + a + "}", 7, "larger than the file"},
      {"MetadataNotObject", R"({"__metadata__":[]})", 0, "__metadata__: expected an object"},
      {"MetadataNotText", R"({"__metadata__":{"k":1}})", 0, "key 'k': expected a string"},
  };
}

class RefusedHeader : public testing::TestWithParam<Refused> {};

TEST_P(RefusedHeader, SaysWhy) {
  const auto view = ParseSafetensors(File(GetParam().header, GetParam().data_bytes), "file");
  ASSERT_FALSE(view.ok());
  EXPECT_THAT(view.status().message(), AllOf(StartsWith("file: "), HasSubstr(GetParam().message)));
}

INSTANTIATE_TEST_SUITE_P(Safetensors, RefusedHeader, testing::ValuesIn(RefusedHeaders()),
                         [](const auto& info) { return std::string(info.param.what); });

TEST(Safetensors, RefusesHostileLengths) {
  const std::vector<std::byte> whole = File("{}", 0);
  EXPECT_TRUE(ParseSafetensors(whole, "file").ok());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(ParseSafetensors(std::span(whole).first(size), "file").ok()) << size;
  }
  for (const std::int64_t add : {1L, -1L, -3L, 1L << 20, 1L << 40, INT64_MAX - 10, INT64_MIN}) {
    EXPECT_FALSE(ParseSafetensors(File("{}", 0, add), "file").ok()) << add;
  }
  const auto too_long = ParseSafetensors(File(std::string(kMaxHeaderBytes + 1, ' '), 0), "file");
  EXPECT_THAT(too_long.status().message(), HasSubstr("header length: expected at most 4194304"));
}

TEST(Safetensors, ReadsWhatItWrites) {
  const std::vector<NamedTensor> tensors{{"b", {2, 3}, {1, 2, 3, 4, 5, 6}},
                                         {"a", {}, {7}},
                                         {"empty", {0, 4}, {}},
                                         {"ö \"quoted\"", {1}, {-0.0F}}};
  const auto bytes = SerializeSafetensors(tensors, {{"key", "{\"x\": 1}\n"}});
  const auto view = ParseSafetensors(bytes, "file");
  ASSERT_TRUE(view.ok()) << view.status().message();
  EXPECT_EQ(view.value().metadata.at("key"), "{\"x\": 1}\n");
  ASSERT_EQ(view.value().tensors.size(), tensors.size());
  for (const NamedTensor& tensor : tensors) {
    const TensorView& read = view.value().tensors.at(tensor.name);
    EXPECT_EQ(read.dtype, "F32");
    EXPECT_EQ(read.shape, tensor.shape);
    ASSERT_EQ(read.bytes.size(), tensor.values.size() * 4);
    if (!tensor.values.empty()) {
      EXPECT_EQ(std::memcmp(read.bytes.data(), tensor.values.data(), read.bytes.size()), 0);
    }
  }
}

class SafetensorsFile : public testing::Test {
 protected:
  support::TemporaryFolder temporary_;
  const std::filesystem::path& folder_ = temporary_.path();
};

TEST_F(SafetensorsFile, IsWrittenWhole) {
  const std::vector<NamedTensor> tensors{{"a", {2}, {1, 2}}};
  const auto file = folder_ / "weights";
  ASSERT_TRUE(WriteSafetensors(file, tensors, {}).ok());
  ASSERT_TRUE(WriteSafetensors(file, tensors, {{"k", "v"}}).ok());  // replaces the old file
  const auto bytes = ReadFile(file);
  ASSERT_TRUE(bytes.ok());
  EXPECT_EQ(bytes.value(), SerializeSafetensors(tensors, {{"k", "v"}}));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 1);
}

TEST_F(SafetensorsFile, CannotBeWrittenWhereThereIsNoFolder) {
  EXPECT_THAT(WriteSafetensors(folder_ / "no" / "weights", {}, {}).message(),
              HasSubstr("cannot be written"));
}

TEST_F(SafetensorsFile, RefusesWhatIsNoFile) {
  EXPECT_THAT(ReadFile(folder_ / "none").status().message(), HasSubstr("none: no such file"));
  EXPECT_THAT(ReadFile(folder_).status().message(), HasSubstr("expected a regular file"));
  const auto pipe = folder_ / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(ReadFile(pipe).status().message(), HasSubstr("expected a regular file"));
}

TEST_F(SafetensorsFile, RefusesOneThatIsTooLarge) {
  const auto file = folder_ / "large";
  std::ofstream(file).put('x');
  std::filesystem::resize_file(file, kMaxFileBytes + 1);  // a sparse file
  EXPECT_THAT(ReadFile(file).status().message(), HasSubstr("expected at most 67108864 bytes"));
}

TEST(Safetensors, OtherMetadataLeavesTheTensorsAsTheyAre) {
  const std::vector<NamedTensor> tensors{{"b", {2}, {1.5F, -2}}, {"a", {1, 1}, {3}}};
  const auto file = SerializeSafetensors(tensors, {{"k", "old"}});
  const std::map<std::string, std::string> metadata{{"k", "a much longer value"}};
  const auto other = WithMetadata(file, metadata, "file");
  ASSERT_TRUE(other.ok()) << other.status().message();
  const auto view = ParseSafetensors(other.value(), "file");
  ASSERT_TRUE(view.ok()) << view.status().message();
  EXPECT_EQ(view.value().metadata, metadata);
  EXPECT_EQ(view.value().tensors.size(), 2U);
  EXPECT_EQ(other.value(), SerializeSafetensors(tensors, metadata)) << "in the same order, too";
  EXPECT_FALSE(WithMetadata(std::span(file).first(20), metadata, "file").ok());
  EXPECT_TRUE(std::ranges::equal(TensorBytes(file), TensorBytes(other.value())));
  EXPECT_EQ(TensorBytes(file).size(), 3 * sizeof(float));
  EXPECT_TRUE(TensorBytes(std::span(file).first(7)).empty());
  EXPECT_TRUE(TensorBytes(std::span(file).first(20)).empty()) << "a header that says it is longer";
}

}  // namespace
}  // namespace styled::net
