// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/disk_speed.h"

#ifdef __linux__

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <memory>
#include <set>
#include <utility>

namespace uwv::model {
namespace {

constexpr double most_seconds = 0.3;
/// As large as a matrix of a block, so that the disk is asked for as much at once; enough of them to be spread out.
constexpr std::int64_t piece_bytes = 16 << 20, most_pieces = 64;
/// Of a piece, what may be left in memory after it was dropped.
constexpr double most_left = 0.05;

class OpenFile {
 public:
  explicit OpenFile(const std::string& path) : handle_(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {}
  ~OpenFile() {
    if (handle_ >= 0) close(handle_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  std::int64_t bytes() const {
    struct stat about {};
    return handle_ >= 0 && fstat(handle_, &about) == 0 ? about.st_size : 0;
  }
  /// Share of a piece that is in the system's cache; 1 where it does not tell.
  double cached(std::int64_t begin, std::int64_t size) const {
    void* const mapped = mmap(nullptr, static_cast<std::size_t>(size), PROT_READ, MAP_SHARED, handle_, begin);
    if (mapped == MAP_FAILED) return 1;
    const std::int64_t page = sysconf(_SC_PAGESIZE);
    std::vector<unsigned char> there(static_cast<std::size_t>((size + page - 1) / page), 1);
    mincore(mapped, static_cast<std::size_t>(size), there.data());
    munmap(mapped, static_cast<std::size_t>(size));
    const auto count = std::count_if(there.begin(), there.end(), [](unsigned char c) { return (c & 1U) != 0; });
    return static_cast<double>(count) / static_cast<double>(there.size());
  }
  void drop(std::int64_t begin, std::int64_t size) const { posix_fadvise(handle_, begin, size, POSIX_FADV_DONTNEED); }
  /// Bytes that came.
  std::int64_t read(std::int64_t begin, std::int64_t size, std::vector<char>& into) const {
    posix_fadvise(handle_, begin, size, POSIX_FADV_WILLNEED);
    std::int64_t done = 0;
    while (done < size) {
      const auto count = pread(handle_, into.data(), static_cast<std::size_t>(size - done), begin + done);
      if (count <= 0) break;
      done += count;
    }
    return done;
  }

 private:
  int handle_;
};

struct Piece {
  const OpenFile* file = nullptr;
  std::int64_t begin = 0, size = 0;
};

/// No two overlap, and the first few are already far apart.
std::vector<Piece> scattered_pieces(const std::vector<std::unique_ptr<OpenFile>>& files) {
  constexpr double golden = 0.6180339887;
  std::vector<Piece> pieces;
  std::set<std::pair<std::size_t, std::int64_t>> taken;
  for (int k = 0; k < most_pieces; ++k)
    for (std::size_t f = 0; f < files.size(); ++f) {
      const std::int64_t bytes = files[f]->bytes(), count = (bytes + piece_bytes - 1) / piece_bytes;
      const double place = std::fmod(k * golden, 1.0);
      const auto piece = static_cast<std::int64_t>(place * static_cast<double>(count));
      if (bytes == 0 || !taken.emplace(f, piece).second) continue;
      const std::int64_t begin = piece * piece_bytes;
      pieces.push_back({files[f].get(), begin, std::min(piece_bytes, bytes - begin)});
    }
  return pieces;
}

}  // namespace

std::optional<DiskSpeed> disk_speed(const std::vector<std::string>& files) {
  std::vector<std::unique_ptr<OpenFile>> open;
  for (const std::string& path : files) open.push_back(std::make_unique<OpenFile>(path));
  using Clock = std::chrono::steady_clock;
  const auto seconds_since = [](Clock::time_point t) {
    return std::chrono::duration<double>(Clock::now() - t).count();
  };
  const auto start = Clock::now();
  std::vector<char> into(static_cast<std::size_t>(piece_bytes));
  double looked_at = 0, cached = 0, read = 0, seconds = 0;
  for (const Piece& piece : scattered_pieces(open)) {
    if (seconds_since(start) > most_seconds) break;
    looked_at += static_cast<double>(piece.size);
    cached += static_cast<double>(piece.size) * piece.file->cached(piece.begin, piece.size);
    piece.file->drop(piece.begin, piece.size);
    if (piece.file->cached(piece.begin, piece.size) > most_left) continue;
    const auto before = Clock::now();
    read += static_cast<double>(piece.file->read(piece.begin, piece.size, into));
    seconds += seconds_since(before);
  }
  if (read == 0) return std::nullopt;
  return DiskSpeed{read / seconds, cached / looked_at};
}

}  // namespace uwv::model

#else

namespace uwv::model {
std::optional<DiskSpeed> disk_speed(const std::vector<std::string>&) { return std::nullopt; }
}  // namespace uwv::model

#endif
