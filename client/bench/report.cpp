#include "bench/report.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "bench/analysis.h"
#include "bench/whole.h"
#include "wire/enum_words.h"

namespace tessera::client {
namespace {

const std::string& integrator_of(const v1::JobSpec& spec) { return spec.content().algorithms().integrator(); }

std::vector<std::uint32_t> sample_counts(const BenchVariantResult& variant) {
  std::vector<std::uint32_t> counts;
  for (const BenchBias& bias : variant.biases) counts.push_back(bias.spp);
  return counts;
}

/// One line a sample count, errors and times being geometric means over the seeds.
std::string runs_table(const BenchVariantResult& variant, const ReferenceNoise& noise, int block) {
  const std::string means = absl::StrCat("of ", block, "x", block);
  std::string text = absl::StrFormat("  %6s %9s %10s %10s %11s %10s %8s %10s %7s %11s  %-22s %11s %7s\n",
                                     "spp", "CPU s", "MSE", "relMSE", "less 0.1 %", means, "FLIP", "bias %",
                                     "t", "efficiency", "95 % interval", means, "Mray/s");
  for (const BenchBias& bias : variant.biases) {
    const auto value = [&](auto property) { return interval_over(variant, bias.spp, property).value; };
    const Interval efficient =
        interval_over(variant, bias.spp, [&](const BenchRun& run) { return efficiency(run, noise); });
    absl::StrAppendFormat(
        &text, "  %6d %9.3f %10.4g %10.4g %11.4g %10.4g %8.4f %+7.3f %s %+7.2f %11.4g  %-22s %11.4g %7.2f\n",
        bias.spp, value([](const BenchRun& run) { return run.cost.cpu_seconds; }),
        value([&](const BenchRun& run) { return without_noise(run.mse, noise.mse); }),
        value([&](const BenchRun& run) { return without_noise(run.relmse, noise.relmse); }),
        value([](const BenchRun& run) { return run.relmse_trimmed; }),
        value([&](const BenchRun& run) { return without_noise(run.relmse_block, noise.relmse_block); }),
        value([](const BenchRun& run) { return run.flip; }), bias.percent, bias.channel, bias.t,
        efficient.value, ends_of(efficient),
        value([&](const BenchRun& run) { return block_efficiency(run, noise); }),
        value([](const BenchRun& run) {
          return 1e-6 * static_cast<double>(run.cost.counts.rays()) / run.cost.cpu_seconds;
        }));
  }
  return text;
}

/// The square of the bias apart from the variance, a line a sample count; nothing where one seed tells none.
std::string bias_table(const BenchVariantResult& variant) {
  if (variant.biases.empty() || std::isnan(variant.biases.front().apart.variance)) return "";
  std::string text =
      absl::StrFormat("  %6s %11s %11s %11s  relative, as relMSE\n", "spp", "variance", "bias^2", "+-");
  for (const BenchBias& bias : variant.biases) {
    absl::StrAppendFormat(&text, "  %6d %11.4g %11.4g %11.4g  %s\n", bias.spp, bias.apart.variance,
                          bias.apart.bias2, bias.apart.bias2_error,
                          std::isnan(bias.apart.bias2_error) ? "four seeds would tell"
                          : bias.apart.is_biased()           ? "biased"
                                                             : "no bias seen");
  }
  return text;
}

/// "camera 12 %, intersection 40 % ...", of the time that all runs took.
std::string stages_line(const BenchCost& cost) {
  std::vector<std::string> parts;
  double rest = cost.cpu_seconds;
  for (const auto& [stage, seconds] : cost.stage_seconds) {
    rest -= seconds;
    if (seconds > 0) parts.push_back(absl::StrFormat("%s %.1f %%", stage, 100 * seconds / cost.cpu_seconds));
  }
  parts.push_back(absl::StrFormat("rest %.1f %%", 100 * rest / cost.cpu_seconds));
  return absl::StrJoin(parts, ", ");
}

/// The structure that rays search, how fast each kind of ray finds something in it, and how much it visits.
std::string structure_text(const BenchVariantResult& variant) {
  const auto figure = [&](const char* name) {
    const auto found = variant.structure.find(name);
    return found == variant.structure.end() ? 0.0 : found->second;
  };
  std::string text = absl::StrFormat("  structure               built in %.2f CPU s, %.4g MB",
                                     figure("build_cpu_seconds"), 1e-6 * figure("bytes"));
  if (figure("primitives") > 0) {
    absl::StrAppendFormat(&text, "; %.0f primitives, %.0f nodes, %.0f leaves, %.0f empty",
                          figure("primitives"), figure("nodes"), figure("leaves"), figure("empty_leaves"));
    absl::StrAppendFormat(&text, ", %.3g references a primitive, depth %.0f",
                          figure("references") / figure("primitives"), figure("depth"));
    if (figure("sah_cost") > 0) absl::StrAppendFormat(&text, ", SAH cost %.4g", figure("sah_cost"));
  }
  std::vector<std::string> kinds;
  constexpr std::array kNames{"camera", "bounce", "shadow"};
  for (std::size_t kind = 0; kind < kNames.size(); ++kind) {
    const BenchRays& rays = variant.ceiling.by_kind[kind];
    if (rays.count == 0) continue;
    const auto count = static_cast<double>(rays.count);
    std::string one = absl::StrFormat("%s %.2f", kNames[kind], 1e-6 * count / rays.cpu_seconds);
    if (rays.primitives > 0) {
      absl::StrAppendFormat(&one, " (%.1f nodes, %.1f primitives)", static_cast<double>(rays.nodes) / count,
                            static_cast<double>(rays.primitives) / count);
    }
    kinds.push_back(std::move(one));
  }
  absl::StrAppend(&text, "\n  Mray/s alone            ", absl::StrJoin(kinds, ", "), "\n");
  return text;
}

std::string variant_text(const BenchVariantResult& variant, const ReferenceNoise& noise, int block) {
  BenchCost all;
  for (const BenchRun& run : variant.runs) all += run.cost;
  std::string text;
  if (!variant.name.empty()) absl::StrAppend(&text, variant.name, ", ", kind_of(variant), "\n");
  absl::StrAppend(&text, runs_table(variant, noise, block), bias_table(variant));
  if (const std::optional<Slope> slope = slope_of(variant, noise)) {
    absl::StrAppendFormat(&text, "  slope of MSE over time  %.3f", slope->value);
    if (std::isfinite(slope->standard_error)) {
      absl::StrAppendFormat(&text, " (standard error %.3f)", slope->standard_error);
    }
    text += "\n";
  }
  const double samples = static_cast<double>(all.counts.samples);
  absl::StrAppendFormat(&text, "  rays a sample           %.2f camera, %.2f bounce, %.2f shadow\n",
                        static_cast<double>(all.counts.camera_rays) / samples,
                        static_cast<double>(all.counts.bounce_rays) / samples,
                        static_cast<double>(all.counts.shadow_rays) / samples);
  const BenchCeiling& ceiling = variant.ceiling;
  const double rays = 1e-6 * static_cast<double>(ceiling.rays);
  absl::StrAppendFormat(&text, "  of the rays alone       %.1f %% (%.2f of %.2f Mray/s)\n",
                        100 * ceiling.share(), rays / ceiling.render_cpu_seconds,
                        rays / ceiling.replay_cpu_seconds);
  absl::StrAppend(&text, structure_text(variant));
  absl::StrAppendFormat(&text, "  rendering               %s\n", stages_line(all));
  absl::StrAppendFormat(&text, "  before rendering        import %.2f, build %.2f CPU s\n",
                        variant.import_cpu_seconds, variant.build_cpu_seconds);
  if (all.counts.dropped_samples > 0)
    absl::StrAppendFormat(&text, "  samples dropped         %d\n", all.counts.dropped_samples);
  return text;
}

std::string verdict(const std::string& a, const std::string& b, const Interval& ratio) {
  if (!ratio.has_ends()) return "one seed shows no significance";
  if (ratio.low > 1) return absl::StrCat(b, " wins");
  if (ratio.high < 1) return absl::StrCat(a, " wins");
  return "the difference is not significant";
}

/// For pixels, and for means over blocks.
std::string comparison_text(const BenchVariantResult& a, const BenchVariantResult& b,
                            const ReferenceNoise& noise, int block) {
  std::string text;
  const auto append = [&](const std::string& what, Efficiency& efficient) {
    absl::StrAppend(&text, "efficiency of ", b.name, " over ", a.name, what, "\n");
    const auto line = [&](const std::string& name, std::optional<std::uint32_t> spp) {
      const Interval ratio = efficiency_ratio(a, b, noise, spp, efficient);
      absl::StrAppendFormat(&text, "  %10s  x %.3f  (95 %%: %s)  %s\n", name, ratio.value, ends_of(ratio),
                            verdict(a.name, b.name, ratio));
    };
    for (const std::uint32_t spp : sample_counts(a)) line(absl::StrCat(spp, " spp"), spp);
    line("all", std::nullopt);
  };
  append("", efficiency);
  append(absl::StrFormat(", of means over %dx%d pixels", block, block), block_efficiency);
  return text;
}

}  // namespace

std::string to_text(const BenchSceneResult& scene) {
  const v1::JobSpec& spec = scene.variants.front().spec;
  const v1::PixelRect& crop = spec.cut().crop();
  std::string text = absl::StrFormat(
      "%s  %dx%d pixels, %s (%s), depth %d, %s, %s\nreference: %s", scene.name, crop.x1() - crop.x0(),
      crop.y1() - crop.y0(), integrator_of(spec), kind_of(scene.variants.front()), spec.view().max_depth(),
      wire::word_of(spec.view().sampler()), spec.farm().isa(), scene.reference);
  if (scene.noise.mse > 0) {
    absl::StrAppendFormat(&text, "; its own MSE %.3g, relMSE %.3g taken off MSE and relMSE", scene.noise.mse,
                          scene.noise.relmse);
  }
  text += "\n";
  for (const BenchVariantResult& variant : scene.variants)
    absl::StrAppend(&text, variant_text(variant, scene.noise, scene.block));
  for (std::size_t i = 1; i < scene.variants.size(); ++i) {
    absl::StrAppend(&text,
                    comparison_text(scene.variants.front(), scene.variants[i], scene.noise, scene.block));
  }
  absl::StrAppend(&text, to_text(scene.whole));
  for (const BenchRefusal& refusal : scene.refusals)
    absl::StrAppend(&text, "not measured: ", refusal.name, ": ", refusal.reason, "\n");
  return text;
}

namespace {

/// "NAME of the scene's" for one scene, with the scene's for several.
std::string series_name(const BenchSceneResult& scene, const BenchVariantResult& variant, bool one_scene) {
  if (variant.name.empty()) return scene.name;
  return one_scene ? variant.name : absl::StrCat(scene.name, ", ", variant.name);
}

double mean_time(const BenchVariantResult& variant, std::uint32_t spp) {
  return interval_over(variant, spp, [](const BenchRun& run) { return run.cost.cpu_seconds; }).value;
}

/// The square of the bias, where it stands out from the noise; the bars are 95 % intervals.
PlotSeries bias_series(const BenchVariantResult& variant, std::size_t color) {
  PlotSeries series{.name = "", .points = {}, .color = color, .dashed = true};
  for (const BenchBias& one : variant.biases) {
    const double bias2 = one.apart.bias2, half = 1.96 * one.apart.bias2_error;
    if (one.apart.is_biased())
      series.points.push_back({mean_time(variant, one.spp), bias2, bias2 - half, bias2 + half});
  }
  return series;
}

}  // namespace

LogLogPlot to_bias_plot(const std::vector<BenchSceneResult>& scenes, const BenchPlan& plan) {
  LogLogPlot plot;
  plot.title = absl::StrCat("Bias and variance", scenes.size() == 1 ? ": " + scenes.front().name : "");
  plot.subtitle = absl::StrCat(plan.spp.front(), " to ", plan.spp.back(), " samples a pixel, ", plan.seeds,
                               " seeds; dashed: square of the bias, where it stands out from the noise");
  plot.x_label = "CPU time of rendering [s]";
  plot.y_label = "relative squared error";
  std::size_t color = 0;
  for (const BenchSceneResult& scene : scenes) {
    for (const BenchVariantResult& variant : scene.variants) {
      PlotSeries variance{
          .name = series_name(scene, variant, scenes.size() == 1), .points = {}, .color = color};
      for (const BenchBias& one : variant.biases)
        variance.points.push_back({mean_time(variant, one.spp), one.apart.variance});
      plot.series.push_back(std::move(variance));
      if (PlotSeries bias = bias_series(variant, color++); !bias.points.empty())
        plot.series.push_back(std::move(bias));
    }
  }
  return plot;
}

LogLogPlot to_plot(const std::vector<BenchSceneResult>& scenes, const BenchPlan& plan) {
  LogLogPlot plot;
  plot.title =
      scenes.size() == 1 ? absl::StrCat("Error over time: ", scenes.front().name) : "Error over time";
  plot.subtitle =
      absl::StrCat(plan.spp.front(), " to ", plan.spp.back(), " samples a pixel, ", plan.seeds,
                   plan.seeds == 1 ? " seed" : " seeds", plan.seeds > 1 ? "; bars: 95 % interval" : "",
                   "; in brackets: slope of MSE over time; dashed: bias^2, where seen");
  plot.x_label = "CPU time of rendering [s]";
  plot.y_label = "relative mean squared error";
  std::size_t color = 0;
  for (const BenchSceneResult& scene : scenes) {
    for (const BenchVariantResult& variant : scene.variants) {
      PlotSeries series;
      series.color = color;
      series.name = series_name(scene, variant, scenes.size() == 1);
      if (const auto slope = slope_of(variant, scene.noise))
        absl::StrAppendFormat(&series.name, "  (%.2f)", slope->value);
      for (const std::uint32_t spp : sample_counts(variant)) {
        const Interval error = interval_over(
            variant, spp, [&](const BenchRun& run) { return without_noise(run.relmse, scene.noise.relmse); });
        series.points.push_back({mean_time(variant, spp), error.value, error.has_ends() ? error.low : 0,
                                 error.has_ends() ? error.high : 0});
      }
      plot.series.push_back(std::move(series));
      if (PlotSeries bias = bias_series(variant, color++); !bias.points.empty())
        plot.series.push_back(std::move(bias));
    }
  }
  return plot;
}

}  // namespace tessera::client
