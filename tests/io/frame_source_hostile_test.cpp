// SPDX-License-Identifier: Apache-2.0
// Files that are not what their names say, or only part of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/clip_fixtures.h"
#include "io/hostile.h"
#include "support/matchers.h"

namespace uwv {
namespace {

using namespace test;

void expect_refused(ErrorCode code, const std::string& path) {
  expect_error(code, path, [&] { read_all(path); });
}

TEST(HostileClip, what_is_no_clip_is_refused_by_name) {
  const TempFolder folder;
  expect_refused(ErrorCode::file_not_found, folder.file("none.mp4"));
  expect_refused(ErrorCode::format_unknown, folder.path().string());
  expect_refused(ErrorCode::file_damaged, folder.write("empty.mp4", ""));
  expect_refused(ErrorCode::file_damaged, folder.write("text.mp4", "Dear diary,\ntoday I am a video.\n"));
  expect_refused(ErrorCode::file_damaged, folder.write("text.txt", std::string(3000, 'a')));
  expect_refused(ErrorCode::format_unknown, "/dev/null");
}

TEST(HostileClip, sound_without_pictures_is_refused) {
  const TempFolder folder;
  std::string wav("RIFF\x24\x10\0\0WAVEfmt \x10\0\0\0\x01\0\x01\0\x40\x1f\0\0\x80\x3e\0\0\x02\0\x10\0data\0\x10\0\0",
                  44);
  wav.resize(44 + 4096, '\0');
  expect_refused(ErrorCode::format_unknown, folder.write("sound.mp4", wav));
}

TEST(HostileClip, playlists_cannot_reach_other_files) {
  const TempFolder folder;
  const std::string secret = write_numbered_clip(folder.file("secret.mp4"), {16, 16}, 3);
  expect_refused(ErrorCode::file_damaged, folder.write("list.mp4", "ffconcat version 1.0\nfile secret.mp4\n"));
  expect_refused(
      ErrorCode::file_damaged,
      folder.write("list.m3u8", "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nsecret.mp4\n#EXT-X-ENDLIST\n"));
}

std::size_t find_box(const std::string& bytes, const std::string& type) {
  const std::size_t at = bytes.find(type);
  EXPECT_NE(at, std::string::npos) << type;
  return at;
}

// 40 frames of noise, so that bytes are spread evenly over the frames.
std::string noisy_clip(const TempFolder& folder) {
  std::mt19937 random(1);
  VideoWriter writer(folder.file("whole.mp4"), {64, 64});
  for (int i = 0; i < 40; ++i) {
    ImageRgb frame(64, 64);
    for (Rgb8& pixel : frame.pixels()) pixel.g = static_cast<std::uint8_t>(random());
    writer.write(frame);
  }
  writer.finish();
  return folder.read("whole.mp4");
}

TEST(HostileClip, a_cut_file_gives_its_readable_frames_and_one_warning) {
  const TempFolder folder;
  const std::string bytes = noisy_clip(folder);
  const std::vector<ImageRgb> whole = read_all(folder.file("whole.mp4"));
  ASSERT_EQ(whole.size(), 40U);
  const std::size_t data = find_box(bytes, "mdat");
  for (const double share : {0.3, 0.5, 0.9}) {
    const auto length = data + static_cast<std::size_t>(share * static_cast<double>(bytes.size() - data));
    const std::string cut = folder.write("cut.mp4", bytes.substr(0, length));
    RecordingMonitor monitor;
    const auto clip = open_clip(cut, whole_clip_unresized(), monitor);
    const std::vector<ImageRgb> frames = read_all(*clip);
    EXPECT_EQ(static_cast<long>(frames.size()), clip->frames());
    EXPECT_NEAR(static_cast<double>(frames.size()), 40 * share, 12);
    EXPECT_EQ(monitor.warnings.size(), 1U) << "cut to " << share;
    for (std::size_t i = 0; i + 4 < frames.size(); ++i) EXPECT_IMAGE_NEAR(frames[i], whole[i], 0);
    ClipOptions beginning = whole_clip_unresized();
    beginning.max_frames = 4;
    RecordingMonitor calm;
    EXPECT_EQ(read_all(*open_clip(cut, beginning, calm)).size(), 4U);
    EXPECT_TRUE(calm.warnings.empty()) << "what was asked for is whole: " << calm.warnings[0];
  }
}

TEST(HostileClip, a_file_without_its_last_bytes_is_called_cut) {
  const TempFolder folder;
  const std::string bytes = noisy_clip(folder);
  // Only the table of contents tells: reading ends in half a packet, or none, as it would at a proper end.
  for (const std::size_t missing : {std::size_t{1}, std::size_t{100}}) {
    RecordingMonitor monitor;
    const auto clip =
        open_clip(folder.write("cut.mp4", bytes.substr(0, bytes.size() - missing)), whole_clip_unresized(), monitor);
    EXPECT_EQ(read_all(*clip).size(), 39U);
    ASSERT_EQ(monitor.warnings.size(), 1U) << missing << " bytes missing";
    EXPECT_THAT(monitor.warnings[0], ::testing::HasSubstr("cut short"));
  }
}

TEST(HostileClip, a_file_without_its_table_of_contents_is_refused) {
  const TempFolder folder;
  const std::string bytes = noisy_clip(folder);
  expect_refused(ErrorCode::file_damaged, folder.write("cut.mp4", bytes.substr(0, find_box(bytes, "moov") + 100)));
  expect_refused(ErrorCode::file_damaged, folder.write("cut.mp4", bytes.substr(0, find_box(bytes, "mdat") + 8)));
}

TEST(HostileClip, garbage_between_frames_is_survived_and_said) {
  const TempFolder folder;
  std::string bytes = noisy_clip(folder);
  const std::size_t data = find_box(bytes, "mdat");
  const std::size_t middle = data + (bytes.size() - data) / 2;
  for (std::size_t i = middle; i < middle + 5000; ++i) bytes[i] = static_cast<char>(i * 31);
  RecordingMonitor monitor;
  const auto clip = open_clip(folder.write("bad.mp4", bytes), whole_clip_unresized(), monitor);
  const std::vector<ImageRgb> frames = read_all(*clip);
  EXPECT_EQ(static_cast<long>(frames.size()), clip->frames());
  EXPECT_GE(frames.size(), 15U);
  EXPECT_EQ(monitor.warnings.size(), 1U);
}

TEST(HostileClip, damaged_bytes_load_or_are_refused) {
  const TempFolder folder;
  write_numbered_clip(folder.file("a.mp4"), {16, 16}, 4);
  const std::string bytes = folder.read("a.mp4");
  const auto read = [](const std::string& path) { read_all(path); };
  try_truncations(bytes, "a.mp4", read, 61);
  try_byte_flips(bytes, "a.mp4", read, 120);
}

}  // namespace
}  // namespace uwv
