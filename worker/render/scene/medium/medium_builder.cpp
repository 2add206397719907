#include "render/scene/medium/medium_builder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/scene/values/fault_list.h"
#include "render/scene/values/located.h"
#include "render/scene/values/spectra.h"
#include "wire/volume_blob.h"

namespace tessera::render {

namespace {

/// The kernels gather samples with 32-bit indices.
constexpr std::size_t kMostSamples = std::size_t{1} << 30;

/// Free flights through a medium with a grid take as many steps as its majorants are thick in the mean: what
/// is denser than this, corner to corner, would take seconds a path.
constexpr double kLargestOpticalDepth = 1e6;

/// Optical depth of the largest majorant along all three edges of the bounds, which no straight way through
/// them is longer than.
double largest_optical_depth(const MediumRecord& medium) {
  Transform bounds_from_render, render_from_bounds;
  std::copy_n(medium.bounds_from_render.m, 12, bounds_from_render.m.begin());
  if (!bounds_from_render.invert(render_from_bounds)) return HUGE_VAL;
  const double edges = render_from_bounds.apply_vector({1, 0, 0}).length() +
                       render_from_bounds.apply_vector({0, 1, 0}).length() +
                       render_from_bounds.apply_vector({0, 0, 1}).length();
  return edges * *std::max_element(medium.majorants.begin(), medium.majorants.end());
}

/// What is the same everywhere of a quantity: itself, or the factor of its grid; null where there is none.
const v1::Spectrum* spectrum_of(const v1::VolumeValue& value) {
  if (value.has_constant()) return &value.constant();
  return value.grid().has_factor() ? &value.grid().factor() : nullptr;
}

bool black(const spectra::Rgb& rgb) { return rgb.r == 0 && rgb.g == 0 && rgb.b == 0; }

}  // namespace

absl::Status MediumBuilder::build(const Media& media, const wire::AlgorithmTraits& algorithm,
                                  std::vector<std::string>& warnings) {
  if (!algorithm.media) {
    names_.left_out = true;
    if (!media.empty()) {
      const auto sees = std::ranges::find(wire::algorithms(), true, &wire::AlgorithmTraits::media);
      warnings.push_back(absl::StrCat("integrator '", algorithm.name,
                                      "' looks at surfaces only: the scene's media are left out; '",
                                      sees->name, "' sees them"));
    }
    return absl::OkStatus();
  }
  for (const v1::Medium& medium : media) {
    FaultList faults(1);
    if (!faults.add(medium, absl::StrCat("medium '", medium.name(), "'"), add(medium))) return faults.first();
  }
  return absl::OkStatus();
}

absl::Status MediumBuilder::add(const v1::Medium& medium) {
  MediumRecord record;
  if (auto s = build_medium(medium, record); !s.ok()) return s;
  if (auto s = names_.names.add(medium.name(), static_cast<int>(table_.media.size())); !s.ok()) return s;
  table_.media.push_back(std::move(record));
  return absl::OkStatus();
}

absl::Status MediumBuilder::set_quantities(const v1::Medium& medium, MediumRecord& record) {
  const float scale = medium.has_scale() ? medium.scale() : 1;
  if (!std::isfinite(scale) || scale < 0)
    return absl::InvalidArgumentError("its scale is negative or not finite");
  if (!(medium.g() > -1 && medium.g() < 1))
    return absl::InvalidArgumentError("its asymmetry g is not within (-1, 1)");
  record.g = medium.g();
  if (auto s = set_value(medium.extinction(), 1, scale, record.sigma_t); !s.ok())
    return located(s, "extinction");
  record.scattering_is_sigma_s = medium.has_sigma_s();
  const v1::VolumeValue& scattering = medium.has_sigma_s() ? medium.sigma_s() : medium.albedo();
  if (auto s = set_value(scattering, 0, medium.has_sigma_s() ? scale : 1, record.albedo); !s.ok()) {
    return located(s, "scattering");
  }
  if (auto s = set_value(medium.emission(), 0, 1, record.emission); !s.ok()) return located(s, "emission");
  record.emits = !black({record.emission.value[0], record.emission.value[1], record.emission.value[2]});
  if (spectral_ != nullptr) set_curves(medium, record);
  return absl::OkStatus();
}

void MediumBuilder::set_curves(const v1::Medium& medium, MediumRecord& record) {
  const float scale = medium.has_scale() ? medium.scale() : 1;
  const auto curve_of = [&](const v1::VolumeValue& value, float factor) {
    const v1::Spectrum* const spectrum = spectrum_of(value);
    return spectrum != nullptr ? spectral_->add_measured(*spectrum, factor).value_or(-1) : -1;
  };
  record.sigma_t.curve = curve_of(medium.extinction(), scale);
  record.albedo.curve =
      medium.has_sigma_s() ? curve_of(medium.sigma_s(), scale) : curve_of(medium.albedo(), 1);
  const v1::Spectrum* const emission = spectrum_of(medium.emission());
  if (emission == nullptr) return;
  const SpectralEmission light = spectral_->emission_of(*emission);
  record.emission.value[0] = light.color.r, record.emission.value[1] = light.color.g;
  record.emission.value[2] = light.color.b;
  record.emission.curve = light.curve;
}

absl::Status MediumBuilder::set_bounds(const v1::Medium& medium, int grid, MediumRecord& record) {
  if (medium.has_world_from_bounds()) {
    const auto bounds_from_render = unit_cube_from_render(medium.world_from_bounds());
    if (!bounds_from_render.ok()) return located(bounds_from_render.status(), "bounds");
    record.bounds_from_render = *bounds_from_render;
  } else {
    record.bounds_from_render = table_.grids[static_cast<std::size_t>(grid)].grid_from_render;
  }
  build_majorants(table_, record);
  if (const double depth = largest_optical_depth(record); !(depth <= kLargestOpticalDepth)) {
    return absl::InvalidArgumentError(absl::StrCat("its optical depth from corner to corner, ", depth,
                                                   ", is above ", kLargestOpticalDepth));
  }
  return absl::OkStatus();
}

absl::Status MediumBuilder::build_medium(const v1::Medium& medium, MediumRecord& record) {
  if (auto s = set_quantities(medium, record); !s.ok()) return s;
  int grid = -1;
  for (const MediumValue* value : {&record.sigma_t, &record.albedo, &record.emission}) {
    if (grid < 0) grid = value->grid;
  }
  record.homogeneous = grid < 0 && !medium.has_world_from_bounds();
  if (!record.homogeneous) return set_bounds(medium, grid, record);
  // Free flights in closed form go by the albedo.
  if (record.scattering_is_sigma_s) divide_by_extinction(record);
  return absl::OkStatus();
}

void MediumBuilder::divide_by_extinction(MediumRecord& record) {
  MediumValue &sigma_t = record.sigma_t, &albedo = record.albedo;
  if (sigma_t.curve >= 0 || albedo.curve >= 0) {
    for (MediumValue* value : {&sigma_t, &albedo}) {
      if (value->curve < 0)
        value->curve = spectral_->add_factor({value->value[0], value->value[1], value->value[2]});
    }
    albedo.curve = spectral_->add_albedo(albedo.curve, sigma_t.curve);
  }
  for (int c = 0; c < 3; ++c) albedo.value[c] = sigma_t.value[c] > 0 ? albedo.value[c] / sigma_t.value[c] : 0;
  record.scattering_is_sigma_s = false;
}

absl::Status MediumBuilder::set_value(const v1::VolumeValue& value, float otherwise, float scale,
                                      MediumValue& result) {
  spectra::Rgb factor{1, 1, 1};
  if (value.has_grid()) {
    const auto grid = add_grid(value.grid());
    if (!grid.ok()) return grid.status();
    result.grid = *grid;
  } else {
    factor = {otherwise, otherwise, otherwise};
  }
  if (const v1::Spectrum* const spectrum = spectrum_of(value)) {
    if (auto s = check_spectrum(*spectrum, value.has_grid() ? "factor" : "spectrum"); !s.ok()) return s;
    factor = emission(*spectrum);
  }
  const float rgb[] = {factor.r, factor.g, factor.b};
  for (int c = 0; c < 3; ++c) {
    result.value[c] = rgb[c] * scale;
    if (!std::isfinite(result.value[c]) || result.value[c] < 0) {
      return absl::InvalidArgumentError("a coefficient is negative or not finite");
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<Affine> MediumBuilder::unit_cube_from_render(const v1::Matrix& world_from_cube) const {
  const auto placement = Transform::from_proto(world_from_cube);
  if (!placement.ok()) return placement.status();
  Transform cube_from_render;
  if (!(space_.from_world * *placement).invert(cube_from_render)) {
    return absl::InvalidArgumentError("its transform is singular");
  }
  return cube_from_render.to_affine();
}

absl::StatusOr<int> MediumBuilder::add_grid(const v1::VolumeGrid& grid) {
  const auto bytes = blobs_(grid.blob().digest());
  if (!bytes.ok()) return located(bytes.status(), absl::StrCat("volume ", grid.blob().digest()));
  const auto volume = wire::decode_volume(bytes->bytes);
  if (!volume.ok()) return located(volume.status(), absl::StrCat("volume ", grid.blob().digest()));
  if (volume->channels != 1 && volume->channels != 3) {
    return absl::InvalidArgumentError(
        absl::StrCat("a grid has ", volume->channels, " channels instead of 1 or 3"));
  }
  if (volume->samples.size() > kMostSamples)
    return absl::ResourceExhaustedError("a grid has more than 2^30 samples");
  if (std::any_of(volume->samples.begin(), volume->samples.end(), [](float x) { return x < 0; })) {
    return absl::InvalidArgumentError("a grid has a negative sample");
  }
  const auto grid_from_render = unit_cube_from_render(grid.world_from_grid());
  if (!grid_from_render.ok()) return located(grid_from_render.status(), "grid");
  DensityGrid record;
  record.size[0] = static_cast<std::int32_t>(volume->nx);
  record.size[1] = static_cast<std::int32_t>(volume->ny);
  record.size[2] = static_cast<std::int32_t>(volume->nz);
  record.channels = static_cast<std::int32_t>(volume->channels);
  record.grid_from_render = *grid_from_render;
  record.samples.assign(volume->samples.begin(), volume->samples.end());
  table_.grids.push_back(std::move(record));
  return static_cast<int>(table_.grids.size()) - 1;
}

}  // namespace tessera::render
