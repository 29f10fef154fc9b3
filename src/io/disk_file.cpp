// SPDX-License-Identifier: Apache-2.0
#include "io/disk_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include "uwv/core/error.h"

namespace uwv::io {

InputFile::InputFile(const std::string& path) : path_(path) {
  // Non-blocking, so that a named pipe is refused below instead of waited for.
  descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor_ < 0) fail(ErrorCode::file_not_found, "{}: cannot be opened ({})", path, std::strerror(errno));
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(descriptor_);
    fail(ErrorCode::file_not_found, "{}: is a folder or a device; a file is wanted", path);
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
}

InputFile::~InputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

InputFile::InputFile(InputFile&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)), size_(other.size_) {}

void InputFile::read_at(std::uint64_t offset, std::span<std::byte> out) const {
  if (offset > size_ || out.size() > size_ - offset)
    fail(ErrorCode::file_damaged, "{}: the file has {} bytes, but {} are wanted at offset {}; it was cut short", path_,
         size_, out.size(), offset);
  while (!out.empty()) {
    const ssize_t got = ::pread(descriptor_, out.data(), out.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0)
      fail(ErrorCode::file_damaged, "{}: reading at offset {} failed ({})", path_, offset,
           got < 0 ? std::strerror(errno) : "the file ends there");
    out = out.subspan(static_cast<std::size_t>(got));
    offset += static_cast<std::uint64_t>(got);
  }
}

std::string read_text(const std::string& path, std::uint64_t max_bytes) {
  const InputFile file(path);
  if (file.size() > max_bytes)
    fail(ErrorCode::file_damaged, "{}: {} bytes are too many for a text file of this kind (at most {})", path,
         file.size(), max_bytes);
  std::string text(static_cast<std::size_t>(file.size()), '\0');
  file.read_at(0, std::as_writable_bytes(std::span(text)));
  return text;
}

MappedFile::MappedFile(const std::string& path) {
  const InputFile file(path);
  size_ = static_cast<std::size_t>(file.size());
  if (size_ == 0) return;
  void* mapped = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file.descriptor(), 0);
  if (mapped == MAP_FAILED)
    fail(ErrorCode::file_not_found, "{}: cannot be mapped into memory ({})", path, std::strerror(errno));
  data_ = static_cast<const std::byte*>(mapped);
}

MappedFile::~MappedFile() {
  if (data_ != nullptr) ::munmap(const_cast<std::byte*>(data_), size_);
}

MappedFile::MappedFile(MappedFile&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}

MappedFile& MappedFile::operator=(MappedFile&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  return *this;
}

OutputFile::OutputFile(std::string path) : path_(std::move(path)), part_path_(path_ + ".part") {
  descriptor_ = ::open(part_path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor_ < 0) fail(ErrorCode::output_failed, "{}: cannot be created ({})", part_path_, std::strerror(errno));
}

OutputFile::~OutputFile() {
  if (descriptor_ < 0) return;
  ::close(descriptor_);
  ::unlink(part_path_.c_str());
}

void OutputFile::append(std::span<const std::byte> bytes) {
  write_at(position_, bytes);
  position_ += bytes.size();
}

void OutputFile::append(std::string_view text) { append(std::as_bytes(std::span(text))); }

void OutputFile::extend(std::uint64_t bytes) {
  require(descriptor_ >= 0, "{}: is already finished", path_);
  if (::ftruncate(descriptor_, static_cast<off_t>(position_ + bytes)) != 0)
    fail(ErrorCode::output_failed, "{}: cannot be made {} bytes long ({})", path_, position_ + bytes,
         std::strerror(errno));
  position_ += bytes;
}

void OutputFile::patch(std::uint64_t offset, std::span<const std::byte> bytes) {
  require(offset <= position_ && bytes.size() <= position_ - offset, "{}: a patch of {} bytes at {} is outside the {}",
          path_, bytes.size(), offset, position_);
  write_at(offset, bytes);
}

void OutputFile::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
  require(descriptor_ >= 0, "{}: is already finished", path_);
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail(ErrorCode::output_failed, "{}: writing failed ({})", path_, std::strerror(errno));
    bytes = bytes.subspan(static_cast<std::size_t>(written));
    offset += static_cast<std::uint64_t>(written);
  }
}

void OutputFile::commit() {
  require(descriptor_ >= 0, "{}: is already finished", path_);
  const int closed = ::close(std::exchange(descriptor_, -1));
  if (closed != 0 || std::rename(part_path_.c_str(), path_.c_str()) != 0) {
    const int reason = errno;
    ::unlink(part_path_.c_str());
    fail(ErrorCode::output_failed, "{}: cannot be completed ({})", path_, std::strerror(reason));
  }
}

void write_file(const std::string& path, std::span<const std::byte> bytes) {
  OutputFile file(path);
  file.append(bytes);
  file.commit();
}

void write_file(const std::string& path, std::string_view text) { write_file(path, std::as_bytes(std::span(text))); }

}  // namespace uwv::io
