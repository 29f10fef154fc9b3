// SPDX-License-Identifier: Apache-2.0
// The options of a run as a table: one line per field of RunOptions drives the command line, its help, the writing of
// run.json and the reading of it back.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>

#include "uwv/pipeline/run_options.h"

namespace uwv {

/// What an option decides; a finished stage is redone when an option of its own or of an earlier stage changed.
/// `clip` holds what every stage depends on: which frames, at which size, through which lens.
enum class OptionScope { nothing, clip, geometry, conditioning, completion, presentation, evaluation };

/// One line of the table.
struct OptionInfo {
  std::string name;   ///< Field of RunOptions and key of run.json, e.g. "max_side".
  std::string group;  ///< Heading in the help.
  std::string value;  ///< Placeholder for what follows the flag ("FILE", "N"); empty for a yes/no option.
  std::string help;   ///< Effect, without the default.
  OptionScope scope;
  bool repeats;  ///< Takes several values.

  std::string flag() const;  ///< "--max-side"
};

/// All options, in the order of the help.
std::span<const OptionInfo> option_table();

/// Sets one option from text, as typed after its flag; a yes/no option takes "true" or "false", a repeated one a
/// comma-separated list. Throws Error(value_invalid) naming the flag, what was found and what was wanted.
void set_option(RunOptions& options, std::string_view name, std::string_view text);

/// The value as text that set_option reads back; "" when unset.
std::string option_text(const RunOptions& options, std::string_view name);

/// All options; unset ones are null.
nlohmann::ordered_json to_json(const RunOptions& options);

/// Options of the given scope only: what decides that stage's bytes.
nlohmann::ordered_json to_json(const RunOptions& options, OptionScope scope);

/// Reads what to_json wrote; missing keys keep their defaults. `where` names the source in errors. Throws
/// Error(value_invalid) naming the key, for unknown keys with the nearest known one.
RunOptions options_from_json(const nlohmann::json& json, std::string_view where);

/// The options of an earlier run: `path` is a run.json, or a file holding the options alone.
RunOptions read_options(const std::string& path);

}  // namespace uwv
