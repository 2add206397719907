// Renders a scene again and again, and holds every image against a reference.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "bench/bias.h"
#include "bench/process.h"
#include "bench/reference.h"
#include "denoise/denoise.h"
#include "image/metrics.h"
#include "local/bench_scene.h"
#include "tessera/v1/job.pb.h"

namespace tessera::client {

/// One way to render a scene, ready to be measured.
struct BenchVariant {
  std::string name;  // "sampler=sobol"; empty where there is nothing to compare
  v1::JobSpec spec;
  std::unique_ptr<BenchScene> scene;
  double import_cpu_seconds = 0;
  std::optional<DenoiseOptions> denoise = {};  // applied to each image; its CPU time is part of the image's
};

/// One image. Errors are against the reference as it is, noise included.
struct BenchRun {
  std::uint32_t spp = 0;
  std::uint64_t seed_offset = 0;
  BenchCost cost;
  double mse = 0, relmse = 0;                  // see metrics.h
  double mse_trimmed = 0, relmse_trimmed = 0;  // without the worst 0.1 % of the pixels
  double relmse_block = 0;                     // relMSE of block means (BenchPlan::block), without those
  double flip = 0;
};

/// The images of all seeds of one sample count against the reference: the mean's channel of largest t, and
/// the square of the bias apart from the variance.
struct BenchBias {
  std::uint32_t spp = 0;
  std::string channel;
  double percent = 0, t = 0;
  BiasAndVariance apart = {};
};

struct BenchVariantResult {
  std::string name;
  v1::JobSpec spec;
  double import_cpu_seconds = 0, build_cpu_seconds = 0;
  std::vector<BenchRun> runs;  // sorted by sample count, then seed
  std::vector<BenchBias> biases;
  BenchCeiling ceiling;                     // the one of median share
  std::map<std::string, double> structure;  // BenchScene::structure
  bool denoised = false;
};

/// "unbiased" ...: the integrator's kind (wire/algorithm.h), and "biased" where images were denoised.
std::string kind_of(const BenchVariantResult& variant);

/// A variant that was asked for and cannot be measured.
struct BenchRefusal {
  std::string name, reason;
};

/// One picture of one process.
struct WholeRun {
  std::uint32_t spp = 0;
  std::uint64_t seed = 0;
  ProcessCost cost;
  double relmse = 0, relmse_trimmed = 0, relmse_block = 0;  // against its side's reference, as it is

  /// 1 / (relMSE without the worst 0.1 % x CPU seconds of the process).
  double efficiency() const { return 1 / (relmse_trimmed * cost.cpu_seconds); }
  /// The same of means over blocks.
  double block_efficiency() const { return 1 / (relmse_block * cost.cpu_seconds); }
};

struct WholeResult {
  std::string name, reference;
  std::vector<WholeRun> runs;  // sorted by sample count, then seed
};

struct BenchSceneResult {
  std::string name;
  std::string reference;  // where the reference comes from
  ReferenceNoise noise;
  int block = CompareOptions{}.block;  // BenchPlan::block
  std::vector<BenchVariantResult> variants;
  std::vector<BenchRefusal> refusals = {};
  std::vector<WholeResult> whole = {};  // processes, this program's first; empty: not asked for
};

struct BenchPlan {
  std::vector<std::uint32_t> spp;  // rising
  std::uint32_t seeds = 1;
  int threads = 1;
  int block = CompareOptions{}.block;  // side of the blocks whose means have an error of their own

  CompareOptions compared() const {
    CompareOptions options;
    options.block = block;
    return options;
  }
};

/// Renders every variant with every sample count and seed, the variants taking turns, seed after seed.
/// `progress` is told what comes next. InvalidArgument where the reference's size is another; Cancelled when
/// stopped.
absl::StatusOr<std::vector<BenchVariantResult>> measure_variants(
    std::span<const BenchVariant> variants, const BenchReference& reference, const BenchPlan& plan,
    const std::function<void(const std::string&)>& progress, std::stop_token stop);

/// R, G, B and the other channels of a render.
absl::StatusOr<Image> assemble_image(const v1::JobSpec& spec, std::uint32_t spp,
                                     std::vector<wire::TileResult> tiles);

}  // namespace tessera::client
