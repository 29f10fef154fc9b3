// SPDX-License-Identifier: Apache-2.0
// The main program: a clip with depth in, the same moments seen from a camera that was never there out.
#include <fmt/format.h>

#include "support/command_line.h"
#include "support/doctor.h"
#include "support/terminal_monitor.h"
#include "uwv/model/convert_checkpoint.h"
#include "uwv/model/foreground_network.h"
#include "uwv/model/view_completion.h"
#include "uwv/pipeline/compare.h"
#include "uwv/pipeline/environment.h"
#include "uwv/pipeline/run.h"

namespace {

constexpr const char* about =
    "Shows an ordinary video or photo from a camera that was never there.\n"
    "Example: uwv_app --video in.mp4 --depth depth.npz --traj t.json --out result";
constexpr const char* more_examples =
    "More examples:\n"
    "  uwv_app --video photo.png --depth photo.exr --fov 55 --traj left --frames 49\n"
    "  uwv_app --video in.mp4 --depth depth.npz --traj orbit --accumulation product_in_view --complete inpaint\n"
    "  uwv_app --video in.mp4 --traj left --model wan2.1-vace --prompt 'a street at night' --memory-limit 16G\n"
    "  uwv_app --options result/run.json --kernel nearest --out faster\n"
    "docs/usage.md explains each of them.";

uwv::RunComponents components() {
  uwv::RunComponents all;
#ifdef UWV_APP_WITH_MODEL
  all.open_depth_network = uwv::open_depth_network;
  all.open_foreground_network = [](const std::string& folder) { return uwv::open_foreground_network(folder); };
  all.open_foreground_tracker = [](const std::string& folder) { return uwv::open_foreground_tracker(folder); };
  all.check_checkpoint = uwv::check_checkpoint;
  all.complete_views = uwv::complete_views;
#endif
  return all;
}

/// What decides memory and time of the model.
bool is_planned(const uwv::OptionInfo& info) {
  return info.scope == uwv::OptionScope::completion
             ? info.name != "complete"
             : info.name == "size" || info.name == "frames" || info.name == "threads";
}

std::string model_plan(const uwv::RunOptions& options) {
  using namespace uwv;
  if (options.diffusion.model.empty() || options.size == Size{})
    fail(ErrorCode::value_invalid, "model plan: --model and --size are needed, for example --size 832x480 --frames 81");
  try {
    options.diffusion.check();
  } catch (const std::invalid_argument& mistake) {  // here the caller is the user
    throw Error(ErrorCode::value_invalid, mistake.what());
  }
#ifdef UWV_APP_WITH_MODEL
  return plan_completion(options.diffusion, options.size, options.frames.value_or(81), options.threads).report();
#else
  fail(ErrorCode::backend_missing,
       "model plan: this program was built without libtorch; run scripts/setup and build again");
#endif
}

std::string model_convert(const uwv::ConversionOptions& options, [[maybe_unused]] uwv::Monitor& monitor) {
#ifdef UWV_APP_WITH_MODEL
  return uwv::convert_checkpoint(options, monitor).brief();
#else
  uwv::fail(uwv::ErrorCode::backend_missing,
            "model convert --out {}: this program was built without libtorch; run scripts/setup and build again",
            options.out);
#endif
}

}  // namespace

int main(int argc, char** argv) {
  using namespace uwv;

  CLI::App program(about, "uwv_app");
  program.set_version_flag("--version", version());
  program.footer(more_examples);
  program.require_subcommand(0, 1);
  const app::RunFlags run_flags(program);

  CLI::App& look_command = *program.add_subcommand("look", "say what a run would meet: depth range, parallax, path");
  look_command.footer("Example: uwv_app look --video in.mp4 --depth depth.npz --traj t.json");
  const app::RunFlags look_flags(look_command);

  CompareOptions compare;
  CLI::App& compare_command = *program.add_subcommand("compare", "PSNR and SSIM of two clips or pictures");
  compare_command.footer(
      "Example: uwv_app compare --a result/colour.mp4 --b truth.mp4 --mask result/generate_mask.mp4");
  compare_command.add_option("--a", compare.a, "first clip")->required()->type_name("FILE");
  compare_command.add_option("--b", compare.b, "second clip")->required()->type_name("FILE");
  compare_command.add_option("--mask", compare.mask, "clip whose white pixels are left out")->type_name("FILE");

  CLI::App& model_command = *program.add_subcommand("model", "about the video diffusion model");
  model_command.require_subcommand(1);
  CLI::App& plan_command =
      *model_command.add_subcommand("plan", "memory and time it would take, without loading weights");
  plan_command.footer("Example: uwv_app model plan --model DIR --size 832x480 --frames 81 --memory-limit 16G");
  const app::RunFlags plan_flags(plan_command, is_planned);

  uwv::ConversionOptions conversion;
  CLI::App& convert_command =
      *model_command.add_subcommand("convert", "write a smaller checkpoint: its layers' weights in 16 or 8 bits");
  convert_command.footer("Example: uwv_app model convert --model DIR --weights int8 --out SMALLER");
  convert_command.add_option("--model", conversion.model, "checkpoint to read, or a folder of one part of it")
      ->required()
      ->type_name("DIR");
  convert_command
      .add_option("--weights", conversion.weights, "bf16: half of float32; int8: a quarter, as --weights int8")
      ->check(CLI::IsMember({"bf16", "int8"}))
      ->capture_default_str();
  convert_command.add_option("--out", conversion.out, "folder to make; there must be none yet")
      ->required()
      ->type_name("DIR");

  const CLI::App& doctor_command =
      *program.add_subcommand("doctor", "versions, renderers and encoders on this machine");

  int exit_code = 0;
  if (!app::parse(program, argc, argv, exit_code)) return exit_code;
  return app::guarded([&] {
    app::TerminalMonitor monitor;
    if (doctor_command.parsed())
      fmt::print("{}", app::doctor_report());
    else if (compare_command.parsed())
      fmt::print("{}", compare_clips(compare, monitor).report());
    else if (plan_command.parsed())
      fmt::print("{}", model_plan(plan_flags.some_options()));
    else if (convert_command.parsed())
      fmt::print("{}\n", model_convert(conversion, monitor));
    else if (look_command.parsed())
      fmt::print("{}\n", look(look_flags.options(), monitor).brief());
    else
      fmt::print("{}", run(
                           run_flags.options(), monitor,
                           [](const SceneLook& look) { fmt::print("scene: {}\n", look.brief()); }, components())
                           .report());
  });
}
