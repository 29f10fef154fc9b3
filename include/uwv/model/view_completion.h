// SPDX-License-Identifier: Apache-2.0
// Completes a rendering of a clip by the video diffusion model: what the source camera never saw is generated. Sheet
// model.md, 4.
//
// The parts of the model are opened one after the other and freed in between: text encoder, autoencoder, transformer,
// autoencoder. This header needs no libtorch; the functions are in the component uwv::model.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "uwv/core/image.h"
#include "uwv/core/mask.h"
#include "uwv/core/monitor.h"
#include "uwv/model/model_options.h"

namespace uwv {

/// The rendering to complete. Any number of frames from 1 on: the last one is repeated until they are 1 + 4k, and what
/// was added is cut off again. Sides that 16 does not divide are continued by their last pixels, and cut off again.
struct RenderedClip {
  Size size;
  long frames = 0;
  /// Frame `k` and what of it is to be generated, both of `size`. Asked in order, several times from the start.
  std::function<void(long k, ImageRgb& colour, GenerateMask& holes)> read;
  /// The source picture of the moment of frame `k`; the network looks at it for what the rendering lacks. Empty: none.
  std::function<void(long k, ImageRgb& colour)> read_source;
};

/// Where the result goes, from the calling thread.
struct CompletedClip {
  std::function<void(long k, const ImageRgb& colour)> write;  ///< In order, each frame once.
  std::function<void(const ImageRgb& picture)> preview;       ///< After each step; may be empty.
};

/// One part of the work.
struct CompletionStage {
  std::string name;
  double seconds = 0;
  std::uint64_t peak_bytes = 0;  ///< Resident memory of the process at its largest so far.
};

struct CompletionSummary {
  bool model_was_run = false;
  std::vector<CompletionStage> stages;
  std::vector<std::string> skipped;   ///< What was left out, and why.
  std::vector<std::string> warnings;  ///< Also told to the monitor.
  std::vector<std::string> choices;   ///< What was automatic and became what, and why.
  int windows = 0, steps = 0;
  long passes = 0;          ///< Of the transformer.
  long skipped_passes = 0;  ///< By step caching.
  double step_seconds = 0;  ///< Mean.

  std::string brief() const {
    if (!model_was_run) return "nothing to generate: the model was not run";
    std::string text = fmt::format("{} steps of {:.2f} s in {} window{}, {} passes", steps, step_seconds, windows,
                                   windows == 1 ? "" : "s", passes);
    for (const CompletionStage& stage : stages) text += fmt::format("; {} {:.1f} s", stage.name, stage.seconds);
    return text;
  }
};

/// What complete_views finds out about the checkpoint before anything long is begun: throws Error naming a part that is
/// missing or that we do not have, reading only settings.
void check_checkpoint(const ModelOptions& options);

/// Does the job. `threads` are torch's; 0 = one per processor. The same options give the same bytes on the same machine
/// and number of threads. Throws std::invalid_argument when options.check() does, Error naming the file for everything
/// wrong with the checkpoint, Error(cancelled) within a block of the transformer or a chunk of the autoencoder when the
/// monitor stops it.
CompletionSummary complete_views(const ModelOptions& options, const RenderedClip& clip, const CompletedClip& out,
                                 int threads, Monitor& monitor);

/// What complete_views would take, found without loading weights.
struct CompletionPlan {
  struct Stage {
    std::string name;
    std::uint64_t peak_bytes = 0;
    double seconds = 0;
  };
  /// Of weights that are read block by block, in each pass, while another block computes.
  struct Reading {
    std::uint64_t bytes = 0;
    double bytes_per_second = 0;   ///< Measured on their disk in a moment; 0 = unknown, and the plan is without it.
    double seconds = 0;            ///< That a pass reads, and
    double computing = 0;          ///< computes; it takes the longer of both.
    bool first_pass_only = false;  ///< The file fits into free memory beside all else, so that it is read once.
    std::string sentence() const;
  };
  std::vector<Stage> stages;
  std::optional<Reading> reading;
  std::vector<std::string> choices;
  std::uint64_t limit = 0;  ///< Bytes that were to be kept.
  double gflops = 0;        ///< Measured on this machine in a moment.
  double seconds_per_step = 0;

  std::string report() const;
};

/// Reads only headers. Throws as complete_views does; Error(out_of_memory) when nothing fits the limit.
CompletionPlan plan_completion(const ModelOptions& options, Size size, long frames, int threads);

}  // namespace uwv
