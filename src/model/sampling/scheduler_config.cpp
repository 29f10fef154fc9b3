// SPDX-License-Identifier: Apache-2.0
#include "model/sampling/scheduler_config.h"

#include <vector>

#include "io/disk_file.h"
#include "io/json_text.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

using nlohmann::json;

constexpr std::uint64_t max_bytes = 1U << 20U;

/// Python writes infinities, which JSON does not know, into a setting that flow sigmas do not use.
std::string without_infinities(std::string text) {
  constexpr std::string_view infinity = ": -Infinity";
  for (auto at = text.find(infinity); at != std::string::npos; at = text.find(infinity, at))
    text.replace(at, infinity.size(), ": null");
  return text;
}

struct Wanted {
  const char* key;
  json value;
};

/// A setting that is missing has the value we have.
void check_settings(const json& config, const std::vector<Wanted>& wanted, const std::string& path) {
  for (const auto& [key, value] : wanted) {
    const auto found = config.find(key);
    if (found != config.end() && *found != value)
      fail(ErrorCode::value_invalid, "{}: /{}: found {}, wanted {}; choose a sampler by name to go without this file",
           path, key, found->dump(), value.dump());
  }
}

double read_shift(const json& config, const char* key, const std::string& path) {
  const auto found = config.find(key);
  if (found == config.end()) return 1;
  const double shift = found->is_number() ? found->get<double>() : 0;
  if (!(shift >= 0.01 && shift <= 100))
    fail(ErrorCode::value_invalid, "{}: /{}: found {}, wanted a number from 0.01 to 100", path, key, found->dump());
  return shift;
}

const std::vector<Wanted> solver_settings{{"prediction_type", "flow_prediction"},
                                          {"use_flow_sigmas", true},
                                          {"solver_order", 2},
                                          {"final_sigmas_type", "zero"},
                                          {"thresholding", false}};

}  // namespace

SamplerOptions read_scheduler_config(const std::string& path) {
  const json config = io::parse_json(without_infinities(io::read_text(path, max_bytes)), path);
  const auto name = config.is_object() ? config.find("_class_name") : config.end();
  if (!config.is_object() || name == config.end() || !name->is_string())
    fail(ErrorCode::value_invalid, "{}: found no object with \"_class_name\", wanted a scheduler's settings", path);
  check_settings(config,
                 {{"num_train_timesteps", 1000},
                  {"use_dynamic_shifting", false},
                  {"shift_terminal", nullptr},
                  {"use_karras_sigmas", false},
                  {"use_exponential_sigmas", false},
                  {"use_beta_sigmas", false}},
                 path);
  SamplerOptions options;
  if (*name == "FlowMatchEulerDiscreteScheduler") {
    check_settings(config, {{"stochastic_sampling", false}, {"invert_sigmas", false}}, path);
    options.shift = read_shift(config, "shift", path);
    return options;
  }
  options.shift = read_shift(config, "flow_shift", path);
  check_settings(config, solver_settings, path);
  if (*name == "UniPCMultistepScheduler") {
    check_settings(config, {{"solver_type", "bh2"}, {"predict_x0", true}, {"lower_order_final", true}}, path);
    options.kind = SamplerKind::unipc;
  } else if (*name == "DPMSolverMultistepScheduler") {
    check_settings(config, {{"solver_type", "midpoint"}, {"algorithm_type", "dpmsolver++"}}, path);
    options.kind = SamplerKind::dpmpp;
  } else {
    fail(ErrorCode::value_invalid,
         "{}: /_class_name: found {}, wanted FlowMatchEulerDiscreteScheduler, UniPCMultistepScheduler or "
         "DPMSolverMultistepScheduler; choose a sampler by name to go without this file",
         path, name->dump());
  }
  return options;
}

}  // namespace uwv::model
