// SPDX-License-Identifier: Apache-2.0
// Memory must not grow with the length of a clip.
#include <gtest/gtest.h>

#include <fstream>

#include "io/clip_fixtures.h"
#include "support/temp_folder.h"

namespace uwv {
namespace {

using namespace test;

long resident_kilobytes() {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word)
    if (word == "VmRSS:") {
      long kilobytes = 0;
      status >> kilobytes;
      return kilobytes;
    }
  return 0;
}

TEST(ClipMemory, stays_level_over_2000_frames) {
#ifdef UWV_SANITIZED
  GTEST_SKIP() << "the sanitizer keeps freed memory";
#endif
  if (resident_kilobytes() == 0) GTEST_SKIP() << "no /proc/self/status";
  const TempFolder folder;
  const Size size{160, 120};  // a frame is 58 kB: keeping one in ten would show
  {
    VideoWriter writer(folder.file("long.mp4"), size);
    const ImageRgb a = smooth_picture(size, 0), b = smooth_picture(size, 1);
    long early = 0;
    for (int i = 0; i < 2000; ++i) {
      writer.write(i % 2 == 0 ? a : b);
      if (i == 200) early = resident_kilobytes();
    }
    EXPECT_LT(resident_kilobytes() - early, 8000) << "while writing";
    writer.finish();
  }
  Monitor monitor;
  const auto clip = open_clip(folder.file("long.mp4"), whole_clip_unresized(), monitor);
  ASSERT_EQ(clip->frames(), 2000);
  ImageRgb frame;
  long early = 0;
  for (long i = 0; i < 2000; ++i) {
    ASSERT_TRUE(clip->read(i, frame));
    if (i == 200) early = resident_kilobytes();
  }
  EXPECT_LT(resident_kilobytes() - early, 8000) << "while reading";
}

}  // namespace
}  // namespace uwv
