// SPDX-License-Identifier: Apache-2.0
// The stages of a run. Each writes its files into a temporary folder and answers with what run.json says of it.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pipeline/output_folder.h"
#include "pipeline/plan.h"
#include "uwv/core/thread_pool.h"
#include "uwv/io/video_writer.h"
#include "uwv/pipeline/run.h"
#include "uwv/render/rasterizer.h"

namespace uwv::pipeline {

/// What the stages share.
struct Workshop {
  const RunComponents& components;
  const Plan& plan;
  Rasterizer& rasterizer;
  ThreadPool& pool;
  Monitor& monitor;
};

/// colour.mp4, generate_mask.mp4, the depth and the masks asked for: Algorithm 1 along the path.
nlohmann::ordered_json make_conditioning(const Workshop& shop, const PartialFolder& into);
std::vector<std::string> conditioning_files(const RunOptions& options);

/// result.mp4: the conditioning in `from` with its holes filled.
nlohmann::ordered_json make_completion(const Workshop& shop, const OutputFolder& from, const PartialFolder& into);
nlohmann::ordered_json make_draft_completion(const Workshop& shop, const OutputFolder& from, const PartialFolder& into);
nlohmann::ordered_json make_model_completion(const Workshop& shop, const OutputFolder& from, const PartialFolder& into);
std::vector<std::string> completion_files(const RunOptions& options);

/// contact_sheet.png, the cameras, the point clouds.
nlohmann::ordered_json make_presentation(const Workshop& shop, const OutputFolder& from, const PartialFolder& into);
std::vector<std::string> presentation_files(const RunOptions& options);

/// A source frame's reliable points, coloured and with normals, in the world of the source cameras.
void write_point_cloud(const std::string& path, const Workshop& shop, const SourceData& data);

/// reference_comparison.png and its figures: renderings at the camera of a real picture, beside that picture.
nlohmann::ordered_json make_evaluation(const Workshop& shop, const PartialFolder& into);
std::vector<std::string> evaluation_files(const RunOptions& options);

/// What the videos of a run are encoded with. The number of threads is fixed: x264's bytes depend on it.
VideoWriterOptions colour_encoding(const Plan& plan);
VideoWriterOptions mask_encoding(const Plan& plan);

}  // namespace uwv::pipeline
