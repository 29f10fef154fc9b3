#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""diffusers' autoencoder on a folder of weights, for comparison with `uwv_bench model vae`.

Run in the environment that scripts/diffusers-env makes:
  .cache/diffusers/bin/python scripts/diffusers-vae.py MODEL --way decode --frames 5 --width 416 --height 240
Prints seconds and processor seconds a frame and the peak memory of the whole process.
"""
import argparse
import resource
import time

import torch
from diffusers import AutoencoderKLWan


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("model")
    parser.add_argument("--way", default="decode", choices=["decode", "encode"])
    parser.add_argument("--dtype", default="float32", choices=["float32", "bfloat16"])
    parser.add_argument("--frames", type=int, default=5)
    parser.add_argument("--width", type=int, default=416)
    parser.add_argument("--height", type=int, default=240)
    parser.add_argument("--tile", type=int, default=0, help="pixels of a tile; 0 = none")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    torch.set_num_threads(args.threads)
    torch.manual_seed(args.seed)
    dtype = getattr(torch, args.dtype)
    vae = AutoencoderKLWan.from_pretrained(args.model, subfolder="vae", torch_dtype=dtype).eval()
    if args.tile:
        vae.enable_tiling(args.tile, args.tile, args.tile // 4 * 3, args.tile // 4 * 3)
    if args.way == "decode":
        shape = (1, vae.config.z_dim, (args.frames - 1) // 4 + 1, args.height // 8, args.width // 8)
        given = torch.randn(shape).to(dtype)
    else:
        given = (torch.rand(1, 3, args.frames, args.height, args.width) * 2 - 1).to(dtype)
    with torch.inference_mode():
        start, processor_start = time.perf_counter(), time.process_time()
        vae.decode(given) if args.way == "decode" else vae.encode(given)
        seconds, processor = time.perf_counter() - start, time.process_time() - processor_start
    print(f"{args.way}: {seconds / args.frames:.2f} s a frame, {processor / args.frames:.2f} s of processors")
    print(f"peak {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e9:.2f} GB")


if __name__ == "__main__":
    main()
