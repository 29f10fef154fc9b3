// SPDX-License-Identifier: Apache-2.0
#include "uwv/io/safetensors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "io/hostile.h"

namespace uwv {
namespace {

using test::expect_error;
using test::TempFolder;
using testing::ElementsAre;

template <class T>
std::string raw(std::initializer_list<T> values) {
  std::string bytes;
  for (const T value : values) bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  return bytes;
}

std::string file_of(const std::string& header, const std::string& data) {
  const std::uint64_t length = header.size();
  return raw({length}) + header + data;
}

std::string one_tensor(const std::string& dtype, const std::string& shape, const std::string& data) {
  return file_of("{\"a\":{\"dtype\":\"" + dtype + "\",\"shape\":" + shape + ",\"data_offsets\":[0," +
                     std::to_string(data.size()) + "]}}",
                 data);
}

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

/// Three tensors whose header length is odd, so that the data is unaligned.
std::string small_valid_file() {
  return file_of(
      R"({"__metadata__":{"by":"test"},"x":{"dtype":"F32","shape":[2,3],"data_offsets":[0,24]},)"
      R"("n":{"dtype":"I64","shape":[],"data_offsets":[24,32]},"e":{"dtype":"U8","shape":[0,4],"data_offsets":[32,32]}})",
      raw({1.F, -2.F, 0.5F, 1e-6F, 1e9F, std::numeric_limits<float>::infinity()}) + raw<std::int64_t>({-7}));
}

void read_everything(const std::string& path) {
  const SafeTensors file = SafeTensors::open(path);
  for (const std::string& name : file.names()) {
    (void)file.as_double(name);
    (void)file.as_float(name);
  }
}

TEST(SafeTensors, ReadsNamesShapesValuesAndMetadata) {
  const TempFolder folder;
  const SafeTensors file = SafeTensors::open(folder.write("a.safetensors", small_valid_file()));
  EXPECT_THAT(file.names(), ElementsAre("e", "n", "x"));
  EXPECT_EQ(file.metadata().at("by"), "test");
  EXPECT_TRUE(file.has("x"));
  EXPECT_FALSE(file.has("__metadata__"));
  EXPECT_THAT(file.info("x").shape, ElementsAre(2, 3));
  EXPECT_EQ(file.info("x").dtype, DType::f32);
  EXPECT_EQ(file.info("n").values(), 1U);
  EXPECT_THAT(file.as_float("x"), ElementsAre(1.F, -2.F, 0.5F, 1e-6F, 1e9F, std::numeric_limits<float>::infinity()));
  EXPECT_THAT(file.as_i64("n"), ElementsAre(-7));
  EXPECT_TRUE(file.as_u8("e").empty());
  EXPECT_EQ(file.bytes("x").size(), 24U);
}

TEST(SafeTensors, ConvertsEveryType) {
  const TempFolder folder;
  const auto values = [&](const std::string& dtype, const std::string& shape, const std::string& data) {
    return SafeTensors::open(folder.write("t.safetensors", one_tensor(dtype, shape, data))).as_double("a");
  };
  EXPECT_THAT(values("BOOL", "[2]", raw<std::uint8_t>({0, 1})), ElementsAre(0, 1));
  EXPECT_THAT(values("U8", "[2]", raw<std::uint8_t>({0, 255})), ElementsAre(0, 255));
  EXPECT_THAT(values("I8", "[2]", raw<std::int8_t>({-128, 127})), ElementsAre(-128, 127));
  EXPECT_THAT(values("U16", "[1]", raw<std::uint16_t>({65535})), ElementsAre(65535));
  EXPECT_THAT(values("I16", "[1]", raw<std::int16_t>({-32768})), ElementsAre(-32768));
  EXPECT_THAT(values("U32", "[1]", raw<std::uint32_t>({4294967295U})), ElementsAre(4294967295.0));
  EXPECT_THAT(values("I32", "[1]", raw<std::int32_t>({-5})), ElementsAre(-5));
  EXPECT_THAT(values("U64", "[1]", raw<std::uint64_t>({1ULL << 63})), ElementsAre(9223372036854775808.0));
  EXPECT_THAT(values("I64", "[1]", raw<std::int64_t>({-9})), ElementsAre(-9));
  EXPECT_THAT(values("F64", "[1]", raw({1e-300})), ElementsAre(1e-300));
  // 1, -2, the largest half, the smallest denormal, -Inf
  EXPECT_THAT(values("F16", "[5]", raw<std::uint16_t>({0x3C00, 0xC000, 0x7BFF, 0x0001, 0xFC00})),
              ElementsAre(1, -2, 65504, std::ldexp(1, -24), -std::numeric_limits<double>::infinity()));
  EXPECT_THAT(values("BF16", "[2]", raw<std::uint16_t>({0x3F80, 0xC049})), ElementsAre(1, -3.140625));
  // 1, the largest (448), the smallest denormal, -1.125
  EXPECT_THAT(values("F8_E4M3", "[4]", raw<std::uint8_t>({0x38, 0x7E, 0x01, 0xB9})),
              ElementsAre(1, 448, std::ldexp(1, -9), -1.125));
  EXPECT_TRUE(std::isnan(values("F8_E4M3", "[1]", raw<std::uint8_t>({0xFF}))[0]));
  EXPECT_THAT(values("F8_E5M2", "[2]", raw<std::uint8_t>({0x3C, 0xFB})), ElementsAre(1, -57344));
  EXPECT_TRUE(std::isnan(values("F16", "[1]", raw<std::uint16_t>({0x7E01}))[0]));
}

TEST(SafeTensors, RefusesWrongTypeAndMissingName) {
  const TempFolder folder;
  const std::string path = folder.write("a.safetensors", small_valid_file());
  const SafeTensors file = SafeTensors::open(path);
  expect_error(ErrorCode::value_invalid, path, [&] { (void)file.as_u8("x"); });
  expect_error(ErrorCode::value_invalid, path, [&] { (void)file.as_i64("x"); });
  expect_error(ErrorCode::value_invalid, path, [&] { (void)file.as_float("y"); });
  expect_error(ErrorCode::file_not_found, folder.file("none"), [&] { SafeTensors::open(folder.file("none")); });
  expect_error(ErrorCode::file_not_found, folder.path(), [&] { SafeTensors::open(folder.path()); });
}

TEST(SafeTensors, RefusesLyingHeaders) {
  const TempFolder folder;
  const std::string four = raw({1.F});
  const auto entry = [](const std::string& name, const std::string& shape, const std::string& offsets) {
    return "\"" + name + R"(":{"dtype":"F32","shape":)" + shape + R"(,"data_offsets":)" + offsets + "}";
  };
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"zero bytes", ""},
      {"text", "this is no tensor file at all"},
      {"header longer than the file", raw<std::uint64_t>({1000}) + "{}"},
      {"header of 2^64-1 bytes", raw<std::uint64_t>({~0ULL}) + "{}"},
      {"array as header", file_of("[]", "")},
      {"broken JSON", file_of("{\"a\":", "")},
      {"duplicate key", file_of("{" + entry("a", "[1]", "[0,4]") + "," + entry("a", "[1]", "[0,4]") + "}", four)},
      {"tensor is a number", file_of("{\"a\":3}", "")},
      {"no shape", file_of(R"({"a":{"dtype":"F32","data_offsets":[0,4]}})", four)},
      {"unknown dtype", one_tensor("F128", "[1]", four)},
      {"negative dimension", one_tensor("F32", "[-1]", four)},
      {"fractional dimension", one_tensor("F32", "[1.0]", four)},
      {"overflowing shape", one_tensor("F32", "[4294967296,4294967296]", four)},
      {"overflow that hits the size", one_tensor("F32", "[4611686018427387905]", four)},
      {"overflow hidden by a zero", one_tensor("F32", "[0,4294967296,4294967296]", "")},
      {"overflow of signed sizes", one_tensor("U8", "[0,9223372036854775808]", "")},
      {"65 dimensions", one_tensor("F32", "[1" + repeated(",1", 64) + "]", four)},
      {"name with an escape", file_of("{" + entry("\\u001b[31m", "[1]", "[4,8]") + "}", four + four)},
      {"shape too large", one_tensor("F32", "[2]", four)},
      {"offsets outside", file_of("{" + entry("a", "[2]", "[0,8]") + "}", four)},
      {"offsets backwards", file_of("{" + entry("a", "[1]", "[4,0]") + "}", four)},
      {"three offsets", file_of("{" + entry("a", "[1]", "[0,4,4]") + "}", four)},
      {"overlap", file_of("{" + entry("a", "[1]", "[0,4]") + "," + entry("b", "[1]", "[0,4]") + "}", four)},
      {"gap", file_of("{" + entry("a", "[1]", "[4,8]") + "}", four + four)},
      {"bytes left over", file_of("{" + entry("a", "[1]", "[0,4]") + "}", four + four)},
      {"metadata no string", file_of(R"({"__metadata__":{"k":1}})", "")},
      {"deep nesting", file_of(std::string(100000, '['), "")},
  };
  for (const auto& [what, bytes] : cases) {
    SCOPED_TRACE(what);
    const std::string path = folder.write("lie.safetensors", bytes);
    expect_error(ErrorCode::file_damaged, path, [&, p = path] { SafeTensors::open(p); });
  }
}

TEST(SafeTensors, NoTruncationIsAccepted) {
  EXPECT_EQ(test::try_truncations(small_valid_file(), "t.safetensors", read_everything), 0);
}

TEST(SafeTensors, SurvivesRandomDamage) {
  test::try_byte_flips(small_valid_file(), "f.safetensors", read_everything, 2000);
}

}  // namespace
}  // namespace uwv
