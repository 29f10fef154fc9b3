// SPDX-License-Identifier: Apache-2.0
#include "uwv/io/npy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>

#include "io/hostile.h"

namespace uwv {
namespace {

using test::expect_error;
using test::TempFolder;
using testing::ElementsAre;
using testing::ElementsAreArray;

const float inf = std::numeric_limits<float>::infinity();

std::vector<float> ramp(std::size_t n) {
  std::vector<float> values(n);
  std::iota(values.begin(), values.end(), 0.5F);
  return values;
}

template <class T>
std::vector<T> read_all(const std::string& path, const std::string& member = "") {
  NpyArrayReader reader(path, member);
  std::vector<T> values(reader.slices() * reader.slice_values());
  reader.read(0, std::span<T>(values));
  return values;
}

/// Reads whatever the header promises, in slices, as a user of the class would.
void read_everything(const std::string& path) {
  std::vector<std::string> names = {""};
  if (is_npz(path)) names = npz_names(path);
  for (const std::string& name : names) {
    NpyArrayReader reader(path, name);
    std::vector<float> slice(reader.slice_values());
    for (std::size_t i = 0; i < reader.slices() && !slice.empty(); ++i) reader.read(i, std::span<float>(slice));
  }
}

std::string npy_bytes(const std::string& header, const std::string& data, char version = 1) {
  std::string bytes = "\x93NUMPY";
  bytes += version;
  bytes += '\0';
  for (int i = 0; i < (version == 1 ? 2 : 4); ++i) bytes += static_cast<char>(header.size() >> (8 * i));
  return bytes + header + data;
}

std::string header_of(const std::string& descr, const std::string& shape, const std::string& fortran = "False") {
  return "{'descr': '" + descr + "', 'fortran_order': " + fortran + ", 'shape': " + shape + ", }\n";
}

template <class T>
std::string raw(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

TEST(Npy, RoundTripsEveryShape) {
  const TempFolder folder;
  for (const std::vector<std::size_t>& shape :
       std::vector<std::vector<std::size_t>>{{}, {1}, {5}, {0}, {3, 4}, {0, 4}, {4, 0}, {2, 3, 4}, {1, 1, 1, 1}}) {
    const std::size_t n = std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies<>());
    const std::vector<float> values = ramp(n);
    write_npy<float>(folder.file("a.npy"), shape, values);
    NpyArrayReader reader(folder.file("a.npy"));
    EXPECT_EQ(reader.header().shape, shape);
    EXPECT_EQ(read_all<float>(folder.file("a.npy")), values);
  }
}

TEST(Npy, RoundTripsExtremeValues) {
  const TempFolder folder;
  const std::vector<float> values = {1e-6F, 1e9F, -1.F, inf, -inf, 0.F, -0.F, 1e-45F};
  write_npy<float>(folder.file("a.npy"), {8}, values);
  EXPECT_EQ(read_all<float>(folder.file("a.npy")), values);
  const std::vector<std::int64_t> integers = {std::numeric_limits<std::int64_t>::min(), 0, (1LL << 53) + 1};
  write_npy<std::int64_t>(folder.file("b.npy"), {3}, integers);
  EXPECT_EQ(read_all<std::int64_t>(folder.file("b.npy")), integers);
}

TEST(Npy, ReadsEveryTypeVersionAndByteOrder) {
  const TempFolder folder;
  const auto values = [&](const std::string& descr, const std::string& data, char version = 1) {
    return read_all<double>(folder.write("a.npy", npy_bytes(header_of(descr, "(2,)"), data, version)));
  };
  EXPECT_THAT(values("|b1", raw<std::uint8_t>({1, 0})), ElementsAre(1, 0));
  EXPECT_THAT(values("|u1", raw<std::uint8_t>({1, 255})), ElementsAre(1, 255));
  EXPECT_THAT(values("|i1", raw<std::int8_t>({1, -1})), ElementsAre(1, -1));
  EXPECT_THAT(values("<u2", raw<std::uint16_t>({1, 65535})), ElementsAre(1, 65535));
  EXPECT_THAT(values("<i2", raw<std::int16_t>({1, -2})), ElementsAre(1, -2));
  EXPECT_THAT(values("<u4", raw<std::uint32_t>({1, 4000000000U})), ElementsAre(1, 4e9));
  EXPECT_THAT(values("<i4", raw<std::int32_t>({1, -3})), ElementsAre(1, -3));
  EXPECT_THAT(values("<u8", raw<std::uint64_t>({1, 1ULL << 60})), ElementsAre(1, std::ldexp(1, 60)));
  EXPECT_THAT(values("<i8", raw<std::int64_t>({1, -4})), ElementsAre(1, -4));
  EXPECT_THAT(values("<f2", raw<std::uint16_t>({0x3C00, 0xC000})), ElementsAre(1, -2));
  EXPECT_THAT(values("<f8", raw<double>({1, 1e300})), ElementsAre(1, 1e300));
  EXPECT_THAT(values("=f4", raw<float>({1, 2}), 2), ElementsAre(1, 2));
  EXPECT_THAT(values(">f4", std::string("\x3F\x80\0\0\x40\0\0\0", 8), 3), ElementsAre(1, 2));
  EXPECT_THAT(values(">i2", std::string("\0\1\xFF\xFE", 4)), ElementsAre(1, -2));
}

TEST(Npy, ReadsHeadersAsOtherProgramsWriteThem) {
  const TempFolder folder;
  for (const std::string header : {"{'shape': (2, 1), 'fortran_order': False, 'descr': '<f4'}",
                                   "{\"descr\":\"<f4\",\"fortran_order\":False,"
                                   "\"shape\":(2,1,)}   \n",
                                   "{'descr': '<f4', 'fortran_order': False, 'shape': (2L, 1L), }"}) {
    SCOPED_TRACE(header);
    const std::string path = folder.write("a.npy", npy_bytes(header, raw<float>({3, 4})));
    EXPECT_THAT(NpyArrayReader(path).header().shape, ElementsAre(2, 1));
    EXPECT_THAT(read_all<float>(path), ElementsAre(3, 4));
  }
}

TEST(Npy, FortranOrderGivesTheSameSlices) {
  const TempFolder folder;
  // a[i][j][k] = 100 i + 10 j + k of shape (2, 3, 4), first index fastest
  std::vector<float> stored;
  for (int k = 0; k < 4; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 2; ++i) stored.push_back(static_cast<float>(100 * i + 10 * j + k));
  const std::string path = folder.write("f.npy", npy_bytes(header_of("<f4", "(2, 3, 4)", "True"), raw(stored)));
  NpyArrayReader reader(path);
  std::vector<float> slice(12);
  for (const std::size_t i : {1U, 0U}) {
    reader.read(i, std::span<float>(slice));
    for (std::size_t at = 0; at < 12; ++at)
      EXPECT_EQ(slice[at], static_cast<float>(100 * i + 10 * (at / 4) + at % 4)) << "slice " << i << " value " << at;
  }
}

TEST(Npy, RefusesLyingHeaders) {
  const TempFolder folder;
  const std::string two = raw<float>({1, 2});
  const auto refused = [&](ErrorCode code, const std::string& what, const std::string& bytes) {
    SCOPED_TRACE(what);
    const std::string path = folder.write("lie.npy", bytes);
    expect_error(code, path, [&] { NpyArrayReader reader(path); });
  };
  using enum ErrorCode;
  refused(file_damaged, "zero bytes", "");
  refused(format_unknown, "text", "hello, this is text");
  refused(format_unknown, "version 9", npy_bytes(header_of("<f4", "(2,)"), two, 9));
  refused(file_damaged, "1e12 values", npy_bytes(header_of("<f4", "(1000000, 1000, 1000)"), two));
  refused(file_damaged, "2^64 values", npy_bytes(header_of("<f4", "(4294967296, 4294967296)"), two));
  refused(file_damaged, "a dimension of 2^64", npy_bytes(header_of("<f4", "(18446744073709551616,)"), two));
  refused(file_damaged, "negative dimension", npy_bytes(header_of("<f4", "(-2,)"), two));
  refused(file_damaged, "one value missing", npy_bytes(header_of("<f4", "(3,)"), two));
  refused(file_damaged, "zero slices of absurd size", npy_bytes(header_of("<f4", "(0, 4294967296, 4294967296)"), two));
  refused(format_unknown, "objects", npy_bytes(header_of("|O", "(2,)"), two));
  refused(format_unknown, "complex", npy_bytes(header_of("<c8", "(1,)"), two));
  refused(format_unknown, "strings", npy_bytes(header_of("<U1", "(2,)"), two));
  refused(format_unknown, "empty type", npy_bytes(header_of("", "(2,)"), two));
  refused(format_unknown, "structured",
          npy_bytes("{'descr': [('a', '<f4')], 'fortran_order': False, 'shape': (2,), }", two));
  refused(file_damaged, "no shape", npy_bytes("{'descr': '<f4', 'fortran_order': False}", two));
  refused(file_damaged, "twice the same key", npy_bytes("{'descr': '<f4', 'descr': '<f4', 'shape': (2,)}", two));
  refused(file_damaged, "open dictionary", npy_bytes("{'descr': '<f4', 'fortran_order': False, 'shape': (2,", two));
  refused(file_damaged, "header longer than the file", std::string("\x93NUMPY\1\0\xFF\x7F{}", 12));
  refused(file_damaged, "header of 4 GiB", std::string("\x93NUMPY\2\0\xFF\xFF\xFF\xFF{}", 14));
  refused(file_damaged, "100 dimensions",
          npy_bytes(header_of(
                        "<f4", "(" +
                                   [] {
                                     std::string ones;
                                     for (int i = 0; i < 100; ++i) ones += "1,";
                                     return ones;
                                   }() +
                                   ")"),
                    two));
}

TEST(Npy, CallersMistakesAreRefused) {
  const TempFolder folder;
  write_npy<float>(folder.file("a.npy"), {2, 3}, ramp(6));
  NpyArrayReader reader(folder.file("a.npy"));
  std::vector<float> slice(3), odd(4);
  EXPECT_THROW(reader.read(2, std::span<float>(slice)), std::invalid_argument);
  EXPECT_THROW(reader.read(0, std::span<float>(odd)), std::invalid_argument);
  EXPECT_THROW(write_npy<float>(folder.file("b.npy"), {7}, ramp(6)), std::invalid_argument);
  std::vector<std::int64_t> integers(3);
  expect_error(ErrorCode::value_invalid, folder.file("a.npy"), [&] { reader.read(0, std::span(integers)); });
}

/// An .npz with a streamed member `depth` of shape (5, 3, 4) and two small ones.
void write_sample_npz(const std::string& path, int deflate_level) {
  NpzWriter writer(path);
  writer.begin("depth", DType::f32, {3, 4}, deflate_level);
  const std::vector<float> values = ramp(60);
  for (std::size_t i = 0; i < 5; ++i) writer.append(std::span<const float>(values).subspan(i * 12, 12));
  writer.end();
  writer.add<double>("scale", {}, std::vector<double>{0.25});
  writer.add<std::int32_t>("index", {2}, std::vector<std::int32_t>{7, 8});
  writer.finish();
}

TEST(Npz, RoundTripsStreamedAndSmallMembers) {
  const TempFolder folder;
  for (const int level : {0, 1, 9}) {
    SCOPED_TRACE(level);
    const std::string path = folder.file("a.npz");
    write_sample_npz(path, level);
    EXPECT_TRUE(is_npz(path));
    EXPECT_THAT(npz_names(path), ElementsAre("depth", "scale", "index"));
    NpyArrayReader reader(path, "depth");
    EXPECT_THAT(reader.header().shape, ElementsAre(5, 3, 4));
    EXPECT_THAT(read_all<float>(path, "depth"), ElementsAreArray(ramp(60)));
    EXPECT_THAT(read_all<double>(path, "scale"), ElementsAre(0.25));
    EXPECT_THAT(read_all<std::int64_t>(path, "index"), ElementsAre(7, 8));
    // any order of slices
    std::vector<float> slice(12);
    for (const std::size_t i : {4U, 0U, 3U, 3U, 1U}) {
      reader.read(i, std::span<float>(slice));
      EXPECT_EQ(slice[0], static_cast<float>(i * 12) + 0.5F);
    }
    EXPECT_FALSE(std::filesystem::exists(path + ".part"));
  }
}

TEST(Npz, TheSameInputGivesTheSameBytes) {
  const TempFolder folder;
  write_sample_npz(folder.file("a.npz"), 6);
  write_sample_npz(folder.file("b.npz"), 6);
  EXPECT_EQ(folder.read("a.npz"), folder.read("b.npz"));
}

TEST(Npz, AnUnfinishedFileLeavesNothingBehind) {
  const TempFolder folder;
  {
    NpzWriter writer(folder.file("a.npz"));
    writer.begin("depth", DType::f32, {1000});
    writer.append(std::span<const float>(ramp(1000)));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Npz, ReportsMissingAndDuplicateMembers) {
  const TempFolder folder;
  const std::string path = folder.file("a.npz");
  write_sample_npz(path, 0);
  expect_error(ErrorCode::value_invalid, path, [&] { NpyArrayReader reader(path, "dep"); });
  expect_error(ErrorCode::value_invalid, path, [&] { NpyArrayReader reader(path); });
  NpzWriter writer(folder.file("b.npz"));
  writer.add<float>("a", {1}, ramp(1));
  EXPECT_THROW(writer.add<float>("a", {1}, ramp(1)), std::invalid_argument);
  expect_error(ErrorCode::output_failed, folder.file("none/a.npz"), [&] { NpzWriter w(folder.file("none/a.npz")); });
}

TEST(Npz, NoticesAWrongByteInTheData) {
  const TempFolder folder;
  write_sample_npz(folder.file("a.npz"), 0);
  std::string bytes = folder.read("a.npz");
  bytes[400] ^= 1;  // inside the values of `depth`
  const std::string path = folder.write("b.npz", bytes);
  expect_error(ErrorCode::file_damaged, path, [&] { read_all<float>(path, "depth"); });
}

TEST(Npz, RefusesAMemberThatClaimsMoreThanDeflateCanGive) {
  const TempFolder folder;
  write_sample_npz(folder.file("a.npz"), 9);
  std::string bytes = folder.read("a.npz");
  const std::size_t entry = bytes.find("PK\1\2");
  bytes.replace(entry + 24, 4, "\xFE\xFF\xFF\xFF");  // 4 GiB unpacked
  const std::string path = folder.write("b.npz", bytes);
  expect_error(ErrorCode::file_damaged, path, [&] { NpyArrayReader reader(path, "depth"); });
}

TEST(Npz, NoTruncationIsAccepted) {
  for (const int level : {0, 6}) {
    const TempFolder folder;
    write_sample_npz(folder.file("a.npz"), level);
    EXPECT_EQ(test::try_truncations(folder.read("a.npz"), "t.npz", read_everything), 0);
  }
}

TEST(Npz, SurvivesRandomDamage) {
  for (const int level : {0, 6}) {
    const TempFolder folder;
    write_sample_npz(folder.file("a.npz"), level);
    test::try_byte_flips(folder.read("a.npz"), "f.npz", read_everything, 2000);
  }
}

TEST(Npy, SurvivesTruncationAndRandomDamage) {
  const TempFolder folder;
  write_npy<float>(folder.file("a.npy"), {2, 3}, ramp(6));
  const std::string bytes = folder.read("a.npy");
  EXPECT_EQ(test::try_truncations(bytes, "t.npy", read_everything), 0);
  test::try_byte_flips(bytes, "f.npy", read_everything, 2000);
}

}  // namespace
}  // namespace uwv
