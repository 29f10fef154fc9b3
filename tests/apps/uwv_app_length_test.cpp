// SPDX-License-Identifier: Apache-2.0
// Clips of one frame and of thousands.
#include <gtest/gtest.h>

#include "apps/clip_maker.h"
#include "apps/program.h"
#include "uwv/io/npy.h"

namespace uwv::test {
namespace {

long peak_kib_of_a_run(const TempFolder& folder, long frames) {
  make_clip(folder, {.size = {96, 64}, .frames = frames});
  const Outcome outcome = run_app(folder.path().string(), run_arguments(std::to_string(frames), {"--max-frames", "0"}));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(NpyArrayReader(folder.file(std::to_string(frames) + "/depth.npz"), "depth").slices(),
            static_cast<std::size_t>(frames));
  return outcome.peak_kib;
}

TEST(ClipLength, OneFrame) {
  const TempFolder folder;
  peak_kib_of_a_run(folder, 1);
}

TEST(ClipLength, MemoryDoesNotGrowWithTheClip) {
  const TempFolder folder;
  const long of_100 = peak_kib_of_a_run(folder, 100);
  const long of_2000 = peak_kib_of_a_run(folder, 2000);
#if !defined(UWV_SANITIZED)  // the sanitizer keeps freed memory
  // 2000 frames of colour and depth would be 80 MiB; poses and packets' positions may take their few.
  EXPECT_LT(of_2000 - of_100, 12 * 1024) << of_100 << " KiB for 100 frames, " << of_2000 << " KiB for 2000";
#endif
}

}  // namespace
}  // namespace uwv::test
