// SPDX-License-Identifier: Apache-2.0
// The parts of one completion, in the order they are done. Each opens what it needs of the checkpoint and frees it.
#pragma once

#include <optional>

#include "model/diffusion/clip_conditions.h"
#include "model/diffusion/completion_setup.h"
#include "model/diffusion/decoded_frames.h"
#include "model/diffusion/preview.h"
#include "model/diffusion/prompt_embeddings.h"
#include "model/diffusion/window_network.h"

namespace uwv::model {

class CompletionJob {
 public:
  CompletionJob(const ModelOptions& options, const RenderedClip& clip, const CompletedClip& out, Monitor& monitor);

  CompletionSummary run();

 private:
  void encode();
  void embed();
  void denoise();
  void decode();
  void copy_through();
  std::vector<DenoiseWindow> make_windows(const WanTransformer& network, PassCount& count);
  DenoiseWindow make_window(const WanTransformer& network, std::size_t k, const at::Tensor& wanted, PassCount& count);
  void show_preview(const LatentColours& colours, const std::optional<TinyVae>& fast, const DenoiseStep& step) const;
  void skip(const std::string& what) { summary_.skipped.push_back(what); }
  void warn(const std::string& sentence);
  template <class Work>
  void timed(const char* name, Work work);

  const ModelOptions& options_;
  const RenderedClip& clip_;
  const CompletedClip& out_;
  Monitor& monitor_;
  CompletionSetup setup_;
  ClipTensors tensors_;
  ClipConditions conditions_;
  std::vector<at::Tensor> references_;  ///< By window; undefined where none is shown.
  PromptEmbeddings text_;
  at::Tensor latents_;
  CompletionSummary summary_;
};

}  // namespace uwv::model
