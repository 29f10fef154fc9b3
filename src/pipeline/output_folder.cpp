// SPDX-License-Identifier: Apache-2.0
#include "pipeline/output_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <system_error>

#include "uwv/core/error.h"

namespace uwv::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using nlohmann::ordered_json;

constexpr const char* run_record_name = "run.json";

/// Runs a step of file handling and turns its failure into a sentence.
template <class Step>
void on_disk(const fs::path& path, std::string_view what, Step step) {
  try {
    step();
  } catch (const fs::filesystem_error& error) {
    fail(ErrorCode::output_failed, "{}: cannot {}: {}", path.string(), what, error.code().message());
  }
}

/// Under its final name the file is always whole.
void write_in_one_step(const fs::path& path, const std::string& text) {
  const fs::path next = path.string() + ".next";
  std::ofstream file(next, std::ios::binary | std::ios::trunc);
  file << text;
  file.close();
  if (!file) {
    std::error_code ignored;
    fs::remove(next, ignored);
    fail(ErrorCode::output_failed, "{}: cannot write; is the disk full?", path.string());
  }
  on_disk(path, "replace it", [&] { fs::rename(next, path); });
}

json parse_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return json::parse(std::string(std::istreambuf_iterator<char>(file), {}), nullptr, /*allow_exceptions=*/false);
}

std::uintmax_t total_bytes(const fs::path& path) {
  if (!fs::is_directory(path)) return fs::is_regular_file(path) ? fs::file_size(path) : 0;
  std::uintmax_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(path))
    if (entry.is_regular_file()) bytes += entry.file_size() + 1;  // + 1: an empty file that vanished counts too
  return bytes;
}

}  // namespace

PartialFolder::PartialFolder(fs::path path) : path_(std::move(path)) {
  on_disk(path_, "start afresh", [&] {
    fs::remove_all(path_);
    fs::create_directory(path_);
  });
}

PartialFolder::~PartialFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

OutputFolder::OutputFolder(const std::string& path) : path_(path) {
  for (fs::path p = fs::absolute(path_).lexically_normal(); !fs::exists(p) && p != p.parent_path(); p = p.parent_path())
    topmost_created_ = p;
  on_disk(path_, "create the output folder", [&] { fs::create_directories(path_); });
  lock_ = ::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock_ < 0) fail(ErrorCode::output_failed, "{}: is not a folder that results can go to", path);
  if (::flock(lock_, LOCK_EX | LOCK_NB) != 0) {
    ::close(lock_);
    fail(ErrorCode::output_failed, "{}: another run is writing here; wait for it or choose another --out", path);
  }
}

OutputFolder::~OutputFolder() {
  if (!topmost_created_.empty()) {
    std::error_code in_use;  // remove() refuses folders that hold something, which is what ends the loop
    const fs::path last = topmost_created_.parent_path();
    for (fs::path p = fs::absolute(path_).lexically_normal(); p != last && !in_use; p = p.parent_path())
      fs::remove(p.has_filename() ? p : p.parent_path(), in_use);
  }
  ::close(lock_);
}

fs::path OutputFolder::marker_path(const std::string& stage) const { return path_ / (".stage-" + stage + ".json"); }

json OutputFolder::read_marker(const std::string& stage) const {
  const json marker = parse_file(marker_path(stage));
  const bool usable = marker.is_object() && marker.contains("files") && marker["files"].is_object() &&
                      marker.contains("key") && marker["key"].is_string() && marker.contains("record");
  return usable ? marker : json();
}

std::vector<std::string> OutputFolder::owned(const std::string& stage) const {
  std::vector<std::string> names;
  const json marker = read_marker(stage);
  if (marker.is_null()) return names;
  for (const auto& [name, bytes] : marker["files"].items())
    if (fs::path(name).filename() == name && name != "." && name != "..") names.push_back(name);
  return names;
}

void OutputFolder::refuse_foreign(const std::vector<std::string>& names, bool overwrite) const {
  if (overwrite) return;
  std::set<std::string> ours;
  for (const auto& entry : fs::directory_iterator(path_)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(".stage-") || !name.ends_with(".json")) continue;
    for (const std::string& file : owned(name.substr(7, name.size() - 12))) ours.insert(file);
  }
  const json record = parse_file(path_ / run_record_name);
  if (record.is_object() && record.value("program", "") == "uwv_app") ours.insert(run_record_name);
  for (const std::string& name : names)
    if (fs::exists(fs::symlink_status(path_ / name)) && !ours.contains(name))
      fail(ErrorCode::output_failed,
           "{}: exists and is not the result of a run; choose another --out, or pass --overwrite to replace it",
           file(name));
}

std::optional<ordered_json> OutputFolder::finished(const std::string& stage, const std::string& key) const {
  const json marker = read_marker(stage);
  if (marker.is_null() || marker["key"] != key) return std::nullopt;
  for (const auto& [name, bytes] : marker["files"].items())
    if (!fs::exists(path_ / name) || bytes != total_bytes(path_ / name)) return std::nullopt;
  return ordered_json::parse(marker["record"].dump());
}

bool OutputFolder::has_marker(const std::string& stage) const { return !read_marker(stage).is_null(); }

PartialFolder OutputFolder::begin(const std::string& stage) const {
  return PartialFolder(path_ / (".partial-" + stage));
}

void OutputFolder::publish(const std::string& stage, const std::string& key, const PartialFolder& partial,
                           const ordered_json& record) {
  ordered_json files = ordered_json::object();
  std::vector<std::string> names;
  on_disk(path_, "publish the results", [&] {
    for (const auto& entry : fs::directory_iterator(partial.path())) names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    for (const std::string& name : names) files[name] = total_bytes(partial.path() / name);

    const std::vector<std::string> old_names = owned(stage);
    ordered_json all = files;
    for (const std::string& name : old_names)
      if (!all.contains(name)) all[name] = 0;
    write_in_one_step(marker_path(stage),
                      ordered_json{{"state", "publishing"}, {"key", ""}, {"files", all}, {"record", nullptr}}.dump(1));
    for (const std::string& name : old_names) fs::remove_all(path_ / name);
    for (const std::string& name : names) {
      fs::remove_all(path_ / name);
      fs::rename(partial.path() / name, path_ / name);
    }
  });
  write_in_one_step(marker_path(stage),
                    ordered_json{{"state", "finished"}, {"key", key}, {"files", files}, {"record", record}}.dump(1));
}

void OutputFolder::retract(const std::string& stage) {
  on_disk(path_, "remove an earlier result", [&] {
    for (const std::string& name : owned(stage)) fs::remove_all(path_ / name);
    fs::remove(marker_path(stage));
  });
}

void OutputFolder::write_record(const ordered_json& record) {
  write_in_one_step(path_ / run_record_name, record.dump(1) + "\n");
}

void refuse_overwriting_inputs(const std::string& out, const std::vector<std::string>& names,
                               const std::vector<std::string>& inputs) {
  const fs::path folder = fs::weakly_canonical(out);
  const auto inside = [](const fs::path& path, const fs::path& of) {
    const auto [of_end, rest] = std::mismatch(of.begin(), of.end(), path.begin(), path.end());
    return of_end == of.end();
  };
  for (const std::string& input : inputs) {
    if (input.empty()) continue;
    const fs::path given = fs::absolute(input).lexically_normal();
    const fs::path entry = fs::weakly_canonical(given.parent_path()) / given.filename();
    for (const fs::path& path : {fs::weakly_canonical(given), entry}) {
      const bool is_pattern = path.filename().string().find_first_of("*?%") != std::string::npos && !fs::exists(path);
      const bool reads_folder = is_pattern ? path.parent_path() == folder : fs::is_directory(path) && path == folder;
      if (reads_folder)
        fail(ErrorCode::output_failed, "{}: is an input folder, results cannot go there; choose another --out", out);
      for (const std::string& name : names)
        if (inside(path, folder / name))
          fail(ErrorCode::output_failed, "{}: is an input, the run would overwrite it; choose another --out", input);
    }
  }
}

}  // namespace uwv::pipeline
