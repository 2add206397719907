#include "render/medium/medium.h"

#include "render/core/affine.h"
#include "render/core/constants.h"
#include "render/medium/density_lookup.h"
#include "render/medium/majorant_walk.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Beyond this many mean free paths nothing comes through that a float can hold.
constexpr float kOpaque = 100.0f;

Spectrum constant(const MediumValue& value, const Spectra& spectra) {
  return spectra.constant(color_of(value.value), Int(value.curve), Mask::all());
}

Spectrum transmitted(Spectrum sigma_t, Float distance) {
  Spectrum result;
  for (int c = 0; c < kSpectrumLanes; ++c)
    result.c[c] = select(sigma_t.c[c] > 0.0f, exp(-min(distance * sigma_t.c[c], kOpaque)), 1.0f);
  return result;
}

/// Probabilities of the components, by throughput.
Spectrum component_probabilities(Spectrum throughput) {
  const Float sum = throughput.mean() * kSpectrumLanes;
  const Mask usable = (sum > 0.0f) & is_finite(sum);
  return select(usable, throughput * (1.0f / select(usable, sum, 1.0f)), Spectrum(1.0f / kSpectrumLanes));
}

Float weighed_sum(Spectrum a, Spectrum b) { return (a * b).mean() * kSpectrumLanes; }

Flight homogeneous_flight(const MediumRecord& medium, const MediumRays& rays, Spectrum throughput, Vec2 u,
                          Mask active) {
  // A component, and a distance by it.
  const Spectrum probability = component_probabilities(throughput);
  const Spectrum sigma_t = constant(medium.sigma_t, rays.spectra);
  Float sigma = sigma_t.c[kSpectrumLanes - 1], above = probability.c[0];
  Mask undecided = Mask::all();
  for (int c = 0; c + 1 < kSpectrumLanes; ++c) {
    const Mask here = undecided & (u.y < above);
    sigma = select(here, sigma_t.c[c], sigma);
    undecided = and_not(undecided, here);
    above = above + probability.c[c + 1];
  }
  const Mask absorbs = sigma > 0.0f;
  const Float t = -log(1.0f - u.x) / select(absorbs, sigma, 1.0f);
  Flight flight;
  flight.scattered = active & absorbs & (t < rays.distance);
  flight.t = select(flight.scattered, t, rays.distance);

  // Over the density of this outcome by any component.
  const Spectrum through = transmitted(sigma_t, flight.t);
  const Spectrum outcome = select(flight.scattered, through * sigma_t, through);
  const Float density = weighed_sum(probability, outcome);
  flight.weight = outcome * (1.0f / select(density > 0.0f, density, 1.0f));
  flight.emission = Spectrum(0.0f);
  const Spectrum albedo = constant(medium.albedo, rays.spectra);
  if (medium.emits) {
    flight.emission = select_or_zero(
        flight.scattered,
        flight.weight * (Spectrum(1.0f) - albedo) *
            rays.spectra.light(color_of(medium.emission.value), Int(medium.emission.curve), active));
  }
  flight.weight = select(flight.scattered, flight.weight * albedo, flight.weight);
  return flight;
}

/// Extinction and scattering at points of a medium that varies.
struct Coefficients {
  Spectrum sigma_t, sigma_s;
};

Coefficients coefficients_at(const MediumTable& table, const MediumRecord& medium, const Spectra& spectra,
                             Vec3 p, Mask active) {
  Coefficients result;
  result.sigma_t = density_at(table, medium.sigma_t, spectra, p, active);
  if (kSpectral && (has_colors(table, medium.albedo) ||
                    (medium.scattering_is_sigma_s && has_colors(table, medium.sigma_t)))) {
    // Two densities that have their colours alone may be the wrong way round at a wavelength: the albedo, as
    // a reflectance, is not.
    Color albedo = color_at(table, medium.albedo, p, active);
    if (medium.scattering_is_sigma_s) {
      const Color extinction = color_at(table, medium.sigma_t, p, active);
      for (int c = 0; c < kBands; ++c) {
        const Mask some = extinction.c[c] > 0.0f;
        albedo.c[c] = select_or_zero(some, min(albedo.c[c] / select(some, extinction.c[c], 1.0f), 1.0f));
      }
    }
    result.sigma_s = spectra.factor(albedo, active) * result.sigma_t;
    return result;
  }
  result.sigma_s = density_at(table, medium.albedo, spectra, p, active);
  if (!medium.scattering_is_sigma_s) result.sigma_s = result.sigma_s * result.sigma_t;
  return result;
}

Flight tracked_flight(const MediumTable& table, const MediumRecord& medium, const MediumRays& rays,
                      Spectrum throughput, NumberStream& numbers, Mask active) {
  Flight flight{Mask::none(), rays.distance, Spectrum(1.0f), Spectrum(0.0f)};
  MajorantWalk walk(medium, rays.origin, rays.direction, rays.distance, active);
  for (;;) {
    const Mask collided = walk.advance(numbers.next());
    if (none(collided)) return flight;
    const Vec3 p = fma(rays.direction, walk.t(), rays.origin);
    const Coefficients at = coefficients_at(table, medium, rays.spectra, p, collided);
    const Spectrum sigma_n = max(Spectrum(walk.majorant()) - at.sigma_t, 0.0f);
    if (medium.emits) {
      const Spectrum absorbed =
          max(at.sigma_t - at.sigma_s, 0.0f) * emission_at(table, medium.emission, rays.spectra, p, collided);
      flight.emission += select_or_zero(collided, flight.weight * absorbed * (1.0f / walk.majorant()));
    }
    // A real collision or none, in proportion to what the path still carries.
    const Spectrum carried = component_probabilities(throughput * flight.weight);
    const Float real = weighed_sum(carried, at.sigma_t), empty = weighed_sum(carried, sigma_n);
    const Float sum = real + empty;
    const Mask scatters = collided & (numbers.next() * sum < real);
    const Mask passes = and_not(collided, scatters);
    const Float chosen = select(scatters, real, empty);
    const Float factor = sum / (walk.majorant() * select(chosen > 0.0f, chosen, 1.0f));
    flight.weight = select(scatters, flight.weight * at.sigma_s * factor, flight.weight);
    flight.weight = select(passes, flight.weight * sigma_n * factor, flight.weight);
    flight.scattered |= scatters;
    flight.t = select(scatters, walk.t(), flight.t);
    walk.stop(scatters | (passes & is_black(flight.weight)));
  }
}

Spectrum tracked_transmittance(const MediumTable& table, const MediumRecord& medium, const MediumRays& rays,
                               NumberStream& numbers, Mask active) {
  Spectrum result(1.0f);
  MajorantWalk walk(medium, rays.origin, rays.direction, rays.distance, active);
  for (;;) {
    const Mask collided = walk.advance(numbers.next());
    if (none(collided)) return result;
    const Vec3 p = fma(rays.direction, walk.t(), rays.origin);
    const Spectrum sigma_t = density_at(table, medium.sigma_t, rays.spectra, p, collided);
    const Spectrum passed = max(Spectrum(1.0f) - sigma_t * (1.0f / walk.majorant()), 0.0f);
    result = select(collided, result * passed, result);
    // Russian roulette where next to nothing is left.
    const Float left = result.max_component();
    const Mask faint = collided & (left < 0.05f);
    const Mask ends = faint & (numbers.next() >= 0.25f);
    result = select(ends, Spectrum(0.0f), select(faint, result * 4.0f, result));
    walk.stop(ends | (collided & is_black(result)));
  }
}

/// g a lane.
Float asymmetry(const MediumTable& table, Int medium, Mask active) {
  Float g(0.0f);
  for_each_distinct(medium, active, [&](std::int32_t m, Mask lanes) {
    g = select(lanes, Float(table.media[static_cast<std::size_t>(m)].g), g);
  });
  return g;
}

/// `cosine` is between the directions before and after.
Float henyey_greenstein(Float g, Float cosine) {
  const Float denominator = max(1.0f + sqr(g) - 2.0f * g * cosine, 1e-12f);
  return kInv4Pi * (1.0f - sqr(g)) / (denominator * sqrt(denominator));
}

}  // namespace

Flight sample_flight(const MediumTable& table, const MediumRays& rays, Spectrum throughput, Vec2 u,
                     NumberStream& numbers, Mask active) {
  Flight result{Mask::none(), rays.distance, Spectrum(1.0f), Spectrum(0.0f)};
  for_each_distinct(rays.medium, active, [&](std::int32_t m, Mask lanes) {
    const MediumRecord& medium = table.media[static_cast<std::size_t>(m)];
    const Flight one = medium.homogeneous ? homogeneous_flight(medium, rays, throughput, u, lanes)
                                          : tracked_flight(table, medium, rays, throughput, numbers, lanes);
    result.scattered |= one.scattered & lanes;
    result.t = select(lanes, one.t, result.t);
    result.weight = select(lanes, one.weight, result.weight);
    result.emission = select(lanes, one.emission, result.emission);
  });
  return result;
}

Spectrum sample_transmittance(const MediumTable& table, const MediumRays& rays, NumberStream& numbers,
                              Mask active) {
  Spectrum result(1.0f);
  for_each_distinct(rays.medium, active, [&](std::int32_t m, Mask lanes) {
    const MediumRecord& medium = table.media[static_cast<std::size_t>(m)];
    const Spectrum one = medium.homogeneous
                             ? transmitted(constant(medium.sigma_t, rays.spectra), rays.distance)
                             : tracked_transmittance(table, medium, rays, numbers, lanes);
    result = select(lanes, one, result);
  });
  return result;
}

Float phase_value(const MediumTable& table, Int medium, Vec3 wo, Vec3 wi, Mask active) {
  return henyey_greenstein(asymmetry(table, medium, active), -dot(wo, wi));
}

PhaseSample sample_phase(const MediumTable& table, Int medium, Vec3 wo, Vec2 u, Mask active) {
  const Float g = asymmetry(table, medium, active);
  // The inverse of the cumulative distribution; uniform where g vanishes.
  const Mask even = abs(g) < 1e-3f;
  const Float safe_g = select(even, 1.0f, g);
  const Float ratio = (1.0f - sqr(safe_g)) / (1.0f + safe_g - 2.0f * safe_g * u.x);
  const Float bent = (1.0f + sqr(safe_g) - sqr(ratio)) / (2.0f * safe_g);
  const Float cosine = clamp(select(even, 1.0f - 2.0f * u.x, -bent), -1.0f, 1.0f);
  // `cosine` is between wo and wi here, so forward scattering has -1.
  const Float sine = safe_sqrt(1.0f - sqr(cosine)), phi = 2.0f * kPi * u.y;
  const Frame frame = Frame::from_normal(wo);
  const Vec3 wi = frame.to_world({sine * cos(phi), sine * sin(phi), cosine});
  return {wi, henyey_greenstein(g, -cosine)};
}

}  // namespace tessera::render::TESSERA_ISA
