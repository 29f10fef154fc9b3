// SPDX-License-Identifier: Apache-2.0
// One copy of a hot loop for processors with AVX2 and one for the rest, picked when the program starts. Without fused
// multiply-add (see UwvOptions.cmake) both give the same bits. Sanitizers cannot run the start-up resolvers.
#pragma once

#if defined(UWV_SANITIZED) || defined(__SANITIZE_THREAD__) || !defined(__x86_64__)
#define UWV_SIMD_CLONES
#define UWV_SIMD_CLONES_512
#else
#define UWV_SIMD_CLONES __attribute__((target_clones("arch=x86-64-v3", "default")))
/// The same with a third copy for AVX-512: for loops that are written in vectors of sixteen floats.
#define UWV_SIMD_CLONES_512 __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#endif
