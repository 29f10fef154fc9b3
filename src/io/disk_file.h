// SPDX-License-Identifier: Apache-2.0
// Files on disk for the readers and writers of this module: random-access input, mapped input, and output that appears
// under its final name only when it is whole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace uwv::io {

/// A regular file opened for reading. Throws Error(file_not_found) when it cannot be opened or is a folder or device.
class InputFile {
 public:
  explicit InputFile(const std::string& path);
  ~InputFile();
  InputFile(InputFile&& other) noexcept;
  InputFile& operator=(InputFile&&) = delete;

  const std::string& path() const { return path_; }
  std::uint64_t size() const { return size_; }
  int descriptor() const { return descriptor_; }
  /// Fills `out` from byte `offset` on. Throws Error(file_damaged) when the file ends before.
  void read_at(std::uint64_t offset, std::span<std::byte> out) const;

 private:
  std::string path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

/// The whole of a text file. Throws Error(file_damaged) when it is larger than `max_bytes`.
std::string read_text(const std::string& path, std::uint64_t max_bytes);

/// A file mapped into memory, read only.
class MappedFile {
 public:
  explicit MappedFile(const std::string& path);
  ~MappedFile();
  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&& other) noexcept;

  std::span<const std::byte> bytes() const { return {data_, size_}; }

 private:
  const std::byte* data_ = nullptr;
  std::size_t size_ = 0;
};

/// A file being written. Bytes go to "<path>.part", renamed to `path` by commit(); without commit() nothing is left
/// behind. Every failure is Error(output_failed).
class OutputFile {
 public:
  explicit OutputFile(std::string path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  const std::string& path() const { return path_; }
  /// Bytes appended so far.
  std::uint64_t position() const { return position_; }
  void append(std::span<const std::byte> bytes);
  void append(std::string_view text);
  /// Appends zero bytes, which take no room on disk until they are overwritten.
  void extend(std::uint64_t bytes);
  /// Overwrites bytes that were appended before.
  void patch(std::uint64_t offset, std::span<const std::byte> bytes);
  void commit();

 private:
  void write_at(std::uint64_t offset, std::span<const std::byte> bytes);

  std::string path_;
  std::string part_path_;
  int descriptor_ = -1;
  std::uint64_t position_ = 0;
};

/// Writes a whole small file.
void write_file(const std::string& path, std::span<const std::byte> bytes);
void write_file(const std::string& path, std::string_view text);

}  // namespace uwv::io
