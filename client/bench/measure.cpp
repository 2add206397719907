#include "bench/measure.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "absl/strings/str_cat.h"
#include "base/cpu_time.h"
#include "image/assemble.h"
#include "image/flip.h"
#include "wire/aov_channels.h"
#include "wire/colour_channels.h"
#include "wire/job_check.h"

namespace tessera::client {
namespace {

constexpr auto kChannelNames = wire::kColourChannels;

absl::StatusOr<BenchBias> bias_of(const Image& reference, const BiasEstimator& images, std::uint32_t spp) {
  const absl::StatusOr<Comparison> comparison = compare_images(reference, images.mean());
  if (!comparison.ok()) return comparison.status();
  std::size_t worst = 0;
  for (std::size_t c = 1; c < comparison->channels.size(); ++c) {
    if (std::abs(comparison->channels[c].t) > std::abs(comparison->channels[worst].t)) worst = c;
  }
  const ChannelBias& bias = comparison->channels[worst];
  return BenchBias{spp, kChannelNames[worst], bias.bias_percent, bias.t, images.result()};
}

absl::StatusOr<BenchRun> judge(const Image& reference, const Image& image, const CompareOptions& compared,
                               const BenchCost& cost, std::uint32_t spp, std::uint64_t seed_offset) {
  const absl::StatusOr<Comparison> comparison = compare_images(reference, image, compared);
  if (!comparison.ok()) return comparison.status();
  const absl::StatusOr<double> flip = flip_error(reference, image);
  if (!flip.ok()) return flip.status();
  return BenchRun{.spp = spp,
                  .seed_offset = seed_offset,
                  .cost = cost,
                  .mse = comparison->mse,
                  .relmse = comparison->relmse,
                  .mse_trimmed = comparison->mse_trimmed,
                  .relmse_trimmed = comparison->relmse_trimmed,
                  .relmse_block = comparison->relmse_block,
                  .flip = *flip};
}

/// Renders as often as there are seeds, at the smallest sample count; the variants take turns.
absl::Status measure_ceilings(std::span<const BenchVariant> variants, const BenchPlan& plan,
                              std::stop_token stop, std::vector<BenchVariantResult>& results) {
  std::vector<std::vector<BenchCeiling>> all(variants.size());
  for (std::uint32_t i = 0; i < plan.seeds; ++i) {
    for (std::size_t v = 0; v < variants.size(); ++v) {
      absl::StatusOr<BenchCeiling> one = variants[v].scene->measure_ceiling(plan.spp.front(), stop);
      if (!one.ok()) return one.status();
      all[v].push_back(*std::move(one));
    }
  }
  for (std::size_t v = 0; v < variants.size(); ++v) {
    std::ranges::sort(all[v], {}, &BenchCeiling::share);
    results[v].ceiling = all[v][all[v].size() / 2];
  }
  return absl::OkStatus();
}

/// CPU seconds of it.
absl::StatusOr<double> denoise(const DenoiseOptions& options, std::uint32_t spp, Image& image) {
  const std::chrono::nanoseconds start = base::process_cpu_time();
  image.metadata["tessera.spp"] = static_cast<std::int32_t>(spp);
  if (const absl::StatusOr<DenoiseReport> done = denoise_image(options, image); !done.ok())
    return done.status();
  return base::in_seconds(base::process_cpu_time() - start);
}

/// All seeds of one sample count.
absl::Status measure_count(std::span<const BenchVariant> variants, const BenchReference& reference,
                           const BenchPlan& plan, std::uint32_t spp,
                           const std::function<void(const std::string&)>& progress, std::stop_token stop,
                           std::vector<BenchVariantResult>& results) {
  std::vector<const BenchScene*> scenes;
  for (const BenchVariant& variant : variants) scenes.push_back(variant.scene.get());
  std::vector<BiasEstimator> sums(variants.size(),
                                  BiasEstimator(reference.image, reference.noise.relmse, plan.seeds));
  for (std::uint32_t seed = 0; seed < plan.seeds; ++seed) {
    progress(absl::StrCat(spp, " samples a pixel, seed ", seed + 1, " of ", plan.seeds));
    absl::StatusOr<std::vector<BenchRender>> renders = render_in_turn(scenes, spp, seed, plan.threads, stop);
    if (!renders.ok()) return renders.status();
    for (std::size_t v = 0; v < variants.size(); ++v) {
      absl::StatusOr<Image> image = assemble_image(variants[v].spec, spp, std::move((*renders)[v].tiles));
      if (!image.ok()) return image.status();
      if (variants[v].denoise) {
        const absl::StatusOr<double> seconds = denoise(*variants[v].denoise, spp, *image);
        if (!seconds.ok()) return seconds.status();
        (*renders)[v].cost.cpu_seconds += *seconds;
      }
      absl::StatusOr<BenchRun> run =
          judge(reference.image, *image, plan.compared(), (*renders)[v].cost, spp, seed);
      if (!run.ok()) return run.status();
      results[v].runs.push_back(*std::move(run));
      sums[v].add(*image);
    }
  }
  for (std::size_t v = 0; v < variants.size(); ++v) {
    absl::StatusOr<BenchBias> bias = bias_of(reference.image, sums[v], spp);
    if (!bias.ok()) return bias.status();
    results[v].biases.push_back(*std::move(bias));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Image> assemble_image(const v1::JobSpec& spec, std::uint32_t spp,
                                     std::vector<wire::TileResult> tiles) {
  AssemblyOptions options;
  options.width = spec.view().width(), options.height = spec.view().height();
  const v1::PixelRect& crop = spec.cut().crop();
  options.crop = {static_cast<std::int32_t>(crop.x0()), static_cast<std::int32_t>(crop.y0()),
                  static_cast<std::int32_t>(crop.x1()), static_cast<std::int32_t>(crop.y1())};
  options.spp = spp;
  options.samples_channel = false;
  options.channels = wire::channels_of(spec.view());
  absl::StatusOr<Assembler> assembler = Assembler::create(std::move(options));
  if (!assembler.ok()) return assembler.status();
  for (wire::TileResult& tile : tiles) {
    if (absl::Status status = assembler->add(std::move(tile)); !status.ok()) return status;
  }
  absl::StatusOr<Assembly> assembly = std::move(*assembler).finish();
  if (!assembly.ok()) return assembly.status();
  return std::move(assembly->image);
}

std::string kind_of(const BenchVariantResult& variant) {
  return variant.denoised ? "biased" : wire::kind_of(variant.spec.content().algorithms());
}

absl::StatusOr<std::vector<BenchVariantResult>> measure_variants(
    std::span<const BenchVariant> variants, const BenchReference& reference, const BenchPlan& plan,
    const std::function<void(const std::string&)>& progress, std::stop_token stop) {
  std::vector<BenchVariantResult> results;
  for (const BenchVariant& variant : variants) {
    const v1::PixelRect& crop = variant.spec.cut().crop();
    const Window& data = reference.image.data;
    const std::int64_t width = crop.x1() - crop.x0(), height = crop.y1() - crop.y0();
    if (width != data.width() || height != data.height()) {
      return absl::InvalidArgumentError(absl::StrCat("the reference (", reference.source, ") is ",
                                                     data.width(), "x", data.height(), ", the render ", width,
                                                     "x", height));
    }
    results.push_back({.name = variant.name,
                       .spec = variant.spec,
                       .import_cpu_seconds = variant.import_cpu_seconds,
                       .build_cpu_seconds = variant.scene->build_cpu_seconds(),
                       .runs = {},
                       .biases = {},
                       .ceiling = {},
                       .structure = variant.scene->structure(),
                       .denoised = variant.denoise.has_value()});
  }
  for (const std::uint32_t spp : plan.spp) {
    if (auto s = measure_count(variants, reference, plan, spp, progress, stop, results); !s.ok()) return s;
  }
  progress("rays alone");
  if (auto s = measure_ceilings(variants, plan, stop, results); !s.ok()) return s;
  return results;
}

}  // namespace tessera::client
