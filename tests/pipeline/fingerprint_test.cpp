// SPDX-License-Identifier: Apache-2.0
#include "pipeline/fingerprint.h"

#include <gtest/gtest.h>

#include "support/temp_folder.h"

namespace uwv::pipeline {
namespace {

TEST(Fingerprint, Sha256OfKnownText) {  // FIPS 180-4's own examples
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(Fingerprint, FileIdentityFollowsItsEnds) {
  const test::TempFolder folder;
  std::string bytes(300 * 1024, 'x');
  const auto hash_of = [&] { return input_identity(folder.write("a", bytes))["sha256"]; };
  const auto first = hash_of();
  bytes.back() = 'y';
  const auto other_end = hash_of();
  bytes.back() = 'x';
  EXPECT_NE(first, other_end);
  EXPECT_EQ(first, hash_of());
  EXPECT_EQ(input_identity(folder.file("a"))["bytes"], bytes.size());
}

TEST(Fingerprint, EmptyAndTinyFiles) {
  const test::TempFolder folder;
  EXPECT_EQ(input_identity(folder.write("empty", ""))["bytes"], 0);
  EXPECT_NE(input_identity(folder.write("one", "1"))["sha256"], input_identity(folder.write("two", "2"))["sha256"]);
}

TEST(Fingerprint, FolderAndPatternFollowTheirFiles) {
  const test::TempFolder folder;
  folder.write("f1.png", "a");
  const auto before = input_identity(folder.path().string());
  EXPECT_EQ(before["files"], 1);
  EXPECT_EQ(before, input_identity(folder.file("f%d.png")));
  folder.write("f2.png", "b");
  EXPECT_NE(before["sha256"], input_identity(folder.path().string())["sha256"]);
}

TEST(Fingerprint, MissingInputIsNull) { EXPECT_TRUE(input_identity("no/such/place/x.mp4").is_null()); }

}  // namespace
}  // namespace uwv::pipeline
