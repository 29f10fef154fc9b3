// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/disk_speed.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <chrono>
#include <fstream>

#include "support/temp_folder.h"

namespace uwv::model {
namespace {

constexpr std::size_t file_bytes = 48 << 20;

/// Of what is on the disk, so that the system can let go of it.
std::string written_file(const test::TempFolder& folder) {
  const std::string path = folder.file("weights.safetensors");
  std::ofstream(path, std::ios::binary) << std::string(file_bytes, 'x');
  const int file = open(path.c_str(), O_RDONLY);
  fsync(file);
  close(file);
  return path;
}

TEST(DiskSpeed, IsMeasuredInAMomentOrUnknown) {
  const test::TempFolder folder;
  const std::string path = written_file(folder);
  const auto start = std::chrono::steady_clock::now();
  const auto speed = disk_speed({path});
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 20);
  if (!speed) GTEST_SKIP() << "the system keeps the file in memory";
  EXPECT_GT(speed->bytes_a_second, 1e5);
  EXPECT_GT(speed->cached, 0.5);  // just written
  EXPECT_LE(speed->cached, 1);
}

TEST(DiskSpeed, OfWhatStaysInMemoryIsUnknown) {
  const test::TempFolder folder;
  const std::string path = written_file(folder);
  const int file = open(path.c_str(), O_RDONLY);
  void* const pages = mmap(nullptr, file_bytes, PROT_READ, MAP_SHARED, file, 0);
  ASSERT_NE(pages, MAP_FAILED);
  // Mapped pages that were read are not let go of.
  volatile char sum = 0;
  for (std::size_t i = 0; i < file_bytes; i += 4096) sum = static_cast<char>(sum + static_cast<const char*>(pages)[i]);
  EXPECT_FALSE(disk_speed({path}));
  munmap(pages, file_bytes);
  close(file);
}

TEST(DiskSpeed, OfNothingIsUnknown) {
  const test::TempFolder folder;
  EXPECT_FALSE(disk_speed({}));
  EXPECT_FALSE(disk_speed({folder.file("missing")}));
  std::ofstream(folder.file("empty"));
  EXPECT_FALSE(disk_speed({folder.file("empty")}));
}

}  // namespace
}  // namespace uwv::model
