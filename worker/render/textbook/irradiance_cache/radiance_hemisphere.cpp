#include "render/textbook/irradiance_cache/radiance_hemisphere.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "render/core/constants.h"
#include "render/textbook/irradiance_cache/record_site.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Where the squared sine has its mean over the hemisphere, 2 / 3, cells are as wide as high with 4 pi / 3
/// times as many sectors as rings.
constexpr double kSectorsPerRing = 4 * std::numbers::pi / 3;

int glossy_rings(int samples) {
  return std::max(static_cast<int>(std::lround(std::sqrt(samples / kSectorsPerRing))), 1);
}

}  // namespace

/// Sixteen cells.
struct RadianceHemisphere::Cells {
  Int number;
  Mask inside;
  Float ring, sector;
};

RadianceHemisphere::RadianceHemisphere(int samples, int bands)
    : rings_(glossy_rings(samples)),
      sectors_(std::max(samples / glossy_rings(samples), 3)),
      harmonics_(bands) {
  const auto padded = static_cast<std::size_t>((cells() + kWidth - 1) / kWidth * kWidth);
  for (std::vector<float>& band : radiance_) band.resize(padded);
  for (std::vector<float>& axis : direction_) axis.resize(padded);
  distance_.resize(padded, std::numeric_limits<float>::infinity());
}

Vec3 RadianceHemisphere::direction(Int cell, Vec2 u) const {
  // Exact below 2^24 cells.
  const Float number = to_float(cell);
  const Float ring = floor((number + 0.5f) * (1 / static_cast<float>(sectors_)));
  const Float sector = number - ring * static_cast<float>(sectors_);
  const Float z = max(1.0f - (ring + u.x) * (1 / static_cast<float>(rings_)), 1e-6f);
  const Float azimuth = (sector + u.y) * (2 * kPi / static_cast<float>(sectors_));
  const Float sine = safe_sqrt(1.0f - z * z);
  return {sine * cos(azimuth), sine * sin(azimuth), z};
}

void RadianceHemisphere::set(int first, Vec3 directions, Vec3 radiance, Float distance) {
  const auto i = static_cast<std::size_t>(first);
  const Mask inside = Mask::first(cells() - first);
  const Float light[kBands] = {radiance.x, radiance.y, radiance.z};
  for (int band = 0; band < kBands; ++band)
    select_or_zero(inside, light[band]).store_unaligned(radiance_[band].data() + i);
  directions.x.store_unaligned(direction_[0].data() + i);
  directions.y.store_unaligned(direction_[1].data() + i);
  directions.z.store_unaligned(direction_[2].data() + i);
  select(inside, distance, std::numeric_limits<float>::infinity()).store_unaligned(distance_.data() + i);
}

/// Adds what the cells and their borders with those before them, in their rings and in their sectors,
/// contribute.
void RadianceHemisphere::add(const Cells& c, std::vector<Float>& sums) const {
  const auto i = static_cast<std::size_t>(c.number.lane(0));
  const Int last_of_ring = c.number + (sectors_ - 1), before = c.number - 1;
  const Int beside = select(c.sector < 0.5f, last_of_ring, before);
  const Mask has_below = c.inside & (c.ring > 0.5f);
  const Int below = c.number - sectors_;
  const Float distance = Float::load_unaligned(distance_.data() + i);

  // The border with the cell beside runs from polar angle to polar angle.
  const float share = 1 / static_cast<float>(rings_), angle = 2 * kPi / static_cast<float>(sectors_);
  const Float upper = 1.0f - c.ring * share, middle = 1.0f - (c.ring + 0.5f) * share,
              lower = max(1.0f - (c.ring + 1.0f) * share, 0.0f);
  const Float polar = acos(min(lower, 1.0f)) - acos(min(upper, 1.0f));
  const Float sine = safe_sqrt(1.0f - middle * middle), azimuth = c.sector * angle;
  const Vec3 beside_at{sine * cos(azimuth), sine * sin(azimuth), middle};
  const Float beside_rate = polar / min(distance, gather(distance_.data(), beside, c.inside));
  // That with the cell below, from azimuth to azimuth.
  const Float ring_sine = safe_sqrt(1.0f - upper * upper), centre = (c.sector + 0.5f) * angle;
  const Vec3 across{cos(centre), sin(centre), Float(0.0f)};
  const Vec3 below_at{ring_sine * across.x, ring_sine * across.y, upper};
  const Float below_rate =
      angle * ring_sine * upper / min(distance, gather(distance_.data(), below, has_below));

  Float light[kBands], beside_step[kBands], below_step[kBands];
  const float solid_angle = 2 * kPi / static_cast<float>(cells());
  for (int band = 0; band < kBands; ++band) {
    const float* radiance = radiance_[band].data();
    const Float here = Float::load_unaligned(radiance + i);
    light[band] = here * solid_angle;
    beside_step[band] = select_or_zero(c.inside, (here - gather(radiance, beside, c.inside)) * beside_rate);
    below_step[band] = select_or_zero(has_below, (here - gather(radiance, below, has_below)) * below_rate);
  }

  Float at_cell[Harmonics::kMost], at_beside[Harmonics::kMost], at_below[Harmonics::kMost];
  harmonics_.evaluate(
      {Float::load_unaligned(direction_[0].data() + i), Float::load_unaligned(direction_[1].data() + i),
       Float::load_unaligned(direction_[2].data() + i)},
      at_cell);
  harmonics_.evaluate(beside_at, at_beside);
  harmonics_.evaluate(below_at, at_below);
  const Float border_x = cos(azimuth), border_y = sin(azimuth);
  Float* sum = sums.data();
  for (int k = 0; k < harmonics_.count(); ++k, sum += GlossyRecords::kOfCoefficient) {
    for (int band = 0; band < kBands; ++band) {
      const Float side = beside_step[band] * at_beside[k], ring = below_step[band] * at_below[k];
      sum[band] += light[band] * at_cell[k];
      sum[kBands + band] += ring * across.x - side * border_y;
      sum[2 * kBands + band] += ring * across.y + side * border_x;
    }
  }
}

RadianceHemisphere::Estimate RadianceHemisphere::estimate() const {
  std::vector<Float> sums(static_cast<std::size_t>(harmonics_.count()) * GlossyRecords::kOfCoefficient,
                          Float(0.0f));
  for (int first = 0; first < cells(); first += kWidth) {
    Cells c{.number = Int::iota(first), .inside = Mask::first(cells() - first), .ring = {}, .sector = {}};
    const Float number = to_float(c.number);
    c.ring = floor((number + 0.5f) * (1 / static_cast<float>(sectors_)));
    c.sector = number - c.ring * static_cast<float>(sectors_);
    add(c, sums);
  }
  Estimate result{.numbers = {}, .mean_distance = 0, .nearest = std::numeric_limits<double>::infinity()};
  result.numbers.reserve(sums.size());
  for (const Float& sum : sums) {
    double total = 0;
    for (int lane = 0; lane < kWidth; ++lane) total += double{sum.lane(lane)};
    result.numbers.push_back(static_cast<float>(total));
  }
  double inverse_distances = 0;
  for (int cell = 0; cell < cells(); ++cell) {
    const double distance = double{distance_[static_cast<std::size_t>(cell)]};
    inverse_distances += 1 / distance;
    result.nearest = std::min(result.nearest, distance);
  }
  result.mean_distance =
      inverse_distances > 0 ? cells() / inverse_distances : std::numeric_limits<double>::infinity();
  return result;
}

}  // namespace tessera::render::TESSERA_ISA
