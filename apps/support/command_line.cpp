// SPDX-License-Identifier: Apache-2.0
#include "support/command_line.h"

#include <fmt/format.h>

#include <cstdio>
namespace uwv::app {
namespace {

std::string help_with_default(const OptionInfo& info) {
  const std::string value = option_text(RunOptions{}, info.name);
  return value.empty() || value == "false" ? info.help : fmt::format("{} [{}]", info.help, value);
}

}  // namespace

RunFlags::RunFlags(CLI::App& command, const Filter& wanted) {
  command.get_formatter()->column_width(32);
  command.add_option("--options", options_file_, "start from the options in this run.json; flags come on top")
      ->type_name("FILE");
  for (const OptionInfo& info : option_table()) {
    if (wanted && !wanted(info)) continue;
    const std::string help = help_with_default(info);
    const std::string name = info.name;
    CLI::Option* option = nullptr;
    if (info.value.empty()) {
      const bool on = option_text(RunOptions{}, name) == "true";
      const std::string flags = on ? info.flag() + ",!--no-" + info.flag().substr(2) : info.flag();
      option = command.add_flag_function(
          flags, [this, name](std::int64_t count) { typed_.emplace_back(name, count > 0 ? "true" : "false"); }, help);
    } else {
      option = command.add_option_function<std::string>(
          info.flag(), [this, name](const std::string& text) { typed_.emplace_back(name, text); }, help);
      option->type_name(info.value);
    }
    option->group(info.group);
    if (name == "layers")
      command
          .add_flag_function(
              "--no-layers", [this](std::int64_t) { typed_.emplace_back("layers", "off"); }, "short for --layers off")
          ->group(info.group);
  }
}

RunOptions RunFlags::some_options() const {
  RunOptions options = options_file_.empty() ? RunOptions{} : read_options(options_file_);
  for (const auto& [name, text] : typed_) set_option(options, name, text);
  return options;
}

RunOptions RunFlags::options() const {
  RunOptions options = some_options();
  try {
    options.check();
  } catch (const std::invalid_argument& mistake) {  // here the caller is the user
    throw Error(ErrorCode::value_invalid, mistake.what());
  }
  return options;
}

bool parse(CLI::App& app, int argc, char** argv, int& exit_code) {
  try {
    app.parse(argc, argv);
    return true;
  } catch (const CLI::Success& answered) {
    exit_code = app.exit(answered);
  } catch (const CLI::ParseError& mistake) {
    fmt::print(stderr, "{}: {}; see {} --help\n", app.get_name(), mistake.what(), app.get_name());
    exit_code = exit_bad_input;
  }
  return false;
}

int guarded(const std::function<void()>& body) {
  try {
    body();
    return exit_done;
  } catch (const Error& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return error.code() == ErrorCode::cancelled ? exit_interrupted : exit_bad_input;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "error: out of memory; try a smaller --size\n");
    return exit_bad_input;
  } catch (const std::exception& bug) {
    fmt::print(stderr, "internal error, please report it: {}\n", bug.what());
    return exit_bug;
  }
}

}  // namespace uwv::app
