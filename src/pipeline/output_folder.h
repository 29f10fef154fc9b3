// SPDX-License-Identifier: Apache-2.0
// The folder a run writes into, and the rules that keep it trustworthy:
//
// - A stage writes into OUT/.partial-<stage>/. When it is whole, its files are renamed into OUT and a marker
//   OUT/.stage-<stage>.json is written, holding the key of everything that decided the bytes. The same key later means
//   the stage can be skipped.
// - The marker lists the files it covers, so that a run never replaces a file that no run of ours has written.
// - Killed at any moment, the folder holds either the old files with the old marker, or a marker that says
//   "publishing", which makes the next run redo that stage.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace uwv::pipeline {

/// A stage's temporary folder; removed with all it holds unless it was published.
class PartialFolder {
 public:
  explicit PartialFolder(std::filesystem::path path);
  ~PartialFolder();
  PartialFolder(const PartialFolder&) = delete;
  PartialFolder& operator=(const PartialFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::string file(std::string_view name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

class OutputFolder {
 public:
  /// Creates the folder where needed and locks it against a second run. Throws Error(output_failed) when that fails.
  explicit OutputFolder(const std::string& path);
  /// Removes the folder again if this object created it and nothing was published.
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::string file(std::string_view name) const { return (path_ / name).string(); }

  /// Throws Error(output_failed) when one of `names` exists here without a marker of ours that lists it, unless
  /// `overwrite`.
  void refuse_foreign(const std::vector<std::string>& names, bool overwrite) const;

  /// The record of a finished stage, if its key is `key` and its files are all there with the size they had.
  std::optional<nlohmann::ordered_json> finished(const std::string& stage, const std::string& key) const;
  /// True when the stage finished here before, with whatever key.
  bool has_marker(const std::string& stage) const;

  /// Starts a stage; what a killed run left of it is removed.
  PartialFolder begin(const std::string& stage) const;

  /// Moves everything the stage wrote into the folder, replacing what an earlier run of the stage wrote, and sets the
  /// marker. `record` is what finished() gives back.
  void publish(const std::string& stage, const std::string& key, const PartialFolder& partial,
               const nlohmann::ordered_json& record);

  /// Removes a stage's files and marker: the options no longer ask for it.
  void retract(const std::string& stage);

  /// Writes run.json, replacing it in one step.
  void write_record(const nlohmann::ordered_json& record);

 private:
  std::filesystem::path marker_path(const std::string& stage) const;
  nlohmann::json read_marker(const std::string& stage) const;
  std::vector<std::string> owned(const std::string& stage) const;

  std::filesystem::path path_;
  std::filesystem::path topmost_created_;
  int lock_ = -1;
};

/// Throws Error(output_failed) when writing `names` into `out` would replace or change one of the `inputs` (files,
/// folders or patterns; empty names are passed over).
void refuse_overwriting_inputs(const std::string& out, const std::vector<std::string>& names,
                               const std::vector<std::string>& inputs);

}  // namespace uwv::pipeline
