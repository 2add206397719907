#include <nlohmann/json.hpp>

#include "bench/analysis.h"
#include "bench/report.h"
#include "wire/enum_words.h"
#include "wire/version.h"

namespace tessera::client {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Interval& interval) {
  return {{"value", interval.value}, {"low", interval.low}, {"high", interval.high}};
}

Json json_of(const BenchRun& run, const ReferenceNoise& noise) {
  return {{"spp", run.spp},
          {"seed_offset", run.seed_offset},
          {"cpu_seconds", run.cost.cpu_seconds},
          {"mse", without_noise(run.mse, noise.mse)},
          {"relmse", without_noise(run.relmse, noise.relmse)},
          {"mse_trimmed", run.mse_trimmed},
          {"relmse_trimmed", run.relmse_trimmed},
          {"relmse_block", without_noise(run.relmse_block, noise.relmse_block)},
          {"flip", run.flip},
          {"efficiency", efficiency(run, noise)},
          {"efficiency_block", block_efficiency(run, noise)},
          {"rays",
           {{"camera", run.cost.counts.camera_rays},
            {"bounce", run.cost.counts.bounce_rays},
            {"shadow", run.cost.counts.shadow_rays},
            {"total", run.cost.counts.rays()}}},
          {"samples", run.cost.counts.samples},
          {"dropped_samples", run.cost.counts.dropped_samples},
          {"stages", run.cost.stage_seconds}};
}

Json json_of(const BenchVariantResult& variant, const ReferenceNoise& noise) {
  Json json{{"name", variant.name},
            {"integrator", variant.spec.content().algorithms().integrator()},
            {"integrator_kind", kind_of(variant)},
            {"sampler", wire::word_of(variant.spec.view().sampler())},
            {"isa", variant.spec.farm().isa()},
            {"import_cpu_seconds", variant.import_cpu_seconds},
            {"build_cpu_seconds", variant.build_cpu_seconds}};
  for (const BenchBias& bias : variant.biases) {
    const Interval efficient =
        interval_over(variant, bias.spp, [&](const BenchRun& run) { return efficiency(run, noise); });
    json["efficiency"].push_back({{"spp", bias.spp}, {"interval", json_of(efficient)}});
    json["bias"].push_back({{"spp", bias.spp},
                            {"channel", bias.channel},
                            {"percent", bias.percent},
                            {"t", bias.t},
                            {"squared", bias.apart.bias2},
                            {"squared_error", bias.apart.bias2_error},
                            {"variance", bias.apart.variance}});
  }
  if (const auto slope = slope_of(variant, noise)) {
    json["slope"] = {{"value", slope->value}, {"standard_error", slope->standard_error}};
  }
  json["ceiling"] = {{"share", variant.ceiling.share()},
                     {"rays", variant.ceiling.rays},
                     {"render_cpu_seconds", variant.ceiling.render_cpu_seconds},
                     {"replay_cpu_seconds", variant.ceiling.replay_cpu_seconds}};
  constexpr std::array kKinds{"camera", "bounce", "shadow"};
  for (std::size_t kind = 0; kind < kKinds.size(); ++kind) {
    const BenchRays& rays = variant.ceiling.by_kind[kind];
    json["ceiling"][kKinds[kind]] = {{"rays", rays.count},
                                     {"cpu_seconds", rays.cpu_seconds},
                                     {"nodes", rays.nodes},
                                     {"primitives", rays.primitives}};
  }
  json["structure"] = variant.structure;
  for (const BenchRun& run : variant.runs) json["runs"].push_back(json_of(run, noise));
  return json;
}

Json json_of(const WholeResult& result) {
  Json json{{"name", result.name}, {"reference", result.reference}};
  for (const WholeRun& run : result.runs) {
    json["runs"].push_back({{"spp", run.spp},
                            {"seed_offset", run.seed},
                            {"cpu_seconds", run.cost.cpu_seconds},
                            {"wall_seconds", run.cost.wall_seconds},
                            {"relmse", run.relmse},
                            {"relmse_trimmed", run.relmse_trimmed},
                            {"relmse_block", run.relmse_block},
                            {"efficiency", run.efficiency()},
                            {"efficiency_block", run.block_efficiency()}});
  }
  return json;
}

Json json_of(const BenchSceneResult& scene) {
  const v1::PixelRect& crop = scene.variants.front().spec.cut().crop();
  Json json{{"name", scene.name},
            {"width", crop.x1() - crop.x0()},
            {"height", crop.y1() - crop.y0()},
            {"block", scene.block},
            {"reference",
             {{"source", scene.reference},
              {"mse", scene.noise.mse},
              {"relmse", scene.noise.relmse},
              {"relmse_block", scene.noise.relmse_block}}}};
  for (const BenchVariantResult& variant : scene.variants)
    json["variants"].push_back(json_of(variant, scene.noise));
  for (std::size_t i = 1; i < scene.variants.size(); ++i) {
    const BenchVariantResult &a = scene.variants.front(), &b = scene.variants[i];
    Json comparison{{"a", a.name}, {"b", b.name}};
    const auto ratio = [&](std::optional<std::uint32_t> spp, Efficiency& efficient) {
      return json_of(efficiency_ratio(a, b, scene.noise, spp, efficient));
    };
    comparison["all"] = ratio(std::nullopt, efficiency);
    comparison["all_block"] = ratio(std::nullopt, block_efficiency);
    for (const BenchBias& bias : a.biases) {
      comparison["by_spp"].push_back({{"spp", bias.spp},
                                      {"interval", ratio(bias.spp, efficiency)},
                                      {"interval_block", ratio(bias.spp, block_efficiency)}});
    }
    json["efficiency_ratios"].push_back(std::move(comparison));
  }
  for (const WholeResult& result : scene.whole) json["whole"].push_back(json_of(result));
  for (const BenchRefusal& refusal : scene.refusals)
    json["not_measured"].push_back({{"name", refusal.name}, {"reason", refusal.reason}});
  return json;
}

}  // namespace

std::string to_json(const std::vector<BenchSceneResult>& scenes, const BenchPlan& plan,
                    const Machine& machine) {
  Json json{{"version", wire::build_version()},
            {"seeds", plan.seeds},
            {"threads", plan.threads},
            {"spp", plan.spp},
            {"machine",
             {{"model", machine.processor_model},
              {"processors", machine.processors},
              {"load", machine.load},
              {"others", machine.others},
              {"loaded", machine.is_loaded()}}}};
  for (const BenchSceneResult& scene : scenes) json["scenes"].push_back(json_of(scene));
  // Names may hold bytes that are not UTF-8.
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace tessera::client
