#include "command/jobs/job_settings.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "wire/algorithm.h"
#include "wire/digest.h"
#include "wire/job_check.h"
#include "wire/limits.h"
#include "wire/tile_result.h"

namespace tessera::client {
namespace {

constexpr std::array kSamplers{"sobol", "independent"};
constexpr std::array kFilters{"box", "triangle", "gaussian", "mitchell",
                              "lanczos"};  // in the order of PixelFilter::Kind
constexpr std::array kIntersections{"auto", "fast", "robust"};
constexpr std::array kDirectLights{"mis", "bsdf"};
constexpr std::array kLightSelections{"auto", "tree", "mixed", "power", "uniform"};
constexpr std::array kTraversals{"packet", "single"};
const std::string kDefaultIntegrator{wire::algorithms().front().name};
constexpr std::uint32_t kDefaultSpp = 16;
constexpr std::uint32_t kDefaultMaxDepth = 5;  // pbrt's
// A unit is the least that is leased. What it costs is not known before: so little that even a scene of 1 ms
// a sample begins with seconds. The coordinator leases several as one as soon as it knows
// (docs/decisions/0020-unit-size.md).
constexpr std::uint64_t kSamplesPerUnit = std::uint64_t{1} << 14;
constexpr std::uint64_t kUsualUnits = std::uint64_t{1}
                                      << 20;  // of a job, at most; the coordinator remembers each
// A pass returns the whole film, so that smaller ones would be more to send and to merge.
constexpr std::uint64_t kSamplesPerPasses = std::uint64_t{1} << 18;

/// Exactly `N` whole numbers, with `separator` between them.
template <std::size_t N>
std::optional<std::array<std::uint32_t, N>> parse_numbers(std::string_view text, char separator) {
  std::array<std::uint32_t, N> numbers{};
  const char* at = text.data();
  const char* const end = at + text.size();
  for (std::size_t i = 0; i < N; ++i) {
    if (i > 0 && (at == end || *at++ != separator)) return std::nullopt;
    const auto [next, error] = std::from_chars(at, end, numbers[i]);
    if (error != std::errc{}) return std::nullopt;
    at = next;
  }
  if (at != end) return std::nullopt;
  return numbers;
}

template <class Names>
absl::Status check_name(const char* what, const std::string& name, const Names& names) {
  if (name.empty() || std::find(names.begin(), names.end(), name) != names.end()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("there is no ", what, " '", name, "'; there is: ", absl::StrJoin(names, ", ")));
}

absl::Status check_settings(const v1::RenderSettings& settings) {
  if (auto s = wire::check_algorithm_name(settings.integrator()); !s.ok()) return s;
  if (auto s = check_name("sampler", settings.sampler(), kSamplers); !s.ok()) return s;
  if (auto s = check_name("intersection", settings.intersection(), kIntersections); !s.ok()) return s;
  if (auto s = check_name("direct light", settings.direct_light(), kDirectLights); !s.ok()) return s;
  if (auto s = check_name("light selection", settings.light_selection(), kLightSelections); !s.ok()) return s;
  return check_name("traversal", settings.traversal(), kTraversals);
}

const std::string& first_of(const std::string& wish, const std::string& scene, const std::string& otherwise) {
  return !wish.empty() ? wish : !scene.empty() ? scene : otherwise;
}

v1::RenderSettings resolve_settings(const JobSettings& request, const v1::RenderSettings& scene) {
  v1::RenderSettings settings;
  settings.set_integrator(first_of(request.integrator, scene.integrator(), kDefaultIntegrator));
  settings.set_sampler(first_of(request.sampler, scene.sampler(), kSamplers[0]));
  settings.set_spp(request.spp.value_or(scene.spp() != 0 ? scene.spp() : kDefaultSpp));
  settings.set_noise(request.noise.value_or(scene.noise()));
  const std::uint32_t depth =
      request.max_depth.value_or(scene.has_max_depth() ? scene.max_depth() : kDefaultMaxDepth);
  settings.set_max_depth(std::min(depth, wire::kMaxDepth));
  settings.set_seed(request.seed.value_or(scene.seed()));
  settings.set_intersection(first_of(request.intersection, scene.intersection(), kIntersections[0]));
  settings.set_direct_light(first_of(request.direct_light, scene.direct_light(), kDirectLights[0]));
  settings.set_light_selection(
      first_of(request.light_selection, scene.light_selection(), kLightSelections[0]));
  settings.set_traversal(first_of(request.traversal, scene.traversal(), kTraversals[0]));
  return settings;
}

absl::StatusOr<v1::PixelRect> resolve_crop(const JobSettings& request, const Resolution& film) {
  v1::PixelRect crop;
  crop.set_x1(film.width);
  crop.set_y1(film.height);
  if (!request.crop) return crop;
  if (request.crop->x1() > film.width || request.crop->y1() > film.height) {
    return absl::OutOfRangeError(absl::StrCat("the crop ends at ", request.crop->x1(), ",",
                                              request.crop->y1(), "; the film ends at ", film.width, ",",
                                              film.height));
  }
  return *request.crop;
}

/// The Scene message, with the film's filter as asked for.
std::string scene_bytes(const JobSettings& request, const v1::Scene& scene) {
  const auto filter = std::find(kFilters.begin(), kFilters.end(), request.filter);
  if (filter == kFilters.end()) return scene.SerializeAsString();
  v1::Scene filtered = scene;
  filtered.mutable_film()->clear_filter();
  filtered.mutable_film()->mutable_filter()->set_kind(
      static_cast<v1::PixelFilter::Kind>(filter - kFilters.begin()));
  return filtered.SerializeAsString();
}

}  // namespace

absl::StatusOr<Resolution> parse_resolution(std::string_view text) {
  const auto numbers = parse_numbers<2>(text, 'x');
  const auto fits = [](std::uint32_t size) { return size > 0 && size <= wire::kMaxFilmSize; };
  if (!numbers || !fits((*numbers)[0]) || !fits((*numbers)[1])) {
    return absl::InvalidArgumentError(
        absl::StrCat("expected WIDTHxHEIGHT, each from 1 to ", wire::kMaxFilmSize, ", as in 640x480"));
  }
  return Resolution{(*numbers)[0], (*numbers)[1]};
}

absl::StatusOr<std::uint64_t> parse_seed(std::string_view text) {
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  if (error == std::errc{} && end == text.data() + text.size()) return seed;
  return absl::InvalidArgumentError("expected a whole number from 0 to 2^64 - 1");
}

absl::StatusOr<v1::PixelRect> parse_crop(std::string_view text) {
  const auto numbers = parse_numbers<4>(text, ',');
  if (!numbers || (*numbers)[0] >= (*numbers)[2] || (*numbers)[1] >= (*numbers)[3]) {
    return absl::InvalidArgumentError(
        "expected x0,y0,x1,y1 in pixels with x0 < x1 and y0 < y1, as in 0,0,320,240");
  }
  v1::PixelRect rect;
  rect.set_x0((*numbers)[0]);
  rect.set_y0((*numbers)[1]);
  rect.set_x1((*numbers)[2]);
  rect.set_y1((*numbers)[3]);
  return rect;
}

absl::Status check_names(const JobSettings& request) {
  if (absl::Status status = check_settings(resolve_settings(request, {})); !status.ok()) return status;
  if (absl::Status status = check_name("pixel filter", request.filter, kFilters); !status.ok()) return status;
  return wire::channels_for_aovs(request.aovs).status();
}

std::uint32_t samples_per_unit(std::uint64_t pixels, std::uint64_t tiles, std::uint32_t spp) {
  const std::uint64_t wanted = std::bit_floor(std::max<std::uint64_t>(1, kSamplesPerUnit / pixels));
  const std::uint64_t least = std::bit_ceil((tiles * spp + kUsualUnits - 1) / kUsualUnits);
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(std::max(wanted, least), std::bit_ceil(spp)));
}

namespace {

std::uint32_t samples_of_a_unit(const v1::JobSpec& spec) {
  const std::uint64_t film = std::uint64_t{spec.width()} * spec.height(), side = spec.tile_size();
  const std::uint32_t spp = spec.settings().spp();
  // Passes go over the whole film, tiles over a square.
  if (wire::works_in_passes(spec)) {
    const std::uint64_t passes = std::bit_floor(std::max<std::uint64_t>(1, kSamplesPerPasses / film));
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(passes, std::bit_ceil(spp)));
  }
  const v1::PixelRect& crop = spec.crop();
  const auto across = [side](std::uint32_t begin, std::uint32_t end) {
    return (end - begin + side - 1) / side + 1;
  };
  return samples_per_unit(side * side, across(crop.x0(), crop.x1()) * across(crop.y0(), crop.y1()), spp);
}

}  // namespace

absl::StatusOr<std::unique_ptr<PreparedJob>> prepare_job(const JobSettings& request,
                                                         const ImportedScene& imported,
                                                         const std::string& name) {
  auto job = std::make_unique<PreparedJob>();
  v1::JobSpec& spec = job->spec;
  const v1::Scene& scene = imported.scene;

  const Resolution film =
      request.resolution.value_or(Resolution{scene.film().width(), scene.film().height()});
  if (film.width == 0 || film.height == 0 || std::max(film.width, film.height) > wire::kMaxFilmSize) {
    return absl::InvalidArgumentError(absl::StrCat("the scene's film has ", film.width, "x", film.height,
                                                   " pixels; 1 to ", wire::kMaxFilmSize,
                                                   " each way are possible"));
  }
  absl::StatusOr<v1::PixelRect> crop = resolve_crop(request, film);
  if (!crop.ok()) return crop.status();
  *spec.mutable_settings() = resolve_settings(request, scene.settings());
  if (absl::Status status = check_settings(spec.settings()); !status.ok()) return status;

  spec.set_name(name);
  spec.set_width(film.width);
  spec.set_height(film.height);
  *spec.mutable_crop() = *std::move(crop);
  spec.set_tile_size(request.tile_size);
  spec.set_samples_per_unit(samples_of_a_unit(spec));
  if (spec.settings().noise() != 0) spec.set_samples_per_unit(std::bit_ceil(spec.settings().spp()));
  if (absl::Status status = wire::check_noise(spec); !status.ok()) {
    return request.noise ? absl::OutOfRangeError(status.message()) : status;
  }
  for (const std::string& aov : request.aovs) spec.add_aovs(aov);
  wire::add_phases(spec);
  if (absl::Status status = wire::check_algorithm(spec); !status.ok()) {
    const bool asked = request.noise || !request.integrator.empty() || !request.direct_light.empty() ||
                       !request.aovs.empty();
    return asked ? absl::OutOfRangeError(status.message()) : status;
  }
  spec.set_isa(request.isa);
  spec.set_user(request.user);
  spec.set_priority(request.priority);
  for (const std::string& tag : request.required_tags) spec.add_required_tags(tag);
  spec.set_max_workers(request.max_workers);
  if (!request.bits.empty()) spec.set_bits(request.bits == "any" ? v1::BITS_ANY : v1::BITS_SAME);

  job->scene.bytes = scene_bytes(request, scene);
  job->scene.ref.set_digest(wire::sha256_hex(job->scene.bytes));
  job->scene.ref.set_size_bytes(job->scene.bytes.size());
  *spec.mutable_scene() = job->scene.ref;
  for (const SceneBlob& blob : imported.blobs) {
    *spec.add_blobs() = blob.ref;
    job->blobs.push_back(&blob);
  }
  job->blobs.push_back(&job->scene);
  return job;
}

}  // namespace tessera::client
