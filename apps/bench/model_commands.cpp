// SPDX-License-Identifier: Apache-2.0
#include "bench/model_commands.h"

#include <memory>

namespace uwv::bench {
namespace {

using Command = std::vector<Table> (*)(const ModelBenchOptions&);

void clip_flags(CLI::App& sub, ModelBenchOptions& options) {
  sub.add_option("--model", options.model, "Folder of the model")->required();
  sub.add_option("--width", options.width, "Picture width, a multiple of 16")->capture_default_str();
  sub.add_option("--height", options.height, "Picture height, a multiple of 16")->capture_default_str();
  sub.add_option("--frames", options.frames, "Frames of the clip, 1 more than a multiple of 4")->capture_default_str();
  sub.add_option("--runs", options.runs, "Measured runs a figure; the median is reported")->capture_default_str();
}

}  // namespace

void add_model_commands(CLI::App& app, std::function<std::vector<Table>()>& run, std::string& json_path) {
  CLI::App& model = *app.add_subcommand("model", "The video model: weights of real sizes, and its networks' speed");
  model.require_subcommand(1);
  const auto options = std::make_shared<ModelBenchOptions>();
  const auto subcommand = [&](const char* name, const char* help, Command function) -> CLI::App& {
    CLI::App& sub = *model.add_subcommand(name, help);
    sub.add_option("--threads", options->threads, "0 = all processors")->capture_default_str();
    sub.add_option("--json", json_path, "Also write the figures to this file");
    sub.add_option("--seed", options->seed, "Of all that is random")->capture_default_str();
    sub.callback([&run, options, function] { run = [options, function] { return function(*options); }; });
    return sub;
  };

  CLI::App& weights = subcommand(
      "make-weights", "Random weights of real sizes; example: uwv_bench model make-weights --config 1.3b --out DIR",
      make_weights);
  weights.add_option("--config", options->config, "tiny, 1.3b, 14b: transformers; vae; text: the text encoder")
      ->check(CLI::IsMember({"tiny", "1.3b", "14b", "vae", "text"}))
      ->capture_default_str();
  weights.add_option("--dtype", options->dtype, "f32 or bf16")
      ->check(CLI::IsMember({"f32", "bf16"}))
      ->capture_default_str();
  weights.add_option("--layers", options->layers, "Of the transformer, for one that is as wide but quicker; 0 = all")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  weights.add_option("--out", options->out, "Folder to write into")->required();

  CLI::App& transformer = subcommand(
      "transformer",
      "One step of the transformer, each way of holding it; example: uwv_bench model transformer --model DIR",
      time_transformer);
  clip_flags(transformer, *options);
  transformer.add_option("--forms", options->forms, "Ways of holding weights; errors are against the first")
      ->delimiter(',')
      ->capture_default_str();
  transformer.add_option("--ref-frames", options->ref_frames, "Frames of the reference video")->capture_default_str();
  transformer.add_option("--text-tokens", options->text_tokens, "Of the prompt, of 512")->capture_default_str();
  transformer.add_flag("--streamed", options->streamed, "Read blocks when their turn comes");
  transformer.add_option("--compare", options->compare,
                         "Folder with inputs and an answer of scripts/diffusers-transformer.py to compare with");

  CLI::App& known = subcommand(
      "known", "One step without the tokens far from holes; example: uwv_bench model known --model DIR --forms bf16",
      time_known_tokens);
  clip_flags(known, *options);
  known.add_option("--forms", options->forms, "The first is the way of holding weights")->delimiter(',');
  known.add_option("--holes", options->holes, "Shares of the picture that are unknown")
      ->delimiter(',')
      ->capture_default_str();
  known.add_option("--margins", options->margins, "Tokens around a hole that are not left out")
      ->delimiter(',')
      ->capture_default_str();

  CLI::App& windows = subcommand(
      "windows", "Seams between the windows of a long clip; example: uwv_bench model windows --model DIR --frames 121",
      measure_windows);
  clip_flags(windows, *options);
  windows.add_option("--transformer", options->transformer, "Its transformer, where that is elsewhere");
  windows.add_option("--overlaps", options->overlaps, "Frames that windows share")
      ->delimiter(',')
      ->capture_default_str();
  windows.add_option("--window-frames", options->window_frames, "Of a window, 1 + 4k")->capture_default_str();
  windows.add_option("--steps", options->steps, "Of the sampler")->capture_default_str();

  CLI::App& vae = subcommand(
      "vae", "The autoencoder, each way of running it; example: uwv_bench model vae --model DIR --forms f32,bf16/2",
      time_vae);
  clip_flags(vae, *options);
  vae.add_option("--forms", options->forms,
                 "f32, bf16, auto, direct (f32 by plain sums), each with /N for N bands; errors are against the first")
      ->delimiter(',')
      ->required();
  vae.add_option("--ways", options->ways, "decode, encode")->delimiter(',')->capture_default_str();

  CLI::App& text = subcommand(
      "text", "One prompt through the text encoder, layer by layer; example: uwv_bench model text --model DIR",
      time_text_encoder);
  text.add_option("--model", options->model, "Folder of the model")->required();
  text.add_option("--forms", options->forms, "Ways of holding weights; errors are against the first")
      ->delimiter(',')
      ->capture_default_str();
  text.add_option("--text-tokens", options->text_tokens, "Of the prompt")->capture_default_str();
  text.add_option("--runs", options->runs, "Measured runs a figure; the median is reported")->capture_default_str();

  CLI::App& ladder = subcommand(
      "ladder", "What fewer steps and bits lose; example: uwv_bench model ladder --model DIR --width 96 --height 64",
      measure_ladder);
  clip_flags(ladder, *options);
  ladder.add_option("--transformer", options->transformer, "Its transformer, where that lies elsewhere");
  ladder.add_option("--prompt-embeds", options->prompt_embeds,
                    "Safetensors with prompt_embeds and negative_prompt_embeds, where there is no text encoder");
  ladder.add_option("--plot", options->plot, "Also draw into this SVG file");
}

}  // namespace uwv::bench
