// SPDX-License-Identifier: Apache-2.0
// NumPy's array files: .npy (one array) and .npz (a zip of named .npy arrays), read and written slice by slice so that
// a clip of depths never has to fit in memory.
//
// Read: versions 1 to 3, both byte orders, C and Fortran order, stored or deflated members, zip64. Values: b1, i1-i8,
// u1-u8, f2, f4, f8. Structured, object, string and complex arrays are refused.
// Written: version 1, little-endian, C order.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "uwv/io/dtype.h"

namespace uwv {

/// What an .npy header says.
struct NpyHeader {
  DType dtype = DType::f32;
  ByteOrder byte_order = ByteOrder::little;
  bool fortran_order = false;      ///< True: the first index varies fastest in the file.
  std::vector<std::size_t> shape;  ///< Empty = a scalar.
  std::size_t values() const;      ///< Product of the shape; 1 for a scalar.
};

/// Names of the arrays in an .npz file (without ".npy"), in file order. Throws Error(file_damaged).
std::vector<std::string> npz_names(const std::string& path);
/// True when the file starts like a zip file.
bool is_npz(const std::string& path);

/// Reads slices along the first dimension of one array.
///
/// Memory is independent of the array's size. Any order of slices is allowed; what it costs depends on the file:
/// .npy and stored .npz members seek; deflated members are fast forwards and start over when going back; Fortran-order
/// arrays are read through in full for every call.
class NpyArrayReader {
 public:
  /// `member` names the array inside an .npz; it may be empty when there is only one, and is ignored for .npy.
  /// Throws Error(file_not_found), Error(format_unknown) when the file is neither or its values are of a type we do
  /// not read, Error(value_invalid) for a missing member, Error(file_damaged) when header and file contradict.
  explicit NpyArrayReader(const std::string& path, const std::string& member = "");
  ~NpyArrayReader();
  NpyArrayReader(NpyArrayReader&&) noexcept;
  NpyArrayReader& operator=(NpyArrayReader&&) noexcept;

  const NpyHeader& header() const;
  /// Length of the first dimension; 1 for a scalar.
  std::size_t slices() const;
  /// Values per slice.
  std::size_t slice_values() const;

  /// Reads whole slices from slice `first` on into `out`, in C order; out.size() must be a multiple of slice_values().
  /// Throws std::invalid_argument outside the array, Error(file_damaged) when the data ends early or fails its
  /// checksum (.npz; checked when an array is read from its start to its end), and Error(value_invalid) when
  /// floating-point values are read as integers.
  void read(std::size_t first, std::span<float> out);
  void read(std::size_t first, std::span<double> out);
  void read(std::size_t first, std::span<std::int64_t> out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Writes one array as .npy. `bytes` are the values, little-endian, C order.
void write_npy(const std::string& path, DType type, const std::vector<std::size_t>& shape,
               std::span<const std::byte> bytes);
template <class T>
void write_npy(const std::string& path, const std::vector<std::size_t>& shape, std::span<const T> values) {
  write_npy(path, dtype_of<T>(), shape, std::as_bytes(values));
}

/// Writes an .npz file member by member. A member may be streamed: its slices are appended one at a time and its first
/// dimension is filled in when it ends. The file appears under its name only after finish(); without it nothing is
/// left behind. Failures are Error(output_failed).
class NpzWriter {
 public:
  explicit NpzWriter(const std::string& path);
  ~NpzWriter();
  NpzWriter(const NpzWriter&) = delete;
  NpzWriter& operator=(const NpzWriter&) = delete;

  /// Starts a streamed member. `slice_shape` is the shape without its first dimension. `deflate_level` 0 stores
  /// (fastest, and readers can seek), 1 to 9 compress.
  void begin(const std::string& name, DType type, const std::vector<std::size_t>& slice_shape, int deflate_level = 0);
  /// Appends one slice; `bytes` must have exactly its size.
  void append(std::span<const std::byte> bytes);
  template <class T>
  void append(std::span<const T> slice) {
    append(std::as_bytes(slice));
  }
  /// Ends the streamed member.
  void end();

  /// Adds a whole array.
  void add(const std::string& name, DType type, const std::vector<std::size_t>& shape, std::span<const std::byte> bytes,
           int deflate_level = 0);
  template <class T>
  void add(const std::string& name, const std::vector<std::size_t>& shape, std::span<const T> values) {
    add(name, dtype_of<T>(), shape, std::as_bytes(values));
  }

  /// Writes the directory and gives the file its name. No member may be under way.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace uwv
