// Lights as bright as their amounts and their photometric files say.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"
#include "photometry/lamps/lamp_file.h"
#include "render/light/light_source.h"
#include "render/light/moving_lights.h"
#include "render/scene/light/light_builder.h"
#include "render/scene/light/photometric_map.h"
#include "render/scene/values/located.h"

namespace tessera::render {

namespace {

using photometry::Quantity;

/// Rays by which the light of textured lights is summed, over all parts of one: their sequence is off by less
/// than 1e-4 of it for textures without detail finer than some hundred steps across. Others that move send
/// about the same with each ray.
constexpr std::size_t kAmountRays = std::size_t{1} << 16, kRaysWithoutTexture = std::size_t{1} << 10;
constexpr std::size_t kFewestRaysOfAPart = 64;

bool shines_by_file(const v1::Light& light) {
  return light.has_goniometric() && light.goniometric().has_photometric_file();
}

/// Intensity of a luminaire where a light's axis is, over its mean.
double axis_over_mean(const photometry::Luminaire& luminaire, double mean) {
  return mean > 0 ? photometry::intensity(luminaire, 0, 0, -1) / mean : 0;
}

}  // namespace

absl::StatusOr<const LightBuilder::FileLight*> LightBuilder::file_light(const v1::BlobRef& file) {
  if (const auto known = file_lights_.find(file.digest()); known != file_lights_.end()) return &known->second;
  const std::string name = file.path().empty() ? "photometric file" : file.path();
  const auto bytes = inputs_.blobs(file.digest());
  if (!bytes.ok()) return located(bytes.status(), name);
  std::vector<std::string> notes;
  auto luminaire = photometry::read_lamp_file(bytes->bytes, {.name = name}, notes);
  if (!luminaire.ok()) return luminaire.status();
  if (inputs_.warnings != nullptr) {
    for (const std::string& note : notes) inputs_.warnings->push_back(absl::StrCat(place_, ": ", note));
  }
  FileLight light{*std::move(luminaire)};
  light.mean_candelas = photometry::flux(light.luminaire) / (4 * std::numbers::pi);
  if (!inputs_.headers_alone && light.mean_candelas > 0)
    light.texture =
        inputs_.textures.image_node(build_photometric_map(light.luminaire).image, kPhotometricBorder);
  return &file_lights_.emplace(file.digest(), std::move(light)).first->second;
}

absl::Status LightBuilder::set_photometric_file(const v1::GoniometricLight& light, LightRecord& record) {
  if (!light.texture().empty())
    return absl::InvalidArgumentError("it has a texture and a photometric file, of which one was expected");
  const auto file = file_light(light.photometric_file());
  if (!file.ok()) return file.status();
  record.texture = (*file)->texture;
  table_.any_textures = table_.any_textures || record.texture >= 0;
  float rows[9];
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) sum += kMapFromLuminaire[3 * row + k] * record.vertices[3 * k + column];
      rows[3 * row + column] = static_cast<float>(sum);
    }
  }
  std::copy(std::begin(rows), std::end(rows), record.vertices);
  return absl::OkStatus();
}

absl::StatusOr<std::optional<Amount>> LightBuilder::amount_of(const v1::Light& light) {
  if (light.has_amount()) {
    const auto amount = read_amount(light.amount(), light);
    if (!amount.ok()) return amount.status();
    return std::optional(*amount);
  }
  if (!shines_by_file(light)) return std::optional<Amount>();
  const auto file = file_light(light.goniometric().photometric_file());
  if (!file.ok()) return file.status();
  const double scale = light.has_scale() ? light.scale() : 1;
  if (!(scale >= 0)) return absl::InvalidArgumentError("its scale is negative");
  return std::optional(Amount{scale * 4 * std::numbers::pi * (*file)->mean_candelas, Quantity::kFlux, true});
}

absl::StatusOr<double> LightBuilder::brightness_of(const Amount& amount) {
  if (amount.value == 0) return 0.0;
  const double of_record = light_of_record(amount, latest_, inputs_.scale, inputs_.spectral);
  if (!(of_record > 0))
    return absl::InvalidArgumentError("amount: its colour is black, of which there is no amount");
  double brightness = amount.value / of_record;
  if (amount.needs_metres()) {
    brightness /= inputs_.scale.metres * inputs_.scale.metres;
    if (!inputs_.scale.says_metres && !warned_of_metres_ && inputs_.warnings != nullptr) {
      warned_of_metres_ = true;
      inputs_.warnings->push_back(
          absl::StrCat(place_,
                       ": it is as bright as its amount says if the scene's unit of length is the metre: "
                       "units { metres: ... } does not tell it"));
    }
  }
  return brightness;
}

absl::Status LightBuilder::scale_lights(std::size_t first, std::size_t last, double factor) {
  bool finite = std::isfinite(factor);
  const auto scale = [&](LightRecord& light) {
    for (float& band : light.radiance) {
      band = static_cast<float>(factor * band);
      finite = finite && std::isfinite(band);
    }
  };
  for (std::size_t i = first; i < last; ++i) {
    scale(table_.lights[i]);
    if (moving_ != nullptr && i < moving_->still.lights.size()) scale(moving_->still.lights[i]);
  }
  return finite ? absl::OkStatus() : absl::InvalidArgumentError("amount: it is too large");
}

absl::Status LightBuilder::set_amount(const v1::Light& light, const LightRecord& record, std::size_t first) {
  const auto amount = amount_of(light);
  if (!amount.ok()) return amount.status();
  if (!amount->has_value()) return absl::OkStatus();
  const auto brightness = brightness_of(**amount);
  if (!brightness.ok()) return brightness.status();
  const std::size_t last = table_.lights.size();
  if ((*amount)->quantity == Quantity::kFlux && record.texture >= 0 && !shines_by_file(light)) {
    pending_amounts_.push_back({place_, first, last, *brightness, luminance_of(latest_.color), true});
    return absl::OkStatus();
  }
  double unit = 1;
  if ((*amount)->quantity == Quantity::kFlux) {
    unit = filled_solid_angle(record);
  } else if (shines_by_file(light)) {
    const auto file = file_light(light.goniometric().photometric_file());
    if (!file.ok()) return file.status();
    unit = axis_over_mean((*file)->luminaire, (*file)->mean_candelas);
    if (!(unit > 0))
      return absl::InvalidArgumentError("amount: its file has no light on the axis; lm or W was expected");
  }
  return scale_lights(first, last, unit > 0 ? *brightness / unit : 0);
}

absl::Status LightBuilder::set_amount(const v1::AreaLight& light, bool moves, std::size_t first) {
  if (!light.has_amount()) return absl::OkStatus();
  const auto amount = read_amount(light.amount(), light);
  if (!amount.ok()) return amount.status();
  auto brightness = brightness_of(*amount);
  if (!brightness.ok()) return brightness.status();
  const std::size_t last = table_.lights.size();
  if (first == last) return absl::OkStatus();
  if (amount->quantity == Quantity::kRadiance) return scale_lights(first, last, *brightness);
  const double flux_of_intensity = std::numbers::pi * (light.two_sided() ? 2 : 1);
  if (amount->quantity == Quantity::kIntensity) {
    if (auto s = check_flat(first); !s.ok()) return s;
    *brightness *= flux_of_intensity;
  }
  if (moves || !light.texture().empty()) {
    pending_amounts_.push_back(
        {place_, first, last, *brightness, luminance_of(latest_.color), !light.texture().empty()});
    return absl::OkStatus();
  }
  double area = 0;
  for (std::size_t i = first; i < last; ++i)
    area += table_.lights[i].same_as < 0 ? double{table_.lights[i].area} : 0;
  if (!(area > 0)) return absl::InvalidArgumentError("amount: its shape has no area");
  return scale_lights(first, last, *brightness / (flux_of_intensity * area));
}

absl::Status LightBuilder::check_flat(std::size_t first) const {
  constexpr double kLargestAngle = 0.01, kLeastCosine = 1 - kLargestAngle * kLargestAngle / 2;
  std::optional<vec64::Vec> normal;
  for (std::size_t i = first; i < table_.lights.size(); ++i) {
    const LightRecord& light = table_.lights[i];
    const LightBounds bounds = table_.sources(light.kind).bounds(table_, light);
    if (!normal) normal = bounds.axis;
    if (bounds.angle <= kLargestAngle && dot(*normal, bounds.axis) >= kLeastCosine) continue;
    return absl::InvalidArgumentError(
        "amount: intensity is that along the normal, and its surface is curved or has several; lm, W, cd/m2 "
        "(nit) or W/(m2 sr) was expected");
  }
  return absl::OkStatus();
}

absl::Status LightBuilder::settle_amounts() {
  for (const PendingAmount& pending : pending_amounts_) {
    const std::size_t all = pending.textured ? kAmountRays : kRaysWithoutTexture;
    const auto rays = static_cast<std::int32_t>(
        std::max(kFewestRaysOfAPart, all / std::max<std::size_t>(1, pending.last - pending.first)));
    spectra::Rgb flux;
    for (std::size_t i = pending.first; i < pending.last; ++i) {
      const LightRecord& light = table_.lights[i];
      if (light.same_as >= 0) continue;
      const auto part = table_.sources(light.kind).emitted_flux(table_, static_cast<std::int32_t>(i), rays);
      flux.r += static_cast<float>(part[0]), flux.g += static_cast<float>(part[1]);
      flux.b += static_cast<float>(part[2]);
    }
    const double luminance = luminance_of(flux);
    if (!(luminance > 0) && pending.brightness > 0)
      return located(absl::InvalidArgumentError("amount: its texture is black, of which there is no amount"),
                     pending.where);
    const double factor = pending.brightness > 0 ? pending.brightness * pending.luminance / luminance : 0;
    if (auto s = scale_lights(pending.first, pending.last, factor); !s.ok()) return located(s, pending.where);
  }
  pending_amounts_.clear();
  return absl::OkStatus();
}

}  // namespace tessera::render
