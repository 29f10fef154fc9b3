// SPDX-License-Identifier: Apache-2.0
// Whether one sees where the windows of a long clip meet: the change from frame to frame at their ends against that
// elsewhere, in the hole, where all is the model's.
#include <filesystem>

#include "bench/completed_clip.h"
#include "bench/model_commands.h"
#include "model/diffusion/windows.h"

namespace uwv::bench {
namespace {

using Frames = std::vector<ImageRgb>;

/// Frame k is the first behind a window's end.
using Ends = std::vector<long>;

long latents_of(long frames) { return 1 + (frames - 1) / 4; }
/// The first frame that a latent frame holds.
long first_frame(long latent) { return latent == 0 ? 0 : 4 * latent - 3; }

/// Windows denoised together, as the library does.
Frames together(ModelOptions options, const RenderedClip& clip, int threads) {
  return complete(options, clip, threads).frames;
}

Ends ends_together(const ModelOptions& options, long frames) {
  Ends ends;
  for (const model::Window& window :
       model::plan_windows(latents_of(frames), {options.window_frames, options.window_overlap})) {
    if (window.first > 0) ends.push_back(first_frame(window.first));
    if (const long behind = window.first + window.count; behind < latents_of(frames))
      ends.push_back(first_frame(behind));
  }
  return ends;
}

/// Windows one after the other; each is shown the last `overlap` frames of the one before as known.
Frames continued(ModelOptions options, const RenderedClip& clip, int overlap, int threads) {
  Frames done;
  while (static_cast<long>(done.size()) < clip.frames) {
    const long known = done.empty() ? 0 : overlap, start = static_cast<long>(done.size()) - known;
    RenderedClip part{clip.size, std::min<long>(options.window_frames, clip.frames - start), {}, {}};
    part.read = [&, start, known](long k, ImageRgb& colour, GenerateMask& holes) {
      clip.read(start + k, colour, holes);
      if (k >= known) return;
      colour = done[static_cast<std::size_t>(start + k)];
      holes = GenerateMask(clip.size.width, clip.size.height);
    };
    part.read_source = [&, start](long k, ImageRgb& colour) { clip.read_source(start + k, colour); };
    const Frames made = complete(options, part, threads).frames;
    done.insert(done.end(), made.begin() + known, made.end());
    ++options.seed;
  }
  return done;
}

Ends ends_continued(long frames, int window, int overlap) {
  Ends ends;
  for (long end = window; end < frames; end += window - overlap) ends.push_back(end);
  return ends;
}

/// Mean change of a channel from the frame before, where both have the hole.
double change(const Frames& frames, const RenderedClip& clip, long k) {
  ImageRgb colour;
  GenerateMask holes;
  clip.read(k - 1, colour, holes);
  double sum = 0, count = 0;
  const ImageRgb &now = frames[static_cast<std::size_t>(k)], &before = frames[static_cast<std::size_t>(k - 1)];
  for (std::size_t i = 0; i < clip.size.pixels(); ++i) {
    if (holes.data()[i] == 0) continue;
    const Rgb8 a = now.data()[i], b = before.data()[i];
    sum += std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b);
    count += 3;
  }
  return count > 0 ? sum / count : 0;
}

struct Seams {
  double at_ends = 0, elsewhere = 0, last_psnr = 0;
  int runs = 0;

  /// Latent frames begin every four frames, where change is another than within them: ends are held against the other
  /// such places.
  void add(const Frames& frames, const RenderedClip& clip, const Ends& ends, const Frames& whole) {
    double end_sum = 0, other_sum = 0, other_count = 0;
    for (const long end : ends) end_sum += change(frames, clip, end);
    for (long k = first_frame(2); k < clip.frames; k += 4) {
      if (std::any_of(ends.begin(), ends.end(), [k](long end) { return std::abs(end - k) < 4; })) continue;
      other_sum += change(frames, clip, k);
      ++other_count;
    }
    at_ends += end_sum / std::max(1.0, static_cast<double>(ends.size()));
    elsewhere += other_sum / std::max(1.0, other_count);
    const auto last = [](const Frames& all) {
      return Frames(all.end() - static_cast<long>(all.size() / 4), all.end());
    };
    last_psnr += psnr(last(frames), last(whole));
    ++runs;
  }
};

void report(Table& table, const char* way, int overlap, const Seams& seams) {
  table.add({way, overlap, seams.at_ends / seams.runs, seams.elsewhere / seams.runs, seams.at_ends / seams.elsewhere,
             seams.last_psnr / seams.runs});
}

}  // namespace

std::vector<Table> measure_windows(const ModelBenchOptions& options) {
  ModelOptions model;
  model.model = options.model;
  model.transformer = options.transformer;
  model.prompt = "a street at night";
  model.steps = options.steps;
  model.guidance = 1;
  model.weights = WeightsForm::f32;
  model.colour_correction = false;
  model.prompt_cache = (std::filesystem::temp_directory_path() / "uwv-bench-prompts").string();
  const RenderedClip clip = moving_pattern({options.width, options.height}, options.frames);
  std::vector<Seams> joint(options.overlaps.size()), chained(options.overlaps.size());
  Seams apart;
  for (int run = 0; run < std::max(1, options.runs); ++run) {
    model.seed = static_cast<long>(options.seed) + 1000L * run;
    model.window_frames = 4 * static_cast<int>(latents_of(options.frames)) + 1;
    model.window_overlap = 4;
    const Frames whole = together(model, clip, options.threads);
    model.window_frames = options.window_frames;
    for (std::size_t i = 0; i < options.overlaps.size(); ++i) {
      model.window_overlap = options.overlaps[i];
      joint[i].add(together(model, clip, options.threads), clip, ends_together(model, clip.frames), whole);
      // One more, so that a window's known frames are whole latent frames.
      const int shown = options.overlaps[i] + 1;
      chained[i].add(continued(model, clip, shown, options.threads), clip,
                     ends_continued(clip.frames, model.window_frames, shown), whole);
    }
    apart.add(continued(model, clip, 0, options.threads), clip, ends_continued(clip.frames, model.window_frames, 0),
              whole);
  }
  Table table("windows", {"way", "overlap", "at_ends", "elsewhere", "ratio", "last_quarter_psnr_db"});
  for (std::size_t i = 0; i < joint.size(); ++i) report(table, "together", options.overlaps[i], joint[i]);
  for (std::size_t i = 0; i < chained.size(); ++i) report(table, "continued", options.overlaps[i] + 1, chained[i]);
  report(table, "apart", 0, apart);
  return {table};
}

}  // namespace uwv::bench
