#include "bench/against.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "wire/enum_words.h"

namespace tessera::client {
namespace {

using Json = nlohmann::ordered_json;

/// Efficiencies by sample count and seed.
using Efficiencies = std::map<std::pair<std::uint32_t, std::uint64_t>, double>;

struct Measured {
  Efficiencies efficiencies;
  double rays_alone_per_second = 0;
};

/// Names a measurement: figures of equal names are comparable.
std::string key_of(const std::string& scene, int width, int height, const std::string& variant,
                   const std::string& integrator, const std::string& sampler) {
  return absl::StrCat(scene, " ", width, "x", height, variant.empty() ? "" : ", ", variant, ", ", integrator,
                      ", ", sampler);
}

/// The results of an earlier run. Throws nlohmann's errors for what is not as report_json.cpp writes it.
std::map<std::string, Measured> earlier_results(const Json& json) {
  std::map<std::string, Measured> results;
  for (const Json& scene : json.at("scenes")) {
    for (const Json& variant : scene.at("variants")) {
      Measured& one = results[key_of(scene.at("name").get<std::string>(), scene.at("width").get<int>(),
                                     scene.at("height").get<int>(), variant.at("name").get<std::string>(),
                                     variant.at("integrator").get<std::string>(),
                                     variant.at("sampler").get<std::string>())];
      const Json& ceiling = variant.at("ceiling");
      one.rays_alone_per_second =
          ceiling.at("rays").get<double>() / ceiling.at("replay_cpu_seconds").get<double>();
      for (const Json& run : variant.at("runs")) {
        one.efficiencies[{run.at("spp").get<std::uint32_t>(), run.at("seed_offset").get<std::uint64_t>()}] =
            1 / (run.at("relmse_trimmed").get<double>() * run.at("cpu_seconds").get<double>());
      }
    }
  }
  return results;
}

Measured measured(const BenchVariantResult& variant) {
  Measured result;
  result.rays_alone_per_second =
      static_cast<double>(variant.ceiling.rays) / variant.ceiling.replay_cpu_seconds;
  for (const BenchRun& run : variant.runs)
    result.efficiencies[{run.spp, run.seed_offset}] = 1 / (run.relmse_trimmed * run.cost.cpu_seconds);
  return result;
}

/// The mean over sample counts for each seed that both have; none where there is no such seed.
std::optional<BenchChange> change_of(const std::string& name, const Measured& before, const Measured& now) {
  std::map<std::uint64_t, std::vector<double>> logs;
  for (const auto& [run, efficiency] : now.efficiencies) {
    const auto found = before.efficiencies.find(run);
    if (found != before.efficiencies.end()) logs[run.second].push_back(std::log(efficiency / found->second));
  }
  if (logs.empty()) return std::nullopt;
  const double speed = now.rays_alone_per_second / before.rays_alone_per_second;
  std::vector<double> ratios, by_rays;
  for (const auto& [seed, of_seed] : logs) {
    const double mean =
        std::accumulate(of_seed.begin(), of_seed.end(), 0.0) / static_cast<double>(of_seed.size());
    ratios.push_back(std::exp(mean));
    by_rays.push_back(std::exp(mean) / speed);
  }
  return BenchChange{name, interval_of(ratios), interval_of(by_rays)};
}

std::string verdict(const Interval& ratio) {
  if (!ratio.has_ends()) return "one seed shows no significance";
  if (ratio.high < 1 - kNotableChange) return "REGRESSION";
  if (ratio.low > 1 + kNotableChange) return "better";
  if (ratio.low > 1 - kNotableChange && ratio.high < 1 + kNotableChange) return "as before";
  return "no change beyond 3 % is shown";
}

}  // namespace

absl::StatusOr<std::string> read_results(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (!file || error) return absl::NotFoundError(absl::StrCat(path, ": cannot be read"));
  if (size > std::uintmax_t{64} << 20)
    return absl::InvalidArgumentError(absl::StrCat(path, ": is larger than 64 MiB"));
  return std::string{std::istreambuf_iterator<char>(file), {}};
}

absl::StatusOr<BenchChanges> changes_since(const std::string& text,
                                           const std::vector<BenchSceneResult>& scenes,
                                           const Machine& machine) {
  BenchChanges changes;
  try {
    const Json json = Json::parse(text);
    const std::map<std::string, Measured> before = earlier_results(json);
    changes.earlier_version = json.at("version").get<std::string>();
    const Json& earlier = json.at("machine");
    changes.earlier_machine = earlier.at("model").get<std::string>();
    changes.same_machine = changes.earlier_machine == machine.processor_model && !machine.is_loaded() &&
                           !earlier.at("loaded").get<bool>();
    for (const BenchSceneResult& scene : scenes) {
      for (const BenchVariantResult& variant : scene.variants) {
        const v1::PixelRect& crop = variant.spec.cut().crop();
        const std::string key = key_of(scene.name, static_cast<int>(crop.x1() - crop.x0()),
                                       static_cast<int>(crop.y1() - crop.y0()), variant.name,
                                       variant.spec.content().algorithms().integrator(),
                                       wire::word_of(variant.spec.view().sampler()));
        const auto found = before.find(key);
        std::optional<BenchChange> change;
        if (found != before.end()) change = change_of(key, found->second, measured(variant));
        if (change) {
          changes.changes.push_back(*std::move(change));
        } else {
          changes.missing.push_back(key);
        }
      }
    }
  } catch (const Json::exception& error) {
    return absl::InvalidArgumentError(absl::StrCat("no results of tessera bench: ", error.what()));
  }
  return changes;
}

std::string to_text(const BenchChanges& changes) {
  std::string text = absl::StrCat(
      "against ", changes.earlier_version, " on ",
      changes.earlier_machine.empty() ? "a processor that is not known" : changes.earlier_machine);
  absl::StrAppend(&text,
                  changes.same_machine
                      ? "\n"
                      : ": another machine, or one with other work, so time is in units of the rays alone\n");
  for (const BenchChange& change : changes.changes) {
    const Interval& ratio = changes.same_machine ? change.ratio : change.by_rays;
    absl::StrAppendFormat(&text, "  x %.3f  (95 %%: %s; by the clock x %.3f)  %s  %s\n", ratio.value,
                          ends_of(ratio), change.ratio.value, verdict(ratio), change.name);
  }
  for (const std::string& name : changes.missing)
    absl::StrAppend(&text, "  not measured then with these settings: ", name, "\n");
  return text;
}

}  // namespace tessera::client
