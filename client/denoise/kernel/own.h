// The parts of each instruction set's kernel.
#pragma once

#include "denoise/kernel/kernel.h"

namespace tessera::client::denoise {

inline constexpr int kMaxPatchRadius = 8;
/// Rows above the picture have numbers below 0.
inline constexpr int kMarginRows = 1024;

namespace TESSERA_ISA {
void statistical_row(const StatisticalTask& task, int y);
void patch_row(const PatchTask& task, int y, int dx, int dy, int count, int fresh, float* scratch,
               float* out);
void blend_row(const PlaneView* planes, int channels, const PlaneView& inside, int y, int dx, int dy,
               int count, const float* distance, float* const* sums, float* weights);
void fit_window(const FitTask& task);
}  // namespace TESSERA_ISA
}  // namespace tessera::client::denoise
