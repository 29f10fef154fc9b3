// SPDX-License-Identifier: Apache-2.0
// "uwv_bench model ...": networks of the video model, timed on weights of their real sizes.
#pragma once

#include <CLI/CLI.hpp>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bench/table.h"

namespace uwv::bench {

struct ModelBenchOptions {
  std::string config = "1.3b";  ///< Which weights are made.
  std::string dtype = "bf16";   ///< Of the weights that are made.
  int layers = 0;               ///< Of a transformer that is made; 0 = as published.
  std::uint64_t seed = 1;
  std::string out;            ///< Folder the weights are written into.
  std::string model;          ///< Folder of the weights that are timed.
  std::string transformer;    ///< Folder of the transformer where that is elsewhere.
  std::string prompt_embeds;  ///< Encoded prompts, where there is no text encoder.
  std::string plot;           ///< SVG file to draw into.
  int width = 416, height = 240, frames = 17;
  int ref_frames = 0;    ///< Of the reference video; 0 = none.
  int text_tokens = 40;  ///< Of the prompt, of 512.
  int runs = 1;
  int threads = 0;  ///< 0 = all processors.
  std::vector<std::string> forms{"f32", "bf16_stored", "bf16", "int8_stored", "int8"};
  std::vector<std::string> ways{"decode", "encode"};  ///< Of the autoencoder.
  std::vector<double> holes{0.1, 0.25, 0.5};          ///< Shares of the picture that are unknown.
  std::vector<int> margins{0, 1, 2, 4, 8};            ///< Tokens around a hole that are not left out.
  std::vector<int> overlaps{4, 8, 20};                ///< Frames that windows share.
  int window_frames = 41;                             ///< Of a window, 1 + 4k.
  int steps = 8;
  bool streamed = false;  ///< Blocks are read when their turn comes.
  std::string compare;    ///< File that the first form's answer is written to or, where it exists, compared with.
};

/// Weights of real sizes and random values in the layout of published checkpoints.
std::vector<Table> make_weights(const ModelBenchOptions& options);

/// Seconds a step, peak memory, and error against float32, for each way of holding the transformer's weights.
std::vector<Table> time_transformer(const ModelBenchOptions& options);

/// Seconds a frame, peak memory, and error against the first form, for each way of running the autoencoder.
std::vector<Table> time_vae(const ModelBenchOptions& options);

/// Seconds a prompt, peak memory, and error against the first form, for each way of holding the text encoder's weights.
std::vector<Table> time_text_encoder(const ModelBenchOptions& options);

/// What a step takes when tokens far from the hole are left out, and what that changes in the hole, for holes and
/// margins of several sizes.
std::vector<Table> time_known_tokens(const ModelBenchOptions& options);

/// How much frames change where windows end against elsewhere, for overlaps of several lengths, when all windows are
/// denoised together and when each continues from the last frames of the one before.
std::vector<Table> measure_windows(const ModelBenchOptions& options);

/// What each choice of sampler, steps, guidance, caching and numbers loses against 50 exact steps.
std::vector<Table> measure_ladder(const ModelBenchOptions& options);

/// Adds the command "model" with all of these below it; the chosen one is put into `run`.
void add_model_commands(CLI::App& app, std::function<std::vector<Table>()>& run, std::string& json_path);

}  // namespace uwv::bench
