// SPDX-License-Identifier: Apache-2.0
#include "uwv/pipeline/option_table.h"

#include <algorithm>
#include <functional>
#include <type_traits>

#include "io/disk_file.h"
#include "io/json_text.h"
#include "pipeline/option_codec.h"

namespace uwv {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;
using pipeline::Codec;

/// A line of the table with the ways into the struct.
struct Option {
  OptionInfo info;
  std::function<ordered_json(const RunOptions&)> write;
  std::function<bool(const json&, RunOptions&)> read;
  std::function<bool(std::string_view, RunOptions&)> parse;
  std::string wanted;
};

/// `reach` takes the options to the field, constant or not.
template <class T, class Reach>
Option option_at(std::string_view name, Reach reach, std::string_view value, std::string_view help) {
  constexpr bool repeats = std::is_same_v<T, std::vector<long>> || std::is_same_v<T, std::vector<std::string>>;
  return {{std::string(name), "", std::string(value), std::string(help), OptionScope::conditioning, repeats},
          [reach](const RunOptions& options) { return Codec<T>::write(reach(options)); },
          [reach](const json& from, RunOptions& options) { return Codec<T>::read(from, reach(options)); },
          [reach](std::string_view text, RunOptions& options) { return Codec<T>::parse(text, reach(options)); },
          Codec<T>::wanted()};
}

template <class T>
Option option(std::string_view name, T RunOptions::*field, std::string_view value, std::string_view help) {
  return option_at<T>(
      name, [field](auto& options) -> auto& { return options.*field; }, value, help);
}

template <class T>
Option option(std::string_view name, T ModelOptions::*field, std::string_view value, std::string_view help) {
  return option_at<T>(
      name, [field](auto& options) -> auto& { return options.diffusion.*field; }, value, help);
}

using O = RunOptions;

std::vector<Option> input_options() {
  return {
      option("video", &O::video, "FILE", "video, photo, folder of pictures, or pattern such as 'frames_%05d.png'"),
      option("depth", &O::depth, "FILE",
             "depth of every frame: .npz .npy .png .exr .pfm, a folder or pattern, or OUT/geometry of a run; unset: "
             "estimated"),
      option("depth_kind", &O::depth_kind, "NAME",
             "what its values are: depth, inverse (1/depth), or relative_inverse or relative_depth: known up to scale "
             "and shift, and brought to the scale of estimated cameras"),
      option("depth_scale", &O::depth_scale, "X", "stored value times X is depth; unset: 1, or 0.001 for 16-bit PNG"),
      option("depth_key", &O::depth_key, "NAME", "member of the .npz to read; unset: the first of the usual names"),
      option("disparity", &O::disparity, "FILE", "stereo disparity in full-size pixels, instead of --depth"),
      option("baseline", &O::baseline, "X", "distance of the stereo pair's cameras; sets the unit of depth"),
      option("doffs", &O::doffs, "PX", "cx of the right camera minus cx of the left: depth = fx*baseline/(disp+doffs)"),
      option("static_depth", &O::static_depth, "", "one depth picture serves every frame (locked-off camera)"),
      option("cameras", &O::cameras, "FILE",
             "source cameras: TUM, transforms.json, .log or uwv JSON; unset: locked off"),
      option("foreground", &O::foreground, "FILE", "mask clip of what moves, white = foreground"),
      option(
          "background", &O::background, "FILE",
          "clip of the same scene without its foreground, shown where that moved away; unset: completed, where depth "
          "is estimated"),
      option("background_depth", &O::background_depth, "FILE", "its depth, where --depth is given"),
      option("normals", &O::normals, "FILE", "normals to use instead of those of the depth: .npy or .npz, (n,h,w,3)"),
      option("fx", &O::fx, "PX", "focal length in pixels of the full-size picture"),
      option("fy", &O::fy, "PX", "the same, vertical; unset: as --fx"),
      option("cx", &O::cx, "PX", "principal point in pixels of the full-size picture; unset: the centre"),
      option("cy", &O::cy, "PX", "the same, vertical"),
      option("fov", &O::fov, "DEG", "horizontal field of view, instead of --fx; unset and nothing else given: 60"),
      option("pixel_centre", &O::pixel_centre, "WHERE",
             "how --cx --cy count pixel centres: half (0.5, 1.5, ..) or integer"),
      option("start", &O::start, "N", "first frame used"),
      option("stride", &O::stride, "N", "use every N-th frame"),
      option("max_frames", &O::max_frames, "N", "use at most N frames, 0 = all"),
  };
}

std::vector<Option> geometry_options() {
  return {
      option("geometry", &O::geometry, "NAME",
             "where depth comes from: auto, import (--depth), network (--depth-model), sfm (measured from the camera's "
             "motion) or prior (layers on a ground plane, an assumption)"),
      option("depth_model", &O::depth_model, "DIR",
             "folder of a depth network exported to TorchScript, with its manifest (docs/depth-models.md)"),
      option("layers", &O::layers, "NAME",
             "show the estimated background where the foreground has moved out of the way: auto (where something moves "
             "or the path uncovers enough), on or off"),
      option(
          "saliency_model", &O::saliency_model, "FILE",
          "finds the foreground: u2netp.onnx or a TorchScript network's folder; unset: .cache/models, else a method by "
          "contrast"),
      option("segmenter", &O::segmenter, "DIR",
             "TorchScript network that follows the foreground from points of the first frame; unset: optical flow"),
      option("depth_smoothing", &O::depth_smoothing, "NAME",
             "relative --depth-kind: how scale and shift of the frames hang together: joint (steady), momentum (the "
             "official running mean) or none (for depth whose unit jumps from frame to frame)"),
      option("max_features", &O::max_features, "N", "sfm: points tracked at once; more is steadier and slower"),
      option("min_parallax_px", &O::min_parallax_px, "PX",
             "sfm: shift that turning cannot explain from which on the camera counts as moving"),
      option("mvs_neighbours", &O::mvs_neighbours, "N", "sfm: other frames each frame's depth is matched in"),
      option("mvs_planes", &O::mvs_planes, "N", "sfm: depth hypotheses; more is finer and slower"),
      option("mvs_scale", &O::mvs_scale, "X", "sfm: matching resolution relative to the working size"),
      option("mvs_key_stride", &O::mvs_key_stride, "N",
             "sfm: match every N-th frame and carry depth over to the others; 0 = by the parallax between frames"),
  };
}

std::vector<Option> size_options() {
  return {
      option("size", &O::size, "WxH", "exact working size; unset: the model's token budget at the clip's aspect ratio"),
      option("no_resize", &O::no_resize, "", "work at the clip's own size"),
      option("max_side", &O::max_side, "N", "longest side the token budget may choose"),
  };
}

std::vector<Option> path_options() {
  return {
      option("traj", &O::traj, "FILE|NAME", "trajectory file (docs/trajectories.md) or the name of a preset"),
      option("frames", &O::frames, "N", "target frames; unset: the file's, else the clip's, 81 for a photo"),
      option("follow_source", &O::follow_source, "",
             "apply the path to the moving source camera of each moment, not to its first pose"),
      option("elevation", &O::elevation, "DEG", "height of the first camera over the orbit's plane"),
      option("radius", &O::radius, "X", "distance to the orbit's centre; unset: median depth of the foreground"),
      option("radius_scale", &O::radius_scale, "X", "scales the path's offsets"),
  };
}

std::vector<Option> render_options() {
  return {
      option("renderer", &O::renderer, "NAME", "auto, gl or cpu; auto takes the CPU where GL is only emulated"),
      option("gl", &O::gl, "NAME", "which headless GL: auto, egl or osmesa"),
      option("cloud", &O::cloud, "NAME",
             "points a frame is drawn from: per_frame (its own), merged (what it leaves open is filled with what other "
             "frames measured) or auto (merged where the camera moved and the path needs it)"),
      option(
          "max_error", &O::max_error, "PX",
          "fewer points where surfaces are flat, moving nothing by more than PX pixels; also in --ply; 0 = keep all; "
          "unset: where it pays"),
      option("kernel", &O::kernel, "NAME", "nearest (fastest), bilinear (the official splat), resample (sharpest)"),
      option("visibility", &O::visibility, "NAME", "none (naive), ztest (a pass fewer) or reproject (the paper's)"),
      option("accumulation", &O::accumulation, "NAME",
             "product (the paper's), product_in_view (for paths that return), none, foreground; unset: none where the "
             "source camera moves, else foreground where there is one, else product"),
      option("alpha", &O::alpha, "DEG", "surfaces turned further than this from the target camera are not drawn"),
      option("normal_filter", &O::normal_filter, "", "drop surfaces turned away from the target camera"),
      option("point_size", &O::point_size, "X", "scales every footprint; more closes cracks of noisy depth"),
      option("max_footprint", &O::max_footprint, "PX", "largest side of a footprint"),
      option("return_size", &O::return_size, "X",
             "scales footprints on reproject's way back; 1 loses pixels on long paths"),
      option("fringe", &O::fringe, "PX",
             "how far rims of surfaces reach into empty pixels; 1 as the official splat does"),
      option("log_depth_max", &O::log_depth_max, "X",
             "bilinear: ln(1 + depth) of the farthest point of the whole clip, for weights as in the official batch"),
      option("depth_tolerance", &O::depth_tolerance, "X",
             "relative depth difference that counts as visible; unset: 0.02 for ztest, else 0"),
      option("reliability", &O::reliability, "NAME",
             "drop depths on edges, where estimators smear: auto (if the first frame's edges are), on or off"),
      option("dropped_points_hide", &O::dropped_points_hide, "",
             "depths that filter drops still hide what is behind them; no: as in the official code"),
      option("reliability_ratio", &O::reliability_ratio, "X", "largest (max-min)/mean of depth within the window"),
      option("reliability_window", &O::reliability_window, "PX", "side of that window, odd"),
      option("slope_radius", &O::slope_radius, "PX", "neighbourhood of normals; 2 or 3 for noisy depth"),
      option("slope_discontinuity", &O::slope_discontinuity, "X", "relative depth step that separates two surfaces"),
      option("max_tilt", &O::max_tilt, "DEG",
             "surfaces tilted further than this are taken for smeared depth and stay dots; unset: 86, 90 = never"),
      option("foreground_ring", &O::foreground_ring, "",
             "drop depth in a band of 12 pixels around the foreground, as the official code does"),
      option("skip_unneeded", &O::skip_unneeded, "", "leave out passes that cannot change a pixel"),
      option("keep_source", &O::keep_source, "",
             "frames seen from the source's own camera are the source picture, whole"),
      option("threads", &O::threads, "N", "rendering threads, 0 = all processors; never changes the result"),
  };
}

std::vector<Option> output_options() {
  return {
      option("out", &O::out, "DIR", "where results go; unset: <clip's stem>_uwv"),
      option("fps", &O::fps, "X", "frame rate of the videos; unset: the trajectory's, else the clip's, else 16"),
      option("crf", &O::crf, "N", "H.264 quality of colour, 0 (lossless) to 51"),
      option("depth_format", &O::depth_format, "NAME", "npz, png16, exr or none"),
      option("save_masks", &O::save_masks, "", "also write M', M'', M_vis and M_front as videos"),
      option("ply", &O::ply, "N,..", "source frames to write as point clouds"),
      option("contact_sheet", &O::contact_sheet, "N", "columns of contact_sheet.png, 0 = none"),
      option("complete", &O::complete, "NAME",
             "fill the holes: none, inpaint (a draft without a model) or model (implied by --model)"),
      option("overwrite", &O::overwrite, "", "redo finished stages, replace files that are not ours"),
  };
}

using M = ModelOptions;

std::vector<Option> checkpoint_options() {
  return {
      option("model", &M::model, "DIR", "checkpoint of the video diffusion model that fills the holes (docs/model.md)"),
      option("transformer", &M::transformer, "DIR", "its transformer, where that lies elsewhere"),
      option("lora", &M::lora, "FILE[:W],..",
             "LoRAs added to the transformer's weights, each with its weight; unset: 1"),
      option("prompt", &M::prompt, "TEXT", "what the clip shows"),
      option("negative_prompt", &M::negative_prompt, "TEXT", "what guidance leads away from"),
      option("prompt_embeds", &M::prompt_embeds, "FILE",
             ".safetensors with prompt_embeds and negative_prompt_embeds, instead of the text encoder"),
      option("prompt_cache", &M::prompt_cache, "DIR", "keeps encoded prompts; unset: in the user's cache folder"),
      option("few_steps", &M::few_steps, "",
             "for LoRAs distilled to few steps: 4 steps, shift 8, guidance 1 where those are unset"),
      option(
          "sampler", &M::sampler, "NAME",
          "euler (official), euler_plain, unipc, unipc_legacy or dpmpp; unset: euler, of plain VACE the checkpoint's"),
      option("steps", &M::steps, "N",
             "passes of the transformer (two each with guidance); unset: 8 with a LoRA, else 50"),
      option("shift", &M::shift, "X", "moves steps to where there is more noise; unset: 5"),
      option("guidance", &M::guidance, "X",
             "how strongly the prompt counts, 1 = half the time; unset: 4 with a LoRA, "
             "else 6"),
      option("cfg_share", &M::cfg_share, "X", "share of the steps, the first ones, that are guided"),
      option("cfg_batch", &M::cfg_batch, "", "both passes of guidance at once: more memory"),
      option("step_cache", &M::step_cache, "X", "leave out steps that change little: 0 none, 0.1 few, 0.3 many"),
      option("skip_known", &M::skip_known, "N",
             "leave out tokens that are known and farther than N tokens from any hole; unset: none"),
      option("seed", &M::seed, "N", "of the noise: the same seed gives the same bytes"),
  };
}

std::vector<Option> ladder_options() {
  return {
      option("reference", &M::reference, "", "show the transformer frames of the source clip"),
      option("colour_correction", &M::colour_correction, "", "fit the result's colours to the first frame"),
      option("window_frames", &M::window_frames, "N",
             "frames denoised at once, 1 + 4k; longer clips take several windows"),
      option("window_overlap", &M::window_overlap, "N", "frames that windows share, 4k"),
      option("device", &M::device, "NAME", "where the model runs: cpu, or cuda, cuda:N where libtorch has it"),
      option("memory_limit", &M::memory_limit, "BYTES",
             "such as 16G: what is auto is chosen to fit; unset: the machine's"),
      option("weights", &M::weights, "NAME",
             "auto, f32 (exact), bf16_stored, bf16, int8_stored or int8: less memory and, with the units, less time"),
      option("stream", &M::stream, "NAME", "read the transformer block by block at every step: auto, on or off"),
      option("vae_precision", &M::vae_precision, "NAME", "numbers of the autoencoder: auto, f32 or bf16"),
      option("vae_bands", &M::vae_bands, "N", "bands of rows it works through one by one; 0 = as memory needs"),
      option("vae_tile", &M::vae_tile, "PX", "side of overlapping squares it works on, blended: for 8K; 0 = none"),
      option("vae_fast", &M::vae_fast, "DIR", "tiny decoder (TAEHV layout) for the result"),
      option("preview", &M::preview, "", "write preview.png after each step"),
  };
}

std::vector<Option> evaluation_options() {
  return {
      option("eval_reference", &O::eval_reference, "FILE", "real picture from another camera to compare with"),
      option("eval_cameras", &O::eval_cameras, "FILE", "file whose first camera took it, in the world of --cameras"),
  };
}

/// What an option decides, where that differs from the rest of its group.
OptionScope scope_of(std::string_view name, OptionScope of_group) {
  using enum OptionScope;
  static constexpr std::pair<std::string_view, OptionScope> others[] = {{"out", nothing},
                                                                        {"prompt_cache", nothing},
                                                                        {"threads", nothing},
                                                                        {"overwrite", nothing},
                                                                        {"layers", conditioning},
                                                                        {"complete", completion},
                                                                        {"ply", presentation},
                                                                        {"contact_sheet", presentation},
                                                                        {"eval_cameras", evaluation},
                                                                        {"eval_reference", evaluation}};
  for (const auto& [other, scope] : others)
    if (other == name) return scope;
  static constexpr std::string_view of_the_clip[] = {"video", "fx",           "fy",    "cx",     "cy",
                                                     "fov",   "pixel_centre", "start", "stride", "max_frames"};
  return std::find(std::begin(of_the_clip), std::end(of_the_clip), name) != std::end(of_the_clip) ? clip : of_group;
}

std::vector<Option> make_table() {
  std::vector<Option> table;
  const auto append = [&](std::string_view group, std::vector<Option> options,
                          OptionScope scope = OptionScope::conditioning) {
    for (Option& entry : options) {
      entry.info.group = group;
      entry.info.scope = scope_of(entry.info.name, scope);
      table.push_back(std::move(entry));
    }
  };
  append("Input", input_options());
  append("Geometry, where no depth is given", geometry_options(), OptionScope::geometry);
  append("Picture size", size_options(), OptionScope::clip);
  append("Camera path", path_options());
  append("Rendering", render_options());
  append("Output", output_options());
  append("Completion by the video diffusion model", checkpoint_options(), OptionScope::completion);
  append("The model's memory and time", ladder_options(), OptionScope::completion);
  append("Comparison with a real picture", evaluation_options());
  return table;
}

const std::vector<Option>& table() {
  static const std::vector<Option> made = make_table();
  return made;
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j)
      diagonal = std::exchange(row[j], std::min({row[j] + 1, row[j - 1] + 1, diagonal + (a[i - 1] != b[j - 1])}));
  }
  return row.back();
}

const Option& find(std::string_view name, std::string_view where) {
  for (const Option& entry : table())
    if (entry.info.name == name) return entry;
  const auto nearest = std::min_element(table().begin(), table().end(), [&](const Option& a, const Option& b) {
    return edit_distance(a.info.name, name) < edit_distance(b.info.name, name);
  });
  fail(ErrorCode::value_invalid, "{}: unknown option '{}'; did you mean '{}'?", where, name, nearest->info.name);
}

}  // namespace

std::string OptionInfo::flag() const {
  std::string flag = "--" + name;
  std::replace(flag.begin() + 2, flag.end(), '_', '-');
  return flag;
}

std::span<const OptionInfo> option_table() {
  static const std::vector<OptionInfo> infos = [] {
    std::vector<OptionInfo> all;
    for (const Option& entry : table()) all.push_back(entry.info);
    return all;
  }();
  return infos;
}

void set_option(RunOptions& options, std::string_view name, std::string_view text) {
  const Option& entry = find(name, "command line");
  if (!entry.parse(text, options))
    fail(ErrorCode::value_invalid, "{}: found '{}', wanted {}", entry.info.flag(), text, entry.wanted);
}

std::string option_text(const RunOptions& options, std::string_view name) {
  const ordered_json value = find(name, "option_text").write(options);
  if (value.is_null()) return "";
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_array()) return value.dump();
  std::string text;
  for (const ordered_json& item : value) text += (text.empty() ? "" : ",") + item.dump();
  return text;
}

ordered_json to_json(const RunOptions& options) {
  ordered_json all = ordered_json::object();
  for (const Option& entry : table()) all[entry.info.name] = entry.write(options);
  return all;
}

ordered_json to_json(const RunOptions& options, OptionScope scope) {
  ordered_json some = ordered_json::object();
  for (const Option& entry : table())
    if (entry.info.scope == scope) some[entry.info.name] = entry.write(options);
  return some;
}

RunOptions options_from_json(const json& from, std::string_view where) {
  if (!from.is_object()) fail(ErrorCode::value_invalid, "{}: found no JSON object where options were wanted", where);
  RunOptions options;
  for (const auto& [name, value] : from.items()) {
    const Option& entry = find(name, where);
    if (!entry.read(value, options))
      fail(ErrorCode::value_invalid, "{}: /{}: found {}, wanted {}", where, name, value.dump(), entry.wanted);
  }
  return options;
}

RunOptions read_options(const std::string& path) {
  constexpr std::uint64_t max_bytes = 64U << 20U;  // run.json lists every warning; megabytes would be absurd already
  const json whole = io::parse_json(io::read_text(path, max_bytes), path);
  return options_from_json(whole.contains("options") ? whole["options"] : whole, path);
}

}  // namespace uwv
