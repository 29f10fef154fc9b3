// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "io/hostile.h"
#include "io/image_sequence.h"

namespace uwv {
namespace {

using test::TempFolder;
using ::testing::ElementsAre;

TEST(NaturalOrder, numbers_count_as_numbers) {
  const std::vector<std::string> sorted{"a",
                                        "a1b",
                                        "a2",
                                        "a2b",
                                        "a10",
                                        "a10b1",
                                        "a10b2",
                                        "b0",
                                        "b000",
                                        "b00001",
                                        "b2",
                                        "b002",
                                        "frame99999999999999999999"};
  std::vector<std::string> shuffled = sorted;
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(3));
  std::sort(shuffled.begin(), shuffled.end(), natural_less);
  const auto at = [&](const std::string& name) { return std::find(shuffled.begin(), shuffled.end(), name); };
  EXPECT_LT(at("a2"), at("a10"));
  EXPECT_LT(at("a10b1"), at("a10b2"));
  EXPECT_LT(at("b000"), at("b00001"));
  EXPECT_LT(at("b00001"), at("b2"));
  EXPECT_LT(at("a"), at("a1b"));
}

TEST(NaturalOrder, is_a_strict_weak_order) {
  std::mt19937 random(5);
  const std::string letters = "01a2";
  std::vector<std::string> names;
  for (int i = 0; i < 60; ++i) {
    std::string name;
    for (unsigned n = random() % 5; n > 0; --n) name += letters[random() % letters.size()];
    names.push_back(name);
  }
  for (const auto& a : names)
    for (const auto& b : names) {
      ASSERT_EQ(natural_less(a, b) + natural_less(b, a), a == b ? 0 : 1) << a << " and " << b;
      for (const auto& c : names)
        ASSERT_FALSE(natural_less(a, b) && natural_less(b, c) && !natural_less(a, c)) << a << ", " << b << ", " << c;
    }
}

std::vector<std::string> names_of(const std::vector<std::string>& paths) {
  std::vector<std::string> names;
  for (const auto& path : paths) names.push_back(path.substr(path.rfind('/') + 1));
  return names;
}

class PictureList : public ::testing::Test {
 protected:
  PictureList() {
    for (const char* name : {"f_2.png", "f_10.png", "f_001.PNG", "f_x.png", ".hidden.png", "notes.txt", "g_7.jpg"})
      folder.write(name, "x");
  }
  TempFolder folder;
};

TEST_F(PictureList, folder_lists_visible_pictures_in_natural_order) {
  EXPECT_THAT(names_of(pictures_in_folder(folder.path().string())),
              ElementsAre("f_001.PNG", "f_2.png", "f_10.png", "f_x.png", "g_7.jpg"));
}

TEST_F(PictureList, patterns) {
  EXPECT_THAT(names_of(*files_matching(folder.file("f_%d.png"))), ElementsAre("f_2.png", "f_10.png"));
  EXPECT_THAT(names_of(*files_matching(folder.file("f_%02d.png"))), ElementsAre("f_10.png"));
  EXPECT_THAT(names_of(*files_matching(folder.file("f_*.png"))), ElementsAre("f_2.png", "f_10.png", "f_x.png"));
  EXPECT_THAT(names_of(*files_matching(folder.file("?_?.*"))), ElementsAre("f_2.png", "f_x.png", "g_7.jpg"));
  EXPECT_FALSE(files_matching(folder.file("f_2.png")));
  EXPECT_FALSE(files_matching(folder.file("50%.png")));
  const std::string none = folder.file("h_%d.png");
  test::expect_error(ErrorCode::file_not_found, none, [&] { files_matching(none); });
  const std::string nowhere = folder.file("nowhere/*.png");
  test::expect_error(ErrorCode::file_not_found, nowhere, [&] { files_matching(nowhere); });
}

TEST(PictureListErrors, folder_without_pictures) {
  const TempFolder folder;
  folder.write("notes.txt", "x");
  test::expect_error(ErrorCode::format_unknown, folder.path().string(),
                     [&] { pictures_in_folder(folder.path().string()); });
}

}  // namespace
}  // namespace uwv
