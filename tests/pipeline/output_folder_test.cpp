// SPDX-License-Identifier: Apache-2.0
#include "pipeline/output_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "support/temp_folder.h"
#include "uwv/core/error.h"

namespace uwv::pipeline {
namespace {

namespace fs = std::filesystem;

void put(const std::string& path, std::string_view text) { std::ofstream(path) << text; }

class OutputFolderTest : public testing::Test {
 protected:
  std::string out() const { return temp_.file("out"); }
  /// Publishes a stage of one file.
  void publish(OutputFolder& folder, const std::string& key, const std::string& file, std::string_view text) const {
    const PartialFolder partial = folder.begin("make");
    put(partial.file(file), text);
    folder.publish("make", key, partial, {{"frames", 3}});
  }
  test::TempFolder temp_;
};

TEST_F(OutputFolderTest, FinishedStageIsFoundByItsKeyOnly) {
  OutputFolder folder(out());
  EXPECT_FALSE(folder.finished("make", "k1"));
  publish(folder, "k1", "a.txt", "one");
  EXPECT_EQ(temp_.read("out/a.txt"), "one");
  EXPECT_EQ(folder.finished("make", "k1").value()["frames"], 3);
  EXPECT_FALSE(folder.finished("make", "k2"));
  EXPECT_FALSE(fs::exists(out() + "/.partial-make"));
}

TEST_F(OutputFolderTest, ChangedOrMissingFilesMakeTheStageUnfinished) {
  OutputFolder folder(out());
  publish(folder, "k1", "a.txt", "one");
  put(folder.file("a.txt"), "longer");
  EXPECT_FALSE(folder.finished("make", "k1"));
  fs::remove(folder.file("a.txt"));
  EXPECT_FALSE(folder.finished("make", "k1"));
}

TEST_F(OutputFolderTest, RepublishingRemovesWhatIsNoLongerMade) {
  OutputFolder folder(out());
  publish(folder, "k1", "a.txt", "one");
  publish(folder, "k2", "b.txt", "two");
  EXPECT_FALSE(fs::exists(folder.file("a.txt")));
  EXPECT_EQ(temp_.read("out/b.txt"), "two");
  EXPECT_TRUE(folder.finished("make", "k2"));
  folder.retract("make");
  EXPECT_FALSE(fs::exists(folder.file("b.txt")));
  EXPECT_FALSE(folder.has_marker("make"));
}

TEST_F(OutputFolderTest, AbandonedStageLeavesNothing) {
  {
    const OutputFolder folder(out());
    const PartialFolder partial = folder.begin("make");
    put(partial.file("a.txt"), "half");
  }
  EXPECT_FALSE(fs::exists(out()));
}

TEST_F(OutputFolderTest, CreatedParentsGoToo) {
  { const OutputFolder folder(temp_.file("x/y/z")); }
  EXPECT_FALSE(fs::exists(temp_.file("x")));
  fs::create_directory(temp_.file("kept"));
  { const OutputFolder folder(temp_.file("kept/y/")); }
  EXPECT_TRUE(fs::exists(temp_.file("kept")));
  EXPECT_FALSE(fs::exists(temp_.file("kept/y")));
}

TEST_F(OutputFolderTest, FoldersThatWereThereStay) {
  fs::create_directory(out());
  { const OutputFolder folder(out()); }
  EXPECT_TRUE(fs::exists(out()));
}

TEST_F(OutputFolderTest, LeftoversOfAKilledRunAreCleared) {
  fs::create_directories(out() + "/.partial-make");
  put(out() + "/.partial-make/old.txt", "old");
  OutputFolder folder(out());
  publish(folder, "k1", "a.txt", "one");
  EXPECT_FALSE(fs::exists(folder.file("old.txt")));
}

TEST_F(OutputFolderTest, KilledWhilePublishingIsRedoneWithoutRefusal) {
  OutputFolder folder(out());
  put(folder.file(".stage-make.json"),
      R"({"state": "publishing", "key": "", "files": {"a.txt": 3, "b.txt": 3}, "record": null})");
  put(folder.file("a.txt"), "new");
  EXPECT_FALSE(folder.finished("make", "k1"));
  EXPECT_NO_THROW(folder.refuse_foreign({"a.txt", "b.txt"}, false));
  publish(folder, "k1", "a.txt", "one");
  EXPECT_TRUE(folder.finished("make", "k1"));
}

TEST_F(OutputFolderTest, ForeignFilesAreRefusedUnlessToldOtherwise) {
  OutputFolder folder(out());
  put(folder.file("a.txt"), "precious");
  EXPECT_THROW(folder.refuse_foreign({"a.txt"}, false), Error);
  EXPECT_NO_THROW(folder.refuse_foreign({"a.txt"}, true));
  EXPECT_NO_THROW(folder.refuse_foreign({"b.txt"}, false));
  put(folder.file("run.json"), R"({"program": "another"})");
  EXPECT_THROW(folder.refuse_foreign({"run.json"}, false), Error);
  folder.write_record({{"program", "uwv_app"}});
  EXPECT_NO_THROW(folder.refuse_foreign({"run.json"}, false));
}

TEST_F(OutputFolderTest, HostileMarkersAreIgnored) {
  OutputFolder folder(out());
  for (const char* text : {"", "{", "[]", "3", R"({"files": 3, "key": "k1", "record": {}})",
                           R"({"files": {"../x": 1}, "key": 3, "record": {}})"}) {
    put(folder.file(".stage-make.json"), text);
    EXPECT_FALSE(folder.finished("make", "k1")) << text;
  }
  put(temp_.file("outside"), "keep");
  put(folder.file(".stage-make.json"), R"({"files": {"../outside": 4, "..": 0, "": 0}, "key": "k1", "record": {}})");
  folder.retract("make");
  EXPECT_TRUE(fs::exists(temp_.file("outside")));
}

TEST_F(OutputFolderTest, SecondRunIsLockedOut) {
  const OutputFolder folder(out());
  EXPECT_THROW(OutputFolder{out()}, Error);
}

TEST_F(OutputFolderTest, AFileIsNoFolder) { EXPECT_THROW(OutputFolder{temp_.write("plain", "x")}, Error); }

TEST_F(OutputFolderTest, InputsAreNeverOverwritten) {
  fs::create_directory(out());
  put(out() + "/colour.mp4", "input");
  const std::vector<std::string> names = {"colour.mp4", "depth"};
  EXPECT_THROW(refuse_overwriting_inputs(out(), names, {out() + "/colour.mp4"}), Error);
  EXPECT_THROW(refuse_overwriting_inputs(out() + "/../out/", names, {out() + "/./colour.mp4"}), Error);
  EXPECT_NO_THROW(refuse_overwriting_inputs(out(), names, {out() + "/other.mp4", ""}));

  fs::create_directory(out() + "/depth");
  put(out() + "/depth/0.png", "x");
  EXPECT_THROW(refuse_overwriting_inputs(out(), names, {out() + "/depth"}), Error);
  EXPECT_THROW(refuse_overwriting_inputs(out(), names, {out() + "/depth/%d.png"}), Error);

  EXPECT_THROW(refuse_overwriting_inputs(out(), names, {out()}), Error) << "a folder of pictures as input and output";
  EXPECT_THROW(refuse_overwriting_inputs(out(), names, {out() + "/frame_*.png"}), Error);

  fs::create_symlink(out() + "/colour.mp4", temp_.file("link.mp4"));
  EXPECT_THROW(refuse_overwriting_inputs(out(), names, {temp_.file("link.mp4")}), Error);
}

}  // namespace
}  // namespace uwv::pipeline
