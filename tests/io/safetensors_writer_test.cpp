// SPDX-License-Identifier: Apache-2.0
#include "uwv/io/safetensors_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <vector>

#include "io/hostile.h"

namespace uwv {
namespace {

using test::expect_error;
using test::TempFolder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

template <class T>
std::span<const std::byte> bytes_of(const std::vector<T>& values) {
  return std::as_bytes(std::span(values));
}

std::string mistake(const std::function<void()>& act) {
  try {
    act();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

TEST(SafeTensorsWriter, WhatIsWrittenInPiecesIsReadBackWhole) {
  const TempFolder folder;
  const std::string path = folder.file("a.safetensors");
  const std::vector<float> x{1, -2, 0.5F, 4, 5, 6};
  const std::vector<std::uint8_t> u{7, 8, 9};
  const std::vector<std::uint16_t> h{0x3F80, 0xC000};
  SafeTensorsWriter writer(path,
                           {{"u", {DType::u8, {3}}},
                            {"x", {DType::f32, {2, 3}}},
                            {"h", {DType::bf16, {2}}},
                            {"empty", {DType::f32, {0, 4}}},
                            {"scalar", {DType::i64, {}}}},
                           {{"made by", "a \"test\" \xC3\xA9"}});
  writer.append("x", bytes_of(x).first(8));
  writer.append("u", bytes_of(u));
  writer.append("x", bytes_of(x).subspan(8));
  writer.append("scalar", bytes_of(std::vector<std::int64_t>{-3}));
  writer.append("h", bytes_of(h));
  EXPECT_FALSE(std::filesystem::exists(path));
  writer.commit();

  const SafeTensors file = SafeTensors::open(path);
  EXPECT_THAT(file.names(), ElementsAre("empty", "h", "scalar", "u", "x"));
  EXPECT_EQ(file.as_float("x"), x);
  EXPECT_EQ(file.as_u8("u"), u);
  EXPECT_THAT(file.as_float("h"), ElementsAre(1.F, -2.F));
  EXPECT_THAT(file.as_i64("scalar"), ElementsAre(-3));
  EXPECT_THAT(file.info("empty").shape, ElementsAre(0U, 4U));
  EXPECT_EQ(file.metadata().at("made by"), "a \"test\" \xC3\xA9");
}

TEST(SafeTensorsWriter, EveryTensorIsAlignedToItsNumbers) {
  const TempFolder folder;
  for (int odd = 1; odd < 20; ++odd) {
    const std::string path = folder.file("a.safetensors");
    const std::vector<std::uint8_t> u(static_cast<std::size_t>(odd), 1);
    const std::vector<std::uint16_t> h(static_cast<std::size_t>(odd), 2);
    const std::vector<float> x(static_cast<std::size_t>(odd), 3);
    write_safetensors(path, {{std::string(static_cast<std::size_t>(odd), 'a'), {{DType::u8, {u.size()}}, bytes_of(u)}},
                             {"h", {{DType::f16, {h.size()}}, bytes_of(h)}},
                             {"x", {{DType::f32, {x.size()}}, bytes_of(x)}}});
    const SafeTensors file = SafeTensors::open(path);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(file.bytes("x").data()) % 4, 0U) << odd;
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(file.bytes("h").data()) % 2, 0U) << odd;
  }
}

TEST(SafeTensorsWriter, NothingIsLeftBehindWithoutCommit) {
  const TempFolder folder;
  { const SafeTensorsWriter writer(folder.file("a.safetensors"), {{"x", {DType::f32, {2}}}}); }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(SafeTensorsWriter, AnEmptyFileIsAFile) {
  const TempFolder folder;
  write_safetensors(folder.file("none.safetensors"), {});
  EXPECT_THAT(SafeTensors::open(folder.file("none.safetensors")).names(), IsEmpty());
}

TEST(SafeTensorsWriter, MistakesAreNamed) {
  const TempFolder folder;
  const std::string path = folder.file("a.safetensors");
  const std::vector<float> three{1, 2, 3};
  SafeTensorsWriter writer(path, {{"x", {DType::f32, {2}}}});
  EXPECT_THAT(mistake([&] { writer.append("y", bytes_of(three)); }), HasSubstr("'y'"));
  EXPECT_THAT(mistake([&] { writer.append("x", bytes_of(three)); }), HasSubstr("8 bytes"));
  EXPECT_THAT(mistake([&] { writer.commit(); }), HasSubstr("0 of the 8 bytes of tensor 'x'"));
  EXPECT_THAT(mistake([&] {
                SafeTensorsWriter(path, {{"__metadata__", {DType::f32, {2}}}});
              }),
              HasSubstr("__metadata__"));
  EXPECT_THAT(mistake([&] {
                SafeTensorsWriter(path, {{"x", {DType::f32, {1UL << 40, 1UL << 40}}}});
              }),
              HasSubstr("overflows"));
  const std::string nowhere = folder.file("no/such/folder.safetensors");
  expect_error(ErrorCode::output_failed, nowhere, [&] { write_safetensors(nowhere, {}); });
}

}  // namespace
}  // namespace uwv
