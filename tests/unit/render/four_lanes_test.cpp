// Kernels whose spectra have four lanes, as those of wavelengths will: nothing outside color/ counts on
// three. Compiled with TESSERA_SPECTRUM_LANES=4, and with it the sources that read colours of tables.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "render/bsdf/material_slots.h"
#include "render/light/light_access.h"
#include "render/medium/medium.h"

namespace tessera::render::TESSERA_ISA {

/// Slots that no model completes are looked at here: no model is asked.
const Bsdf* bsdf_model(BsdfKind) { return nullptr; }

namespace {

static_assert(kSpectrumLanes == 4);

constexpr float kColor[kBands] = {0.25f, 0.5f, 2.0f};

/// All lanes of the spectrum, lane 0 of the packet.
void expect_color(Spectrum spectrum, double tolerance = 0) {
  for (int i = 0; i < kSpectrumLanes; ++i)
    EXPECT_NEAR(spectrum.c[i].lane(0), kColor[band_of(i)], tolerance) << "lane " << i;
}

TEST(FourLanes, ColoursComeBackAsTheyWere) {
  const Spectrum spectrum = spectrum_of(kColor);
  expect_color(spectrum);
  const Vec3 rgb = rgb_of(spectrum);
  EXPECT_EQ(rgb.x.lane(0), kColor[0]);
  EXPECT_EQ(rgb.y.lane(0), kColor[1]);
  EXPECT_EQ(rgb.z.lane(0), kColor[2]);
}

TEST(FourLanes, SlotsOfMaterialsDoNotReadTheTexturesNumber) {
  MaterialTable table;
  table.materials.resize(2);
  for (MaterialRecord& record : table.materials) {
    std::copy(std::begin(kColor), std::end(kColor), record.spectra[0].value);
    record.spectra[0].texture = 7;  // beside the colour in memory
  }
  for (const MaterialRecord* common :
       {static_cast<const MaterialRecord*>(nullptr), std::as_const(table).materials.data() + 1}) {
    BsdfParams params;
    load_constants(table, Int(1), common, Int(0), Mask::all(), params);
    expect_color(params.spectra[0]);
  }
}

TEST(FourLanes, RadianceOfLightsDoesNotReadTheirArea) {
  LightTable table;
  table.lights.resize(2);
  std::copy(std::begin(kColor), std::end(kColor), table.lights[1].radiance);
  table.lights[1].area = 99;
  expect_color(LightLanes{table, Int(1), Mask::all()}.radiance());
}

TEST(FourLanes, MediaAreCrossedByEveryLane) {
  MediumTable table;
  MediumRecord& medium = table.media.emplace_back();
  std::copy(std::begin(kColor), std::end(kColor), medium.sigma_t.value);
  medium.sigma_t.grid = -1;
  const Float zero(0.0f);
  const MediumRays rays{Int(0), {zero, zero, zero}, {zero, zero, Float(1.0f)}, Float(1.5f)};
  NumberStream numbers{UInt(5)};
  const Spectrum through = sample_transmittance(table, rays, numbers, Mask::all());
  // Two roundings of 6e-8, and those of exp.
  for (int i = 0; i < kSpectrumLanes; ++i)
    EXPECT_NEAR(through.c[i].lane(0), std::exp(-1.5 * kColor[band_of(i)]), 1e-6) << "lane " << i;

  // A flight that is chosen by any lane: what it scatters and lets through adds up to the transmittance.
  double sum[kSpectrumLanes] = {};
  constexpr int kFlights = 4096;
  for (int n = 0; n < kFlights; ++n) {
    const Vec2 u{Float((static_cast<float>(n / 64) + 0.5f) / 64),
                 Float((static_cast<float>(n % 64) + 0.5f) / 64)};
    const Flight flight = sample_flight(table, rays, Spectrum(1.0f), u, numbers, Mask::all());
    if (flight.scattered.bits() & 1) continue;
    for (int i = 0; i < kSpectrumLanes; ++i) sum[i] += flight.weight.c[i].lane(0) / kFlights;
  }
  // Midpoints of a step function along u.x, of 64 x 4: off by half a column, times the largest weight of 4.
  for (int i = 0; i < kSpectrumLanes; ++i)
    EXPECT_NEAR(sum[i], through.c[i].lane(0), 4 * 0.5 / 64) << "lane " << i;
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
