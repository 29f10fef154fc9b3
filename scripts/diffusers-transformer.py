#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""One step of diffusers' transformer on a folder of weights, for comparison with `uwv_bench model transformer`.

Run in the environment that scripts/diffusers-env makes:
  .cache/diffusers/bin/python scripts/diffusers-transformer.py MODEL --frames 17 --width 416 --height 240 --out case.safetensors
Prints seconds a step and the peak memory; --out saves inputs and answer for `uwv_bench model transformer --compare`.
"""
import argparse
import resource
import time

import torch
from diffusers import WanVACETransformer3DModel
from safetensors.torch import save_file


def inputs(config, args):
    rows, columns, frames = args.height // 8, args.width // 8, (args.frames - 1) // 4 + 1
    torch.manual_seed(args.seed)
    text = torch.randn(1, 512, config.text_dim)
    text[:, args.text_tokens:] = 0
    return {
        "latents": torch.randn(1, config.in_channels, frames, rows, columns),
        "control": torch.randn(1, config.vace_in_channels, frames, rows, columns),
        "text": text,
    }


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("model")
    parser.add_argument("--dtype", default="float32", choices=["float32", "bfloat16"])
    parser.add_argument("--frames", type=int, default=17)
    parser.add_argument("--width", type=int, default=416)
    parser.add_argument("--height", type=int, default=240)
    parser.add_argument("--text-tokens", type=int, default=40)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--runs", type=int, default=1)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out")
    args = parser.parse_args()
    torch.set_num_threads(args.threads)
    dtype = getattr(torch, args.dtype)
    start = time.perf_counter()
    model = WanVACETransformer3DModel.from_pretrained(args.model, subfolder="transformer", torch_dtype=dtype).eval()
    print(f"open {time.perf_counter() - start:.2f} s")
    case = inputs(model.config, args)
    call = {
        "hidden_states": case["latents"].to(dtype),
        "control_hidden_states": case["control"].to(dtype),
        "encoder_hidden_states": case["text"].to(dtype),
        "timestep": torch.tensor([500.0]),
    }
    with torch.inference_mode():
        for run in range(args.runs + 1):
            start = time.perf_counter()
            answer = model(**call, return_dict=False)[0]
            print(f"{'first step' if run == 0 else 'step'} {time.perf_counter() - start:.2f} s", flush=True)
    print(f"peak {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6:.2f} GB")
    if args.out:
        save_file({**case, "out": answer.float()}, args.out)


if __name__ == "__main__":
    main()
