#include "command/jobs/job_settings.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "wire/algorithm.h"
#include "wire/digest.h"
#include "wire/film_format.h"
#include "wire/film_size.h"
#include "wire/job_check.h"
#include "wire/lens_ghosts.h"
#include "wire/limits.h"
#include "wire/pixel_filter.h"
#include "wire/resolve_settings.h"
#include "wire/scene_views.h"
#include "wire/settings.h"

namespace tessera::client {
namespace {

// A unit is the least that is leased. What it costs is not known before: so little that even a scene of 1 ms
// a sample begins with seconds. The coordinator leases several as one as soon as it knows
// (docs/decisions/0020-unit-size.md).
constexpr std::uint64_t kSamplesPerUnit = std::uint64_t{1} << 14;
// A job has no more units than this: the coordinator remembers each.
constexpr std::uint64_t kMostUnits = std::uint64_t{1} << 20;
constexpr std::uint32_t kTileSize = 32;
// With a border, whose samples are for this tile alone. As wide as the filter: 3 % of the samples with a
// border of one pixel, where smaller tiles would have 6 and 13. As wide as groups that share light: 11 %, for
// 49 with tiles of 32.
constexpr std::uint32_t kBorderedTileSize = 128;
// Large tiles are results of many bytes: of so many samples a pixel, at least.
constexpr std::uint32_t kLeastBorderedSamples = 4;
// A pass returns the whole film, so that smaller ones would be more to send and to merge.
constexpr std::uint64_t kSamplesPerPasses = std::uint64_t{1} << 18;

/// Exactly `N` numbers, with `separator` between them.
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

absl::Status resolve_layers(const JobSettings& request, const v1::Scene& scene, v1::JobSpec::View& view) {
  const auto layers = layers_of_job(request.layers, scene, view.max_depth());
  if (!layers.ok())
    return request.layers.any() ? absl::OutOfRangeError(layers.status().message()) : layers.status();
  view.clear_layers();
  for (const layers::Layer& layer : *layers) {
    v1::Layer& message = *view.add_layers();
    message.set_name(layer.name);
    message.set_expression(layer.expression);
  }
  return absl::OkStatus();
}

absl::Status check_overscan(const JobSettings& request, const v1::Scene& scene) {
  if (request.overscan == 0) return absl::OkStatus();
  if (request.crop)
    return absl::OutOfRangeError("--overscan is of the whole film: it does not go with --crop");
  if (wire::sees_all_around(scene.camera()) || std::ranges::any_of(scene.views(), wire::sees_all_around))
    return absl::OutOfRangeError("--overscan: a camera that sees all around has no more to see");
  const auto has_map = [](const v1::Camera& camera) { return camera.distortion().has_map(); };
  if (has_map(scene.camera()) || std::ranges::any_of(scene.views(), has_map))
    return absl::OutOfRangeError("--overscan: a distortion map ends where the film does");
  return absl::OkStatus();
}

/// The screen of a film with so many more pixels on each side, which shows the same in those that it had.
void widen_screen(std::uint32_t overscan, const Resolution& picture, v1::Camera& camera) {
  float screen[4] = {-1, 1, -1, 1};
  const float aspect = static_cast<float>(picture.width) / static_cast<float>(picture.height);
  if (camera.screen_window_size() == 4) {
    std::copy_n(camera.screen_window().begin(), 4, screen);
  } else if (aspect > 1) {
    screen[0] = -aspect, screen[1] = aspect;
  } else {
    screen[2] = -1 / aspect, screen[3] = 1 / aspect;
  }
  const float x = (screen[1] - screen[0]) * static_cast<float>(overscan) / static_cast<float>(picture.width);
  const float y = (screen[3] - screen[2]) * static_cast<float>(overscan) / static_cast<float>(picture.height);
  const auto width = static_cast<double>(picture.width), height = static_cast<double>(picture.height);
  wire::keep_film_scale({width, height}, {width + 2 * overscan, height + 2 * overscan}, camera);
  camera.clear_screen_window();
  for (const float border : {screen[0] - x, screen[1] + x, screen[2] - y, screen[3] + y})
    camera.add_screen_window(border);
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

v1::PixelFilter filter_of(const JobSettings& request, const v1::Scene& scene) {
  if (!request.filter) return scene.film().filter();
  v1::PixelFilter filter;
  filter.set_kind(*request.filter);
  return filter;
}

/// The Scene message, with the film's filter and the camera's screen as asked for.
std::string scene_bytes(const JobSettings& request, const Resolution& picture, const v1::Scene& scene) {
  if (!request.filter && request.overscan == 0) return scene.SerializeAsString();
  v1::Scene changed = scene;
  *changed.mutable_film()->mutable_filter() = filter_of(request, scene);
  if (request.overscan > 0) {
    widen_screen(request.overscan, picture, *changed.mutable_camera());
    for (v1::Camera& camera : *changed.mutable_views()) widen_screen(request.overscan, picture, camera);
  }
  return changed.SerializeAsString();
}

/// Whether samples go into several pixels, where that is left to the program, or asked of several
/// integrators.
absl::Status resolve_reconstruction(const JobSettings& request, v1::Reconstruction asked,
                                    const v1::PixelFilter& filter, v1::JobSpec& spec) {
  if (asked == v1::RECONSTRUCTION_SAMPLE) return absl::OkStatus();
  const bool can = wire::allows_scattering(spec).ok();
  if (asked == v1::RECONSTRUCTION_SCATTER) {
    if (!can && request.several_integrators)
      spec.mutable_view()->set_reconstruction(v1::RECONSTRUCTION_SAMPLE);
    return wire::check_scattering(filter);
  }
  if (can && wire::gains_by_scattering(filter))
    spec.mutable_view()->set_reconstruction(v1::RECONSTRUCTION_SCATTER);
  return absl::OkStatus();
}

/// The same for pixels that share light. Who asks for their variance takes their noise to be independent.
/// Warns where the picture would have shared but for what was asked for beside it.
void resolve_sharing(const JobSettings& request, v1::PathSharing asked, v1::JobSpec& spec,
                     std::vector<std::string>& warnings) {
  if (asked == v1::PATH_SHARING_OFF) return;
  if (asked <= v1::PATH_SHARING_AUTO && spec.view().lens_ghosts() == v1::LENS_GHOSTS_LIGHTS) return;
  const bool can = wire::allows_sharing(spec).ok();
  if (asked > v1::PATH_SHARING_OFF) {
    if (!can && request.several_integrators) spec.mutable_view()->set_path_sharing(v1::PATH_SHARING_OFF);
    return;
  }
  const bool variance = std::ranges::find(request.aovs, v1::AOV_VARIANCE) != request.aovs.end();
  if (can && !variance) {
    spec.mutable_view()->set_path_sharing(v1::PATH_SHARING_AUTO);
    return;
  }
  const wire::AlgorithmTraits* const algorithm =
      wire::find_algorithm(spec.content().algorithms().integrator());
  if (algorithm == nullptr || !algorithm->shares_paths || spec.view().max_depth() < 2) return;
  warnings.push_back(absl::StrCat(
      "pixels do not share the light of their paths, because of ", can ? "--aov variance" : "layers",
      ": the picture may have several times the variance; render it in a job of its own, or say "
      "--path-sharing off"));
}

/// Whether a tile takes samples beyond its edges.
bool has_borders(const v1::JobSpec::View& view) {
  const bool shares =
      view.path_sharing() != v1::PATH_SHARING_UNSPECIFIED && view.path_sharing() != v1::PATH_SHARING_OFF;
  return shares || view.reconstruction() == v1::RECONSTRUCTION_SCATTER;
}

bool has_ghosts(const v1::Camera& camera) {
  return camera.lens().ghosts() && camera.near_clip() == 0 && camera.far_clip() == 0 &&
         !camera.has_distortion() && !camera.has_shutter();
}

/// Whether light is sent into the camera's lens, where that is left to the program, or asked of several
/// integrators. Ways of sampling that do not go with it are taken where somebody asks for them.
void resolve_lens_ghosts(const JobSettings& request, const v1::RenderSettings& asked, const v1::Scene& scene,
                         v1::JobSpec& spec) {
  v1::JobSpec::View& view = *spec.mutable_view();
  if (asked.lens_ghosts() == v1::LENS_GHOSTS_LIGHTS) {
    if (request.several_integrators && !wire::allows_light_into_lens(spec).ok()) view.clear_lens_ghosts();
    return;
  }
  if (asked.lens_ghosts() == v1::LENS_GHOSTS_FILM) return;
  const bool has_any = has_ghosts(scene.camera()) || std::ranges::any_of(scene.views(), has_ghosts);
  if (has_any && wire::allows_light_into_lens(spec).ok()) view.set_lens_ghosts(v1::LENS_GHOSTS_LIGHTS);
}

void resolve_glass_shadows(const JobSettings& request, v1::Algorithms& algorithms) {
  const bool can = wire::find_algorithm(algorithms.integrator())->straight_shadows;
  if (!can && request.several_integrators) algorithms.clear_glass_shadows();
}

}  // namespace

absl::StatusOr<Resolution> parse_resolution(std::string_view text) {
  const auto numbers = parse_numbers<2>(text, 'x');
  if (!numbers || !wire::is_film_size((*numbers)[0], (*numbers)[1])) {
    return absl::InvalidArgumentError(
        absl::StrCat("expected WIDTHxHEIGHT, as in 640x480: pixels, ", wire::kFilmSizes));
  }
  return Resolution{(*numbers)[0], (*numbers)[1]};
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

std::uint32_t samples_per_unit(std::uint64_t pixels, std::uint64_t tiles, std::uint32_t spp) {
  const std::uint64_t wanted = std::bit_floor(std::max<std::uint64_t>(1, kSamplesPerUnit / pixels));
  const std::uint64_t least = std::bit_ceil((tiles * spp + kMostUnits - 1) / kMostUnits);
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(std::max(wanted, least), std::bit_ceil(spp)));
}

namespace {

std::uint32_t samples_of_a_unit(const v1::JobSpec& spec) {
  const std::uint64_t film = std::uint64_t{spec.view().width()} * spec.view().height(),
                      side = spec.cut().tile_size();
  const std::uint32_t spp = spec.samples().spp();
  // A result takes its time for each channel, however many samples it has.
  const auto layers = static_cast<std::uint32_t>(spec.view().layers_size());
  const std::uint32_t longer = std::bit_floor(1 + layers * 3 / 4);
  // Passes go over the whole film, tiles over a square.
  if (wire::works_in_passes(spec)) {
    const std::uint64_t passes = std::bit_floor(std::max<std::uint64_t>(1, kSamplesPerPasses / film));
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(passes * longer, std::bit_ceil(spp)));
  }
  const v1::PixelRect& crop = spec.cut().crop();
  const auto across = [side](std::uint32_t begin, std::uint32_t end) {
    return (end - begin + side - 1) / side + 1;
  };
  const std::uint32_t least = has_borders(spec.view()) ? kLeastBorderedSamples : 1;
  const std::uint32_t samples =
      samples_per_unit(side * side, across(crop.x0(), crop.x1()) * across(crop.y0(), crop.y1()), spp);
  return std::min(std::max(samples, least) * longer, std::bit_ceil(spp));
}

/// The AOVs that are asked for and those that denoising needs, each once.
std::set<v1::AOV> aovs_of(const JobSettings& request) {
  std::set<v1::AOV> aovs(request.aovs.begin(), request.aovs.end());
  if (request.denoise)
    aovs.insert({v1::AOV_VARIANCE, v1::AOV_ALBEDO, v1::AOV_NORMAL, v1::AOV_DEPTH, v1::AOV_HALVES});
  return aovs;
}

/// A fault of the job: OutOfRange where the scene without what the command line asks for would not have it.
absl::Status blamed(const absl::Status& fault, const JobSettings& request, const ImportedScene& imported) {
  const bool asks = request.settings.ByteSizeLong() > 0 || request.filter || !request.aovs.empty() ||
                    request.layers.any() || request.denoise;
  if (!asks || prepare_job({}, imported, "").status() == fault) return fault;
  return absl::OutOfRangeError(fault.message());
}

void warn_of_bias(const v1::JobSpec& spec, std::vector<std::string>& warnings) {
  const wire::AlgorithmTraits& algorithm = *wire::find_algorithm(spec.content().algorithms().integrator());
  if (spec.content().algorithms().glass_shadows() == v1::GLASS_SHADOWS_STRAIGHT)
    warnings.push_back("light passes clear glass unbent (glass_shadows): the picture is an approximation");
  if (algorithm.bias != wire::Bias::kBiased) return;
  warnings.push_back(absl::StrCat("integrator '", algorithm.name,
                                  "' is biased: no number of samples makes its picture the right one"));
}

}  // namespace

absl::StatusOr<std::unique_ptr<PreparedJob>> prepare_job(const JobSettings& request,
                                                         const ImportedScene& imported,
                                                         const std::string& name) {
  auto job = std::make_unique<PreparedJob>();
  v1::JobSpec& spec = job->spec;
  const v1::Scene& scene = imported.scene;

  const Resolution picture =
      request.resolution.value_or(Resolution{scene.film().width(), scene.film().height()});
  if (absl::Status status = check_overscan(request, scene); !status.ok()) return status;
  const Resolution film{picture.width + 2 * request.overscan, picture.height + 2 * request.overscan};
  if (!wire::is_film_size(film.width, film.height)) {
    return absl::InvalidArgumentError(absl::StrCat("the scene's film has ", film.width, "x", film.height,
                                                   " pixels; ", wire::kFilmSizes, ", are possible"));
  }
  absl::StatusOr<v1::PixelRect> crop = resolve_crop(request, film);
  if (!crop.ok()) return crop.status();
  v1::RenderSettings asked = scene.settings();
  asked.MergeFrom(request.settings);
  wire::resolve_settings(asked, spec);
  if (auto s = resolve_layers(request, scene, *spec.mutable_view()); !s.ok()) return s;
  const std::string& integrator = spec.content().algorithms().integrator();
  if (absl::Status status = wire::check_algorithm_name(integrator); !status.ok()) return status;
  if (!request.several_integrators) {
    if (absl::Status status = wire::check_owner(request.settings, integrator); !status.ok())
      return absl::OutOfRangeError(status.message());
  }

  for (const v1::AOV aov : aovs_of(request)) spec.mutable_view()->add_aovs(aov);
  resolve_lens_ghosts(request, asked, scene, spec);
  if (absl::Status status =
          resolve_reconstruction(request, asked.reconstruction(), filter_of(request, scene), spec);
      !status.ok())
    return blamed(status, request, imported);
  resolve_sharing(request, asked.path_sharing(), spec, job->warnings);
  resolve_glass_shadows(request, *spec.mutable_content()->mutable_algorithms());

  v1::JobSpec::View& view = *spec.mutable_view();
  view.set_width(film.width);
  view.set_height(film.height);
  if (request.view) view.set_seed(view.seed() + *request.view);
  v1::JobSpec::Cut& cut = *spec.mutable_cut();
  if (scene.views_size() > 0) cut.set_views(1 + static_cast<std::uint32_t>(scene.views_size()));
  *cut.mutable_crop() = *std::move(crop);
  cut.set_tile_size(request.tile_size.value_or(has_borders(view) ? kBorderedTileSize : kTileSize));
  cut.set_samples_per_unit(samples_of_a_unit(spec));
  if (spec.samples().noise() != 0) cut.set_samples_per_unit(std::bit_ceil(spec.samples().spp()));
  wire::add_phases(spec);
  if (absl::Status status = wire::check_settings(spec); !status.ok())
    return blamed(status, request, imported);
  if (request.denoise && spec.samples().spp() < 2)
    return absl::OutOfRangeError("--denoise: one sample a pixel tells nothing of its noise; 2 or more do");
  warn_of_bias(spec, job->warnings);
  v1::JobSpec::Farm& farm = *spec.mutable_farm();
  farm.set_name(name);
  farm.set_isa(request.isa);
  farm.set_user(request.user);
  farm.set_priority(request.priority);
  for (const std::string& tag : request.required_tags) farm.add_required_tags(tag);
  farm.set_max_workers(request.max_workers);
  farm.set_bits(request.bits);
  farm.set_comment(request.comment);
  farm.set_webhook(request.webhook);

  farm.set_overscan(request.overscan);

  job->scene.bytes = scene_bytes(request, picture, scene);
  job->scene.ref.set_digest(wire::sha256_hex(job->scene.bytes));
  job->scene.ref.set_size_bytes(job->scene.bytes.size());
  spec.mutable_content()->set_scene(job->scene.ref.digest());
  *farm.add_blobs() = job->scene.ref;
  for (const SceneBlob& blob : imported.blobs) {
    *farm.add_blobs() = blob.ref;
    job->blobs.push_back(&blob);
  }
  job->blobs.push_back(&job->scene);
  return job;
}

}  // namespace tessera::client
