// The inner loops of denoising, compiled once for each instruction set. All have the same bits: sixteen lanes
// are worked on alike, whatever the machine's own width, and nothing is fused.
#pragma once

namespace tessera::client::denoise {

inline constexpr int kMaxGuides = 8;

/// A plane as kernels see it: pixel (x, y) at pixels[y * stride + x], valid within the margin (plane.h).
struct PlaneView {
  const float* pixels = nullptr;
  int stride = 0;
};

/// A pixel's variance counts as at most so many times what is usual about the pixel that it is compared with:
/// the edge of a lamp, whose noise is larger than the wall's light, is not like the wall for that.
inline constexpr float kMostVariance = 4;

struct StatisticalTask {
  int width = 0, height = 0;
  int window_radius = 0;
  float critical = 0;  // the test's bound on the square of the difference over its variance
  PlaneView first[3] = {}, second[3] = {};  // means of the halves
  PlaneView variance[3] = {};               // variance of a half's mean
  PlaneView usual[3] = {};                  // variance about the pixel
  PlaneView inside = {};                    // 1 in the picture, 0 in its margin
  int guides = 0;
  // Scaled: pixels that differ by about 1 have little to do with each other.
  PlaneView guide[kMaxGuides] = {};
  // Where the averages of the halves go; pixel (x, y) at [y * stride + x], 16 at a time.
  float *first_out[3] = {}, *second_out[3] = {};
  int stride = 0;
};

/// The result of one row.
using StatisticalRow = void (*)(const StatisticalTask& task, int y);

/// Pixels between the centres of neighbouring windows.
inline constexpr int kCentreStep = 4;
inline constexpr int kWindowRadius = 9;
inline constexpr int kWindowSide = 2 * kWindowRadius + 1;
inline constexpr int kWindowPixels = kWindowSide * kWindowSide;
inline constexpr int kPaddedWindow = (kWindowPixels + 15) / 16 * 16;
inline constexpr int kPatchRadius = 3;
/// Windows' weights are found with each of these bandwidths: k of NL-means.
inline constexpr int kBandwidths = 2;

/// Distances of patches: what NL-means weighs by.
struct PatchTask {
  int channels = 0;
  PlaneView value[3] = {}, variance[3] = {};
  PlaneView usual[3] = {};  // variance about the pixel
  int patch_radius = 0;
};

/// The mean over the patch, and over channels, of the squared difference of pixels x + dx, y + dy and x, y,
/// less what noise makes of it, in units of the noise [Rousselle et al. 2012], for x in [0, count), 16 at a
/// time. `scratch`: (2 * r + 1) rows of count + 48 floats, r being the patch's radius, those of y - r ...
/// y + r at row % (2 * r + 1); rows from y + r - `fresh` + 1 on are made anew.
using PatchRow = void (*)(const PatchTask& task, int y, int dx, int dy, int count, int fresh, float* scratch,
                          float* out);

/// Sums of fits, over all windows that a pixel is in.
struct FitSums {
  float *value[3] = {}, *weight = nullptr;
  int stride = 0;
};

struct FitTask {
  int x = 0, y = 0;  // the centre
  int guides = 0;
  PlaneView guide[kMaxGuides] = {};
  PlaneView inside = {};
  PlaneView colour[3] = {};
  const float* distance = nullptr;  // patch distances of the window's pixels, kPaddedWindow of them
  float bandwidth = 0;              // k
  FitSums sums = {};                // pixel (x, y) at [y * stride + x], valid in the window
};

/// Fits colours of a window by a first-order function of the guides, and adds the fit to all its pixels
/// [Bitterli et al. 2016].
using FitWindow = void (*)(const FitTask& task);

/// Adds the plane's row y, displaced by (dx, dy), weighted by exp(-distance), to `sums`, and the weights to
/// `weights`: `count` pixels from x = 0 on, 16 at a time.
using BlendRow = void (*)(const PlaneView* planes, int channels, const PlaneView& inside, int y, int dx,
                          int dy, int count, const float* distance, float* const* sums, float* weights);

struct Kernel {
  StatisticalRow statistical_row = nullptr;
  PatchRow patch_row = nullptr;
  FitWindow fit_window = nullptr;
  BlendRow blend_row = nullptr;
};

/// The best for this machine.
const Kernel& kernel();

}  // namespace tessera::client::denoise
