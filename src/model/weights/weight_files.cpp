// SPDX-License-Identifier: Apache-2.0
#include "model/weights/weight_files.h"

#include <ATen/ATen.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>

#include "io/disk_file.h"
#include "io/json_text.h"
#include "io/printable.h"
#include "model/float_tensor.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t max_index_bytes = 64'000'000;
constexpr std::size_t names_told = 10;

at::ScalarType scalar_type(DType type, const std::string& where) {
  switch (type) {
    case DType::boolean: return at::kBool;
    case DType::u8: return at::kByte;
    case DType::i8: return at::kChar;
    case DType::i16: return at::kShort;
    case DType::i32: return at::kInt;
    case DType::i64: return at::kLong;
    case DType::f8_e4m3: return at::kFloat8_e4m3fn;
    case DType::f8_e5m2: return at::kFloat8_e5m2;
    case DType::f16: return at::kHalf;
    case DType::bf16: return at::kBFloat16;
    case DType::f32: return at::kFloat;
    case DType::f64: return at::kDouble;
    case DType::u16:
    case DType::u32:
    case DType::u64: break;
  }
  fail(ErrorCode::value_invalid, "{}: is {}, a type weights are not stored in; F32, F16, BF16 or F8 are wanted", where,
       to_string(type));
}

bool is_pickle(const fs::path& file) {
  const std::string extension = file.extension().string();
  return extension == ".pt" || extension == ".pth" || extension == ".bin" || extension == ".ckpt";
}

[[noreturn]] void refuse_pickle(const fs::path& file) {
  fail(ErrorCode::format_unknown,
       "{}: is a Python pickle, which can run code when it is read, so it is not; convert it once where you trust it: "
       "python -c \"import torch, safetensors.torch as s; s.save_file({{k: v.contiguous() for k, v in "
       "torch.load('{}', weights_only=True).items()}}, 'model.safetensors')\"",
       file.string(), file.filename().string());
}

std::vector<fs::path> files_ending(const fs::path& folder, const std::string& end) {
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().filename().string().ends_with(end)) found.push_back(entry.path());
  std::sort(found.begin(), found.end());
  return found;
}

/// The file that Hugging Face's libraries would read of a folder that holds others, too.
std::optional<fs::path> usual_file(const fs::path& folder) {
  for (const char* name : {"diffusion_pytorch_model.safetensors", "model.safetensors"})
    if (fs::is_regular_file(folder / name)) return folder / name;
  return std::nullopt;
}

/// Names and the files that hold them, by an index.json.
std::map<std::string, std::string> read_index(const fs::path& index) {
  const nlohmann::json json = io::parse_json(io::read_text(index.string(), max_index_bytes), index.string());
  const auto map = json.is_object() ? json.find("weight_map") : json.end();
  if (!json.is_object() || map == json.end() || !map->is_object())
    fail(ErrorCode::file_damaged, "{}: has no object 'weight_map'", index.string());
  std::map<std::string, std::string> files;
  for (const auto& [name, file] : map->items()) {
    if (!file.is_string() || fs::path(file.get<std::string>()).has_parent_path() || file.get<std::string>().empty())
      fail(ErrorCode::file_damaged, "{}: the file of tensor '{}' is not a plain file name", index.string(),
           io::printable(name));
    files.emplace(name, file.get<std::string>());
  }
  return files;
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), names_told); ++i) text += (i == 0 ? "" : ", ") + names[i];
  if (names.size() > names_told) text += fmt::format(" and {} more", names.size() - names_told);
  return text;
}

/// madvise wants whole pages; only those that lie wholly inside are dropped, all that are touched are fetched.
void advise(std::span<const std::byte> bytes, int advice) {
  const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  const auto first = reinterpret_cast<std::uintptr_t>(bytes.data());
  const auto last = first + bytes.size();
  const bool drop = advice == MADV_DONTNEED;
  const auto from = drop ? (first + page - 1) / page * page : first / page * page;
  const auto to = drop ? last / page * page : (last + page - 1) / page * page;
  if (from < to) madvise(reinterpret_cast<void*>(from), to - from, advice);
}

}  // namespace

WeightFiles WeightFiles::open(const std::string& path) {
  WeightFiles weights;
  weights.path_ = path;
  std::vector<fs::path> files;
  std::map<std::string, std::string> index;
  fs::path index_path;
  if (!fs::exists(path)) fail(ErrorCode::file_not_found, "{}: there is no such file or folder", path);
  if (!fs::is_directory(path)) {
    if (is_pickle(path)) refuse_pickle(path);
    files.emplace_back(path);
  } else if (const auto indices = files_ending(path, ".safetensors.index.json"); !indices.empty()) {
    if (indices.size() > 1)
      fail(ErrorCode::value_invalid, "{}: holds {} indices ({}, {}); name one file or leave one index", path,
           indices.size(), indices[0].filename().string(), indices[1].filename().string());
    index_path = indices[0];
    index = read_index(index_path);
    std::set<std::string> shards;
    for (const auto& [name, file] : index) shards.insert(file);
    for (const std::string& shard : shards) files.push_back(fs::path(path) / shard);
  } else if (const auto usual = usual_file(path)) {
    files.push_back(*usual);
  } else {
    files = files_ending(path, ".safetensors");
    if (files.empty()) {
      for (const auto& entry : fs::directory_iterator(path))
        if (is_pickle(entry.path())) refuse_pickle(entry.path());
      fail(ErrorCode::file_not_found, "{}: holds no *.safetensors", path);
    }
  }
  for (const fs::path& file : files) {
    weights.files_.push_back(SafeTensors::open(file.string()));
    for (const std::string& name : weights.files_.back().names()) {
      const std::string here = file.filename().string();
      if (const auto listed_in = index.find(name); !index_path.empty() && listed_in == index.end())
        fail(ErrorCode::file_damaged, "{}: {} holds tensor '{}', which the index does not list", index_path.string(),
             here, io::printable(name));
      else if (!index_path.empty() && listed_in->second != here)
        fail(ErrorCode::file_damaged, "{}: says that '{}' is in {}, but {} holds it", index_path.string(),
             io::printable(name), listed_in->second, here);
      if (!weights.entries_.emplace(name, Entry{weights.files_.size() - 1, name}).second)
        fail(ErrorCode::file_damaged, "{}: more than one file holds tensor '{}' ({} is the second)", path,
             io::printable(name), here);
    }
  }
  for (const auto& [name, file] : index)
    if (!weights.has(name))
      fail(ErrorCode::file_damaged, "{}: says that {} holds '{}', but it does not", index_path.string(), file,
           io::printable(name));
  return weights;
}

std::vector<std::string> WeightFiles::names() const {
  std::vector<std::string> names;
  names.reserve(entries_.size());
  for (const auto& [name, entry] : entries_) names.push_back(name);
  return names;
}

const WeightFiles::Entry& WeightFiles::entry(const std::string& name) const {
  const auto found = entries_.find(name);
  if (found == entries_.end())
    fail(ErrorCode::value_invalid, "{}: holds no tensor named '{}' (it has {} others)", path_, name, entries_.size());
  return found->second;
}

const TensorInfo& WeightFiles::info(const std::string& name) const {
  const Entry& e = entry(name);
  return files_[e.file].info(e.stored_name);
}

std::vector<std::int64_t> WeightFiles::shape(const std::string& name) const {
  const auto& stored = info(name).shape;
  return {stored.begin(), stored.end()};
}

std::uint64_t WeightFiles::bytes() const {
  std::uint64_t sum = 0;
  for (const auto& [name, e] : entries_) sum += files_[e.file].bytes(e.stored_name).size();
  return sum;
}

void WeightFiles::rename(const std::function<std::string(const std::string&)>& rename) {
  std::map<std::string, Entry> renamed;
  for (const auto& [name, e] : entries_) {
    const std::string to = rename(name);
    if (!to.empty() && !renamed.emplace(to, e).second)
      fail(ErrorCode::file_damaged, "{}: two of its tensors mean '{}' ('{}' is the second)", path_, io::printable(to),
           io::printable(name));
  }
  entries_ = std::move(renamed);
}

at::Tensor WeightFiles::view(const std::string& name) const { return mapped(name).to(device_); }

at::Tensor WeightFiles::mapped(const std::string& name) const {
  if (is_quantised(name))
    fail(ErrorCode::value_invalid,
         "{}: tensor '{}' is held in 8 bits, which only the layers' own matrices may be; convert the checkpoint anew",
         path_, io::printable(name));
  return stored(name);
}

QuantisedWeight WeightFiles::quantised(const std::string& name) const {
  return {stored(name).to(device_), stored(scales_name(name)).to(device_)};
}

at::Tensor WeightFiles::stored(const std::string& name) const {
  const Entry& e = entry(name);
  const auto type = scalar_type(info(name).dtype, fmt::format("{}: tensor '{}'", path_, name));
  const auto stored = files_[e.file].bytes(e.stored_name);
  // The mapping is read-only; at::from_blob has no const form.
  void* data = const_cast<std::byte*>(stored.data());
  if (reinterpret_cast<std::uintptr_t>(data) % c10::elementSize(type) == 0)
    return at::from_blob(data, shape(name), at::TensorOptions(type));
  at::Tensor copy = at::empty(shape(name), at::TensorOptions(type));
  std::copy(stored.begin(), stored.end(), static_cast<std::byte*>(copy.data_ptr()));
  return copy;
}

at::Tensor WeightFiles::load(const std::string& name, at::ScalarType type) const {
  // Moved as stored, for fewer bytes, and widened there.
  return view(name).to(type, /*non_blocking=*/false, /*copy=*/device_.is_cpu());
}

void WeightFiles::will_need(const std::string& name) const {
  const Entry& e = entry(name);
  advise(files_[e.file].bytes(e.stored_name), MADV_WILLNEED);
}

void WeightFiles::release(const std::string& name) const {
  const Entry& e = entry(name);
  advise(files_[e.file].bytes(e.stored_name), MADV_DONTNEED);
}

void WeightFiles::refuse_scaled() const {
  for (const auto& [name, e] : entries_)
    for (const char* end : {"scaled_fp8", ".scale_weight", ".weight_scale"})
      if (name.ends_with(end))
        fail(ErrorCode::value_invalid,
             "{}: holds 8-bit numbers with scales of their own ('{}'), which would be wrong without them and are not "
             "read; take the weights in bf16 or f16, and ask for 8 bits by option",
             path_, io::printable(name));
}

std::vector<std::string> WeightFiles::check(const TensorShapes& wanted) const {
  refuse_scaled();
  std::vector<std::string> missing, misshaped, extra;
  for (const auto& [name, shape_wanted] : wanted) {
    if (!has(name))
      missing.push_back(name);
    else if (const std::string complaint = misfit(name, shape_wanted); !complaint.empty())
      misshaped.push_back(complaint);
  }
  std::string complaint;
  if (!missing.empty()) complaint += fmt::format("lacks {} tensors: {}", missing.size(), listed(missing));
  if (!misshaped.empty())
    complaint +=
        fmt::format("{}has {} of another shape: {}", missing.empty() ? "" : "; ", misshaped.size(), listed(misshaped));
  if (!complaint.empty())
    fail(ErrorCode::value_invalid, "{}: {}; is config.json the one of these weights?", path_, complaint);
  for (const auto& [name, e] : entries_)
    if (const std::string weight = name.substr(0, name.rfind('.'));
        !wanted.contains(name) && !(wanted.contains(weight) && name == scales_name(weight)))
      extra.push_back(name);
  return extra;
}

/// How a tensor differs from what is wanted of it; empty when it does not.
std::string WeightFiles::misfit(const std::string& name, const std::vector<std::int64_t>& wanted) const {
  if (shape(name) != wanted)
    return fmt::format("{} {} instead of {}", name, shape_text(shape(name)), shape_text(wanted));
  const bool whole_numbers = info(name).dtype == DType::i8;
  const std::string scales = scales_name(name);
  if (whole_numbers != has(scales))
    return whole_numbers ? fmt::format("{} of I8 without {}", name, scales)
                         : fmt::format("{} beside {} of {}", scales, name, to_string(info(name).dtype));
  if (!whole_numbers) return "";
  if (wanted.size() != 2) return fmt::format("{} of I8, which only matrices may be", name);
  if (info(scales).dtype != DType::f32 || shape(scales) != std::vector<std::int64_t>{wanted[0]})
    return fmt::format("{} {} of {} instead of [{}] of F32", scales, shape_text(shape(scales)),
                       to_string(info(scales).dtype), wanted[0]);
  return "";
}

}  // namespace uwv::model
